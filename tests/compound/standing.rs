//! Tables stand, cups hold, arches let through, heaps come to rest; on any number of threads the same.

use crate::common::dice::Dice;
use crate::common::mesh_parts::voxels;
use crate::common::structures::{block, cuboid, floor};
use crate::shapes::{arch, chair, cup, dumbbell, table};
use bevy_cleave::mass::VolumeIntegrals;
use bevy_cleave::prelude::*;
use bevy_cleave::slice::DecompositionOptions;
use glam::{Quat, Vec3};

const H: f32 = 1.0 / 60.0;

fn with_floor() -> Simulation {
    let mut simulation = Simulation::default();
    simulation.bodies.insert(floor(0.6)).expect("usable");
    simulation
}

fn add(simulation: &mut Simulation, desc: BodyDesc) -> u32 {
    simulation.bodies.insert(desc).expect("usable body")
}

fn run(simulation: &mut Simulation, seconds: f32) {
    (0..(seconds / H) as usize).for_each(|_| {
        simulation.step(H);
    });
}

#[test]
fn furniture_stands_and_sleeps() {
    for shape in [table(), chair(), arch(), cup()] {
        let mut simulation = with_floor();
        let body = add(&mut simulation, BodyDesc::compound(shape, 1e-3 * Vec3::Y));
        run(&mut simulation, 4.0);
        let pose = simulation.bodies.pose(body);
        assert!(pose.position.length() < 2e-3, "{pose:?}");
        assert!(pose.rotation.dot(Quat::IDENTITY).abs() > 0.999_99);
        assert!(simulation.bodies.is_asleep(body), "{pose:?}");
        // It stands on as few points as there are to be.
        let points: usize = simulation
            .contacts
            .manifolds()
            .iter()
            .map(|m| m.points().len())
            .sum();
        assert!(points <= 4, "{points} points");
    }
}

#[test]
fn a_table_bears_what_stands_on_it() {
    let mut simulation = with_floor();
    let desk = add(&mut simulation, BodyDesc::compound(table(), Vec3::ZERO));
    let cube = cuboid(Vec3::splat(0.2));
    let load: Vec<u32> = (0..4)
        .map(|i| {
            let at = Vec3::new(0.3, 0.85 + 0.2 * i as f32, 0.2);
            add(&mut simulation, block(&cube, at, 0.6))
        })
        .collect();
    let below = add(&mut simulation, block(&cube, Vec3::new(0.0, 0.1, 0.0), 0.6));
    run(&mut simulation, 5.0);
    for (i, &slot) in load.iter().enumerate() {
        let height = simulation.bodies.center_of_mass(slot).y;
        let expected = 0.85 + 0.2 * i as f32;
        assert!((height - expected).abs() < 2e-3, "{height} {expected}");
    }
    let under = simulation.bodies.center_of_mass(below);
    assert!(under.distance(0.1 * Vec3::Y) < 1e-3, "{under}");
    assert!(simulation.bodies.is_asleep(desk));
}

#[test]
fn a_cup_holds_a_ball_and_is_carried_with_it() {
    let ball = ConvexMesh::sphere(0.08).expect("valid");
    let many = ConvexMesh::icosphere(0.08, 2).expect("valid");
    for shape in [ball, many, cuboid(Vec3::splat(0.1))] {
        let mut simulation = with_floor();
        let vessel = add(&mut simulation, BodyDesc::compound(cup(), 0.5 * Vec3::Y));
        let held = add(
            &mut simulation,
            BodyDesc::dynamic(shape, Vec3::new(0.01, 1.0, 0.02)),
        );
        run(&mut simulation, 3.0);
        // It is pushed along, and what it holds goes with it.
        simulation
            .bodies
            .set_velocity(vessel, Vec3::new(1.5, 0.0, 0.5), Vec3::ZERO)
            .expect("usable");
        run(&mut simulation, 3.0);
        let pose = simulation.bodies.pose(vessel);
        let inside = pose.inverse_transform_point(simulation.bodies.center_of_mass(held));
        assert!(pose.position.x > 0.1, "{pose:?}");
        let is_inside = inside.x.abs() < 0.1 && inside.z.abs() < 0.1 && inside.y > 0.02;
        assert!(is_inside && inside.y < 0.2, "{inside}");
    }
}

#[test]
fn an_arch_lets_through_what_fits_and_stops_what_does_not() {
    for (size, fits) in [(0.7, true), (0.9, false)] {
        let mut simulation = with_floor();
        let desc = BodyDesc {
            kind: RigidBody::Static,
            ..BodyDesc::compound(arch(), Vec3::ZERO)
        };
        add(&mut simulation, desc);
        let crate_ = cuboid(Vec3::new(size, 0.6, 0.6));
        let body = BodyDesc {
            linear_velocity: 3.0 * Vec3::Z,
            friction: Friction::new(0.0).with_combine(CombineRule::Min),
            ..BodyDesc::dynamic(crate_, Vec3::new(0.0, 0.3, -2.0))
        };
        let body = add(&mut simulation, body);
        run(&mut simulation, 2.0);
        let z = simulation.bodies.center_of_mass(body).z;
        assert_eq!(z > 1.0, fits, "{size}: {z}");
    }
}

/// Compounds of all kinds, balls and boxes, thrown together.
fn heap(seed: u64) -> Simulation {
    let dice = &mut Dice::new(seed);
    let mut simulation = with_floor();
    for i in 0..24 {
        let at = Vec3::new(
            dice.in_range(-0.8, 0.8),
            0.8 + 0.5 * i as f32,
            dice.in_range(-0.8, 0.8),
        );
        let desc = match dice.below(7) {
            0 => BodyDesc::compound(table(), at),
            1 => BodyDesc::compound(chair(), at),
            2 => BodyDesc::compound(cup(), at),
            3 => BodyDesc::compound(arch(), at),
            4 => BodyDesc::compound(dumbbell(), at),
            5 => BodyDesc::dynamic(ConvexMesh::sphere(0.2).expect("valid"), at),
            _ => BodyDesc::dynamic(cuboid(dice.vector(0.1, 0.5)), at),
        };
        let desc = BodyDesc {
            pose: Pose::new(at, dice.rotation()),
            friction: Friction::new(0.5),
            ..desc
        };
        add(&mut simulation, desc);
    }
    simulation
}

#[test]
fn heaps_of_compounds_come_to_rest() {
    for seed in 0..6 {
        let mut simulation = heap(seed);
        run(&mut simulation, 20.0);
        let bodies = &simulation.bodies;
        for slot in bodies.iter().skip(1) {
            let at = bodies.center_of_mass(slot);
            assert!(at.is_finite() && at.y > 0.0 && at.y < 4.0, "{seed}: {at}");
            let (v, w) = bodies.velocity(slot);
            let speed = v.length() + 0.3 * w.length();
            // What is round rolls away.
            let shape = bodies.compound(slot);
            let mut parts = shape.iter().flat_map(|shape| shape.parts());
            let rolls = bodies.convex(slot).is_some_and(ConvexMesh::is_round)
                || parts.any(|part| part.shape.is_round());
            assert!(rolls || speed < 0.5, "{seed}: body {slot} at {speed} m/s");
        }
        let deepest = simulation.contacts.manifolds().iter();
        let deepest = deepest.flat_map(|m| m.points().iter().map(|p| p.separation));
        let deepest = deepest.fold(0.0, f32::min);
        assert!(deepest > -5e-3, "{seed}: {deepest} m deep");
    }
}

#[test]
fn a_fast_ball_goes_through_no_wall_of_parts() {
    let dice = &mut Dice::new(3);
    for speed in [10.0, 60.0, 300.0] {
        for _ in 0..10 {
            let bricks = (0..6).flat_map(|x| (0..6).map(move |y| (x, y)));
            // Two layers: what is behind has no face in front.
            let bricks = bricks.flat_map(|(x, y)| [0.0, 0.1].map(|z| (x, y, z)));
            let bricks = bricks.map(|(x, y, z)| {
                let at = Vec3::new(0.4 * x as f32 - 1.0, 0.2 * y as f32 + 0.1, z);
                (Pose::from_position(at), cuboid(Vec3::new(0.4, 0.2, 0.1)))
            });
            let wall = Compound::new(bricks).expect("usable");
            let mut simulation = with_floor();
            let desc = BodyDesc {
                kind: RigidBody::Static,
                ..BodyDesc::compound(wall, Vec3::ZERO)
            };
            add(&mut simulation, desc);
            let ball = if dice.below(2) == 0 {
                ConvexMesh::sphere(0.1)
            } else {
                ConvexMesh::cuboid(0.2, 0.15, 0.1)
            };
            let at = Vec3::new(dice.in_range(-0.9, 0.9), dice.in_range(0.3, 0.9), -3.0);
            let body = BodyDesc {
                linear_velocity: speed * (Vec3::Z + 0.1 * dice.vector(-1.0, 1.0)),
                angular_velocity: dice.vector(-10.0, 10.0),
                ..BodyDesc::dynamic(ball.expect("valid"), at)
            };
            let body = add(&mut simulation, body);
            for _ in 0..60 {
                simulation.step(H);
                let at = simulation.bodies.center_of_mass(body);
                let is_beside = at.x.abs() > 1.1 || at.y > 1.15;
                assert!(at.z < 0.0 || is_beside, "{speed} m/s: {at}");
            }
        }
    }
}

/// Boxes that lie across a bench and a step: several contacts for one pair of bodies, of which some come and go.
#[test]
fn each_of_several_contacts_of_a_pair_keeps_its_impulses() {
    let bench = Compound::new([
        (
            Pose::from_position(0.2 * Vec3::Y),
            cuboid(Vec3::new(1.0, 0.4, 0.4)),
        ),
        (
            Pose::from_position(Vec3::new(0.0, 0.4, 0.4)),
            cuboid(Vec3::new(1.0, 0.8, 0.4)),
        ),
    ]);
    let mut simulation = with_floor();
    simulation.config.sleep = SleepConfig::off();
    let desc = BodyDesc {
        kind: RigidBody::Static,
        ..BodyDesc::compound(bench.expect("usable"), Vec3::ZERO)
    };
    add(&mut simulation, desc);
    // It stands on the bench and leans against the step.
    let turn = Quat::from_xyzw(0.12, 0.0, 0.0, 1.0).normalize();
    let board = BodyDesc {
        pose: Pose::new(Vec3::new(0.0, 0.8, 0.0), turn),
        friction: Friction::new(0.8),
        ..BodyDesc::dynamic(cuboid(Vec3::new(0.3, 0.8, 0.05)), Vec3::ZERO)
    };
    let board = add(&mut simulation, board);
    run(&mut simulation, 3.0);
    let (v, _) = simulation.bodies.velocity(board);
    assert!(v.length() < 1e-3, "{v}");
    let manifolds = simulation.contacts.manifolds().len();
    assert!(manifolds > 1, "{manifolds} manifolds");
    let cache = &simulation.report.cache;
    assert_eq!(cache.exact_hits, cache.points, "{cache:?}");
}

/// A mesh that is not convex becomes a compound: something fits into the cup, and nothing into its hull.
#[test]
fn a_cup_from_a_mesh_holds_a_ball() {
    let walls = (0..5).flat_map(|x| (0..5).flat_map(move |z| (0..5).map(move |y| [x, y, z])));
    let is_wall = |&[x, y, z]: &[i32; 3]| y == 0 || x == 0 || x == 4 || z == 0 || z == 4;
    let walls: Vec<[i32; 3]> = walls.filter(is_wall).collect();
    let mesh = voxels(&walls);
    let volume = mesh.volume();
    let compound = Compound::from_mesh(mesh, DecompositionOptions::default()).expect("a solid");
    assert!(compound.len() < 12 && compound.visual().is_some());
    let sum = VolumeIntegrals::of_compound(&compound).volume;
    assert!((sum / volume - 1.0).abs() < 0.02, "{sum} {volume}");
    let middle = compound.aabb().center();
    let mut simulation = with_floor();
    let vessel = add(&mut simulation, BodyDesc::compound(compound, Vec3::Y));
    let ball = ConvexMesh::sphere(1.2).expect("valid");
    let ball = BodyDesc::dynamic(ball, middle + 5.0 * Vec3::Y);
    let ball = add(&mut simulation, ball);
    run(&mut simulation, 4.0);
    let pose = simulation.bodies.pose(vessel);
    let inside = pose.inverse_transform_point(simulation.bodies.center_of_mass(ball)) - middle;
    // It lies on the bottom, 1 m thick, of a cup 5 m high.
    assert!((inside.y - (1.0 + 1.2 - 2.5)).abs() < 0.05, "{inside}");
    assert!(inside.x.abs() < 0.35 && inside.z.abs() < 0.35, "{inside}");
}
