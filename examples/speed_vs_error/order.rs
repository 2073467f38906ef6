//! Order of convergence: the exact method in ever shorter steps, on motions that are smooth.

use crate::measure::{G, H, simulation_with};
use crate::structures::{DOMINO, domino, floor, sliding_box};
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Shares of the step that are tried.
pub(crate) const PARTS: [u8; 4] = [1, 2, 4, 8];

/// A motion and its errors.
pub(crate) struct Convergence {
    pub(crate) title: &'static str,
    /// Errors in steps of `H / PARTS`.
    pub(crate) errors: [f64; 4],
}

impl Convergence {
    /// Orders from each step to the next shorter one: 1 halves the error where the step is halved.
    pub(crate) fn orders(&self) -> [f64; 3] {
        let e = &self.errors;
        [0, 1, 2].map(|i| (e[i] / e[i + 1]).log2())
    }
}

pub(crate) fn measure() -> [Convergence; 2] {
    [
        Convergence {
            title: "cube that slides with 10 m/s on friction 0.5: place after 1 s, m",
            errors: PARTS.map(|n| slide(H / f32::from(n))),
        },
        Convergence {
            title: "domino that falls about its edge: lean after 0.4 s, rad",
            errors: PARTS.map(|n| fall(H / f32::from(n))),
        },
    ]
}

/// Error of `v t - mu g t^2 / 2`.
fn slide(h: f32) -> f64 {
    let mut simulation = simulation_with(SolverConfig::exact(), sliding_box(0.5, 10.0, 0.0));
    let steps = (1.0 / h).round() as usize;
    (0..steps).for_each(|_| simulation.step(h));
    (f64::from(simulation.bodies.center_of_mass(1).x) - (10.0 - 0.25 * G)).abs()
}

/// Error of the pendulum that stands on its head, `(h^2 + d^2) / 3 phi'' = g (h sin phi - d cos phi) / 2`, from 15 degrees
/// with 0.5 rad/s.
fn fall(h: f32) -> f64 {
    let (lean, rate, seconds) = (15.0_f32.to_radians(), 0.5_f32, 0.4);
    let bodies = [floor(0.6), domino(0.0, lean, rate)];
    let mut simulation = simulation_with(SolverConfig::exact(), bodies);
    let steps = (seconds / f64::from(h)).round() as usize;
    (0..steps).for_each(|_| simulation.step(h));
    let up = simulation.bodies.pose(1).rotation * Vec3::Y;
    let exact = pendulum(f64::from(lean), f64::from(rate), seconds);
    (f64::from(up.x).asin() - exact).abs()
}

/// Lean after `seconds`, by midpoint steps of 10 us.
fn pendulum(lean: f64, rate: f64, seconds: f64) -> f64 {
    let (d, h) = (f64::from(DOMINO.x), f64::from(DOMINO.y));
    let rise = |phi: f64| 1.5 * G * (h * phi.sin() - d * phi.cos()) / (h * h + d * d);
    let dt = 1e-5;
    let (mut phi, mut rate) = (lean, rate);
    for _ in 0..(seconds / dt).round() as usize {
        let (middle, middle_rate) = (phi + 0.5 * dt * rate, rate + 0.5 * dt * rise(phi));
        phi += dt * middle_rate;
        rate += dt * rise(middle);
    }
    phi
}
