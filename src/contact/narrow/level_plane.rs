//! Where all that a shape may touch of a level is one plane, it is over a half-space.

use crate::contact::local_manifold::LocalManifold;
use crate::contact::narrow::half_space::examine_half_space;
use crate::contact::narrow::level::LevelPair;
use crate::contact::narrow::round::pair::examine_round_half_space;
use crate::contact::narrow::round::patch::RoundScratch;
use crate::contact::narrow::scratch::{NarrowScratch, SatResult};
use crate::geometry::flat_ground::FlatGround;
use crate::geometry::hull_lanes::lowest_height;
use crate::math::{Aabb, Plane, Pose, rotate};
use glam::{Mat3, Vec3};

/// How far the centroid may be behind a triangle with a back that nothing touches, as a share of the thickness of the shape along its
/// normal: a splinter that came down fast has sunk in so far. It is half of what the centroid of any convex shape is above its lowest point at
/// least, so that what is behind the triangle as a whole is not taken for it.
const SUNK: f32 = 0.125;

impl LevelPair<'_> {
    /// The plane that the shape is over, if it sees nothing else of the level in the step, nor until it has slid as far as it may.
    pub(crate) fn ground_below(&self) -> Option<FlatGround> {
        if !self.is_usable() || !self.reach_over_plane.is_finite() {
            return None;
        }
        let turn = Mat3::from_quat(self.hull_in_mesh.rotation);
        let tight = self.shape.bounds(&turn, self.hull_in_mesh.position);
        let swept = Aabb {
            min: tight.min + self.travel.min(Vec3::ZERO),
            max: tight.max + self.travel.max(Vec3::ZERO),
        };
        let seen = swept.fattened(self.reach + self.slide);
        let ground = self.mesh.flat_ground(&seen, self.is_by_slot)?;
        // What is behind a triangle does not touch it, or touches the other side.
        self.is_in_front(ground.at, ground.normal).then_some(ground)
    }

    /// Whether the shape is on the side of a triangle, which has this corner, that its normal looks to.
    pub(in crate::contact::narrow) fn is_in_front(&self, corner: Vec3, normal: Vec3) -> bool {
        let hull = self.shape.hull();
        let middle = self.hull_in_mesh.transform_point(hull.centroid());
        let height = normal.dot(middle - corner);
        if height > 0.0 || self.mesh.is_two_sided() {
            return height > 0.0;
        }
        if -height > SUNK * hull.aabb().diagonal() {
            return false;
        }
        let up = rotate(self.hull_in_mesh.rotation.inverse(), normal);
        let points = &hull.lanes.points;
        let thickness = -lowest_height(points, -up) - lowest_height(points, up);
        -height < SUNK * thickness
    }

    /// The contact with that plane, unless it is out of reach, and what bears besides, if something does.
    pub(crate) fn examine_ground(
        &self,
        ground: &FlatGround,
        hulls: &mut NarrowScratch,
        round: &mut RoundScratch,
    ) -> [Option<LocalManifold>; 2] {
        let Pose { position, rotation } = self.hull_in_mesh;
        let back = rotation.inverse();
        // Triangles may be far from each other and from the origin.
        let height = ground
            .normal
            .as_dvec3()
            .dot(ground.at.as_dvec3() - position.as_dvec3());
        let plane = Plane {
            normal: rotate(back, ground.normal),
            offset: height as f32,
        };
        // The level with the origin of the shape as its own.
        let (pose, reach) = (Pose::new(Vec3::ZERO, back), self.reach_over_plane);
        let (found, beside) = if self.shape.is_round() {
            let found = examine_round_half_space(self.shape, plane, pose, reach, round);
            (found, None)
        } else {
            let found = examine_half_space(self.shape.hull(), plane, pose, reach, hulls);
            (found, hulls.beside)
        };
        let SatResult::Touching(patch) = found else {
            return [None; 2];
        };
        let patch = (patch.count > 0).then_some(patch);
        [patch, beside].map(|patch| {
            let mut patch = patch?;
            patch.slot = ground.slot;
            patch.normal_in_b = Some(-ground.normal);
            for point in &mut patch.points {
                point.on_b += position;
            }
            Some(patch)
        })
    }
}
