//! Kinematic bodies that are moved by their `Transform`: they go there within the step, so that they push and carry.

use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::math::Pose;
use bevy_math::Vec3;

/// A body's diameters that a move within one step may be long; a longer one is a jump, which pushes nobody.
const LONGEST_MOVE: f32 = 1.0;

/// Where a body is to be after the step, and the velocity that it has then.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KinematicTarget {
    slot: u32,
    id: BodyId,
    pose: Pose,
    velocity: (Vec3, Vec3),
}

impl KinematicTarget {
    /// Lets the body move from where it is to `pose` within a step of `step_dt` seconds; nothing for a jump, which is to be made
    /// at once.
    pub(crate) fn begin(bodies: &mut Bodies, slot: u32, pose: Pose, step_dt: f32) -> Option<Self> {
        let from = bodies.pose(slot);
        let shift = pose.position - from.position;
        let is_jump = shift.length() > LONGEST_MOVE * 2.0 * bodies.radius(slot);
        if is_jump || !pose.is_finite() || step_dt <= 0.0 || step_dt.is_nan() {
            return None;
        }
        let center = bodies.mass(slot).center;
        let way = pose.transform_point(center) - from.transform_point(center);
        let turn = pose.rotation * from.rotation.inverse();
        let turn = if turn.w < 0.0 { -turn } else { turn };
        // Half a turn within a step has no direction.
        if turn.w < 1e-3 {
            return None;
        }
        // The tangent of half the angle, and two terms of the series of its arc.
        let half = turn.xyz() / turn.w;
        let angle = 2.0 * (1.0 - half.length_squared() / 3.0) * half;
        let target = Self {
            slot,
            id: bodies.id(slot),
            pose,
            velocity: bodies.velocity(slot),
        };
        let moved = bodies.set_velocity(slot, way / step_dt, angle / step_dt);
        moved.is_ok().then_some(target)
    }

    /// Puts the body there, to the bit.
    pub(crate) fn end(&self, bodies: &mut Bodies) {
        if bodies.is_current(self.slot, self.id) {
            bodies.arrive(self.slot, self.pose, self.velocity);
        }
    }
}
