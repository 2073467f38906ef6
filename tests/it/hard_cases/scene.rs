//! Scenes that are put together body by body.

use super::support::simulation;
use crate::common::structures::floor;
use bevy_cleave::prelude::*;

/// A simulation of a floor at height 0 with friction `mu`.
pub(crate) fn with_floor(mu: f32) -> Simulation {
    simulation([floor(mu)])
}

/// Adds a body and returns its slot.
pub(crate) fn add(simulation: &mut Simulation, desc: BodyDesc) -> u32 {
    simulation.bodies.insert(desc).expect("usable body")
}

/// Computes the masses, which the first step would do, so that energies can be measured before it.
pub(crate) fn weigh(simulation: &mut Simulation) {
    bevy_cleave::step::mass_properties(&mut simulation.bodies, &mut simulation.report);
}
