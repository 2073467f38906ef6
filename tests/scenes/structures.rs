//! Structures whose behaviour is known in advance, as lists of bodies in exact contact: what moves does so by the solver.
//!
//! The static body comes first, and where there are several, all of them; then the dynamic ones, from the ground up.
#![allow(dead_code, reason = "each user builds some of them")]

use bevy_cleave::prelude::*;
use glam::Vec3;

/// A horizontal floor at height 0 with friction `mu`.
pub(crate) fn floor(mu: f32) -> BodyDesc {
    half_space(Vec3::Y, mu)
}

/// A static half-space through the origin.
pub(crate) fn half_space(normal: Vec3, mu: f32) -> BodyDesc {
    BodyDesc {
        friction: Friction::new(mu),
        ..BodyDesc::floor(HalfSpace::new(normal).expect("a direction"))
    }
}

/// A dynamic body with friction `mu`.
pub(crate) fn block(shape: &ConvexMesh, position: Vec3, mu: f32) -> BodyDesc {
    BodyDesc {
        friction: Friction::new(mu),
        ..BodyDesc::dynamic(shape.clone(), position)
    }
}

/// A static body with friction `mu`.
pub(crate) fn fixed(shape: &ConvexMesh, position: Vec3, mu: f32) -> BodyDesc {
    BodyDesc {
        kind: RigidBody::Static,
        ..block(shape, position, mu)
    }
}

/// A box with edges of the lengths in `size`, m.
pub(crate) fn cuboid(size: Vec3) -> ConvexMesh {
    ConvexMesh::cuboid(size.x, size.y, size.z).expect("valid size")
}

/// From -1 to 1, different for every `i`, without a pattern that a column could lean along: multiples of an irrational
/// number, folded.
fn scatter(i: usize, irrational: f64) -> f32 {
    (2.0 * (i as f64 * irrational).fract() - 1.0) as f32
}

/// A column of `count` unit cubes on a floor, friction 0.6, each off the axis by up to 1 mm in x and z.
pub(crate) fn tower(count: usize) -> Vec<BodyDesc> {
    let shape = cuboid(Vec3::ONE);
    let cubes = (0..count).map(|i| {
        let (x, z) = (scatter(i, 0.618_034), scatter(i, 0.414_214));
        let off_axis = 7e-4 * Vec3::new(x, 0.0, z);
        block(&shape, Vec3::Y * (i as f32 + 0.5) + off_axis, 0.6)
    });
    std::iter::once(floor(0.6)).chain(cubes).collect()
}

/// Four unit cubes of 1 t under a fifth of `factor` t, friction 0.6.
pub(crate) fn mass_ratio(factor: f32) -> Vec<BodyDesc> {
    let mut bodies = tower(5);
    bodies[5].density *= factor;
    bodies
}
