//! Planks in the harmonic overhang (case 11).

use super::support::{displacement, frames, run, simulation, threshold};
use crate::common::structures::corbel;

/// How far a plank has moved after 10 s, m.
fn moved(fraction: f64) -> f32 {
    let mut simulation = simulation(corbel(10, fraction));
    let start = frames(&simulation);
    run(&mut simulation, 10.0);
    displacement(&simulation, &start)
}

/// Hard because every plank balances within a few millimetres of its edge, and the one at the bottom carries ten: the
/// overhang of N planks of length L is at most `L/2 H_N` (harmonic number), 1.464484 m for ten.
#[test]
fn corbel_stands_at_97_percent_of_the_harmonic_overhang_and_falls_at_103() {
    let stands = |fraction: f64| {
        let moved = moved(fraction);
        println!(
            "case 11: at {fraction:.4} of the overhang moved {:.3} mm",
            1e3 * moved
        );
        moved < 0.01
    };
    let found = threshold(1.03, 0.97, stands);
    println!(
        "case 11: largest overhang {:+.1} % off",
        100.0 * (found - 1.0)
    );
}
