//! What a pair that moves far within the step touches first, if anything.
//!
//! A gap along a separating axis tells that two hulls are apart, not that its plane will be hit: the plane has no end, and the
//! face has. So where the motion of a step would close the gap, the hulls are moved along it, from axis to axis: up to the
//! moment at which one stops separating, then on if another one does. If there is none, they touch.
//!
//! Where they do, each axis along which they overlap by less than the contact tolerance is as good a wall as any: the hulls
//! get past each other on either side of it. The one that the motion runs against least is what stops them; the hidden side of a
//! flush neighbor is not, since its top is not run against at all.
//!
//! # References
//! B. Mirtich, "Impulse-based Dynamic Simulation of Rigid Body Systems", 1996 (conservative advancement); E. Catto,
//! "Continuous Collision", GDC 2013 (from axis to axis).

use crate::contact::local_manifold::LocalManifold;
use crate::contact::narrow::clipping::Clipping;
use crate::contact::narrow::course::{ALONG, Course, TOUCH};
use crate::contact::narrow::sat::{distance_along, examine_hulls};
use crate::contact::narrow::scratch::{
    FaceAxis, HullPair, MERGE, NarrowScratch, SatCache, SatResult,
};
use crate::geometry::ConvexHull;
use crate::geometry::distance::{Separation, distance};
use crate::geometry::hull_lanes::{Points4, lowest, point};
use crate::geometry::support::{Core, PlacedCore};
use crate::math::{Pose, rotate};
use glam::Vec3;

/// Most axes, one after the other, that are followed. What is not decided then counts as touching, so that nothing is missed.
const MAX_AXES: usize = 64;

/// Hulls that are nearer than this many touching distances at so many moments touch: edges that slide along each other separate by ever
/// another axis.
const CLOSE: f32 = 2.0;
const MAX_CLOSE: u32 = 8;

/// Most chords by which one axis is followed.
const MAX_CHORDS: usize = 64;

/// Share of the touching distance that is left along an axis that is followed no further: the next one that is worth following leaves
/// much more.
const SPENT: f32 = 0.1;

/// How much shorter the next chord is at least.
const SHORTER: f32 = 0.9;

/// Cosine of the angle between normals that count as one.
const SAME: f32 = 0.9999;

/// How much less the motion must run against another axis for it to be taken instead.
pub(super) const LESS: f32 = 0.5;

/// Share of its length by which a motion may take the hulls into each other along a face along which they were clear of each
/// other: what slides fast is not held down all the way.
pub(super) const GRAZE: f32 = 0.02;

/// What becomes of a pair within the step.
#[derive(Clone, Copy, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "lives on the stack of one pair's test, never in an array"
)]
pub(crate) enum CastResult {
    /// It touches as the patch at the start says.
    AsFound,
    /// It touches first as this patch says, which was found at this pose. Good for the step only.
    Touches(LocalManifold, Pose),
    /// It does not touch.
    Misses,
}

/// A pair that moves.
#[derive(Debug)]
pub(crate) struct Cast<'h> {
    pub(crate) hulls: [&'h ConvexHull; 2],
    pub(crate) course: Course,
    /// Overlap that counts as none, m.
    pub(crate) tolerance: f32,
    /// Gap up to which a patch has all points, m.
    pub(crate) reach: f32,
    /// Gap up to which contacts are kept that the motion does not close, m.
    pub(crate) margin: f32,
}

impl Cast<'_> {
    /// What becomes of a pair whose patch at the start is this one; perhaps an empty one.
    pub(crate) fn outcome(&self, found: &LocalManifold, scratch: &mut NarrowScratch) -> CastResult {
        let (moment, last, touches) = self.first_touch(found);
        if !touches {
            return self.miss(moment, last, scratch);
        }
        let pose = self.course.at(moment);
        let turn = self.course.turn_of_a(moment);
        let is_as_found = |normal| found.count > 0 && rotate(turn, normal).dot(found.normal) > SAME;
        // The axis that separated last is the normal, if faces are not to be preferred.
        let patch = (!is_as_found(last))
            .then(|| self.patch_at(&pose, scratch))
            .flatten();
        let normal = patch.as_ref().map_or(last, |patch| patch.normal);
        if let Some(axis) = self.lesser_axis(moment, normal, None, scratch) {
            return self.pass_along(axis, moment, scratch);
        }
        match patch {
            Some(patch) if !is_as_found(patch.normal) => {
                CastResult::Touches(self.course.bind(patch, &pose), pose)
            }
            _ => CastResult::AsFound,
        }
    }

    /// The patch of the hulls at a pose, if it has points.
    fn patch_at(&self, pose: &Pose, scratch: &mut NarrowScratch) -> Option<LocalManifold> {
        let [a, b] = self.hulls;
        match examine_hulls(a, b, *pose, self.reach, SatCache::NONE, scratch) {
            SatResult::Touching(patch) if patch.count > 0 => Some(patch),
            _ => None,
        }
    }

    /// Distance that counts as none, m.
    fn touch(&self) -> f32 {
        TOUCH * self.size()
    }

    /// The smaller hull's diagonal, m.
    fn size(&self) -> f32 {
        let [a, b] = self.hulls.map(|hull| hull.aabb().diagonal());
        a.min(b)
    }

    /// How far the hulls are apart at a moment along an axis that does not turn (A's frame at the start), m.
    fn separation(&self, moment: f32, along: Vec3) -> f32 {
        let [a, b] = self.hulls;
        let axis = rotate(self.course.turn_of_a(moment).inverse(), along);
        distance_along(a, b, &self.course.at(moment), axis)
    }

    /// The hulls' nearest points at a moment.
    fn nearest(&self, moment: f32) -> Separation {
        let [a, b] = self.hulls.map(Core::of_hull);
        let b = PlacedCore::new(b, &self.course.at(moment));
        distance(&a, &b, f64::INFINITY)
    }

    /// Up to when an axis that does not turn separates hulls that are `distance` (m) apart along it at `moment`; `None` if it does up
    /// to the end of the step.
    ///
    /// Heights of corners along the axis are linear in time but for their turn, which bends them by at most `spin^2 radius`. So a
    /// corner stays above the lower of its heights at the ends of a time `t`, less `spin^2 radius t^2 / 8`; and the least of all
    /// corners' heights above their chord, less the same.
    fn end_of_separation(&self, along: Vec3, mut moment: f32, mut distance: f32) -> Option<f32> {
        let Course { end, .. } = self.course;
        let (bend, nothing) = (self.course.bend(), SPENT * self.touch());
        let mut ahead = end - moment;
        for _ in 0..MAX_CHORDS {
            let next = self.separation(moment + ahead, along);
            if distance.min(next) > bend * ahead * ahead {
                if moment + ahead >= end {
                    return None;
                }
                (moment, distance) = (moment + ahead, next);
                ahead = end - moment;
                continue;
            }
            if distance <= nothing {
                break;
            }
            let chord = (distance - 0.5 * nothing) / (distance - next).max(f32::MIN_POSITIVE);
            let straight = (0.5 * distance / bend.max(f32::MIN_POSITIVE)).sqrt();
            ahead = (ahead * chord.min(SHORTER)).min(straight);
        }
        Some(moment)
    }

    /// The first moment at which no axis separates the hulls, the normal along which they touch, A's frame at that moment, and
    /// that they do; or the last axis that separated them, and that they do not.
    fn first_touch(&self, found: &LocalManifold) -> (f32, Vec3, bool) {
        let [a, b] = self.hulls;
        let touch = self.touch();
        // Of an empty patch the axis is not known: that is looked for first.
        let (mut axis, mut moment, mut gap) = (found.normal, 0.0, 0.0);
        let mut close = 0;
        if found.count > 0 {
            gap = distance_along(a, b, &self.course.b_in_a, axis);
            if gap <= touch {
                return (0.0, axis, true);
            }
        }
        for _ in 0..MAX_AXES {
            let along = rotate(self.course.turn_of_a(moment), axis);
            if gap > 0.0 {
                let Some(last) = self.end_of_separation(along, moment, gap) else {
                    return (moment, axis, false);
                };
                moment = last;
            }
            match self.nearest(moment) {
                Separation::Near(near) if near.distance as f32 > touch && close < MAX_CLOSE => {
                    close += u32::from(near.distance as f32 <= CLOSE * touch);
                    (axis, gap) = (near.normal.as_vec3().normalize(), near.distance as f32);
                }
                _ => {
                    let back = self.course.turn_of_a(moment).inverse();
                    return (moment, rotate(back, along), true);
                }
            }
        }
        (moment, axis, true)
    }

    /// The face that the motion runs against least, among those along which the hulls overlap by less than the tolerance; if
    /// that is less than `most` (m per step), or much less than against the normal, at this moment.
    fn lesser_axis(
        &self,
        moment: f32,
        normal: Vec3,
        most: Option<f32>,
        scratch: &mut NarrowScratch,
    ) -> Option<(FaceAxis, bool)> {
        let [a, b] = self.hulls;
        let pose = &self.course.at(moment);
        scratch.load(a, b, pose);
        // Where they touch, on either: no face separates by more than the height of such a point.
        let on_a = a.vertices()[lowest(a.lanes.points.iter(), -normal).0];
        let on_b = point(&scratch.b_in_a, lowest(scratch.b_in_a.iter(), normal).0);
        let approach = |normal: Vec3| self.course.approach(moment, normal, on_b).max(0.0);
        let mut least = most.unwrap_or(LESS * approach(normal));
        if least <= 0.0 {
            return None;
        }
        let tolerance = self.tolerance + GRAZE * moment * self.course.travel.length();
        let mut best: Option<(FaceAxis, bool)> = None;
        let sides = [
            (false, a, on_b),
            (true, b, pose.inverse_transform_point(on_a)),
        ];
        for (b_refers, hull, place) in sides {
            for (face, plane) in hull.faces().iter().map(|face| face.plane).enumerate() {
                if plane.distance(place) < -tolerance {
                    continue;
                }
                let normal = if b_refers {
                    -(scratch.turn * plane.normal)
                } else {
                    plane.normal
                };
                let against = approach(normal);
                let is_equal = against == least;
                if against > least {
                    continue;
                }
                let axis = FaceAxis::new(hull, face, other_points(b_refers, scratch));
                let is_better =
                    !is_equal || best.is_none_or(|(b, _)| axis.separation > b.separation);
                if axis.separation >= -tolerance
                    && is_better
                    && self.is_clear(normal, pose, b_refers)
                {
                    least = against;
                    best = Some((axis, b_refers));
                }
            }
        }
        best
    }

    /// Whether the hulls overlap by less than the tolerance at the start along a face's normal, A's frame.
    fn is_clear(&self, normal: Vec3, pose: &Pose, b_refers: bool) -> bool {
        let [a, b] = self.hulls;
        let start = &self.course.b_in_a;
        let normal = if b_refers {
            rotate(start.rotation, rotate(pose.rotation.inverse(), normal))
        } else {
            normal
        };
        distance_along(a, b, start, normal) >= -self.tolerance
    }

    /// The contact along a face that the hulls pass each other on: where they are nearest to each other, so that what slides has
    /// its next support as soon as it comes there.
    fn pass_along(
        &self,
        (axis, b_refers): (FaceAxis, bool),
        first: f32,
        scratch: &mut NarrowScratch,
    ) -> CastResult {
        let [a, b] = self.hulls;
        let pose = self.course.at(self.course.nearest_moment(first));
        scratch.load(a, b, &pose);
        let hull = if b_refers { b } else { a };
        let axis = FaceAxis::new(hull, axis.face, other_points(b_refers, scratch));
        let clipping = Clipping {
            pair: HullPair {
                a,
                b,
                b_in_a: &pose,
                margin: self.reach,
            },
            merge: MERGE * self.size(),
        };
        let patch = clipping.face_patch(&axis, b_refers, scratch);
        if patch.count > 0 {
            CastResult::Touches(self.course.bind(patch, &pose), pose)
        } else {
            CastResult::Misses
        }
    }

    /// A near miss keeps a contact along what the hulls pass each other on, if it is a face that the motion does not run against,
    /// nor can turning: gravity may.
    fn miss(&self, moment: f32, axis: Vec3, scratch: &mut NarrowScratch) -> CastResult {
        let most = ALONG * self.course.travel.length();
        match self.lesser_axis(moment, axis, Some(most), scratch) {
            Some(axis)
                if axis.0.separation < self.margin
                    && axis.0.separation + self.tolerance > self.course.turning() =>
            {
                self.pass_along(axis, moment, scratch)
            }
            _ => CastResult::Misses,
        }
    }
}

/// The points of the hull that does not refer, in the frame of the one that does.
fn other_points(b_refers: bool, scratch: &NarrowScratch) -> &[Points4] {
    if b_refers {
        &scratch.a_in_b
    } else {
        &scratch.b_in_a
    }
}
