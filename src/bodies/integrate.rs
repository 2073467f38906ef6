//! Puts the bodies where the solver has moved them.

use crate::bodies::body::BodyError;
use crate::bodies::body::{BodyInfo, RigidBody};
use crate::bodies::inertia::inverse_inertia;
use crate::bodies::sleep_state::Status;
use crate::bodies::solver_body::{Motion, SolverBody};
use crate::bodies::store::Bodies;
use crate::mass::MassProperties;
use crate::math::{Pose, rotate};
use crate::threads::parts::{front, front_mut};
use crate::threads::team::Team;
use crate::tuning::{MAX_PARTS, MIN_MOVED_BODIES, MOVED_BODIES_WORTH_HELP};
use glam::{Mat3, Quat, Vec3};

/// The last motion of a step: all bodies go where the solver has moved them, and what drove them for the step ends.
pub fn integrate_positions(bodies: &mut Bodies, problems: &mut Vec<(u32, BodyError)>) {
    move_bodies(bodies, problems);
    bodies.end_drives();
}

impl Bodies {
    /// Velocity of a body's material at a point of the world, m/s.
    pub(crate) fn velocity_at(&self, slot: u32, point: Vec3) -> Vec3 {
        let (linear, angular) = self.velocity(slot);
        linear + angular.cross(point - self.center_of_mass(slot))
    }

    /// The pose of a body as it will be after the step that has been solved.
    pub(crate) fn pose_after_step(&self, slot: u32) -> Pose {
        let i = slot as usize;
        if !self.is_moving(slot) {
            return self.pose(slot);
        }
        let Motion { shift, rotation } = self.motion[i];
        let center = self.center[i] + shift;
        Pose::new(center - rotate(rotation, self.mass[i].center), rotation)
    }
}

/// Moves all bodies and refreshes what follows from their poses.
///
/// A body whose state would no longer be finite, or that would turn too fast for any rotation to tell, is stopped where it is
/// instead; `problems` says so.
pub(crate) fn move_bodies(bodies: &mut Bodies, problems: &mut Vec<(u32, BodyError)>) {
    if bodies.local.is_on {
        return move_local_bodies(bodies, problems);
    }
    let awake = bodies.dynamic().saturating_sub(bodies.asleep());
    Team::lead_present_if(awake >= MOVED_BODIES_WORTH_HELP, |team| {
        let mut overflown = [const { Vec::new() }; MAX_PARTS];
        let parts = parts(bodies, team).zip(&mut overflown);
        Team::each(team, parts, |(mut part, overflown)| {
            part.integrate(overflown)
        });
        let overflown = overflown.iter().flatten();
        problems.extend(overflown.map(|&slot| (slot, BodyError::Overflow)));
    });
}

/// The same of those that take local steps.
fn move_local_bodies(bodies: &mut Bodies, problems: &mut Vec<(u32, BodyError)>) {
    let local = std::mem::take(&mut bodies.local.slots);
    let mut overflown = Vec::new();
    for mut all in parts(bodies, None) {
        for &slot in &local {
            all.integrate_body(slot as usize, &mut overflown);
        }
    }
    bodies.local.slots = local;
    problems.extend(overflown.iter().map(|&slot| (slot, BodyError::Overflow)));
}

/// Bodies in slots that follow each other.
struct MassPart<'b> {
    first: u32,
    status: &'b [Status],
    info: &'b [Option<BodyInfo>],
    mass: &'b [MassProperties],
    motion: &'b [Motion],
    velocity: &'b mut [SolverBody],
    center: &'b mut [Vec3],
    rotation: &'b mut [Quat],
    inverse_inertia: &'b mut [Mat3],
}

/// Parts of all bodies for a team.
fn parts<'b>(bodies: &'b mut Bodies, team: Option<&Team>) -> impl Iterator<Item = MassPart<'b>> {
    let count = bodies.slots();
    let size = Team::part_size(team, count, MIN_MOVED_BODIES);
    let (mut status, mut info) = (&bodies.status[..], &bodies.info[..]);
    let (mut mass, mut motion) = (&bodies.mass[..], &bodies.motion[..]);
    let (mut velocity, mut center) = (&mut bodies.velocity[..], &mut bodies.center[..]);
    let mut rotation = &mut bodies.rotation[..];
    let mut inverse_inertia = &mut bodies.inverse_inertia[..];
    let part = move |first: usize| {
        let size = size.min(count - first);
        MassPart {
            first: first as u32,
            status: front(&mut status, size),
            info: front(&mut info, size),
            mass: front(&mut mass, size),
            motion: front(&mut motion, size),
            velocity: front_mut(&mut velocity, size),
            center: front_mut(&mut center, size),
            rotation: front_mut(&mut rotation, size),
            inverse_inertia: front_mut(&mut inverse_inertia, size),
        }
    };
    (0..count).step_by(size).map(part)
}

impl MassPart<'_> {
    /// `overflown`: slots of bodies that were stopped.
    fn integrate(&mut self, overflown: &mut Vec<u32>) {
        for i in 0..self.status.len() {
            self.integrate_body(i, overflown);
        }
    }

    /// The same for one of them.
    fn integrate_body(&mut self, i: usize, overflown: &mut Vec<u32>) {
        if !self.is_moving(i) {
            return;
        }
        let motion = self.motion[i];
        let center = self.center[i] + motion.shift;
        let body = &mut self.velocity[i];
        // A turn whose square overflows leaves a quaternion of zeros.
        let is_usable = center.is_finite()
            && motion.rotation.length_squared() > 0.5
            && body.linear.is_finite()
            && body.angular.is_finite();
        if !is_usable {
            (body.linear, body.angular) = (Vec3::ZERO, Vec3::ZERO);
            overflown.push(self.first + i as u32);
            return;
        }
        self.center[i] = center;
        self.rotation[i] = motion.rotation;
        if body.inverse_mass > 0.0 {
            self.inverse_inertia[i] = inverse_inertia(&self.mass[i], motion.rotation);
        }
    }

    /// Whether the body takes part and is not static.
    fn is_moving(&self, i: usize) -> bool {
        // What contacts move is not static; that spares most bodies a look at far memory.
        let may_move = || {
            let info = self.info[i].as_ref();
            self.velocity[i].inverse_mass > 0.0
                || info.is_some_and(|info| info.kind != RigidBody::Static)
        };
        matches!(self.status[i], Status::Active | Status::Local) && may_move()
    }
}
