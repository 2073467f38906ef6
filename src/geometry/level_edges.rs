//! What lies beyond the edges of the triangles of a level.

use crate::geometry::level_triangle::{EdgeKind, LevelTriangle};
use glam::Vec3;

/// Sine of the angle up to which two triangles at an edge are one plane.
const FLAT: f32 = 1e-3;

/// The sides of all triangles, sorted by the numbers of their ends, the smaller one first, and then by triangle: the larger end, and
/// four times the triangle and the side. Those whose smaller end is `v` begin at the `v`th number.
fn sides(corners: &[[u32; 3]]) -> (Vec<u32>, Vec<(u32, u32)>) {
    let ends = |of: &[u32; 3], side: usize| {
        let [from, to] = [of[side], of[(side + 1) % 3]];
        (from.min(to), from.max(to))
    };
    let vertices = corners
        .iter()
        .flatten()
        .max()
        .map_or(0, |&most| most as usize + 1);
    let mut starts = vec![0; vertices + 1];
    for of in corners {
        (0..3).for_each(|side| starts[ends(of, side).0 as usize + 1] += 1);
    }
    for v in 0..vertices {
        starts[v + 1] += starts[v];
    }
    let mut next = starts.clone();
    let mut sorted = vec![(0, 0); 3 * corners.len()];
    for (triangle, of) in (0..).zip(corners) {
        for side in 0..3 {
            let (low, high) = ends(of, side);
            let place = &mut next[low as usize];
            sorted[*place as usize] = (high, 4 * triangle + side as u32);
            *place += 1;
        }
    }
    for run in starts.windows(2) {
        sorted[run[0] as usize..run[1] as usize].sort_unstable();
    }
    (starts, sorted)
}

/// Whether a place is on the side of an edge where the triangle itself is.
fn is_beside(triangle: &LevelTriangle, edge: usize, at: Vec3) -> bool {
    let from = triangle.corners[edge];
    let along = triangle.corners[(edge + 1) % 3] - from;
    triangle.plane.normal.cross(along).dot(at - from) > 0.0
}

/// Finds out what lies beyond each edge. `corners` are numbers of positions.
pub(super) fn find_edges(triangles: &mut [LevelTriangle], corners: &[[u32; 3]]) {
    let (starts, sides) = sides(corners);
    let runs = starts
        .windows(2)
        .map(|run| &sides[run[0] as usize..run[1] as usize]);
    for run in runs.flat_map(|run| run.chunk_by(|a, b| a.0 == b.0)) {
        for &(_, own) in run {
            let (triangle, edge) = ((own / 4) as usize, (own % 4) as usize);
            let opposite = corners[triangle][(edge + 2) % 3];
            let plane = triangles[triangle].plane;
            let mut kind = EdgeKind::Open;
            for &(_, other) in run.iter().filter(|other| other.1 / 4 != own / 4) {
                let (other, across) = ((other / 4) as usize, (other % 4) as usize);
                // The same triangle again is no neighbor, nor is one folded back.
                if corners[other][(across + 2) % 3] == opposite {
                    continue;
                }
                let tip = triangles[other].corners[(across + 2) % 3];
                let ends = [across, (across + 1) % 3].map(|k| triangles[other].corners[k]);
                let length = (tip - ends[0]).length().max((tip - ends[1]).length());
                let rise = plane.distance(tip);
                if rise.abs() <= FLAT * length && is_beside(&triangles[triangle], edge, tip) {
                    continue;
                }
                kind = if rise > FLAT * length {
                    EdgeKind::Concave
                } else if rise >= -FLAT * length && kind != EdgeKind::Concave {
                    EdgeKind::Flat
                } else if kind == EdgeKind::Open {
                    EdgeKind::Convex
                } else {
                    kind
                };
            }
            triangles[triangle].edges[edge] = kind;
        }
    }
}
