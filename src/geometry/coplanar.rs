//! Triangles of a hull that lie in one plane, joined to polygons.

use crate::math::Plane;
use glam::{DVec3, Vec3};

/// No region.
const NONE: u32 = u32::MAX;

/// A polygon of the hull of a cloud: its loop as indices into the cloud.
pub(crate) struct PolygonFace {
    corners: Vec<u32>,
    pub(crate) plane: Plane,
}

/// The plane of a triangle, rounded to `f32` such that it still goes through the triangle.
fn triangle_plane(points: &[DVec3], triangle: [u32; 3]) -> Plane {
    let [a, b, c] = triangle.map(|corner| points[corner as usize]);
    let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
    let offset = normal.as_dvec3().dot((a + b + c) / 3.0) as f32;
    Plane { normal, offset }
}

/// Each triangle as a polygon of its own.
pub(crate) fn unmerged(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<PolygonFace> {
    let face = |&triangle: &[u32; 3]| PolygonFace {
        corners: triangle.to_vec(),
        plane: triangle_plane(points, triangle),
    };
    triangles.iter().map(face).collect()
}

/// Joins triangles whose corners lie within `tolerance` (m) of the plane of the largest among them, and drops corners
/// that end up inside a face or on a straight edge.
///
/// `None` if a joined region is not bounded by one simple loop, which rounding can cause at the tolerance.
pub(crate) fn merge_coplanar(
    points: &[DVec3],
    triangles: &[[u32; 3]],
    tolerance: f64,
) -> Option<Vec<PolygonFace>> {
    let neighbors = triangle_neighbors(triangles);
    let area_vector = |triangle: usize| {
        let [a, b, c] = triangles[triangle].map(|corner| points[corner as usize]);
        (b - a).cross(c - a)
    };
    let mut seeds: Vec<usize> = (0..triangles.len()).collect();
    seeds.sort_by(|&i, &j| {
        let by_area = area_vector(j)
            .length_squared()
            .total_cmp(&area_vector(i).length_squared());
        by_area.then(i.cmp(&j))
    });
    let mut region_of = vec![NONE; triangles.len()];
    let mut faces = Vec::new();
    for seed in seeds {
        if region_of[seed] != NONE {
            continue;
        }
        let region = faces.len() as u32;
        let normal = area_vector(seed).normalize_or_zero();
        let base = points[triangles[seed][0] as usize];
        let near = |corner: u32| normal.dot(points[corner as usize] - base).abs() <= tolerance;
        region_of[seed] = region;
        let mut members = vec![seed];
        let mut next = 0;
        while next < members.len() {
            for across in neighbors[members[next]] {
                let joins = region_of[across] == NONE && triangles[across].into_iter().all(near);
                if joins {
                    region_of[across] = region;
                    members.push(across);
                }
            }
            next += 1;
        }
        faces.push(PolygonFace {
            corners: boundary_loop(triangles, &neighbors, &region_of, &members)?,
            plane: triangle_plane(points, triangles[seed]),
        });
    }
    drop_straight_corners(points.len(), &mut faces)?;
    Some(faces)
}

/// For each triangle the one across the edge from its corner `k` to its corner `k + 1`.
fn triangle_neighbors(triangles: &[[u32; 3]]) -> Vec<[usize; 3]> {
    let mut edges: Vec<([u32; 2], usize, usize)> = Vec::with_capacity(3 * triangles.len());
    for (triangle, corners) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (from, to) = (corners[k], corners[(k + 1) % 3]);
            edges.push(([from.min(to), from.max(to)], triangle, k));
        }
    }
    edges.sort_unstable();
    let mut neighbors = vec![[usize::MAX; 3]; triangles.len()];
    for pair in edges.chunks_exact(2) {
        let [(_, a, edge_of_a), (_, b, edge_of_b)] = [pair[0], pair[1]];
        neighbors[a][edge_of_a] = b;
        neighbors[b][edge_of_b] = a;
    }
    neighbors
}

/// The loop around a region of triangles, or `None` if it is not one simple loop. Starts at its smallest index.
fn boundary_loop(
    triangles: &[[u32; 3]],
    neighbors: &[[usize; 3]],
    region_of: &[u32],
    members: &[usize],
) -> Option<Vec<u32>> {
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for &triangle in members {
        for k in 0..3 {
            if region_of[neighbors[triangle][k]] != region_of[triangle] {
                edges.push([triangles[triangle][k], triangles[triangle][(k + 1) % 3]]);
            }
        }
    }
    edges.sort_unstable();
    if edges.windows(2).any(|pair| pair[0][0] == pair[1][0]) {
        return None;
    }
    let start = edges.first()?[0];
    let mut corners = vec![start];
    loop {
        let last = *corners.last()?;
        let edge = edges.binary_search_by_key(&last, |edge| edge[0]).ok()?;
        let next = edges[edge][1];
        if next == start {
            break;
        }
        if corners.len() == edges.len() {
            return None;
        }
        corners.push(next);
    }
    (corners.len() == edges.len()).then_some(corners)
}

/// Drops corners that only two faces share: the edge there is straight within the tolerance. `None` if a face vanishes.
fn drop_straight_corners(points: usize, faces: &mut [PolygonFace]) -> Option<()> {
    let mut sharing = vec![0_u32; points];
    for &corner in faces.iter().flat_map(|face| &face.corners) {
        sharing[corner as usize] += 1;
    }
    for face in faces.iter_mut() {
        face.corners.retain(|&corner| sharing[corner as usize] > 2);
        if face.corners.len() < 3 {
            return None;
        }
    }
    Some(())
}

/// The points that are corners of faces, in their order, and the faces' loops as indices into them.
pub(crate) fn compact(points: &[Vec3], faces: &[PolygonFace]) -> (Vec<Vec3>, Vec<Vec<u32>>) {
    let mut used: Vec<u32> = faces
        .iter()
        .flat_map(|face| face.corners.iter().copied())
        .collect();
    used.sort_unstable();
    used.dedup();
    let vertices = used.iter().map(|&point| points[point as usize]).collect();
    let renumber = |corner: &u32| used.partition_point(|point| point < corner) as u32;
    let loops = faces
        .iter()
        .map(|face| face.corners.iter().map(renumber).collect())
        .collect();
    (vertices, loops)
}
