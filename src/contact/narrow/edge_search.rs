//! Pairs of edges whose common perpendicular separates two hulls best.
//!
//! Few edges can be the best axis: those near the other hull. Of these, most pairs are ruled out on the Gauss map.

use crate::contact::narrow::scratch::Arcs4;
use crate::contact::narrow::scratch::NearEdge;
use crate::contact::narrow::scratch::{FaceAxis, NarrowScratch};
use crate::geometry::ConvexHull;
use crate::geometry::hull_lanes::{LANES, Points4, lowest_height, point};
use crate::math::{Aabb, Plane};
use glam::Vec3;

/// Sine below which two edges count as parallel: their cross product is then too rounded to be an axis, and the faces
/// beside the edges bound the overlap to within this angle.
const PARALLEL: f32 = 1e-3;

/// The pair of edges whose common perpendicular separates best.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeAxis {
    pub(crate) edges: [usize; 2],
    /// Unit vector from A to B, A's frame.
    pub(crate) normal: Vec3,
    pub(crate) separation: f32,
}

impl NarrowScratch {
    /// Collects the edges that can be the best axis, given that no axis separates by more than `reach` (m) nor by less
    /// than `-reach`.
    ///
    /// Where an edge pair is the best axis, a point of the one edge and a point of the other are as far apart as the
    /// hulls, by the gap or by the depth of the overlap: at most `reach`. Each point lies in its own hull. So either
    /// edge comes within `reach` of the other hull's box. And of a face that separates by `s`, its own hull being below
    /// and the other one above `s`, the edge of its own hull has a point above `s - reach`, the other below `reach`.
    pub(crate) fn load_near_edges(
        &mut self,
        a: &ConvexHull,
        b: &ConvexHull,
        [face_a, face_b]: [&FaceAxis; 2],
        reach: f32,
    ) {
        let (box_a, box_b) = (a.aabb(), self.aabb);
        // Rounding of the boxes and of the reach itself is far below a thousandth.
        let reach = reach + 1e-3 * (reach + box_a.diagonal().min(box_b.diagonal()));
        let (plane_a, plane_b) = (face_a.plane, self.plane_in_a(&face_b.plane));
        let turn = self.turn;
        let near = Vicinity {
            own: (plane_a, face_a.separation - reach),
            other: (plane_b, reach),
            bounds: box_b.fattened(reach),
        };
        near.classify(&a.lanes.points, &mut self.classes);
        let normal_of = |face: u32| a.faces()[face as usize].plane.normal;
        near.collect(
            a,
            &a.lanes.points,
            &self.classes,
            normal_of,
            &mut self.near_a,
        );
        let near = Vicinity {
            own: (plane_b, face_b.separation - reach),
            other: (plane_a, reach),
            bounds: box_a.fattened(reach),
        };
        near.classify(&self.b_in_a, &mut self.classes);
        let normal_of = |face: u32| turn * b.faces()[face as usize].plane.normal;
        near.collect(b, &self.b_in_a, &self.classes, normal_of, &mut self.near_b);
        self.arcs_b.clear();
        self.arcs_b.extend(self.near_b.chunks(LANES).map(|edges| {
            let mut arcs = Arcs4::default();
            for (l, edge) in edges.iter().enumerate() {
                arcs.along.set(l, edge.along);
                arcs.normals[0].set(l, edge.normals[0]);
                arcs.normals[1].set(l, edge.normals[1]);
            }
            arcs
        }));
    }
}

/// Where the edges of a hull must be to count; see [`NarrowScratch::load_near_edges`].
#[derive(Debug)]
struct Vicinity {
    /// Best face of the edges' own hull, and the height above it that an edge must come up to.
    own: (Plane, f32),
    /// Best face of the other hull, and the height above it that an edge must come down to.
    other: (Plane, f32),
    /// Box that an edge must meet.
    bounds: Aabb,
}

impl Vicinity {
    /// Bit 0 for vertices that are high enough above the own face, bit 1 for those that are low enough above the other.
    fn classify(&self, points: &[Points4], classes: &mut Vec<[u8; LANES]>) {
        let least = self.own.1 + self.own.0.offset;
        let most = self.other.1 + self.other.0.offset;
        classes.clear();
        classes.extend(points.iter().map(|group| {
            let own = group.along(self.own.0.normal);
            let other = group.along(self.other.0.normal);
            let mut class = [0; LANES];
            for l in 0..LANES {
                class[l] = u8::from(own[l] >= least) | u8::from(other[l] <= most) << 1;
            }
            class
        }));
    }

    /// Fills `near` with the edges that count; corners and normals along the same axes as the planes.
    fn collect(
        &self,
        hull: &ConvexHull,
        corners: &[Points4],
        classes: &[[u8; LANES]],
        normal_of: impl Fn(u32) -> Vec3,
        near: &mut Vec<NearEdge>,
    ) {
        near.clear();
        let classes = classes.as_flattened();
        for (index, edge) in hull.edges().iter().enumerate() {
            let (v, w) = (edge.vertices[0] as usize, edge.vertices[1] as usize);
            if classes[v] | classes[w] != 3 {
                continue;
            }
            let (from, to) = (point(corners, v), point(corners, w));
            let span = Aabb {
                min: from.min(to),
                max: from.max(to),
            };
            if self.bounds.overlaps(&span) {
                near.push(NearEdge {
                    index,
                    from,
                    along: to - from,
                    normals: [normal_of(edge.faces[0]), normal_of(edge.faces[1])],
                });
            }
        }
    }
}

/// The edge pair that separates better than `floor` (m) and every other pair, if there is one.
///
/// An edge is an arc on the Gauss map, between the normals of its two faces. Only pairs whose arcs cross (B's being
/// mirrored) are edges of the Minkowski difference; the others cannot be the best axis and are skipped.
pub(crate) fn best_edge_pair(
    a: &ConvexHull,
    scratch: &NarrowScratch,
    floor: f32,
) -> Option<EdgeAxis> {
    let mut best: Option<EdgeAxis> = None;
    let mut floor = floor;
    for edge_a in &scratch.near_a {
        for (edges, arcs) in scratch.near_b.chunks(LANES).zip(&scratch.arcs_b) {
            for (edge_b, crossing) in edges.iter().zip(arcs.crossing(edge_a)) {
                if crossing < 0.0
                    && let Some(axis) = weigh(a, scratch, edge_a, edge_b, floor)
                {
                    floor = axis.separation;
                    best = Some(axis);
                }
            }
        }
    }
    best
}

/// The axis of two edges whose arcs may cross, if it separates by more than `floor` (m).
fn weigh(
    a: &ConvexHull,
    scratch: &NarrowScratch,
    edge_a: &NearEdge,
    edge_b: &NearEdge,
    floor: f32,
) -> Option<EdgeAxis> {
    let normal = edge_axis(edge_a, edge_b)?;
    if normal.dot(edge_b.from - edge_a.from) <= floor {
        return None;
    }
    // The supports say what this axis is worth, whatever rounding did to it.
    let separation =
        lowest_height(&scratch.b_in_a, normal) + lowest_height(&a.lanes.points, -normal);
    (separation > floor).then_some(EdgeAxis {
        edges: [edge_a.index, edge_b.index],
        normal,
        separation,
    })
}

/// The common perpendicular of two edges, from A outwards, if their arcs on the Gauss map cross.
fn edge_axis(a: &NearEdge, b: &NearEdge) -> Option<Vec3> {
    // B's arc is mirrored: its ends are -m0 and -m1. With e the direction of an edge as its first face runs through it,
    // n0 x n1 is parallel to e, so e is the plane normal of the arc.
    let sides_b = b.normals.map(|m| -m.dot(a.along));
    if sides_b[0] * sides_b[1] >= 0.0 {
        return None;
    }
    let sides_a = a.normals.map(|n| n.dot(b.along));
    if sides_a[0] * sides_a[1] >= 0.0 {
        return None;
    }
    let axis = a.along.cross(b.along);
    let least = PARALLEL * PARALLEL * a.along.length_squared() * b.along.length_squared();
    if axis.length_squared() <= least {
        return None;
    }
    // Both arcs cross the other's great circle; they meet if they do so on the same side of the sphere.
    let outward = axis * 1.0_f32.copysign(axis.dot(a.normals[0] + a.normals[1]));
    (outward.dot(b.normals[0] + b.normals[1]) < 0.0).then(|| outward.normalize())
}
