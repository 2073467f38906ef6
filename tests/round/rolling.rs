//! What rolls keeps rolling, and what stands stays.

use crate::common::scenes::awake;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// Length of a step, s.
const H: f32 = 1.0 / 60.0;

/// A ground to roll on.
#[derive(Clone, Copy, Debug)]
enum Ground {
    HalfSpace,
    Box,
    Mesh,
}

fn ground(kind: Ground) -> BodyDesc {
    match kind {
        Ground::HalfSpace => BodyDesc::floor(HalfSpaceShape::new(Vec3::Y).expect("a unit vector")),
        Ground::Box => BodyDesc {
            pose: Pose::new(Vec3::new(60.0, -1.0, 0.0), Quat::IDENTITY),
            ..BodyDesc::new(
                RigidBody::Static,
                Shape::Convex(ConvexMesh::cuboid(150.0, 2.0, 10.0).expect("a box")),
            )
        },
        Ground::Mesh => {
            let level = StaticMesh::from_heights(&vec![0.0; 200 * 11], 200, 0.73).expect("flat");
            BodyDesc {
                pose: Pose::new(Vec3::new(-5.0, 0.0, -4.1), Quat::IDENTITY),
                ..BodyDesc::level(level)
            }
        }
    }
}

/// Lays a shape whose axis is along z on the ground, and rolls it along x.
fn roll(kind: Ground, shape: ConvexMesh, radius: f32, speed: f32, secs: f32) -> (f32, f32, Vec3) {
    let mut simulation = awake();
    simulation.config.sleep.enabled = false;
    simulation.bodies.insert(ground(kind)).expect("a ground");
    let mut desc = BodyDesc::dynamic(shape, Vec3::new(0.0, radius, 0.0));
    desc.pose.rotation = Quat::from_rotation_arc(Vec3::Y, Vec3::Z);
    desc.linear_velocity = speed * Vec3::X;
    desc.angular_velocity = -speed / radius * Vec3::Z;
    let slot = simulation.bodies.insert(desc).expect("usable");
    let steps = (secs / H) as usize;
    let mut lowest = f32::INFINITY;
    for _ in 0..steps {
        simulation.step(H);
        lowest = lowest.min(simulation.bodies.velocity(slot).0.x);
    }
    let (linear, _) = simulation.bodies.velocity(slot);
    (linear.x, lowest, simulation.bodies.pose(slot).position)
}

#[test]
fn what_rolls_keeps_its_speed() {
    let shapes = [
        ("sphere", ConvexMesh::sphere(0.5)),
        ("capsule", ConvexMesh::capsule(0.5, 1.0)),
        ("cylinder", ConvexMesh::cylinder(0.5, 1.0)),
        ("flat cylinder", ConvexMesh::cylinder(0.5, 0.2)),
    ];
    for (name, shape) in shapes {
        let shape = shape.expect("usable");
        for kind in [Ground::HalfSpace, Ground::Box, Ground::Mesh] {
            let (speed, lowest, place) = roll(kind, shape.clone(), 0.5, 2.0, 60.0);
            let loss = 1.0 - speed / 2.0;
            println!("{name} on {kind:?}: lost {loss:e} of its speed, at {place}");
            // Of balls there is nothing to lose but rounding; the axis of what is long turns a little.
            let most = if name == "sphere" { 1e-5 } else { 1e-4 };
            assert!(loss < most && loss > -2e-4, "{name} on {kind:?}: {loss:e}");
            assert!(
                lowest > 2.0 * (1.0 - 2.0 * most),
                "{name} on {kind:?}: {lowest} m/s"
            );
            assert!(place.z.abs() < 0.05, "{name} on {kind:?}: at {place}");
        }
    }
}
