//! Puts the bodies where the solver has moved them.

use super::bodies::{Bodies, BodyError};

/// Moves all bodies and refreshes what follows from their poses.
///
/// A body whose state would no longer be finite is stopped where it is instead; `problems` says so.
pub fn integrate_positions(bodies: &mut Bodies, problems: &mut Vec<(u32, BodyError)>) {
    for slot in 0..bodies.slots() as u32 {
        let i = slot as usize;
        if !bodies.is_moving(slot) {
            continue;
        }
        let motion = bodies.motion[i];
        let centre = bodies.centre[i] + motion.shift;
        let (linear, angular) = bodies.velocity(slot);
        let is_finite = centre.is_finite()
            && motion.rotation.is_finite()
            && linear.is_finite()
            && angular.is_finite();
        if !is_finite {
            bodies.halt(slot);
            problems.push((slot, BodyError::Overflow));
            continue;
        }
        bodies.centre[i] = centre;
        bodies.rotation[i] = motion.rotation;
        bodies.refresh_world(slot);
    }
}
