//! What games build of joints, on the ground: ragdolls, a door, a bridge that is driven over.

use crate::common::ragdoll::add_ragdoll;
use crate::common::scenes::awake;
use crate::scene::{Bridge, H, Random, heavy, largest_gap};
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

fn insert(simulation: &mut Simulation, body: BodyDesc) -> u32 {
    simulation.bodies.insert(body).expect("usable")
}

fn fixed(size: Vec3, at: Vec3) -> BodyDesc {
    BodyDesc {
        kind: RigidBody::Static,
        ..heavy(size, at, 1.0)
    }
}

fn floor() -> BodyDesc {
    BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y })
}

fn fastest(simulation: &Simulation) -> f32 {
    let speed = |slot: u32| simulation.bodies.velocity(slot).0.length();
    simulation.bodies.iter().map(speed).fold(0.0, f32::max)
}

#[test]
fn ragdolls_fall_down_stairs_in_one_piece_at_all_step_rates() {
    for rate in [30_u16, 60, 120, 240] {
        let mut simulation = awake();
        insert(&mut simulation, floor());
        for i in 0..12_u8 {
            let rise = 0.18 * f32::from(12 - i);
            let size = Vec3::new(4.0, rise, 0.3);
            let at = Vec3::new(0.0, 0.5 * rise, 0.3 * f32::from(i));
            insert(&mut simulation, fixed(size, at));
        }
        let mut ids = Vec::new();
        for k in 0..3_u8 {
            let feet = Vec3::new(1.2 * f32::from(k) - 1.2, 2.3, -0.1);
            let turn = Quat::from_rotation_y(0.9 * f32::from(k));
            ids.extend(add_ragdoll(&mut simulation, feet, turn));
        }
        for slot in 13..simulation.bodies.slots() as u32 {
            let push = Vec3::new(0.0, 0.0, 2.5);
            simulation
                .bodies
                .set_velocity(slot, push, Vec3::ZERO)
                .expect("finite");
        }
        let h = 1.0 / f32::from(rate);
        let (mut worst, mut speed) = (0.0_f64, 0.0_f32);
        for _ in 0..6 * rate {
            simulation.step(h);
            worst = worst.max(largest_gap(&simulation, &ids));
            speed = speed.max(fastest(&simulation));
        }
        let rest = fastest(&simulation);
        println!(
            "ragdolls at {rate} Hz: largest gap {worst:e} m, fastest {speed} m/s, {rest} m/s at the end"
        );
        assert!(worst < 1e-4, "{rate} Hz: {worst}");
        // From 2.3 m and with a push no part comes to more than some 12 m/s.
        assert!(speed < 20.0, "{rate} Hz: {speed}");
        assert!(rest < 1.0, "{rate} Hz: {rest}");
    }
}

/// Without friction nothing but contacts brakes them: heads and feet that touch nothing swing for minutes.
#[test]
fn ragdolls_with_friction_in_their_joints_come_to_rest_and_sleep() {
    let mut awake = Vec::new();
    for seed in 0..24 {
        let mut random = Random::new(seed);
        let mut simulation = Simulation::default();
        insert(&mut simulation, floor());
        let feet = Vec3::new(0.0, random.range(2.0, 3.0), 0.0);
        let turn = random.rotation();
        for id in add_ragdoll(&mut simulation, feet, turn) {
            let joint = *simulation.joints.get(id).expect("there");
            let joint = joint.with_angular_friction(0.5);
            let Simulation { joints, bodies, .. } = &mut simulation;
            joints.set(bodies, id, joint).expect("usable");
        }
        let rests = (0..900).any(|_| {
            simulation.step(H);
            simulation.report.awake == 0
        });
        awake.extend((!rests).then_some(seed));
    }
    assert!(awake.len() <= 1, "{awake:?}");
}

/// A ragdoll that flies and spins as one: its joints and its parts.
fn throw(
    simulation: &mut Simulation,
    (feet, speed, spin): (Vec3, Vec3, Vec3),
) -> (Vec<JointId>, Vec<u32>) {
    let others = simulation.bodies.len();
    let ids = add_ragdoll(simulation, feet, Quat::IDENTITY);
    let parts: Vec<u32> = simulation.bodies.iter().skip(others).collect();
    for &slot in &parts {
        let arm = simulation.bodies.center_of_mass(slot) - (feet + 1.1 * Vec3::Y);
        let velocity = speed + spin.cross(arm);
        let set = simulation.bodies.set_velocity(slot, velocity, spin);
        set.expect("finite");
    }
    (ids, parts)
}

/// Limbs that hit the floor turn by a large part of a radian in a sub-step, and are not stopped apart from the rest.
#[test]
fn thrown_ragdolls_stay_in_one_piece_at_30_hz() {
    let (mut open, mut worst) = (0, 0.0_f64);
    for seed in 0..24 {
        let mut random = Random::new(seed);
        let mut simulation = awake();
        insert(&mut simulation, floor());
        let feet = random.range(0.0, 2.0) * Vec3::Y;
        let (speed, spin) = (random.vector(-10.0, 10.0), random.vector(-15.0, 15.0));
        let (ids, _) = throw(&mut simulation, (feet, speed, spin));
        let mut gap = 0.0_f64;
        for _ in 0..75 {
            simulation.step(1.0 / 30.0);
            gap = gap.max(largest_gap(&simulation, &ids));
        }
        open += usize::from(gap > 1e-4);
        worst = worst.max(gap);
    }
    println!("thrown ragdolls: {open} come open, largest gap {worst:e} m");
    assert!(open == 0, "{open}, {worst}");
}

#[test]
fn ragdolls_that_are_thrown_at_a_plate_stay_in_one_piece_and_in_front_of_it() {
    let mut behind = 0;
    for speed in [10.0, 20.0, 40.0, 80.0] {
        let mut worst = 0.0_f64;
        for seed in 0..24 {
            let mut random = Random::new(seed);
            let mut simulation = awake();
            let plate = fixed(Vec3::new(60.0, 60.0, 0.05), Vec3::ZERO);
            insert(&mut simulation, plate);
            let feet = random.range(-3.0, -1.5) * Vec3::Z;
            let spin = random.vector(-15.0, 15.0);
            let (ids, parts) = throw(&mut simulation, (feet, speed * Vec3::Z, spin));
            for _ in 0..60 {
                simulation.step(1.0 / 60.0);
                worst = worst.max(largest_gap(&simulation, &ids));
            }
            let is_behind = |&&slot: &&u32| simulation.bodies.center_of_mass(slot).z > 0.0;
            behind += parts.iter().filter(is_behind).count();
        }
        println!("ragdolls at a plate with {speed} m/s: largest gap {worst:e} m");
        assert!(worst < 1e-4, "{speed} m/s: {worst}");
    }
    println!("{behind} of 1056 parts are behind the plate");
    assert!(behind == 0, "{behind}");
}

/// A frame of 5 kg stands on the floor, with a door of 500 kg on two hinges that swings to its stop.
#[test]
fn a_heavy_door_swings_on_a_light_frame() {
    let mut simulation = awake();
    insert(&mut simulation, floor());
    let frame = heavy(Vec3::new(0.1, 2.0, 4.0), Vec3::new(0.0, 1.0, 0.0), 5.0);
    let frame = insert(&mut simulation, frame);
    let door = heavy(Vec3::new(1.0, 1.8, 0.1), Vec3::new(0.6, 1.05, 0.0), 500.0);
    let door = insert(&mut simulation, door);
    // What stands beside the frame and keeps it upright.
    insert(
        &mut simulation,
        fixed(Vec3::new(1.0, 2.0, 0.5), Vec3::new(-0.55, 1.0, 1.5)),
    );
    insert(
        &mut simulation,
        fixed(Vec3::new(1.0, 2.0, 0.5), Vec3::new(0.55, 1.0, 1.75)),
    );
    insert(
        &mut simulation,
        fixed(Vec3::new(1.0, 2.0, 0.5), Vec3::new(-0.55, 1.0, -1.5)),
    );
    insert(
        &mut simulation,
        fixed(Vec3::new(1.0, 2.0, 0.5), Vec3::new(0.55, 1.0, -1.75)),
    );
    let poses = [frame, door].map(|slot| simulation.bodies.pose(slot));
    let ids: Vec<JointId> = [0.4, 1.7]
        .into_iter()
        .map(|y| {
            let joint = Joint::hinge().with_angular_limits(-1.2, 1.2).with_anchor(
                Vec3::new(0.1, y, 0.0),
                Vec3::Y,
                poses,
            );
            simulation.join(Some(frame), door, joint).expect("usable")
        })
        .collect();
    let spin = Vec3::new(0.0, 1.0, 0.0);
    let push = spin.cross(Vec3::new(0.5, 0.0, 0.0));
    simulation
        .bodies
        .set_velocity(door, push, spin)
        .expect("finite");
    let (mut worst, mut angle) = (0.0_f64, 0.0_f32);
    for _ in 0..300 {
        simulation.step(1.0 / 60.0);
        worst = worst.max(largest_gap(&simulation, &ids));
        angle = angle.max(simulation.joints.load(ids[0]).expect("there").angle.abs());
    }
    println!("door: largest gap {worst:e} m, opened to {angle} rad");
    assert!(worst < 1e-4, "{worst}");
    assert!((angle - 1.2).abs() < 0.01, "{angle}");
}

/// A truck of 2 t with 3 t on it rolls over a bridge of 100 planks of 50 kg between two banks.
#[test]
fn a_truck_drives_over_a_suspension_bridge() {
    let mut simulation = awake();
    let bridge = Bridge {
        planks: 100,
        plank: Vec3::new(0.4, 0.1, 4.0),
        mass: 50.0,
        height: -0.05,
        sag: 1.5,
        per_seam: 2,
        has_far_end: true,
    };
    let half = bridge.half();
    for side in [-1.0, 1.0] {
        let at = Vec3::new(side * (half + 5.0), -0.5, 0.0);
        insert(&mut simulation, fixed(Vec3::new(10.0, 1.0, 6.0), at));
    }
    let mut ids = bridge.add(&mut simulation);
    let chassis = heavy(
        Vec3::new(4.0, 0.4, 2.0),
        Vec3::new(-half - 4.0, 1.0, 0.0),
        1600.0,
    );
    let chassis = insert(&mut simulation, chassis);
    let load = heavy(
        Vec3::new(2.0, 1.0, 1.8),
        Vec3::new(-half - 4.0, 1.7, 0.0),
        3000.0,
    );
    let load = insert(&mut simulation, load);
    let mut wheels = Vec::new();
    for (x, z) in [(-1.4, -1.2), (-1.4, 1.2), (1.4, -1.2), (1.4, 1.2)] {
        let at = Vec3::new(-half - 4.0 + x, 0.6, z);
        let wheel = ConvexMesh::cylinder(0.6, 0.3).expect("valid size");
        let mut wheel = BodyDesc::dynamic(wheel, at);
        wheel.density = 100.0 / 0.34;
        wheel.pose.rotation = Quat::from_rotation_arc(Vec3::Y, Vec3::Z);
        let wheel = insert(&mut simulation, wheel);
        let poses = [chassis, wheel].map(|slot| simulation.bodies.pose(slot));
        let axle = Joint::hinge()
            .with_anchor(at, Vec3::Z, poses)
            .with_angular_drive(JointDrive::velocity(-8.0, 2500.0));
        ids.push(simulation.join(Some(chassis), wheel, axle).expect("usable"));
        wheels.push(wheel);
    }
    let (mut worst, mut farthest) = (0.0_f64, f32::NEG_INFINITY);
    for _ in 0..600 {
        simulation.step(1.0 / 60.0);
        worst = worst.max(largest_gap(&simulation, &ids));
        farthest = farthest.max(simulation.bodies.center_of_mass(chassis).x);
    }
    let on_top = simulation.bodies.center_of_mass(load) - simulation.bodies.center_of_mass(chassis);
    println!("truck: largest gap {worst:e} m, got to {farthest} m of {half}, load {on_top} above");
    assert!(worst < 1e-4, "{worst}");
    assert!(farthest > half - 3.0, "{farthest}");
    assert!(on_top.distance(Vec3::new(0.0, 0.7, 0.0)) < 0.3, "{on_top}");
}
