//! Planks in the harmonic overhang (case 11).

use crate::structures::corbel;
use crate::support::{displacement, frames, run, simulation};

/// How far a plank has moved after `seconds`, m.
fn moved(fraction: f64, seconds: f64) -> f32 {
    let mut simulation = simulation(corbel(10, fraction));
    let start = frames(&simulation);
    run(&mut simulation, seconds);
    displacement(&simulation, &start)
}

/// Hard because every plank balances within a few millimetres of its edge, and the one at the bottom carries ten: the
/// overhang of N planks of length L is at most `L/2 H_N` (harmonic number), 1.464484 m for ten.
#[test]
fn corbel_stands_at_97_percent_of_the_harmonic_overhang_and_falls_at_103() {
    let (inside, beyond) = (moved(0.97, 10.0), moved(1.03, 5.0));
    println!(
        "case 11: at 97 % moved {:.3} mm, at 103 % {beyond:.2} m",
        1e3 * inside
    );
    assert!(inside < 0.01, "moved {inside} m");
    assert!(beyond > 0.2, "moved {beyond} m only");
}
