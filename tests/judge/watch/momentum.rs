//! Momentum stays where nothing acts from outside.
//!
//! Equal and opposite impulses on two `f32` velocities leave what rounding leaves: 6e-8 of a velocity for each of some 1e4
//! updates, added up like a random walk, 1e-5 of the sum of all momenta. Angular momentum about the common center is only
//! kept as well as the two bodies' contact points stay together within a step: bound 1e-2 of the sum of all.

use super::Worst;
use crate::judge::laws::{Breach, Law};
use crate::judge::run::Run;
use glam::DVec3;

/// Bounds as shares of the sums of the bodies' own momenta.
const LINEAR: f64 = 1e-4;
const ANGULAR: f64 = 1e-2;

pub(super) struct Momentum {
    at_start: [DVec3; 2],
    /// Sums of the absolute values at the start, kg m/s and kg m2/s.
    sizes: [f64; 2],
    linear: Worst,
    angular: Worst,
}

impl Momentum {
    pub(super) fn new(run: &Run<'_>) -> Self {
        let [momenta, spins] = [0, 1].map(|which| {
            let each = momenta(run).into_iter().map(|both| both[which]);
            each.collect::<Vec<_>>()
        });
        Self {
            at_start: [momenta.iter().sum(), spins.iter().sum()],
            sizes: [momenta, spins].map(|each| each.iter().map(|m| m.length()).sum()),
            linear: Worst::default(),
            angular: Worst::default(),
        }
    }

    pub(super) fn look(&mut self, run: &Run<'_>, step: u32) {
        let [mut linear, mut angular] = self.at_start.map(|at_start| -at_start);
        for [momentum, spin] in momenta(run) {
            linear += momentum;
            angular += spin;
        }
        let [momenta, spins] = self.sizes;
        let linear = linear.length() / (LINEAR * momenta).max(f64::MIN_POSITIVE);
        let angular = angular.length() / (ANGULAR * spins).max(f64::MIN_POSITIVE);
        self.linear.note(linear, step, 0);
        self.angular.note(angular, step, 0);
    }

    pub(super) fn breach(&self) -> Option<Breach> {
        let say = |name: &str, bound: f64, worst: &Worst| {
            let share = bound * worst.excess;
            format!("{name} off by {share:.1e} in step {}", worst.step)
        };
        let linear = self
            .linear
            .breach(Law::Momentum, |worst| say("linear", LINEAR, worst));
        let angular = self
            .angular
            .breach(Law::Momentum, |worst| say("angular", ANGULAR, worst));
        linear.or(angular)
    }
}

/// Momentum, and angular momentum about the common center of mass, of each body.
fn momenta(run: &Run<'_>) -> Vec<[DVec3; 2]> {
    let bodies = run.dynamic().map(|(_, slot, _)| {
        let (mass, inertia) = run.inertia(slot);
        (mass, inertia, run.state(slot))
    });
    let bodies: Vec<_> = bodies.collect();
    let mass: f64 = bodies.iter().map(|(mass, ..)| mass).sum();
    let mean = |of: fn(&super::super::run::State) -> DVec3| {
        bodies.iter().map(|(m, _, s)| *m * of(s)).sum::<DVec3>() / mass
    };
    let (center, drift) = (mean(|s| s.center), mean(|s| s.linear));
    let each = bodies.iter().map(|(mass, inertia, state)| {
        let spin = *inertia * state.angular;
        let orbit = (state.center - center).cross(*mass * (state.linear - drift));
        [*mass * state.linear, spin + orbit]
    });
    each.collect()
}
