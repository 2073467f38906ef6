//! What is kept of a pair of bodies from step to step, so that most pairs need no collision test.
//!
//! A test finds that the bodies are some distance apart, or where they nearly touch. Either holds while they have moved
//! little against each other since: a bound of how far any point of the smaller body has moved as seen from the larger
//! one tells. The state belongs to the pair and depends on nothing but how its two bodies moved.

use super::manifold::{BodyPlace, BoundPatch};
use glam::{Quat, Vec3};

/// How far a pair may move until its contact is found anew, as a share of the least extent of the smaller body.
///
/// The gaps are followed exactly for corners on faces, and to first order for edges: then two edges of 1 m that turn by
/// this much against each other are off by half its square, a micrometre. What is late by up to this much is a change
/// of features: a corner that slides over an edge.
const RECYCLE: f32 = 1e-3;

/// How much the bound of the motion is raised for rounding, as a share of the lengths that go into it.
const ROUNDING: f32 = 1e-6;

/// A body as its pairs see it in one step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PairBody {
    pub(crate) place: BodyPlace,
    pub(crate) rotation: Quat,
    /// Largest distance of the surface from the centre of mass, m; infinite for a half-space.
    pub(crate) radius: f32,
    /// Least extent of the hull's box, m; infinite for a half-space.
    pub(crate) least_extent: f32,
    /// Changes with the shape, mass or material of the body.
    pub(crate) version: u32,
    /// How far the centre goes within the step, m.
    pub(crate) travel: Vec3,
    /// How far a point of the body may turn within the step, m.
    pub(crate) turning: f32,
}

/// How the smaller body of a pair is seen from the larger one.
#[derive(Clone, Copy, Debug, Default)]
struct Sight {
    /// Centre of mass of the smaller body, m.
    centre: Vec3,
    rotation: Quat,
}

impl Sight {
    fn of(a: &PairBody, b: &PairBody) -> Self {
        let (large, small) = if a.radius < b.radius { (b, a) } else { (a, b) };
        Self {
            centre: large.place.turn.transpose() * (small.place.centre - large.place.centre),
            rotation: large.rotation.inverse() * small.rotation,
        }
    }

    /// How far a point of the smaller body, of the given radius (m), can have moved since `before`, m.
    ///
    /// A turn by the angle t moves it by at most `2 r sin(t / 2)`; the quaternions differ by `2 sin(t / 4)`.
    fn motion_since(&self, before: &Self, radius: f32) -> f32 {
        let turn = (self.rotation - before.rotation).length();
        let rounding = ROUNDING * (radius + self.centre.abs().element_sum());
        (self.centre - before.centre).length() + 2.0 * radius * turn + rounding
    }
}

/// What the last test of a pair found.
#[derive(Clone, Copy, Debug, Default)]
enum Finding {
    /// There was no test yet.
    #[default]
    Nothing,
    /// The bodies were at least `distance` (m) apart, along `axis` (unit vector from A to B, A's frame).
    Apart { axis: Vec3, distance: f32 },
    /// All points up to `reach` (m) are in the patch.
    Near { reach: f32 },
}

/// Whether the last test of a pair still tells what is now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Verdict {
    /// The bodies are farther apart than the margin.
    Apart,
    /// The patch still holds.
    Near,
    /// The pair must be tested again; if it was apart at the last test, along this axis (A's frame).
    Unknown(Option<Vec3>),
}

/// One pair from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct PairState {
    versions: [u32; 2],
    finding: Finding,
    /// At the last test.
    sight: Sight,
    pub(crate) patch: BoundPatch,
    pub(crate) friction: f32,
    pub(crate) restitution: f32,
}

/// How far a pair may move until its contact is found anew, m.
fn tolerance(a: &PairBody, b: &PairBody) -> f32 {
    RECYCLE * a.least_extent.min(b.least_extent)
}

/// Up to which gap a test looks for points so that the patch holds for `margin` (m) until it is found anew: the pair may
/// move by the tolerance, and the margin may grow by half of it as the bodies get faster.
pub(crate) fn reach_of_test(a: &PairBody, b: &PairBody, margin: f32) -> f32 {
    margin + 1.5 * tolerance(a, b)
}

impl PairState {
    /// What the last test says about the pair now, where bodies farther apart than `margin` (m) do not matter.
    pub(crate) fn verdict(&self, a: &PairBody, b: &PairBody, margin: f32) -> Verdict {
        if self.versions != [a.version, b.version] {
            return Verdict::Unknown(None);
        }
        let moved = || Sight::of(a, b).motion_since(&self.sight, a.radius.min(b.radius));
        match self.finding {
            Finding::Nothing => Verdict::Unknown(None),
            Finding::Apart { axis, distance } => {
                if distance - moved() > margin {
                    Verdict::Apart
                } else {
                    Verdict::Unknown(Some(axis))
                }
            }
            Finding::Near { reach } => {
                let moved = moved();
                if moved <= tolerance(a, b) && moved + margin <= reach {
                    Verdict::Near
                } else {
                    Verdict::Unknown(None)
                }
            }
        }
    }

    /// Whether the last test found contact points.
    pub(crate) fn touches(&self) -> bool {
        matches!(self.finding, Finding::Near { .. }) && self.patch.count > 0
    }

    /// Notes that a test now found the bodies `distance` (m) apart along `axis`.
    pub(crate) fn set_apart(&mut self, a: &PairBody, b: &PairBody, axis: Vec3, distance: f32) {
        self.note(a, b, Finding::Apart { axis, distance });
    }

    /// Notes the patch that a test now found, which holds all points up to `reach` (m).
    pub(crate) fn set_near(&mut self, a: &PairBody, b: &PairBody, patch: BoundPatch, reach: f32) {
        self.note(a, b, Finding::Near { reach });
        self.patch = patch;
    }

    fn note(&mut self, a: &PairBody, b: &PairBody, finding: Finding) {
        self.versions = [a.version, b.version];
        self.sight = Sight::of(a, b);
        self.finding = finding;
    }
}
