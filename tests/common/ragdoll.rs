//! A ragdoll: eleven boxes of 75 kg together, with shoulders, hips and a neck that turn within cones, elbows and knees that bend one way.

use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// Size (m), place of the middle above the ground and beside the spine (m), mass (kg) of each part; sides come in pairs.
const PARTS: [([f32; 3], [f32; 2], f32); 7] = [
    ([0.32, 0.20, 0.22], [0.0, 1.00], 12.0),
    ([0.36, 0.44, 0.24], [0.0, 1.33], 30.0),
    ([0.18, 0.24, 0.20], [0.0, 1.69], 5.0),
    ([0.30, 0.09, 0.09], [0.34, 1.48], 2.5),
    ([0.30, 0.08, 0.08], [0.65, 1.48], 1.5),
    ([0.14, 0.42, 0.14], [0.09, 0.68], 6.5),
    ([0.11, 0.44, 0.11], [0.09, 0.24], 3.5),
];

/// Adds a ragdoll whose feet are at a place; its joints.
pub(crate) fn add_ragdoll(simulation: &mut Simulation, feet: Vec3, turn: Quat) -> Vec<JointId> {
    let mut add = |part: usize, side: f32| {
        let ([x, y, z], [beside, above], mass) = PARTS[part];
        let shape = ConvexMesh::cuboid(x, y, z).expect("valid size");
        let at = feet + turn * Vec3::new(side * beside, above, 0.0);
        let mut body = BodyDesc::dynamic(shape, at);
        body.density = mass / (x * y * z);
        body.pose.rotation = turn;
        (simulation.bodies.insert(body).expect("usable"), side)
    };
    let [pelvis, chest, head] = [0, 1, 2].map(|part| add(part, 1.0).0);
    let limbs = [-1.0, 1.0].map(|side| [3, 4, 5, 6].map(|part| add(part, side)));
    let mut ids = Vec::new();
    let mut join = |a: u32, b: u32, at: Vec3, axis: Vec3, joint: Joint| {
        let poses = [a, b].map(|slot| simulation.bodies.pose(slot));
        let joint = joint.with_anchor(feet + turn * at, turn * axis, poses);
        ids.push(simulation.join(Some(a), b, joint).expect("usable"));
    };
    join(
        pelvis,
        chest,
        Vec3::new(0.0, 1.10, 0.0),
        Vec3::Y,
        Joint::cone_twist(0.5, 0.4),
    );
    join(
        chest,
        head,
        Vec3::new(0.0, 1.56, 0.0),
        Vec3::Y,
        Joint::cone_twist(0.6, 0.8),
    );
    for [upper_arm, lower_arm, upper_leg, lower_leg] in limbs {
        let side = upper_arm.1;
        let across = side * Vec3::X;
        let shoulder = Vec3::new(0.19 * side, 1.48, 0.0);
        join(
            chest,
            upper_arm.0,
            shoulder,
            across,
            Joint::cone_twist(1.4, 0.8),
        );
        let elbow = Vec3::new(0.495 * side, 1.48, 0.0);
        let bend = Joint::hinge().with_angular_limits(-2.2, 0.0);
        join(upper_arm.0, lower_arm.0, elbow, side * Vec3::Y, bend);
        let hip = Vec3::new(0.09 * side, 0.89, 0.0);
        join(
            pelvis,
            upper_leg.0,
            hip,
            Vec3::NEG_Y,
            Joint::cone_twist(1.0, 0.4),
        );
        let knee = Vec3::new(0.09 * side, 0.47, 0.0);
        let bend = Joint::hinge().with_angular_limits(0.0, 2.3);
        join(upper_leg.0, lower_leg.0, knee, Vec3::X, bend);
    }
    ids
}
