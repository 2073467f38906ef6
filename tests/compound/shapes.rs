//! Furniture and the like.

use crate::common::structures::cuboid;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// A box of `size` (m) whose middle is at a place.
pub(crate) fn brick(size: Vec3, at: Vec3) -> (Pose, ConvexMesh) {
    (Pose::from_position(at), cuboid(size))
}

pub(crate) fn compound(parts: Vec<(Pose, ConvexMesh)>) -> Compound {
    Compound::new(parts).expect("usable parts")
}

/// A table 0.75 m high that stands on the plane y = 0 of its frame.
pub(crate) fn table() -> Compound {
    let mut parts = vec![brick(Vec3::new(1.2, 0.05, 0.8), 0.725 * Vec3::Y)];
    for [x, z] in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
        let at = Vec3::new(0.55 * x, 0.35, 0.35 * z);
        parts.push(brick(Vec3::new(0.06, 0.7, 0.06), at));
    }
    compound(parts)
}

/// A chair: a seat, four legs, a back that leans.
pub(crate) fn chair() -> Compound {
    let mut parts = vec![brick(Vec3::new(0.45, 0.04, 0.45), 0.44 * Vec3::Y)];
    for [x, z] in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
        let at = Vec3::new(0.2 * x, 0.21, 0.2 * z);
        parts.push(brick(Vec3::new(0.04, 0.42, 0.04), at));
    }
    let back = Pose::new(
        Vec3::new(-0.22, 0.68, 0.0),
        Quat::from_xyzw(0.0, 0.0, 0.08, 1.0).normalize(),
    );
    parts.push((back, cuboid(Vec3::new(0.03, 0.5, 0.45))));
    compound(parts)
}

/// A square cup with a bottom, open above, whose inside is 0.2 m wide and 0.25 m deep.
pub(crate) fn cup() -> Compound {
    let wall = 0.02;
    let mut parts = vec![brick(Vec3::new(0.24, wall, 0.24), 0.5 * wall * Vec3::Y)];
    for side in [-1.0, 1.0] {
        let high = wall + 0.125;
        parts.push(brick(
            Vec3::new(wall, 0.25, 0.24),
            Vec3::new(0.11 * side, high, 0.0),
        ));
        parts.push(brick(
            Vec3::new(0.2, 0.25, wall),
            Vec3::new(0.0, high, 0.11 * side),
        ));
    }
    compound(parts)
}

/// Two posts and what lies on them: 1 m high inside, 0.8 m wide.
pub(crate) fn arch() -> Compound {
    compound(vec![
        brick(Vec3::new(0.2, 1.0, 0.3), Vec3::new(-0.5, 0.5, 0.0)),
        brick(Vec3::new(0.2, 1.0, 0.3), Vec3::new(0.5, 0.5, 0.0)),
        brick(Vec3::new(1.2, 0.2, 0.3), 1.1 * Vec3::Y),
    ])
}

/// A bar and two balls that it reaches into.
pub(crate) fn dumbbell() -> Compound {
    let ball = ConvexMesh::sphere(0.15).expect("valid");
    let bar = ConvexMesh::cylinder(0.05, 0.6).expect("valid");
    compound(vec![
        (Pose::IDENTITY, bar),
        (Pose::from_position(0.35 * Vec3::Y), ball.clone()),
        (Pose::from_position(-0.35 * Vec3::Y), ball),
    ])
}
