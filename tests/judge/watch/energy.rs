//! Energy never rises, seen from a floor that moves steadily.
//!
//! What may rise for a while is what soft contacts store: they sag by 1.25e-4 of an extent under a load, and the step is of
//! first order in what turns, so that a bound of 1e-3 of all the energy there is is some ten times what a right step
//! needs. Rounding of `f32` velocities is 1e-7 of it. Restitution takes energy and never gives any.
//!
//! Where restitution is 1 and nothing rubs, energy does not fall either, by more than 1 % in the whole time.

use super::Worst;
use crate::judge::laws::{Breach, Law};
use crate::judge::run::Run;
use glam::DVec3;

/// Rise above the least so far, as a share of all the energy that the scene starts with.
const RISE: f64 = 1e-3;

/// Loss in a scene without losses, as a share of the same.
const LOSS: f64 = 1e-2;

pub(super) struct Energy {
    /// Velocity of the floor, m/s.
    frame: DVec3,
    gravity: DVec3,
    /// Kinetic energy and weight times height above the lowest body, J.
    all: f64,
    /// Energy at the start and the least until now, J.
    start: f64,
    least: f64,
    rise: Worst,
    loss: Worst,
}

impl Energy {
    pub(super) fn new(run: &Run<'_>) -> Self {
        let mut actors = run.scene.actors.iter();
        let floor = actors.find(|actor| !actor.is_dynamic());
        let mut energy = Self {
            frame: floor.map_or(DVec3::ZERO, |floor| floor.linear.as_dvec3()),
            gravity: run.scene.gravity.as_dvec3(),
            all: 0.0,
            start: 0.0,
            least: 0.0,
            rise: Worst::default(),
            loss: Worst::default(),
        };
        let depth = |slot| energy.gravity.dot(run.state(slot).center);
        let deepest = run
            .dynamic()
            .fold(f64::MIN, |deep, (_, slot, _)| deep.max(depth(slot)));
        energy.start = energy.sum(run, 0);
        energy.least = energy.start;
        // From where the deepest lies, and as far below it as each body reaches.
        let below = run.dynamic().map(|(_, slot, _)| {
            let (mass, _) = run.inertia(slot);
            let (_, radius) = run.size(slot);
            mass * (energy.gravity.length() * radius + deepest)
        });
        energy.all = energy.least + below.sum::<f64>();
        energy
    }

    /// Kinetic and potential energy in the frame of the floor after `step` steps, J.
    fn sum(&self, run: &Run<'_>, step: u32) -> f64 {
        let time = f64::from(step) * f64::from(run.scene.step_length());
        let bodies = run.dynamic().map(|(_, slot, _)| {
            let state = run.state(slot);
            let (mass, inertia) = run.inertia(slot);
            let kinetic = mass * (state.linear - self.frame).length_squared()
                + state.angular.dot(inertia * state.angular);
            let fallen = self.gravity.dot(state.center - time * self.frame);
            0.5 * kinetic - mass * fallen
        });
        bodies.sum()
    }

    pub(super) fn look(&mut self, run: &Run<'_>, step: u32) {
        let now = self.sum(run, step);
        let rise = now - self.least;
        self.rise.note(rise / (RISE * self.all), step, 0);
        let loss = self.start - now;
        self.loss.note(loss / (LOSS * self.all), step, 0);
        self.least = self.least.min(now);
    }

    /// Whether energy rose.
    pub(super) fn breach(&self) -> Option<Breach> {
        self.rise.breach(Law::Energy, |worst| {
            let share = RISE * worst.excess;
            format!(
                "rises by {share:.1e} of all there is until step {}",
                worst.step
            )
        })
    }

    /// Whether energy was lost where nothing takes any.
    pub(super) fn loss(&self) -> Option<Breach> {
        self.loss.breach(Law::Elastic, |worst| {
            let share = LOSS * worst.excess;
            format!(
                "loses {share:.1e} of all there is until step {}",
                worst.step
            )
        })
    }
}
