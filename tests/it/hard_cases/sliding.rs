//! Sliding to a stop (case 2).

use super::support::{G, H, discrete_stop, run, simulation_with, substep};
use crate::common::structures::sliding_box;
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Distance that a unit cube with friction 0.5 slides from 10 m/s at `heading` degrees to its own axes, m.
fn stop(config: SolverConfig, heading: f64) -> f64 {
    let mut simulation = simulation_with(config, sliding_box(0.5, 10.0, heading));
    run(&mut simulation, 3.0);
    let (v, _) = simulation.bodies.velocity(1);
    assert!(v.length() < 1e-3, "still slides at {v}");
    let way = simulation.bodies.center_of_mass(1) - 0.5 * Vec3::Y;
    f64::from(way.length())
}

/// Hard because a pyramid of friction stops a box 29 % short along its diagonals; the distance is the sum of the speeds of
/// semi-implicit Euler at the sub-step, `h sum(v0 - k mu g h)`.
#[test]
fn sliding_cube_stops_where_the_discrete_formula_says_in_eight_directions() {
    let config = SolverConfig::default();
    let (exact, continuous) = (discrete_stop(10.0, 0.5 * G, substep(H)), 100.0 / G);
    let mut worst = 0.0_f64;
    for k in 0..8_u8 {
        let distance = stop(config, 45.0 * f64::from(k));
        let error = distance / exact - 1.0;
        println!(
            "case 2: {k} x 45 degrees: {distance:.5} m, {error:+.1e} of {exact:.5}, {:+.1e} of {continuous:.5}",
            distance / continuous - 1.0
        );
        worst = worst.max(error.abs());
    }
    assert!(worst < 1e-3, "{worst:.1e} off {exact} m");
}

/// Hard for nobody: it shows that the case tells the models apart. Two independent bounds of `mu n` give
/// `mu sqrt(2)` along the diagonal, so the cube stops at `v^2 / (2 sqrt(2) mu g)`, 29 % short.
#[test]
fn box_friction_stops_a_cube_short_along_its_diagonal_by_a_factor_of_the_square_root_of_two() {
    let boxed = Pgs {
        substeps: SoftStep::default().min_substeps,
        friction: FrictionModel::Box,
        ..Pgs::default()
    };
    let config = boxed.into();
    let exact = discrete_stop(10.0, 0.5 * G * 2.0_f64.sqrt(), substep(H));
    let distance = stop(config, 45.0);
    println!("case 2: box friction, 45 degrees: {distance:.5} m of {exact:.5}");
    assert!(
        (distance / exact - 1.0).abs() < 1e-2,
        "{distance} m, not {exact} m"
    );
}
