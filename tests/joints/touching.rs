//! Joints and contacts of one island: contacts give no energy there either, and motors and springs are not denied theirs.

use crate::common::scenes::awake_on_floor;
use crate::scene::{H, chain, heavy};
use bevy_cleave::prelude::*;
use glam::Vec3;

fn insert(simulation: &mut Simulation, body: BodyDesc) -> u32 {
    simulation.bodies.insert(body).expect("usable")
}

fn energy(simulation: &Simulation) -> f64 {
    let bodies = &simulation.bodies;
    let dynamic = bodies
        .iter()
        .filter(|&slot| bodies.kind(slot) == RigidBody::Dynamic);
    let of = |slot| {
        let weight = 9.81 * f64::from(bodies.mass(slot).mass);
        bodies.kinetic_energy(slot) + weight * f64::from(bodies.center_of_mass(slot).y)
    };
    dynamic.map(of).sum()
}

/// Which joints a stack of laths has.
#[derive(Clone, Copy, Debug)]
enum Laths {
    Loose,
    /// A pendulum hangs on one of them.
    WithPendulum,
    /// Each slides on the next.
    Sliding,
}

/// A heavy block falls on a stack of laths: how fast it comes back, m/s, and the largest gain of energy in a step, as a share of what there was.
fn rebound(mass: f32, laths: Laths) -> (f32, f64) {
    let mut simulation = awake_on_floor();
    let lath = Vec3::new(2.0, 0.04, 0.3);
    let slots: Vec<u32> = (0..10_u8)
        .map(|i| {
            let at = Vec3::new(0.0, lath.y * (f32::from(i) + 0.5), 0.0);
            insert(&mut simulation, heavy(lath, at, 2.4))
        })
        .collect();
    match laths {
        Laths::Loose => {}
        Laths::WithPendulum => {
            let at = Vec3::new(1.5, 0.18, 0.0);
            let bob = insert(&mut simulation, heavy(Vec3::splat(0.1), at, 0.5));
            let joint = Joint::ball().with_anchors(Vec3::X, -0.5 * Vec3::X);
            simulation.join(Some(slots[4]), bob, joint).expect("usable");
        }
        Laths::Sliding => {
            let joint = Joint::slider()
                .with_axes(Vec3::Y, Vec3::Y)
                .with_contacts(true);
            for pair in slots.windows(2) {
                simulation
                    .join(Some(pair[0]), pair[1], joint)
                    .expect("usable");
            }
        }
    }
    let mut block = heavy(Vec3::splat(0.5), Vec3::new(0.0, 0.7, 0.0), mass);
    block.linear_velocity = Vec3::new(0.0, -8.0, 0.0);
    let block = insert(&mut simulation, block);
    let (mut fastest, mut gain) = (0.0_f32, 0.0_f64);
    simulation.step(H);
    let before = energy(&simulation);
    let mut last = before;
    for _ in 0..60 {
        simulation.step(H);
        let now = energy(&simulation);
        gain = gain.max((now - last) / before);
        last = now;
        fastest = fastest.max(simulation.bodies.velocity(block).0.y);
    }
    (fastest, gain)
}

/// Symptom: one joint in an island had switched the guard off for all of it, and a block of a tonne came back at 4 m/s.
#[test]
fn contacts_give_no_energy_where_there_are_joints() {
    for mass in [20.0, 155.0, 1000.0] {
        for laths in [Laths::Loose, Laths::WithPendulum, Laths::Sliding] {
            let (speed, gain) = rebound(mass, laths);
            println!("{mass} kg, {laths:?}: back at {speed} m/s, gains {gain:e} in a step");
            assert!(speed < 0.6, "{mass} {laths:?}: {speed}");
            assert!(gain < 0.02, "{mass} {laths:?}: {gain}");
        }
    }
}

/// A foot on the floor, and a load above it that slides along y.
fn jack(drive: JointDrive) -> (Simulation, u32) {
    let mut simulation = awake_on_floor();
    let foot = heavy(Vec3::new(1.0, 0.2, 1.0), Vec3::new(0.0, 0.1, 0.0), 2.0);
    let foot = insert(&mut simulation, foot);
    let load = heavy(Vec3::new(1.0, 0.5, 1.0), Vec3::new(0.0, 0.75, 0.0), 20.0);
    let load = insert(&mut simulation, load);
    let joint = Joint::slider()
        .with_axes(Vec3::Y, Vec3::Y)
        .with_anchors(Vec3::ZERO, Vec3::new(0.0, -0.65, 0.0))
        .with_linear_drive(drive);
    simulation.join(Some(foot), load, joint).expect("usable");
    (simulation, load)
}

/// Symptom: beside contacts the bounds of rows were forgotten half way through a sub-step, and motors, springs and limits bore nothing.
#[test]
fn a_motor_that_stands_on_the_floor_lifts_its_load_at_its_speed() {
    let (mut simulation, load) = jack(JointDrive::velocity(0.5, 1e4));
    for step in 0..120 {
        simulation.step(H);
        let speed = simulation.bodies.velocity(load).0.y;
        assert!(step < 2 || (speed - 0.5).abs() < 0.005, "{step}: {speed}");
    }
    let height = simulation.bodies.center_of_mass(load).y;
    assert!((height - 1.75).abs() < 0.02, "{height}");
}

/// A spring of 20 kN/m that is compressed by 0.2 m under 20 kg: while the foot stands, the load moves as if on the ground.
#[test]
fn a_spring_that_stands_on_the_floor_throws_its_load_with_its_energy() {
    let spring = JointSpring::Coefficients {
        stiffness: 2e4,
        damping: 0.0,
    };
    let (mut simulation, load) = jack(JointDrive::spring(0.2, spring));
    let mut fastest = 0.0_f32;
    for _ in 0..30 {
        simulation.step(1.0 / 240.0);
        fastest = fastest.max(simulation.bodies.velocity(load).0.y);
    }
    // Until the spring bears nothing but the weight.
    let lift = 0.2 - 20.0 * 9.81 / 2e4;
    let expected = lift * (2e4_f32 / 20.0).sqrt();
    println!("thrown at {fastest} m/s, expected {expected}");
    assert!(
        (fastest / expected - 1.0).abs() < 0.02,
        "{fastest} {expected}"
    );
}

#[test]
fn reports_know_how_far_joints_are_from_solved() {
    let mut chain = chain(10, 100.0, Vec3::X, Vec3::ZERO);
    chain.simulation.config.measure_error = true;
    for _ in 0..30 {
        chain.simulation.step(H);
        let residual = chain.simulation.report.error.expect("asked for").residual;
        // Velocities are rounded to single precision behind the solution.
        assert!(
            residual.relative > 0.0 && residual.relative < 1e-4,
            "{residual:?}"
        );
        assert!(residual.velocity_error < 0.01, "{residual:?}");
    }
}
