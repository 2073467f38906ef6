//! What a pair that moves far within the step touches first, if anything, when one of the two is round.
//!
//! The shapes are moved along their course by as much as they surely do not touch, again and again: the gap along the direction in
//! which they are nearest, by how fast they come towards each other along it. What only turns about its middle, as a ball does, does
//! not come nearer for that.

use crate::contact::narrow::cast::CastResult;
use crate::contact::narrow::course::{ALONG, Course, TOUCH};
use crate::contact::narrow::round::axis::SolidPair;
use crate::contact::narrow::round::patch::{PatchRule, RoundScratch, patch_along};
use crate::contact::narrow::round::solid::{Form, Solid};
use crate::geometry::ConvexMesh;
use crate::math::rotate;
use glam::Vec3;

/// Most moments at which a pair is looked at. What is not decided then counts as touching.
const MAX_MOMENTS: usize = 100;

/// A pair that moves.
#[derive(Debug)]
pub(crate) struct RoundCast<'s> {
    pub(crate) meshes: [&'s ConvexMesh; 2],
    pub(crate) course: Course,
    /// Gap up to which a patch has all points, m.
    pub(crate) reach: f32,
    /// Gap up to which a contact is kept that the motion goes along, m.
    pub(crate) margin: f32,
}

impl RoundCast<'_> {
    fn size(&self) -> f32 {
        let [a, b] = self.meshes.map(|mesh| mesh.aabb().diagonal());
        a.min(b)
    }

    fn pair(&self, moment: f32) -> SolidPair<'_> {
        let [a, b] = self.meshes.map(Solid::of);
        SolidPair {
            a,
            b,
            b_in_a: self.course.at(moment),
        }
    }

    /// How far turning can bring the surfaces together in the whole step, m.
    fn turning(&self) -> f32 {
        let of = |side: usize| {
            let center = self.course.centers[side];
            let radius = match Solid::of(self.meshes[side]).form {
                Form::Point(at) => at.distance(center),
                _ => self.course.radii[side],
            };
            self.course.spins[side].length() * radius
        };
        of(0) + of(1)
    }

    /// What becomes of the pair, which is apart by `gap` (m) along `normal` (A's frame) at the start.
    pub(crate) fn outcome(&self, normal: Vec3, gap: f32, scratch: &mut RoundScratch) -> CastResult {
        let touch = TOUCH * self.size();
        if gap <= touch {
            return CastResult::AsFound;
        }
        let (turning, end) = (self.turning(), self.course.end);
        let (mut axis, mut distance, mut moment) = (normal, gap, 0.0);
        for _ in 0..MAX_MOMENTS {
            let along = rotate(self.course.turn_of_a(moment), axis);
            let rate = (-self.course.travel.dot(along)).max(0.0) + turning;
            if distance >= rate * (end - moment) {
                return self.miss(normal, gap, turning);
            }
            moment += distance / rate;
            let pair = self.pair(moment);
            let found = pair.axis(f64::from(self.reach));
            if found.separation <= f64::from(touch) {
                let rule = PatchRule::new(self.reach, self.size());
                let patch = patch_along(&pair, &found, rule, scratch);
                let pose = pair.b_in_a;
                return CastResult::Touches(self.course.bind(patch, &pose), pose);
            }
            (axis, distance) = (found.normal, found.separation as f32);
        }
        CastResult::AsFound
    }

    /// What misses keeps a contact along what it goes along, if it is near: gravity may bring it there.
    fn miss(&self, normal: Vec3, gap: f32, turning: f32) -> CastResult {
        let approach = turning - self.course.travel.dot(normal);
        let is_along = approach <= ALONG * self.course.travel.length();
        if gap <= self.margin && is_along {
            CastResult::AsFound
        } else {
            CastResult::Misses
        }
    }
}
