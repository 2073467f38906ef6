//! What a pair that moves far within the step touches first, if anything, when one of the two is round.
//!
//! The shapes are moved along their course by as much as they surely do not touch, again and again: the gap along the direction in
//! which they are nearest, by how fast they come towards each other along it. What only turns about its middle, as a ball does, does
//! not come nearer for that.
//!
//! Where they touch, a face along which they overlap by less than the contact tolerance is as good a wall as the direction that is found,
//! as for two hulls (`contact/narrow/cast.rs`): a ball that rolls on to a flush neighbor meets its edge by the sag, and its top is not run
//! against at all.

use crate::contact::narrow::cast::{CastResult, GRAZE, LESS};
use crate::contact::narrow::course::{ALONG, Course, TOUCH};
use crate::contact::narrow::round::axis::SolidPair;
use crate::contact::narrow::round::patch::{PatchRule, RoundScratch, patch_along, wide_patch};
use crate::contact::narrow::round::solid::{Form, Solid};
use crate::geometry::ConvexMesh;
use crate::math::{Pose, rotate};
use glam::Vec3;

/// Most moments at which a pair is looked at. What is not decided then counts as touching.
const MAX_MOMENTS: usize = 100;

/// A face of one of two shapes.
#[derive(Clone, Copy, Debug)]
struct Wall {
    /// Own frame.
    outward: Vec3,
    is_of_b: bool,
}

impl Wall {
    /// The direction from A to B along it, A's frame.
    fn normal(&self, b_in_a: &Pose) -> Vec3 {
        if self.is_of_b {
            -rotate(b_in_a.rotation, self.outward)
        } else {
            self.outward
        }
    }
}

/// A pair that moves.
#[derive(Debug)]
pub(crate) struct RoundCast<'s> {
    pub(crate) meshes: [&'s ConvexMesh; 2],
    pub(crate) course: Course,
    /// Overlap that counts as none, m.
    pub(crate) tolerance: f32,
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

    /// How far turning can bring the surfaces together in the whole step, m. What is round about an axis does not come nearer by turning
    /// about it.
    fn turning(&self) -> f32 {
        let of = |side: usize| {
            let (center, radius) = (self.course.centers[side], self.course.radii[side]);
            let spin = match side {
                0 => self.course.spins[0],
                _ => rotate(self.course.b_in_a.rotation.inverse(), self.course.spins[1]),
            };
            match Solid::of(self.meshes[side]).form {
                Form::Point(at) => spin.length() * at.distance(center),
                Form::Segment(_) | Form::Frustum(_) => {
                    let off = Vec3::new(center.x, 0.0, center.z).length();
                    let across = Vec3::new(spin.x, 0.0, spin.z).length();
                    spin.length() * off + across * (radius + off)
                }
                Form::Hull(_) | Form::Triangle(_) => spin.length() * radius,
            }
        };
        of(0) + of(1)
    }

    /// What becomes of the pair, which is apart by `gap` (m) along `normal` (A's frame) at the start.
    pub(crate) fn outcome(&self, normal: Vec3, gap: f32, scratch: &mut RoundScratch) -> CastResult {
        let touch = TOUCH * self.size();
        if gap <= touch {
            let wall = self.lesser_wall(0.0, normal);
            return wall.map_or(CastResult::AsFound, |w| self.pass_along(w, 0.0, scratch));
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
                if let Some(wall) = self.lesser_wall(moment, found.normal) {
                    return self.pass_along(wall, moment, scratch);
                }
                let rule = PatchRule::new(self.reach, self.size());
                let patch = patch_along(&pair, &found, rule, scratch);
                let pose = pair.b_in_a;
                return CastResult::Touches(self.course.bind(patch, &pose), pose);
            }
            (axis, distance) = (found.normal, found.separation as f32);
        }
        CastResult::AsFound
    }

    /// The face that the motion runs against least, among those along which the shapes overlap by less than the tolerance, if that is
    /// much less than against the direction in which they touch at this moment.
    fn lesser_wall(&self, moment: f32, found: Vec3) -> Option<Wall> {
        let pair = self.pair(moment);
        let start = self.pair(0.0);
        let approach = |normal: Vec3| {
            let is_a_smaller = self.course.radii[0] < self.course.radii[1];
            let place = pair.place_along(normal.as_dvec3(), is_a_smaller);
            self.course
                .approach(moment, normal, place.as_vec3())
                .max(0.0)
        };
        let mut least = LESS * approach(found);
        let tolerance = self.tolerance + GRAZE * moment * self.course.travel.length();
        let mut best = None;
        for (is_of_b, solid) in [(false, pair.a), (true, pair.b)] {
            let Form::Hull(hull) = solid.form else {
                continue;
            };
            for outward in hull.faces().iter().map(|face| face.plane.normal) {
                let wall = Wall { outward, is_of_b };
                let normal = wall.normal(&pair.b_in_a);
                if normal.dot(found) <= 0.0 || approach(normal) >= least {
                    continue;
                }
                let is_clear = [&pair, &start].into_iter().all(|pair| {
                    pair.separation(wall.normal(&pair.b_in_a)) >= -f64::from(tolerance)
                });
                if is_clear {
                    (least, best) = (approach(normal), Some(wall));
                }
            }
        }
        best
    }

    /// The contact along a face that the shapes pass each other on, where they are nearest to each other from a moment on.
    fn pass_along(&self, wall: Wall, first: f32, scratch: &mut RoundScratch) -> CastResult {
        let pair = self.pair(self.course.nearest_moment(first));
        let pose = pair.b_in_a;
        let rule = PatchRule::new(self.reach, self.size());
        let patch = wide_patch(&pair, wall.normal(&pose), rule, scratch);
        if patch.count > 0 {
            CastResult::Touches(self.course.bind(patch, &pose), pose)
        } else {
            CastResult::Misses
        }
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
