//! Several meshes as one.

use crate::geometry::TriMesh;
use glam::{Vec2, Vec3, Vec4};

impl TriMesh {
    /// One mesh of all triangles. Vertices at one position stay as many as they were, so that what is closed stays closed; an attribute
    /// that only some have gets a plain value on the others.
    pub(crate) fn joined(meshes: &[Self]) -> Self {
        joined(meshes)
    }
}

fn joined(meshes: &[TriMesh]) -> TriMesh {
    let mut whole = TriMesh::default();
    let has = |of: fn(&TriMesh) -> bool| meshes.iter().any(of);
    let has_normals = has(|mesh| !mesh.normals.is_empty());
    let has_colors = has(|mesh| !mesh.colors.is_empty());
    let has_uvs = has(|mesh| !mesh.uvs.is_empty());
    let has_materials = has(|mesh| !mesh.materials.is_empty());
    let mut topology = 0;
    let mut solid: (Vec<[u32; 3]>, Vec<u16>) = Default::default();
    for mesh in meshes {
        let first = whole.positions.len() as u32;
        let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
        whole.positions.extend_from_slice(&mesh.positions);
        let numbers = mesh.topology.iter().map(|number| topology + number);
        whole.topology.extend(numbers);
        topology += mesh.topology_count() as u32;
        let up = Vec3::Y;
        append(&mut whole.normals, &mesh.normals, vertices, has_normals, up);
        append(
            &mut whole.colors,
            &mesh.colors,
            vertices,
            has_colors,
            Vec4::ONE,
        );
        append(&mut whole.uvs, &mesh.uvs, vertices, has_uvs, Vec2::ZERO);
        let mut materials = Vec::new();
        append(&mut materials, &mesh.materials, triangles, has_materials, 0);
        let moved = mesh.triangles.iter().map(|t| t.map(|v| first + v));
        let sheets = mesh.sheets as usize;
        whole.triangles.extend(moved.clone().take(sheets));
        solid.0.extend(moved.skip(sheets));
        if has_materials {
            whole.materials.extend_from_slice(&materials[..sheets]);
            solid.1.extend_from_slice(&materials[sheets..]);
        }
        whole.sheets += mesh.sheets;
    }
    whole.triangles.append(&mut solid.0);
    whole.materials.append(&mut solid.1);
    whole
}

/// Adds an attribute of some vertices or triangles, if any mesh has it.
fn append<T: Copy>(all: &mut Vec<T>, part: &[T], count: usize, is_used: bool, plain: T) {
    if is_used && part.is_empty() {
        all.extend(std::iter::repeat_n(plain, count));
    }
    all.extend_from_slice(part);
}
