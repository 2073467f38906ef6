//! Limits, motors, springs and friction do what their equations say.

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use crate::scene::{H, Random, gap, heavy};
use bevy_cleave::prelude::*;
use glam::Vec3;
use std::ops::Range;

const G: f32 = 9.81;

/// Joints with friction that are tried: where what is asked of a step goes against what sticks, which is seldom.
const FRICTIONS: Range<u64> = 300..380;

/// A box of 2 kg on a slider along x, without gravity, 3 m from the origin.
fn slider(joint: Joint, velocity: f32) -> (Simulation, u32, JointId) {
    let mut simulation = awake();
    simulation.gravity.0 = Vec3::ZERO;
    let mut body = heavy(Vec3::ONE, Vec3::new(3.0, 0.0, 0.0), 2.0);
    body.linear_velocity.x = velocity;
    let slot = simulation.bodies.insert(body).expect("usable");
    let id = simulation.join(None, slot, joint).expect("usable");
    (simulation, slot, id)
}

fn place(simulation: &Simulation, slot: u32) -> f32 {
    simulation.bodies.center_of_mass(slot).x
}

#[test]
fn a_slider_stops_at_its_limits_and_comes_back_as_restitution_says() {
    for (velocity, end) in [(10.0, 7.0), (-10.0, -4.0)] {
        let joint = Joint::slider().with_linear_limits(-4.0, 7.0);
        let (mut simulation, slot, _) = slider(joint, velocity);
        for _ in 0..60 {
            simulation.step(H);
        }
        let (v, _) = simulation.bodies.velocity(slot);
        assert!(v.length() < 1e-4, "{v}");
        assert!((place(&simulation, slot) - end).abs() < 1e-4);
    }
    let mut joint = Joint::slider().with_linear_limits(-4.0, 7.0);
    joint.linear[0].restitution = 0.5;
    let (mut simulation, slot, _) = slider(joint, 10.0);
    for _ in 0..30 {
        simulation.step(H);
    }
    let (v, _) = simulation.bodies.velocity(slot);
    assert!((v.x + 5.0).abs() < 1e-3, "{v}");
}

#[test]
fn a_velocity_motor_accelerates_with_its_force_and_then_holds_its_speed() {
    let joint = Joint::slider().with_linear_drive(JointDrive::velocity(3.0, 4.0));
    let (mut simulation, slot, id) = slider(joint, 0.0);
    for _ in 0..60 {
        simulation.step(H);
    }
    let (v, _) = simulation.bodies.velocity(slot);
    assert!((v.x - 2.0).abs() < 1e-4, "{v}");
    let force = simulation.joints.load(id).expect("there").force;
    assert!((force.x - 4.0).abs() < 1e-3, "{force}");
    // x = a t^2 / 2
    assert!((place(&simulation, slot) - 4.0).abs() < 1e-4);
    for _ in 0..60 {
        simulation.step(H);
    }
    let (v, _) = simulation.bodies.velocity(slot);
    assert!((v.x - 3.0).abs() < 1e-4, "{v}");
}

#[test]
fn friction_brakes_with_its_force() {
    let mut joint = Joint::slider();
    joint.linear[0].friction = 4.0;
    let (mut simulation, slot, _) = slider(joint, 10.0);
    for _ in 0..120 {
        simulation.step(H);
    }
    let (v, _) = simulation.bodies.velocity(slot);
    assert!((v.x - 6.0).abs() < 1e-3, "{v}");
    // x = 10 t - a t^2 / 2
    assert!((place(&simulation, slot) - 19.0).abs() < 1e-3);
    for _ in 0..240 {
        simulation.step(H);
    }
    assert!(simulation.bodies.velocity(slot).0.length() < 1e-5);
}

#[test]
fn springs_swing_and_decay_as_their_closed_form_says() {
    for ratio in [0.0_f64, 0.1, 0.5, 1.0] {
        let spring = JointSpring::Frequency {
            hertz: 2.0,
            damping_ratio: ratio as f32,
        };
        let joint = Joint::slider().with_linear_drive(JointDrive::spring(0.0, spring));
        let (mut simulation, slot, _) = slider(joint, 0.0);
        let omega = std::f64::consts::TAU * 2.0;
        let mut worst = 0.0_f64;
        for step in 1..=120 {
            simulation.step(H);
            let expected = 3.0 * decay(omega, ratio, f64::from(step) / 60.0);
            worst = worst.max((f64::from(place(&simulation, slot)) - expected).abs());
        }
        println!(
            "spring, ratio {ratio}: off by {:e} of its amplitude",
            worst / 3.0
        );
        assert!(worst < 0.02 * 3.0, "{ratio}: {worst}");
    }
}

/// A power of ten with a random exponent.
#[expect(
    clippy::disallowed_methods,
    reason = "a test may differ in the last bit"
)]
fn decades(random: &mut Random, from: f32, to: f32) -> f32 {
    10.0_f32.powf(random.range(from, to))
}

/// Friction along and about all that a joint lets move, each as strong as it likes: which of it sticks turns at once where the motion does.
#[test]
fn friction_gives_no_energy() {
    let (mut gains, mut worst) = (0, 0.0_f64);
    for seed in FRICTIONS {
        let mut random = Random::new(seed);
        let mut simulation = awake();
        let length = random.range(0.2, 0.8);
        let mut joint =
            [Joint::rod(length), Joint::rope(length), Joint::ball()][(seed % 3) as usize];
        for axis in joint.linear.iter_mut().chain(&mut joint.angular) {
            if axis.range == AxisRange::Free {
                axis.friction = decades(&mut random, -2.0, 2.0);
            }
        }
        let mut body = heavy(
            random.vector(0.2, 0.8),
            Vec3::ZERO,
            decades(&mut random, 0.0, 2.0),
        );
        body.pose.rotation = random.rotation();
        body.linear_velocity = random.vector(-2.0, 2.0);
        body.angular_velocity = random.vector(-5.0, 5.0);
        let slot = simulation.bodies.insert(body).expect("usable");
        let at = Pose::new(random.vector(-0.4, 0.4), random.rotation());
        let poses = [Pose::IDENTITY, simulation.bodies.pose(slot)];
        let mut joint = joint.with_frame(at, poses);
        if joint.distance.range != AxisRange::Free {
            joint.frame_a.position += length * Vec3::Y;
        }
        simulation.join(None, slot, joint).expect("usable");
        let energy = |simulation: &Simulation| {
            let weight = 9.81 * f64::from(simulation.bodies.mass(slot).mass);
            let height = f64::from(simulation.bodies.center_of_mass(slot).y);
            (
                simulation.bodies.kinetic_energy(slot) + weight * height,
                weight,
            )
        };
        simulation.step(1.0 / 120.0);
        let (before, weight) = energy(&simulation);
        let mut gain = 0.0_f64;
        for _ in 0..240 {
            simulation.step(1.0 / 120.0);
            gain = gain.max((energy(&simulation).0 - before) / weight);
        }
        gains += usize::from(gain > 1e-2);
        worst = worst.max(gain);
    }
    println!("friction: {gains} gain more than a centimeter's height, the worst {worst:e} m");
    assert!(gains == 0, "{gains}, {worst}");
}

/// Amplitude at a time after release from rest.
#[expect(
    clippy::disallowed_methods,
    reason = "a test may differ in the last bit"
)]
fn decay(omega: f64, ratio: f64, t: f64) -> f64 {
    if ratio >= 1.0 {
        return (-omega * t).exp() * (1.0 + omega * t);
    }
    let root = (1.0 - ratio * ratio).sqrt();
    let phase = omega * root * t;
    (-ratio * omega * t).exp() * (phase.cos() + ratio / root * phase.sin())
}

#[test]
fn springs_are_stable_whatever_their_stiffness() {
    for stiffness in [1.0, 1e3, 1e6, 1e9, 1e12] {
        let spring = JointSpring::Coefficients {
            stiffness,
            damping: 0.0,
        };
        // Many on one body, and bodies on bodies.
        let mut simulation = awake();
        simulation.gravity.0 = Vec3::ZERO;
        let mut last = None;
        for i in 0..4 {
            let body = heavy(Vec3::splat(0.5), Vec3::new(i as f32 + 1.0, 0.0, 0.0), 1.0);
            let slot = simulation.bodies.insert(body).expect("usable");
            for at in [Vec3::Y, Vec3::Z, Vec3::NEG_Y, Vec3::NEG_Z, Vec3::X] {
                let joint = Joint::spring(0.8, spring).with_anchors(0.2 * at, 0.2 * at);
                simulation.join(last, slot, joint).expect("usable");
            }
            last = Some(slot);
        }
        let mut fastest = 0.0_f32;
        for _ in 0..600 {
            simulation.step(H);
            let of = |slot| simulation.bodies.velocity(slot).0.length();
            fastest = simulation.bodies.iter().map(of).fold(fastest, f32::max);
        }
        println!("stiffness {stiffness:e}: {fastest} m/s");
        // Each spring was too long by a fifth of a meter; a body of 1 kg got no more than all that these held.
        let stored = 0.5 * 20.0 * 0.2 * 0.2 * stiffness;
        assert!(fastest < (2.0 * stored).sqrt(), "{stiffness}: {fastest}");
    }
}

/// A bar of 1 m and 2 kg on a hinge about z at the origin, level.
fn crank(joint: Joint) -> (Simulation, u32, JointId) {
    let mut simulation = awake();
    let body = heavy(Vec3::new(1.0, 0.1, 0.1), Vec3::new(0.5, 0.0, 0.0), 2.0);
    let slot = simulation.bodies.insert(body).expect("usable");
    let poses = [Pose::IDENTITY, simulation.bodies.pose(slot)];
    let joint = joint.with_anchor(Vec3::ZERO, Vec3::Z, poses);
    let id = simulation.join(None, slot, joint).expect("usable");
    (simulation, slot, id)
}

#[test]
fn a_hinge_motor_holds_a_weight_with_the_torque_of_its_lever_and_stalls_beyond() {
    let torque = 2.0 * G * 0.5;
    let motor = |max| Joint::hinge().with_angular_drive(JointDrive::velocity(0.0, max));
    let (mut simulation, _, id) = crank(motor(2.0 * torque));
    for _ in 0..60 {
        simulation.step(H);
    }
    let load = *simulation.joints.load(id).expect("there");
    assert!((load.torque.z - torque).abs() < 0.01 * torque, "{load:?}");
    assert!(load.angle.abs() < 1e-4, "{load:?}");
    assert!((load.force.y - 2.0 * G).abs() < 0.01 * G, "{load:?}");
    // Too weak: it comes to swing about where the lever is short enough.
    let (mut simulation, _, id) = crank(motor(0.5 * torque));
    for _ in 0..60 {
        simulation.step(H);
        let load = simulation.joints.load(id).expect("there");
        assert!(load.torque.z <= 0.5 * torque * 1.001, "{load:?}");
    }
    assert!(simulation.joints.load(id).expect("there").angle < -0.3);
}

#[test]
fn a_hinge_that_falls_on_its_limit_gains_no_energy() {
    let (mut simulation, slot, id) = crank(Joint::hinge().with_angular_limits(-0.7, 0.7));
    let energy = |simulation: &Simulation| {
        let height = f64::from(simulation.bodies.center_of_mass(slot).y);
        simulation.bodies.kinetic_energy(slot) + 2.0 * 9.81 * height
    };
    let mut most = energy(&simulation);
    for _ in 0..240 {
        simulation.step(H);
        let now = energy(&simulation);
        assert!(now < most + 1e-3, "{now} J of {most}");
        most = most.max(now);
        assert!(gap(&simulation, id) < 1e-5);
    }
    let angle = simulation.joints.load(id).expect("there").angle;
    assert!((angle + 0.7).abs() < 1e-4, "{angle}");
    assert!(simulation.bodies.velocity(slot).1.length() < 1e-4);
}

#[test]
fn a_joint_breaks_at_its_strength_and_lets_go_without_a_kick() {
    for (strength, holds) in [(30.0, true), (15.0, false)] {
        let mut simulation = awake();
        let body = heavy(Vec3::ONE, Vec3::NEG_Y, 2.0);
        let slot = simulation.bodies.insert(body).expect("usable");
        let joint = Joint::ball()
            .with_anchors(Vec3::ZERO, Vec3::Y)
            .with_strength(strength, f32::INFINITY);
        let id = simulation.join(None, slot, joint).expect("usable");
        simulation.step(H);
        assert_eq!(simulation.joints.contains(id), holds);
        assert_eq!(simulation.joints.broken.len(), usize::from(!holds));
        simulation.step(H);
        assert!(simulation.joints.broken.is_empty());
        let (v, _) = simulation.bodies.velocity(slot);
        let fall = if holds { 0.0 } else { -G * H };
        assert!((v.y - fall).abs() < 1e-4, "{v}");
    }
}

/// What a motor of this speed drives, carried by the world, a fixed body or a heavy one on the floor: how far it got in 4 s, and whether it
/// fell asleep.
fn driven(dice: &mut Dice, speed: f32, limit: Option<f32>) -> (f32, bool) {
    let mut simulation = Simulation::default();
    let floor = HalfSpaceShape { normal: Vec3::Y };
    simulation
        .bodies
        .insert(BodyDesc::floor(floor))
        .expect("ok");
    let size = [0.1, 0.3, 1.0][dice.below(3)] * dice.in_range(1.0, 3.0);
    let mut base = heavy(size * Vec3::new(4.0, 1.0, 4.0), 0.5 * size * Vec3::Y, 1e3);
    let carrier = dice.below(3);
    if carrier == 1 {
        base.kind = RigidBody::Static;
    }
    let base = (carrier > 0).then(|| simulation.bodies.insert(base).expect("ok"));
    let at = 2.0 * size * Vec3::Y;
    let extent = size * Vec3::new(dice.in_range(0.1, 2.0), 0.3, dice.in_range(0.1, 2.0));
    let slot = simulation
        .bodies
        .insert(heavy(extent, at, 2.0))
        .expect("ok");
    let is_turned = dice.below(2) == 0;
    let drive = JointDrive::velocity(speed, 1e3);
    let (joint, axis) = if is_turned {
        let joint = Joint::hinge().with_angular_drive(drive);
        let limited = |limit: f32| joint.with_angular_limits(-limit, limit);
        (limit.map_or(joint, limited), Vec3::Y)
    } else {
        let joint = Joint::slider().with_linear_drive(drive);
        let limited = |limit: f32| joint.with_linear_limits(-limit, limit);
        (limit.map_or(joint, limited), Vec3::X)
    };
    let pose = |slot: u32| simulation.bodies.pose(slot);
    let poses = [base.map_or(Pose::IDENTITY, pose), pose(slot)];
    let id = simulation
        .join(base, slot, joint.with_anchor(at, axis, poses))
        .expect("usable");
    for _ in 0..240 {
        simulation.step(H);
    }
    let load = simulation.joints.load(id).expect("there");
    let way = if is_turned {
        load.angle
    } else {
        load.translation.length()
    };
    (way.abs(), simulation.bodies.is_asleep(slot))
}

#[test]
fn what_a_motor_drives_never_sleeps_however_slow_and_sleeps_where_it_stalls() {
    let mut dice = Dice::new(31);
    for member in 0..60 {
        let speed = [1e-4, 1e-3, 1e-2][dice.below(3)] * dice.in_range(1.0, 30.0);
        let (way, asleep) = driven(&mut dice, speed, None);
        assert!(!asleep, "{member}: {speed}");
        assert!(
            (way - 4.0 * speed).abs() < 0.02 * way,
            "{member}: {way} of {speed}"
        );
        let (way, asleep) = driven(&mut dice, speed, Some(0.5 * speed));
        assert!(asleep, "{member}: {way} of {speed}");
        assert!(
            (way - 0.5 * speed).abs() < 0.02 * way,
            "{member}: {way} of {speed}"
        );
    }
}
