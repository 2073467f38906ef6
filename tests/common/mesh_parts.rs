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

/// A torus about the y axis: `around` by `across` quadrilaterals, each two triangles.
#[allow(
    clippy::disallowed_methods,
    reason = "shapes of tests may differ in the last bit between platforms"
)]
pub(crate) fn torus(major: f32, minor: f32, around: u32, across: u32) -> TriMesh {
    let turn = |i: u32, n: u32| std::f32::consts::TAU * i as f32 / n as f32;
    let mut positions = Vec::new();
    for i in 0..around {
        let (sin, cos) = turn(i, around).sin_cos();
        for k in 0..across {
            let (height, out) = turn(k, across).sin_cos();
            let radius = major + minor * out;
            positions.push(Vec3::new(radius * cos, minor * height, radius * sin));
        }
    }
    let vertex = |i: u32, k: u32| i % around * across + k % across;
    let quads = (0..around).flat_map(|i| (0..across).map(move |k| (i, k)));
    let triangles = quads.flat_map(|(i, k)| {
        let [a, b] = [vertex(i, k), vertex(i, k + 1)];
        let [c, d] = [vertex(i + 1, k + 1), vertex(i + 1, k)];
        [[a, b, c], [a, c, d]]
    });
    let triangles = triangles.collect();
    TriMesh::new(positions, triangles).unwrap()
}

/// The cells of a grid that are solid, as one surface without inner walls; cells are unit cubes.
pub(crate) fn voxels(solid: &[[i32; 3]]) -> TriMesh {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for cell in solid {
        for axis in 0..3 {
            for step in [-1, 1] {
                let mut beside = *cell;
                beside[axis] += step;
                if solid.contains(&beside) {
                    continue;
                }
                let first = positions.len() as u32;
                let mut normal = Vec3::ZERO;
                normal[axis] = step as f32;
                let center = Vec3::from_array(cell.map(|x| x as f32)) + 0.5 + 0.5 * normal;
                let [mut u, mut v] = [Vec3::ZERO; 2];
                u[(axis + 1) % 3] = 0.5;
                v[(axis + 2) % 3] = 0.5 * step as f32;
                positions.extend([
                    center - u - v,
                    center + u - v,
                    center + u + v,
                    center - u + v,
                ]);
                triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k| first + k)));
            }
        }
    }
    TriMesh::new(positions, triangles).unwrap()
}

/// A prism along z, 2 `half_depth` m thick, over convex polygons that share corners: edges of one polygon only have walls. Corners in m,
/// counter-clockwise.
pub(crate) fn extruded(points: &[[f32; 2]], polygons: &[&[u32]], half_depth: f32) -> TriMesh {
    let layer = |z: f32| points.iter().map(move |&[x, y]| Vec3::new(x, y, z));
    let positions: Vec<Vec3> = layer(half_depth).chain(layer(-half_depth)).collect();
    let back = points.len() as u32;
    let edges = |polygon: &[u32]| -> Vec<[u32; 2]> {
        let next = polygon.iter().cycle().skip(1);
        polygon.iter().zip(next).map(|(&a, &b)| [a, b]).collect()
    };
    let all: Vec<[u32; 2]> = polygons.iter().flat_map(|polygon| edges(polygon)).collect();
    let mut triangles = Vec::new();
    for polygon in polygons {
        for pair in polygon[1..].windows(2) {
            let front = [polygon[0], pair[0], pair[1]];
            triangles.extend([front, [0, 2, 1].map(|k| front[k] + back)]);
        }
    }
    let walls = all.iter().filter(|&&[a, b]| !all.contains(&[b, a]));
    for &[a, b] in walls {
        triangles.extend([[a, a + back, b + back], [a, b + back, b]]);
    }
    TriMesh::new(positions, triangles).unwrap()
}
