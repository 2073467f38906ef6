//! Kinematic bodies that are moved by their `Transform`: they go there within the step, so that they push and carry.

use crate::bodies::body::RigidBody;
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
    /// Where the body in this slot is to be, a pose that is one ([`Bodies::set_pose`]).
    pub(crate) fn new(bodies: &Bodies, slot: u32, pose: Pose) -> Self {
        Self {
            slot,
            id: bodies.id(slot),
            pose,
            velocity: (Vec3::ZERO, Vec3::ZERO),
        }
    }

    /// Lets the body move from where it is within a step of `step_dt` seconds. One that is to jump is put there at once: it is on no way,
    /// and this is false. To be called when shapes are what they will be in the step.
    pub(crate) fn begin(&mut self, bodies: &mut Bodies, step_dt: f32) -> bool {
        let slot = self.slot;
        if bodies.radius(slot) == 0.0 {
            // Another shape or density since the last mass phase; what is wrong with it is told by the next.
            let _ = bodies.refresh_mass(slot);
        }
        let shift = self.pose.position - bodies.pose(slot).position;
        let is_jump = shift.length() > LONGEST_MOVE * 2.0 * bodies.radius(slot);
        let is_on_way = !is_jump && self.begin_far(bodies, step_dt);
        if !is_on_way {
            let put = bodies.set_pose(slot, self.pose);
            debug_assert!(put.is_ok(), "no pose: {:?}", self.pose);
        }
        is_on_way
    }

    /// The same however far it is, and nothing where there is no way.
    fn begin_far(&mut self, bodies: &mut Bodies, step_dt: f32) -> bool {
        self.velocity = bodies.velocity(self.slot);
        let way = self.way(bodies, step_dt);
        way.is_some_and(|(way, turn)| {
            let moved = bodies.set_velocity(self.slot, way / step_dt, turn / step_dt);
            moved.is_ok()
        })
    }

    /// The way of the center of mass (m) and the turn (rad) to where the body is to be, if there is one.
    fn way(&self, bodies: &Bodies, step_dt: f32) -> Option<(Vec3, Vec3)> {
        let (slot, pose) = (self.slot, self.pose);
        let from = bodies.pose(slot);
        let is_kinematic = bodies.kind(slot) == RigidBody::Kinematic;
        if !is_kinematic || !pose.is_finite() || step_dt <= 0.0 || step_dt.is_nan() {
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
        Some((way, angle))
    }

    /// Lets a body go to `pose` on its way, however far that is, in place of where it may have been told to go before: by one of the
    /// first `told` targets.
    pub(crate) fn redirect(
        (targets, told): (&mut Vec<Self>, &mut usize),
        bodies: &mut Bodies,
        (slot, pose): (u32, Pose),
        step_dt: f32,
    ) {
        let before = targets[..*told].iter().position(|it| it.slot == slot);
        if let Some(before) = before {
            *told -= 1;
            let (linear, angular) = targets.remove(before).velocity;
            if bodies.set_velocity(slot, linear, angular).is_err() {
                return;
            }
        }
        let mut target = Self::new(bodies, slot, pose);
        if pose != bodies.pose(slot) && target.begin_far(bodies, step_dt) {
            targets.push(target);
        }
    }

    /// Puts the body there, to the bit.
    pub(crate) fn end(&self, bodies: &mut Bodies) {
        if bodies.is_current(self.slot, self.id) {
            bodies.arrive(self.slot, self.pose, self.velocity);
        }
    }
}
