//! What the choice of the defaults rests on, measured.

use crate::measure::{H, displacement, frames, kinetic_energy, simulation_with, steps};
use crate::settings::{fixed, soft};
use crate::structures::{mass_ratio, tower};
use bevy_cleave::prelude::*;

/// A tower of 10 with a stiffness of its contacts.
pub(crate) struct Noise {
    /// [`SolverConfig::contact_frequency`].
    pub(crate) frequency: f32,
    /// Largest kinetic energy in the last 5 of 10 s, J.
    pub(crate) energy: f64,
    /// Largest displacement, m.
    pub(crate) moved: f32,
}

/// A tower of 10 for several stiffnesses, 8 sub-steps of 1 + 1 sweeps.
pub(crate) fn noise() -> [Noise; 4] {
    [0.15, 0.2, 0.25, 0.3].map(|frequency| {
        let config = SoftStep {
            contact_frequency: frequency,
            ..soft(8, 1)
        }
        .into();
        let (moved, energy) = rest(config, tower(10));
        Noise {
            frequency,
            energy,
            moved,
        }
    })
}

/// Numbers of sub-steps in the table of the sag.
pub(crate) const SUBSTEPS: [u32; 4] = [8, 16, 32, 64];
/// Loads in it, as multiples of the mass of the cubes below.
pub(crate) const LOADS: [f32; 3] = [10.0, 100.0, 1000.0];

/// Largest displacement (m) in 10 s of four cubes under a load, for each load and number of sub-steps of 4 + 4 sweeps.
pub(crate) fn sag() -> [[f32; 4]; 3] {
    LOADS.map(|load| SUBSTEPS.map(|n| rest(fixed(n, 4), mass_ratio(load)).0))
}

/// Largest displacement (m) in 10 s, and largest kinetic energy in the second half, J.
fn rest(config: SolverConfig, bodies: Vec<BodyDesc>) -> (f32, f64) {
    let mut simulation = simulation_with(config, bodies);
    let start = frames(&simulation);
    let (mut moved, mut energy, count) = (0.0_f32, 0.0_f64, steps(10.0));
    for k in 0..count {
        simulation.step(H);
        moved = moved.max(displacement(&simulation, &start));
        if 2 * k >= count {
            energy = energy.max(kinetic_energy(&simulation));
        }
    }
    (moved, energy)
}
