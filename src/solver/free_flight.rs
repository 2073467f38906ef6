//! How bodies move that touch nothing.

use crate::bodies::free_rotation::{FreeRotations, SPINS};
use crate::bodies::solver_body::Motion;
use crate::bodies::store::Bodies;
use crate::math::rotate_by;
use crate::solver::contact_solver::{ContactSolver, Progress};
use crate::solver::settings::SubstepSettings;
use glam::Vec3;

impl ContactSolver {
    /// Moves the bodies that touch nothing, exactly under constant acceleration: `x += h v + h^2 g / 2`.
    pub(crate) fn move_free_bodies(&mut self, bodies: &mut Bodies, settings: &SubstepSettings) {
        let mut spinning = Spinning::default();
        if bodies.local.is_on {
            for index in 0..bodies.local.slots.len() {
                let slot = bodies.local.slots[index];
                self.move_free_body(bodies, slot, settings, &mut spinning);
            }
        } else {
            self.carriers.clear();
            for slot in 0..bodies.slots() as u32 {
                self.move_free_body(bodies, slot, settings, &mut spinning);
            }
        }
        spinning.turn(bodies, settings);
    }

    /// Moves the body in `slot` if it touches nothing.
    fn move_free_body(
        &mut self,
        bodies: &mut Bodies,
        slot: u32,
        settings: &SubstepSettings,
        spinning: &mut Spinning,
    ) {
        let (step, i) = (settings.step_dt(), slot as usize);
        if self.progress[i] != Progress::Pending || !bodies.is_moving(slot) {
            return;
        }
        let driven = self.drive_free_body(bodies, slot, settings);
        let spin = bodies.spin(slot, step);
        let body = &mut bodies.velocity[i];
        let fall = if body.inverse_mass > 0.0 {
            self.progress[i] = Progress::Solved;
            settings.gravity * step
        } else {
            if !bodies.local.is_on {
                self.carriers.push(slot);
            }
            Vec3::ZERO
        };
        let shift = match driven {
            Some(shift) => shift,
            None => {
                let shift = step * (body.linear + 0.5 * fall);
                body.linear += fall;
                shift
            }
        };
        let rotation = match spin {
            Some(spin) => {
                spinning.slots[spinning.spins.len()] = slot;
                spinning.spins.push(spin, body.angular);
                bodies.rotation[i]
            }
            None => rotate_by(bodies.rotation[i], body.angular, step),
        };
        bodies.motion[i] = Motion { shift, rotation };
        if spinning.spins.len() == SPINS {
            spinning.turn(bodies, settings);
        }
    }

    /// How far a body that is driven moves, m; it has the velocities of the end of the step then. By the mean of the velocities
    /// before and after each sub-step, which is the parabola where nothing brakes.
    fn drive_free_body(
        &self,
        bodies: &mut Bodies,
        slot: u32,
        settings: &SubstepSettings,
    ) -> Option<Vec3> {
        if bodies.drives.is_empty() {
            return None;
        }
        let drive = bodies.drive_of(slot, settings.gravity)?;
        let body = &mut bodies.velocity[slot as usize];
        let (h, mut shift) = (settings.substep_dt, Vec3::ZERO);
        drive.restrain(&mut body.linear, &mut body.angular);
        for _ in 0..settings.substeps {
            let before = body.linear;
            body.linear += h * settings.gravity;
            drive.advance(&mut body.linear, &mut body.angular, h);
            drive.restrain(&mut body.linear, &mut body.angular);
            shift += 0.5 * h * (before + body.linear);
        }
        Some(shift)
    }
}

/// Bodies that touch nothing and must be followed within the step, until there are enough to be turned together.
#[derive(Default)]
struct Spinning {
    slots: [u32; SPINS],
    spins: FreeRotations,
}

impl Spinning {
    /// Turns them for the step, and begins anew.
    fn turn(&mut self, bodies: &mut Bodies, settings: &SubstepSettings) {
        for _ in 0..settings.substeps {
            self.spins.advance(settings.substep_dt, settings.lane_width);
        }
        for (slot, (spin, omega)) in self.slots.iter().zip(self.spins.iter()) {
            let i = *slot as usize;
            bodies.velocity[i].angular = omega;
            bodies.motion[i].rotation = spin.rotation;
        }
        *self = Self::default();
    }
}
