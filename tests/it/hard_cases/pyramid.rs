//! A pyramid of cubes (case 8).

use super::support::{
    G, H, displacement, frames, movable, normal_impulse, penetration, simulation, steps,
};
use crate::common::structures::pyramid;
use bevy_cleave::prelude::*;
use std::time::{Duration, Instant};

/// Hard because 1275 cubes share their loads in countless ways and errors run through fifty rows; at rest nothing moves and
/// the floor carries the weight.
#[test]
fn pyramid_of_base_fifty_stands() {
    let mut simulation = simulation(pyramid(50));
    let start = frames(&simulation);
    let (mut deepest, mut moved, mut reaction) = (0.0_f32, 0.0_f32, 0.0_f64);
    let mut times: Vec<Duration> = Vec::new();
    let count = steps(10.0);
    for k in 0..count {
        let before = Instant::now();
        simulation.step(H);
        times.push(before.elapsed());
        moved = moved.max(displacement(&simulation, &start));
        deepest = deepest.max(penetration(&simulation));
        if 10 * k >= 9 * count {
            reaction += 10.0 * floor_load(&simulation) / count as f64;
        }
    }
    times.sort();
    println!(
        "case 8: moved {:.2} mm, penetration {:.2} mm, floor carries {:+.1e} off, p50 {:.2?}, {} contacts",
        1e3 * moved,
        1e3 * deepest,
        reaction - 1.0,
        times[count / 2],
        simulation.report.contacts
    );
    assert!(moved < 0.01, "a cube moved {moved} m");
    assert!(deepest < 5e-3, "{deepest} m deep");
    assert!(
        (reaction - 1.0).abs() < 5e-3,
        "the floor carries {reaction} of the weight"
    );
}

/// What the floor (slot 0) carries as a share of the weight of all bodies.
fn floor_load(simulation: &Simulation) -> f64 {
    let slots = movable(simulation);
    let mass: f64 = slots
        .iter()
        .map(|&s| f64::from(simulation.bodies.mass(s).mass))
        .sum();
    let carried: f64 = slots
        .iter()
        .map(|&s| f64::from(normal_impulse(simulation, 0, s)))
        .sum();
    carried / (mass * G * f64::from(H))
}

/// Hard because errors add up: Box3D's comment on its own pyramid of base 80 says that it falls after 1000 steps.
#[test]
fn pyramid_of_base_eighty_stands_for_1200_steps() {
    assert_stands(80, 1200);
}

/// Nearly three minutes.
#[test]
fn pyramid_of_base_twenty_stands_for_ten_thousand_steps() {
    assert_stands(20, 10_000);
}

fn assert_stands(base: usize, count: usize) {
    let mut simulation = simulation(pyramid(base));
    let start = frames(&simulation);
    let mut moved = 0.0_f32;
    for k in 1..=count {
        simulation.step(H);
        if k % 100 == 0 {
            moved = moved.max(displacement(&simulation, &start));
            assert!(
                moved < 0.1,
                "base {base}: a cube moved {moved} m within {k} steps"
            );
        }
    }
    println!(
        "case 8: base {base}: moved {:.2} mm within {count} steps",
        1e3 * moved
    );
}
