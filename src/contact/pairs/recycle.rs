//! What is kept of a pair of bodies from step to step, so that most pairs need no collision test.
//!
//! A test finds that the bodies are some distance apart, or where they nearly touch. Either holds while they have moved
//! little against each other since: a bound of how far any point of the smaller body has moved as seen from the larger
//! one tells. The state belongs to the pair and depends on nothing but how its two bodies moved.

use crate::contact::body_manifold::{BodyManifold, BodyPlace};
use crate::contact::narrow::scratch::SatCache;
use crate::contact::pairs::touches::{NO_TOUCH, Touch, Touches};
use crate::math::Pose;
use glam::{Quat, Vec3};

/// How far a pair may move until its contact is found anew, as a share of the least extent of the smaller body, where
/// the points stay what they are (corners on faces, crossings of edges): their gaps and places are then followed.
const RECYCLE: f32 = 1e-3;

/// The same where a corner is about to slide over an edge, as in a stack of equal boxes. A support that is off by this
/// much matters: at ten times the share a pyramid of base 50 moves by 14 mm instead of 6.
const RECYCLE_UNSTEADY: f32 = 1e-4;

/// How far a pair may slide along a face on which the smaller body's corners stand, as a share of the least extent of
/// the smaller body. The points are exact all that way; it is the contact code of the face that is left behind.
pub(crate) const SLIDE: f32 = 0.1;

/// Approach within a step, as a share of the least extent of the smaller body, from which it is found out what the pair will touch:
/// what rests shakes by less. Contact generation of a pyramid at rest takes 759 instructions a pair, half as many again with a tenth of this
/// share, and took 547 without any look at the motion (`cargo run --release --example performance`).
const APPROACH: f32 = 3e-4;

/// Most of [`haste`], as a share of the step.
const MAX_HASTE: f32 = 8.0;

/// How much the bound of the motion is raised for rounding, as a share of the lengths that go into it.
const ROUNDING: f32 = 1e-6;

/// A body as its pairs see it in one step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PairBody {
    pub(crate) place: BodyPlace,
    pub(crate) rotation: Quat,
    /// Largest distance of the surface from the center of mass, m; infinite for a half-space.
    pub(crate) radius: f32,
    /// How far the center goes within the step, m.
    pub(crate) travel: Vec3,
    /// How far a point of the body may turn within the step, m.
    pub(crate) turning: f32,
    /// The turn of the step, world axes, rad.
    pub(crate) spin: Vec3,
}

/// What the quickest look at a pair needs of a body.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MotionBound {
    /// A bound of the way that any point of the body has gone since the first step, m.
    pub(crate) path: f64,
    /// How far a point of the body may go within the step, m.
    pub(crate) ahead: f32,
    /// Least extent of the hull's box, m; infinite for a half-space.
    pub(crate) min_extent: f32,
    /// Changes with the shape, mass or material of the body.
    pub(crate) version: u32,
    /// How often the path began anew.
    epoch: u32,
}

/// A path begins anew when it is longer than this, m: until then it is good to a nanometre.
const LONGEST_PATH: f64 = 1e6;

impl MotionBound {
    /// Adds to the path.
    pub(crate) fn walk(&mut self, way: f32) {
        self.path += f64::from(way);
        // So that a path that is not a number ends too.
        let is_usable = self.path <= LONGEST_PATH;
        if !is_usable {
            self.path = 0.0;
            self.epoch = self.epoch.wrapping_add(1);
        }
    }
}

/// What a pair's state is tied to: changes with either body, because all of these numbers only grow.
fn epoch_of([a, b]: [&MotionBound; 2]) -> u32 {
    let epoch = |pace: &MotionBound| pace.version.wrapping_add(pace.epoch);
    epoch(a).wrapping_add(epoch(b))
}

impl PairBody {
    /// How far any point of the body can have moved since `before`, m.
    pub(crate) fn motion_since(&self, before: &Self) -> f32 {
        let turn = (self.rotation - before.rotation).length();
        let shift = (self.place.center - before.place.center).length();
        // A half-space has no bound unless it does not turn.
        let turned = if turn > 0.0 {
            2.0 * self.radius * turn
        } else {
            0.0
        };
        shift + turned
    }
}

/// How the smaller body of a pair is seen from the larger one.
#[derive(Clone, Copy, Debug, Default)]
struct RelativePose {
    /// Center of mass of the smaller body, m.
    center: Vec3,
    rotation: Quat,
}

impl RelativePose {
    fn of(a: &PairBody, b: &PairBody) -> Self {
        let (large, small) = if a.radius < b.radius { (b, a) } else { (a, b) };
        Self {
            center: large.place.turn.transpose() * (small.place.center - large.place.center),
            rotation: large.rotation.inverse() * small.rotation,
        }
    }

    /// How the smaller body, of the given radius (m), has moved since `before`.
    ///
    /// A turn by the angle t moves a point by at most `2 r sin(t / 2)`; the quaternions differ by `2 sin(t / 4)`.
    fn motion_since(&self, before: &Self, radius: f32) -> PairMotion {
        let turn = (self.rotation - before.rotation).length();
        let rounding = ROUNDING * (radius + self.center.abs().element_sum());
        PairMotion {
            shift: self.center - before.center,
            rest: 2.0 * radius * turn + rounding,
        }
    }
}

/// How the smaller body of a pair has moved as seen from the larger one.
#[derive(Clone, Copy, Debug)]
struct PairMotion {
    /// Of the center of mass, m.
    shift: Vec3,
    /// How far a point can have moved besides, m.
    rest: f32,
}

impl PairMotion {
    /// How far a point can have moved, m.
    fn length(&self) -> f32 {
        self.shift.length() + self.rest
    }

    /// The same along a direction, m.
    fn along(&self, direction: Vec3) -> f32 {
        self.shift.dot(direction).abs() + self.rest
    }
}

/// Whether the last test of a pair still tells what is now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Recycle {
    /// It does.
    Holds,
    /// The pair must be tested again; if it was apart at the last test, along this axis (A's frame).
    Unknown(Option<Vec3>),
}

/// How long what is known of a pair holds: all that the quick look reads, one pair after the other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RecycleTest {
    /// Sum of the bodies' paths at the last test, m.
    path: f64,
    /// How far the bodies may move against each other, m.
    tolerance: f32,
    /// How far they may move, together with the margin of the contacts that matter, m: their distance if they were apart;
    /// else the gap up to which the patch has all points.
    limit: f32,
    /// See [`epoch_of`].
    epoch: u32,
    /// Number of contact points.
    pub(crate) points: u32,
    /// Where the pair's state is in its list.
    pub(crate) state: u32,
    /// Where its touch is, or [`NO_TOUCH`].
    pub(crate) touch: u32,
}

const _: () = assert!(size_of::<RecycleTest>() == 32);

impl RecycleTest {
    /// Of a pair that was never tested, whose state is at this place.
    pub(crate) fn new(state: u32) -> Self {
        Self {
            path: 0.0,
            tolerance: f32::NEG_INFINITY,
            limit: f32::NEG_INFINITY,
            epoch: 0,
            points: 0,
            state,
            touch: NO_TOUCH,
        }
    }

    /// Whether the last test found contacts and looked for them farther than this, m, as for a local step it must not.
    pub(crate) fn is_wider_than(&self, widest: f32) -> bool {
        self.points > 0 && self.limit > widest
    }

    /// Whether what the last test found holds for bodies of the given paces, if contacts up to `margin` (m) matter: a quick
    /// look, which may say no for want of detail.
    pub(crate) fn surely_holds(&self, paces: [&MotionBound; 2], margin: f32) -> bool {
        let moved = (paces[0].path + paces[1].path - self.path) as f32;
        moved <= self.tolerance && moved + margin < self.limit && self.epoch == epoch_of(paces)
    }
}

/// What a closer look at a pair needs of its last test: a cache line.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(crate) struct PairState {
    /// Unit vector from A to B, A's frame, along which the bodies were apart.
    axis: Option<Vec3>,
    sight: RelativePose,
    /// The faces of A and B that separated best.
    pub(crate) faces: [u32; 2],
}

const _: () = assert!(size_of::<PairState>() == 64);

/// A pair as a test sees it.
#[derive(Debug)]
pub(crate) struct PairView<'v> {
    pub(crate) bodies: [&'v PairBody; 2],
    pub(crate) paces: [&'v MotionBound; 2],
    pub(crate) term: &'v mut RecycleTest,
    pub(crate) state: &'v mut PairState,
    pub(crate) touches: &'v mut Touches,
}

/// Up to which gap a test looks for points so that the patch holds for `margin` (m) until it is found anew: the pair may
/// move by the tolerance, and the margin may grow by three times that as the bodies get faster.
pub(crate) fn reach_of_test(paces: [&MotionBound; 2], margin: f32) -> f32 {
    margin + 4.0 * RECYCLE * smaller_extent(paces)
}

/// Least extent of the smaller body, m.
pub(crate) fn smaller_extent([a, b]: [&MotionBound; 2]) -> f32 {
    a.min_extent.min(b.min_extent)
}

/// How far points must come towards each other within the step for it to matter by which face, m.
pub(crate) fn min_approach(paces: [&MotionBound; 2]) -> f32 {
    APPROACH * smaller_extent(paces)
}

/// How many times as far a pair of bodies may go in the step as it does by its velocities, if gravity moves what is at rest by
/// `fall` (m).
pub(crate) fn haste([a, b]: [&PairBody; 2], fall: f32) -> f32 {
    let way = (b.travel - a.travel).length() + a.turning + b.turning;
    // From rest, a body may go anywhere; but then it is slow, and the next step sees it coming.
    1.0 + (fall / way).min(MAX_HASTE)
}

/// Whether the motion of the step closes the gap of a point of a patch, by at least so much, m.
fn closes(patch: &BodyManifold, [a, b]: [&PairBody; 2], least: f32, fall: f32) -> bool {
    let apart = b.place.center - a.place.center;
    let travel = b.travel - a.travel;
    let (normal, mut arms) = patch.arms(&a.place, &b.place);
    // What the velocity of a point leaves out of its turn.
    let bend = 0.5 * (a.turning * a.spin.length() + b.turning * b.spin.length());
    arms.any(|[on_a, on_b]| {
        let gap = normal.dot(apart + on_b - on_a);
        let turned = b.spin.cross(on_b) - a.spin.cross(on_a);
        let approach = bend - normal.dot(travel + turned);
        approach > least && gap < haste([a, b], fall) * approach
    })
}

impl PairView<'_> {
    /// Whether the motion of the step may bring the bodies through what the patch says, so that it must be found out what they
    /// touch.
    pub(crate) fn needs_cast(&self, patch: &BodyManifold, fall: f32) -> bool {
        let least = min_approach(self.paces);
        if patch.count > 0 {
            closes(patch, self.bodies, least, fall)
        } else {
            self.paces[0].ahead + self.paces[1].ahead > least
        }
    }

    /// Whether the bodies do not touch, or move so little that [`closes`] need not be asked.
    pub(crate) fn is_quiet(term: &RecycleTest, paces: [&MotionBound; 2]) -> bool {
        term.points == 0 || paces[0].ahead + paces[1].ahead <= min_approach(paces)
    }

    /// What the last test says about the pair now, where bodies farther apart than `margin` (m) do not matter. `fall`: see
    /// [`haste`]; `widest`: see [`RecycleTest::is_wider_than`].
    pub(crate) fn verdict(&mut self, margin: f32, fall: f32, widest: f32) -> Recycle {
        let Self {
            term,
            state,
            touches,
            ..
        } = self;
        let [a, b] = self.bodies;
        if term.epoch != epoch_of(self.paces) || term.is_wider_than(widest) {
            return Recycle::Unknown(None);
        }
        let sight = RelativePose::of(a, b);
        let motion = sight.motion_since(&state.sight, a.radius.min(b.radius));
        let mut moved = motion.length();
        let most = SLIDE * smaller_extent(self.paces);
        if moved > term.tolerance
            && let Some(Touch { patch, .. }) = touches.of(term.touch)
            && moved + term.tolerance <= patch.slide.min(most)
        {
            // What a slide changes, with all that the quick look lets pass after this, is nothing.
            let normal = patch.normal_for(a.radius < b.radius, sight.rotation);
            moved = motion.along(normal);
        }
        let closes = || match touches.of(term.touch) {
            Some(touch) => closes(&touch.patch, self.bodies, min_approach(self.paces), fall),
            None => false,
        };
        if moved <= term.tolerance && moved + margin < term.limit && !closes() {
            // The way there and back does not count.
            term.path = self.paces[0].path + self.paces[1].path - f64::from(moved);
            Recycle::Holds
        } else {
            Recycle::Unknown(state.axis)
        }
    }

    /// What the last test says about the next one, if it found these shapes touching. `centers`: of mass, own frames, m.
    pub(crate) fn hint(&self, b_in_a: &Pose, centers: [Vec3; 2]) -> SatCache {
        let is_current = self.term.epoch == epoch_of(self.paces);
        match self.touches.of(self.term.touch) {
            Some(Touch { patch, .. }) if patch.count > 0 && is_current => SatCache {
                faces: Some(self.state.faces),
                ..patch.hint(b_in_a, centers)
            },
            _ => SatCache::NONE,
        }
    }

    /// Notes that a test now found the bodies `distance` (m) apart, along `axis` if it was along one.
    pub(crate) fn set_apart(&mut self, axis: impl Into<Option<Vec3>>, distance: f32) {
        self.note(0, f32::INFINITY, distance);
        self.state.axis = axis.into();
        self.touches.end(&mut self.term.touch);
    }

    /// Notes what this step will make of the pair, which says nothing of the next one: where it will touch, if it will.
    pub(crate) fn set_passing(&mut self, touch: Option<Touch>) {
        let points = touch.as_ref().map_or(0, |touch| touch.patch.count);
        self.note(points, f32::NEG_INFINITY, f32::NEG_INFINITY);
        self.state.axis = None;
        match touch {
            Some(touch) => self.touches.set(&mut self.term.touch, touch),
            None => self.touches.end(&mut self.term.touch),
        }
    }

    /// Notes that a test now found these touches, with all points up to `reach` (m); good for the step only unless the pair is quiet.
    pub(crate) fn set_near_all(
        &mut self,
        touches: impl DoubleEndedIterator<Item = Touch> + Clone,
        reach: f32,
        is_quiet: bool,
    ) {
        let points = touches.clone().map(|touch| touch.patch.count).sum();
        let kept = |value: f32| if is_quiet { value } else { f32::NEG_INFINITY };
        let tolerance = kept(RECYCLE_UNSTEADY * smaller_extent(self.paces));
        self.note(points, tolerance, kept(reach));
        self.state.axis = None;
        self.touches.set_all(&mut self.term.touch, touches);
    }

    /// Notes that a test now found that the bodies touch, with all points up to `reach` (m).
    pub(crate) fn set_near(&mut self, touch: Touch, reach: f32) {
        let [least, most] = [RECYCLE_UNSTEADY, RECYCLE].map(|s| s * smaller_extent(self.paces));
        let patch = &touch.patch;
        self.note(
            patch.count,
            patch.recycle_distance.clamp(least, most),
            reach,
        );
        self.state.axis = None;
        self.touches.set(&mut self.term.touch, touch);
    }

    fn note(&mut self, points: u32, tolerance: f32, limit: f32) {
        let [a, b] = self.paces;
        *self.term = RecycleTest {
            path: a.path + b.path,
            tolerance,
            limit,
            epoch: epoch_of([a, b]),
            points,
            ..*self.term
        };
        self.state.sight = RelativePose::of(self.bodies[0], self.bodies[1]);
    }
}
