//! Semi-implicit Euler: velocities first, then positions from the new velocities; with a stable gyroscopic term.

use super::bodies::{Bodies, BodyError, RigidBody, Status};
use crate::math::{rotate, rotate_by};
use glam::{Mat3, Quat, Vec3};

/// Applies gravity and the gyroscopic torque to the velocities of all dynamic bodies: the step's `v*`.
///
/// `h`: step length, s.
pub fn apply_forces(bodies: &mut Bodies, gravity: Vec3, h: f32) {
    for i in 0..bodies.slots() {
        if bodies.status[i] == Status::Active && bodies.velocity[i].inverse_mass > 0.0 {
            let frame = bodies.rotation[i] * bodies.mass[i].principal_frame;
            let body = &mut bodies.velocity[i];
            body.linear += gravity * h;
            body.angular = gyroscopic(body.angular, frame, bodies.mass[i].principal, h);
        }
    }
}

/// Angular velocity after `h` seconds of free spinning, world axes.
///
/// Euler's equations in the principal frame, `I d(omega)/dt = -omega x I omega`, by one Newton step on implicit Euler:
///
/// ```text
/// f(omega') = I (omega' - omega) + h omega' x I omega' = 0
/// df/domega' = I + h (skew(omega') I - skew(I omega'))
/// ```
///
/// started at `omega`. Unlike the explicit term it does not gain energy. Source: Catto, "Numerical Methods", GDC 2015.
///
/// - `omega`: world axes, rad/s
/// - `frame`: `world_from_principal`
/// - `principal`: principal moments of inertia, kg m2
fn gyroscopic(omega: Vec3, frame: Quat, principal: Vec3, h: f32) -> Vec3 {
    if principal.x == principal.y && principal.y == principal.z {
        return omega;
    }
    let w = rotate(frame.inverse(), omega);
    // Divided by the largest moment, so that the determinant does not underflow for small bodies.
    let i = principal / principal.max_element();
    let momentum = i * w;
    let f = h * w.cross(momentum);
    let jacobian = Mat3::from_diagonal(i)
        + (crate::math::skew(w) * Mat3::from_diagonal(i) - crate::math::skew(momentum)) * h;
    if jacobian.determinant().abs() < f32::MIN_POSITIVE {
        return omega;
    }
    rotate(frame, w - jacobian.inverse() * f)
}

/// Moves all bodies by their velocities for `h` seconds and refreshes what follows from the pose.
///
/// A body whose state would no longer be finite is stopped where it is instead; `problems` says so.
pub fn integrate_positions(bodies: &mut Bodies, problems: &mut Vec<(u32, BodyError)>, h: f32) {
    for i in 0..bodies.slots() {
        let slot = i as u32;
        if bodies.status[i] != Status::Active || bodies.info(slot).kind == RigidBody::Static {
            continue;
        }
        let body = bodies.velocity[i];
        let centre = bodies.centre[i] + body.linear * h;
        let rotation = rotate_by(bodies.rotation[i], body.angular, h);
        if !(centre.is_finite() && rotation.is_finite()) {
            bodies.halt(slot);
            problems.push((slot, BodyError::Overflow));
            continue;
        }
        bodies.centre[i] = centre;
        bodies.rotation[i] = rotation;
        bodies.refresh_world(slot);
    }
}
