//! How bodies move that touch nothing.

use super::bodies::{Bodies, Motion};
use super::contact_solver::{ContactSolver, Progress};
use super::demand::SubstepSettings;
use super::spin::{SPINS, Spin};
use crate::math::rotate_by;
use glam::Vec3;

impl ContactSolver {
    /// Moves the bodies that touch nothing, exactly under constant acceleration: `x += h v + h^2 g / 2`.
    pub(super) fn move_free_bodies(&mut self, bodies: &mut Bodies, settings: &SubstepSettings) {
        let step = settings.step();
        let mut spinning = Spinning::default();
        for slot in 0..bodies.slots() as u32 {
            let i = slot as usize;
            if self.progress[i] != Progress::Open || !bodies.is_moving(slot) {
                continue;
            }
            let spin = bodies.spin(slot, step);
            let body = &mut bodies.velocity[i];
            let fall = if body.inverse_mass > 0.0 {
                self.progress[i] = Progress::Moved;
                settings.gravity * step
            } else {
                Vec3::ZERO
            };
            let shift = step * (body.linear + 0.5 * fall);
            body.linear += fall;
            let rotation = match spin {
                Some(spin) => {
                    spinning.push(slot, spin, body.angular);
                    bodies.rotation[i]
                }
                None => rotate_by(bodies.rotation[i], body.angular, step),
            };
            bodies.motion[i] = Motion { shift, rotation };
            if spinning.count == SPINS {
                spinning.turn(bodies, settings);
            }
        }
        spinning.turn(bodies, settings);
    }
}

/// Bodies that touch nothing and must be followed within the step, until there are enough to be turned together.
#[derive(Default)]
struct Spinning {
    count: usize,
    slots: [u32; SPINS],
    spins: [Spin; SPINS],
    omegas: [Vec3; SPINS],
}

impl Spinning {
    fn push(&mut self, slot: u32, spin: Spin, omega: Vec3) {
        self.slots[self.count] = slot;
        self.spins[self.count] = spin;
        self.omegas[self.count] = omega;
        self.count += 1;
    }

    /// Turns them for the step, and begins anew.
    fn turn(&mut self, bodies: &mut Bodies, settings: &SubstepSettings) {
        let config = &settings.config;
        for _ in 0..config.substeps {
            Spin::advance_some(
                &mut self.spins,
                &mut self.omegas,
                self.count,
                settings.h,
                config.lane_width,
            );
        }
        for lane in 0..self.count {
            let i = self.slots[lane] as usize;
            bodies.velocity[i].angular = self.omegas[lane];
            bodies.motion[i].rotation = self.spins[lane].rotation;
        }
        *self = Self::default();
    }
}
