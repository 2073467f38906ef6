//! Pendulums keep their period and their energy.

use crate::common::scenes::awake;
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
    let mut simulation = awake();
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
    let mut simulation = awake();
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

/// Angles from the vertical and angular velocities of two bars of 1 m that hang on each other, and how these change:
/// `(4/3) t1'' + (1/2) cos(t1 - t2) t2'' = -(1/2) sin(t1 - t2) w2^2 - (3/2) g sin t1`,
/// `(1/3) t2'' + (1/2) cos(t1 - t2) t1'' = (1/2) sin(t1 - t2) w1^2 - (1/2) g sin t2`.
#[expect(
    clippy::disallowed_methods,
    reason = "a test may differ in the last bit"
)]
fn rates([t1, t2, w1, w2]: [f64; 4]) -> [f64; 4] {
    let (sine, cosine) = (t1 - t2).sin_cos();
    let g = 9.81;
    let b1 = -0.5 * sine * w2 * w2 - 1.5 * g * t1.sin();
    let b2 = 0.5 * sine * w1 * w1 - 0.5 * g * t2.sin();
    let (a11, a12, a22) = (4.0 / 3.0, 0.5 * cosine, 1.0 / 3.0);
    let determinant = a11 * a22 - a12 * a12;
    [
        w1,
        w2,
        (a22 * b1 - a12 * b2) / determinant,
        (a11 * b2 - a12 * b1) / determinant,
    ]
}

/// A step of Runge and Kutta's of the fourth order.
fn advance(state: [f64; 4], h: f64) -> [f64; 4] {
    let along = |rates: [f64; 4], h: f64| std::array::from_fn(|i| state[i] + h * rates[i]);
    let a = rates(state);
    let b = rates(along(a, 0.5 * h));
    let c = rates(along(b, 0.5 * h));
    let d = rates(along(c, h));
    std::array::from_fn(|i| state[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]))
}

#[test]
#[expect(
    clippy::disallowed_methods,
    reason = "a test may differ in the last bit"
)]
fn a_double_pendulum_follows_its_equations_for_five_seconds() {
    for (start, bound) in [([0.2, 0.3], 1e-3), ([1.2, 0.4], 1e-2)] {
        let mut simulation = awake();
        let (mut last, mut at) = (None, Vec3::ZERO);
        let mut slots = Vec::new();
        for angle in start {
            let down = Vec3::new(f32::sin(angle), -f32::cos(angle), 0.0);
            // Thin, so that the moment is that of a rod to 1e-6.
            let mut bar = heavy(Vec3::new(1e-3, 1.0, 1e-3), at + 0.5 * down, 1.0);
            bar.pose.rotation = glam::Quat::from_rotation_z(angle);
            let slot = simulation.bodies.insert(bar).expect("usable");
            let pose = |slot: Option<u32>| match slot {
                Some(slot) => simulation.bodies.pose(slot),
                None => Pose::IDENTITY,
            };
            let joint = Joint::hinge().with_anchor(at, Vec3::Z, [pose(last), pose(Some(slot))]);
            simulation.join(last, slot, joint).expect("usable");
            at += down;
            last = Some(slot);
            slots.push(slot);
        }
        let mut state = [f64::from(start[0]), f64::from(start[1]), 0.0, 0.0];
        let mut worst = 0.0_f64;
        for _ in 0..300 {
            simulation.step(H);
            for _ in 0..40 {
                state = advance(state, 1.0 / 2400.0);
            }
            let [first, second] = [state[0], state[1]].map(f64::sin_cos);
            let end = glam::DVec3::new(first.0 + second.0, -first.1 - second.1, 0.0);
            let tip = crate::scene::point(&simulation, slots[1], Vec3::new(0.0, -0.5, 0.0));
            worst = worst.max(tip.distance(end));
        }
        println!("double pendulum from {start:?}: off by {worst:e} m in 5 s");
        assert!(worst < bound, "{start:?}: {worst} m");
    }
}
