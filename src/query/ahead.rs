//! Bodies as a step will leave them: what moves by its velocity, whatever it meets.

use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use crate::math::{Pose, rotate, rotate_by};
use crate::query::ball::Ball;
use crate::query::place::Place;
use glam::{Quat, Vec3};

/// How a body moves within a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mover {
    pub(crate) slot: u32,
    pub(crate) kind: RigidBody,
    /// Of mass, before the step, m.
    center: Vec3,
    /// How far that goes, m.
    shift: Vec3,
    /// How the body turns about it, and the same as an axis with the angle as its length, rad.
    pub(crate) turn: Quat,
    pub(crate) angle: Vec3,
}

impl Mover {
    /// Of the body in a slot, if it moves within a step, and may come into a ball then.
    fn of(bodies: &Bodies, slot: u32, (within, step_dt): (Ball, f32)) -> Option<Self> {
        let (linear, angular) = bodies.velocity(slot);
        let (center, shift) = (bodies.center_of_mass(slot), step_dt * linear);
        let radius = bodies.radius(slot);
        let reach = within.radius + radius + shift.length();
        // What has no end has no radius.
        let is_far = radius > 0.0 && center.distance_squared(within.center) > reach * reach;
        let is_still = linear == Vec3::ZERO && angular == Vec3::ZERO;
        let moves = !is_far && !is_still && bodies.is_moving(slot);
        moves.then(|| Self {
            slot,
            kind: bodies.kind(slot),
            center,
            shift,
            turn: rotate_by(Quat::IDENTITY, angular, step_dt),
            angle: step_dt * angular,
        })
    }

    /// How far a point of the body goes, m.
    pub(crate) fn way(&self, point: Vec3) -> Vec3 {
        let arm = point - self.center;
        self.shift + rotate(self.turn, arm) - arm
    }

    /// The body where it will be.
    fn place(&self, bodies: &Bodies) -> Place {
        let mut place = Place::of(bodies, self.slot);
        let rotation = (self.turn * bodies.pose(self.slot).rotation).normalize();
        let center = self.center + self.shift;
        let to_center = rotate(rotation, bodies.mass(self.slot).center);
        place.go_to(Pose::new(center - to_center, rotation), center);
        place
    }
}

/// Bodies that move within a step, and where they will be then.
#[derive(Debug, Default)]
pub(crate) struct Ahead {
    movers: Vec<Mover>,
    places: Vec<Place>,
}

impl Ahead {
    /// Takes a body in, if it moves and may come into a ball within a step of so many seconds.
    pub(crate) fn look(&mut self, bodies: &Bodies, slot: u32, around: (Ball, f32)) {
        let is_known = self.movers.iter().any(|mover| mover.slot == slot);
        let Some(mover) = Mover::of(bodies, slot, around).filter(|_| !is_known) else {
            return;
        };
        let place = mover.place(bodies);
        if place.pose().is_finite() {
            self.movers.push(mover);
            self.places.push(place);
        }
    }

    /// How a body moves, if it does.
    pub(crate) fn mover(&self, slot: u32) -> Option<Mover> {
        self.movers.iter().find(|mover| mover.slot == slot).copied()
    }

    /// Where a body will be.
    pub(crate) fn pose(&self, bodies: &Bodies, slot: u32) -> Pose {
        let place = self.places.iter().find(|place| place.slot == slot);
        place.map_or_else(|| bodies.pose(slot), Place::pose)
    }

    pub(crate) fn movers(&self) -> &[Mover] {
        &self.movers
    }

    pub(crate) fn places(&self) -> &[Place] {
        &self.places
    }
}
