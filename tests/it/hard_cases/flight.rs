//! Free flight (case 3) and free tumbling (case 14).

use super::support::{G, H, energy, run, simulation, spin, steps, weightless};
use crate::common::structures::{block, cuboid};
use glam::{DVec3, Vec3};

/// Hard because semi-implicit Euler falls 16 cm too deep in 2 s of steps of 1/60 s; under constant acceleration the way is
/// `g t^2 / 2 = 19.62 m` and can be integrated exactly.
#[test]
fn free_fall_is_exact() {
    let mut simulation = simulation([block(&cuboid(Vec3::ONE), Vec3::ZERO, 0.5)]);
    run(&mut simulation, 2.0);
    let fallen = -f64::from(simulation.bodies.center_of_mass(0).y);
    let error = fallen / (2.0 * G) - 1.0;
    println!("case 3: fell {fallen:.5} m in 2 s, {error:+.1e}");
    assert!(error.abs() < 1e-5, "fell {fallen} m, not {} m", 2.0 * G);
}

/// Hard because the way is 200 m and the error of a step adds up 120 times: `v t + g t^2 / 2`.
#[test]
fn projectile_is_exact() {
    let speed = 100.0 * DVec3::new(0.6, 0.8, 0.0);
    let mut shot = block(&cuboid(Vec3::ONE), Vec3::ZERO, 0.5);
    shot.linear_velocity = speed.as_vec3();
    let mut simulation = simulation([shot]);
    run(&mut simulation, 2.0);
    let exact = 2.0 * speed - 2.0 * G * DVec3::Y;
    let error = (simulation.bodies.center_of_mass(0).as_dvec3() - exact).length() / exact.length();
    println!("case 3: projectile {error:.1e} off");
    assert!(error < 1e-5, "{error} off {exact}");
}

/// Hard because an explicit gyroscopic term gains energy without bound, an implicit one damps the flips away and none never
/// flips; the spin about the middle axis changes sign every 2.718776 s, first after 1.59136 s (elliptic integral).
#[test]
fn dzhanibekov_box_keeps_momentum_and_energy_and_flips_for_a_minute() {
    let mut body = block(&cuboid(Vec3::new(1.0, 0.5, 0.2)), Vec3::ZERO, 0.5);
    body.angular_velocity = Vec3::new(0.01, 10.0, 0.01);
    let mut simulation = weightless([body]);
    simulation.step(1e-9);
    let (l0, e0) = (spin(&simulation, 0), energy(&simulation));
    let (mut worst_l, mut worst_direction, mut worst_e) = (0.0_f64, 0.0_f64, 0.0_f64);
    let (mut crossings, mut last) = (Vec::new(), 10.0_f64);
    for k in 0..steps(60.0) {
        simulation.step(H);
        let (l, e) = (spin(&simulation, 0), energy(&simulation));
        worst_l = worst_l.max((l.length() / l0.length() - 1.0).abs());
        worst_direction = worst_direction.max((l - l0).length() / l0.length());
        worst_e = worst_e.max((e / e0 - 1.0).abs());
        let (_, omega) = simulation.bodies.velocity(0);
        let middle = f64::from((simulation.bodies.pose(0).rotation.inverse() * omega).y);
        if middle * last < 0.0 {
            crossings.push((k as f64 + last / (last - middle)) * f64::from(H));
        }
        last = middle;
    }
    println!(
        "case 14: |L| {worst_l:.1e}, L {worst_direction:.1e}, energy {worst_e:.1e}, {} flips, at {:.3?} s",
        crossings.len(),
        &crossings[..crossings.len().min(3)]
    );
    assert!(worst_l < 1e-3, "|L| changed by {worst_l}");
    assert!(worst_e < 1e-2, "energy changed by {worst_e}");
    // Rounding decides how near to the middle axis each flip ends, and with that when the next one comes.
    assert!(crossings.len() >= 22, "{} flips, not 22", crossings.len());
    let (first, last) = (crossings[0], crossings[crossings.len() - 1]);
    assert!(last > 56.0, "the last flip came after {last} s");
    assert!(
        (first / 1.59136 - 1.0).abs() < 0.02,
        "first flip after {first} s"
    );
}
