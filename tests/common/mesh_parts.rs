//! Boxes, and meshes of several parts.

use bevy_cleave::geometry::{TriMesh, primitives};
use bevy_cleave::math::Pose;
use glam::{Quat, Vec3};
use std::borrow::Borrow;

/// Meshes side by side or one in the other, as one; those marked `true` are turned inside out.
pub(crate) fn joined<M: Borrow<TriMesh>>(parts: &[(M, bool)]) -> TriMesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (mesh, is_cavity) in parts {
        let mesh: &TriMesh = mesh.borrow();
        let first = positions.len() as u32;
        positions.extend_from_slice(mesh.positions());
        triangles.extend(mesh.triangles().iter().map(|t| {
            let [a, b, c] = t.map(|v| first + v);
            if *is_cavity { [a, c, b] } else { [a, b, c] }
        }));
    }
    TriMesh::new(positions, triangles).unwrap()
}

/// A box about a point, m.
pub(crate) fn cuboid(size: Vec3, center: Vec3) -> TriMesh {
    let hull = primitives::cuboid(size.x, size.y, size.z).unwrap();
    let pose = Pose::new(center, Quat::IDENTITY);
    hull.to_mesh().transformed(&pose)
}
