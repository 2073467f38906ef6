//! Pendulums keep their period and their energy.

use crate::scene::{H, heavy};
use bevy_cleave::prelude::*;
use glam::Vec3;

fn energy(simulation: &Simulation, slot: u32) -> f64 {
    let mass = f64::from(simulation.bodies.mass(slot).mass);
    simulation.bodies.kinetic_energy(slot)
        + mass * 9.81 * f64::from(simulation.bodies.center_of_mass(slot).y)
}

#[test]
fn a_bar_released_level_keeps_period_and_energy_for_a_minute() {
    let mut simulation = Simulation::default();
    let slot = simulation
        .bodies
        .insert(heavy(Vec3::new(2.0, 0.2, 0.2), Vec3::X, 80.0))
        .expect("usable");
    let poses = [Pose::IDENTITY, simulation.bodies.pose(slot)];
    let hinge = Joint::hinge().with_anchor(Vec3::ZERO, Vec3::Z, poses);
    let id = simulation.join(None, slot, hinge).expect("usable");
    // 4 K(sin 45 deg) sqrt(I / (m g l)), I = m (4 + 0.04) / 12 + m.
    let inertia: f64 = (4.0 + 0.04) / 12.0 + 1.0;
    let period = 4.0 * 1.854_074_677_301_372 * (inertia / 9.81_f64).sqrt();
    let mut crossings = Vec::new();
    let mut last = 0.0_f64;
    let (mut least, mut most) = (0.0_f64, 0.0_f64);
    for step in 0..3600 {
        simulation.step(H);
        let angle = f64::from(simulation.joints.load(id).expect("there").angle);
        let middle = -std::f64::consts::FRAC_PI_2;
        if last > middle && angle <= middle {
            let part = (last - middle) / (last - angle);
            crossings.push((f64::from(step) + part) / 60.0);
        }
        last = angle;
        let now = energy(&simulation, slot);
        least = least.min(now);
        most = most.max(now);
    }
    let measured = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
    let scale = 80.0 * 9.81;
    println!(
        "period {measured} of {period}; energy {:e} {:e}",
        least / scale,
        most / scale
    );
    assert!(
        (measured / period - 1.0).abs() < 1e-3,
        "{measured} of {period}"
    );
    assert!(most - least < 0.01 * scale, "{least} to {most} J");
}

#[test]
fn a_gyroscope_on_a_ball_joint_precesses_level_at_the_rate_of_its_spin() {
    let mut simulation = Simulation::default();
    // A disc of square section, half a meter from the joint: I_3 = m / 6; precession at m g d / (I_3 s).
    let (spin, rate) = (60.0_f32, 0.5 * 9.81 * 6.0 / 60.0_f32);
    let mut disc = heavy(Vec3::new(0.1, 1.0, 1.0), Vec3::new(0.5, 0.0, 0.0), 2.0);
    disc.angular_velocity = Vec3::new(spin, rate, 0.0);
    disc.linear_velocity = Vec3::new(0.0, 0.0, -0.5 * rate);
    let slot = simulation.bodies.insert(disc).expect("usable");
    let joint = Joint::ball().with_anchors(Vec3::ZERO, Vec3::new(-0.5, 0.0, 0.0));
    simulation.join(None, slot, joint).expect("usable");
    let (mut turned, mut last) = (0.0_f64, Vec3::X);
    for _ in 0..300 {
        simulation.step(H);
        let now = simulation.bodies.center_of_mass(slot).normalize();
        turned += f64::from(last.cross(now).y);
        last = now;
        assert!(now.y.abs() < 0.01, "not level: {now}");
    }
    let expected = f64::from(rate) * 5.0;
    println!("gyroscope: turned by {turned} of {expected} rad");
    assert!(
        (turned / expected - 1.0).abs() < 0.01,
        "{turned} of {expected}"
    );
}
