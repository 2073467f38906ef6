//! Where a plane cuts edges, four edges at a time.

use crate::math::Plane;
use crate::simd::dispatch::run;
use crate::simd::float4::columns;
use crate::simd::lanes::{Kernel, LaneWidth, Lanes};
use glam::Vec3;

/// Edges that are looked at side by side: as many `f64` as fit in the widest register.
const LANES: usize = 4;

/// One coordinate of a point on each edge.
type Four<T> = [T; LANES];

/// An edge of the hull with ends on both sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct CutEdge {
    /// Its end below, and that above.
    pub(super) ends: [u32; 2],
    /// Its faces, in the hull's order.
    pub(super) faces: [u32; 2],
    /// Whether the first face runs along it from below to above.
    pub(super) goes_up: bool,
}

/// Fills `points` with one point on each edge: what [`crossing`](crate::slice::clip::crossing) says of it, from the end with
/// the smaller number. No edge lies in the plane.
pub(super) fn find_cut_points(
    width: LaneWidth,
    plane: &Plane,
    vertices: &[Vec3],
    edges: &[CutEdge],
    points: &mut Vec<Vec3>,
) {
    points.resize(edges.len(), Vec3::ZERO);
    let cutting = CutPointLoop {
        plane,
        vertices,
        edges,
        points,
    };
    run(width, cutting);
}

struct CutPointLoop<'a> {
    plane: &'a Plane,
    vertices: &'a [Vec3],
    edges: &'a [CutEdge],
    points: &'a mut [Vec3],
}

impl Kernel for CutPointLoop<'_> {
    type Output = ();
    const NEEDS_32_REGISTERS: bool = false;

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (fours, rest) = self.edges.as_chunks::<LANES>();
        let (points, points_of_rest) = self.points.as_chunks_mut::<LANES>();
        for (edges, points) in fours.iter().zip(points) {
            *points = cut_four(self.plane, self.vertices, edges.each_ref());
        }
        if let [first, ..] = rest {
            // Filled up with the first one.
            let edges = std::array::from_fn(|lane| rest.get(lane).unwrap_or(first));
            let points = cut_four(self.plane, self.vertices, edges);
            points_of_rest.copy_from_slice(&points[..rest.len()]);
        }
    }
}

#[inline(always)]
fn cut_four(plane: &Plane, vertices: &[Vec3], edges: [&CutEdge; LANES]) -> [Vec3; LANES] {
    let [mut low, mut high] = [[&Vec3::ZERO; LANES]; 2];
    for l in 0..LANES {
        let [a, b] = edges[l].ends;
        low[l] = &vertices[a.min(b) as usize];
        high[l] = &vertices[a.max(b) as usize];
    }
    let (low, high) = (columns(low), columns(high));
    let (a, b) = (doubles(&low), doubles(&high));
    let (from, to) = (heights(plane, &a), heights(plane, &b));
    let mut along = [0.0; LANES];
    for l in 0..LANES {
        along[l] = (from[l] / (from[l] - to[l])).clamp(0.0, 1.0);
    }
    let mut cut = [[0.0; LANES]; 3];
    for axis in 0..3 {
        for l in 0..LANES {
            let between = a[axis][l] + along[l] * (b[axis][l] - a[axis][l]);
            cut[axis][l] = limit(between as f32, low[axis][l], high[axis][l]);
        }
    }
    let [x, y, z] = cut;
    std::array::from_fn(|l| Vec3::new(x[l], y[l], z[l]))
}

#[inline(always)]
fn doubles(points: &[Four<f32>; 3]) -> [Four<f64>; 3] {
    let mut doubles = [[0.0; LANES]; 3];
    for axis in 0..3 {
        for l in 0..LANES {
            doubles[axis][l] = f64::from(points[axis][l]);
        }
    }
    doubles
}

/// Signed distances from the plane, m.
#[inline(always)]
fn heights(plane: &Plane, [x, y, z]: &[Four<f64>; 3]) -> Four<f64> {
    let [nx, ny, nz] = plane.normal.to_array().map(f64::from);
    let offset = f64::from(plane.offset);
    let mut heights = [0.0; LANES];
    for l in 0..LANES {
        heights[l] = nx * x[l] + ny * y[l] + nz * z[l] - offset;
    }
    heights
}

/// A number, or the nearer of two others where it is not between them.
#[inline(always)]
fn limit(number: f32, a: f32, b: f32) -> f32 {
    let (least, most) = if a < b { (a, b) } else { (b, a) };
    let number = if number > least { number } else { least };
    if number < most { number } else { most }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slice::clip::crossing;
    use rand_core::Rng;
    use rand_pcg::Pcg32;

    #[test]
    fn four_edges_at_a_time_are_cut_where_one_is() {
        let mut dice = Pcg32::new(1, 1);
        let mut signed = || f32::from((dice.next_u32() >> 16) as u16) / 32768.0 - 1.0;
        let vertices: Vec<Vec3> = (0..200)
            .map(|_| Vec3::new(signed(), signed(), signed()))
            .collect();
        let mut points = Vec::new();
        for count in 0..60 {
            let normal = Vec3::new(signed(), signed(), signed());
            let plane = Plane::through(0.1 * vertices[0], normal);
            let is_below = |v: u32| plane.normal.dot(vertices[v as usize]) < plane.offset;
            let (below, above): (Vec<u32>, Vec<u32>) = (0..200).partition(|&v| is_below(v));
            let edges: Vec<CutEdge> = (below.iter().zip(&above).take(count))
                .map(|(&below, &above)| CutEdge {
                    ends: [below, above],
                    faces: [0; 2],
                    goes_up: true,
                })
                .collect();
            let expected: Vec<Vec3> = (edges.iter())
                .map(|edge| {
                    let [a, b] = edge.ends;
                    let [low, high] = [a.min(b), a.max(b)].map(|v| vertices[v as usize]);
                    crossing(&plane, low, high).0
                })
                .collect();
            for width in [LaneWidth::Four, LaneWidth::Widest] {
                find_cut_points(width, &plane, &vertices, &edges, &mut points);
                assert_eq!(points, expected);
            }
        }
    }
}
