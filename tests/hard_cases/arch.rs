//! A masonry arch (case 10).

use crate::structures::arch;
use crate::support::{displacement, frames, run, simulation};

/// How far a stone of an arch of 15 has moved after 10 s, m.
fn moved(thickness: f64, mu: f32) -> f32 {
    let mut simulation = simulation(arch(15, thickness, mu));
    let start = frames(&simulation);
    run(&mut simulation, 10.0);
    displacement(&simulation, &start)
}

/// Hard because a line of thrust must stay inside a ring a tenth as thick as its radius, so a soft contact opens hinges; 15
/// voussoirs need 0.1061 of the radius (Milankovitch 1907; limit analysis by linear programming).
#[test]
fn arch_stands_a_tenth_above_the_least_thickness_and_falls_a_tenth_below_it() {
    let [thick, thin] = [0.117, 0.095].map(|thickness| moved(thickness, 0.9));
    println!(
        "case 10: at t/R 0.117 moved {:.3} mm, at 0.095 {thin:.2} m",
        1e3 * thick
    );
    assert!(thick < 0.01, "moved {thick} m");
    assert!(thin > 0.1, "moved {thin} m only");
}

/// Hard because the stones at the springing slide on each other at almost the friction that holds them; at 0.15 of the
/// radius 15 voussoirs need 0.3484 (limit analysis).
#[test]
fn arch_stands_a_tenth_above_the_least_friction_and_slides_a_tenth_below_it() {
    let [rough, smooth] = [0.38, 0.32].map(|mu| moved(0.15, mu));
    println!(
        "case 10: at mu 0.38 moved {:.3} mm, at 0.32 {smooth:.2} m",
        1e3 * rough
    );
    assert!(rough < 0.01, "moved {rough} m");
    assert!(smooth > 0.1, "moved {smooth} m only");
}
