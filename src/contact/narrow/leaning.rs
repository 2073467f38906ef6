//! Two edges that cross while a face beside one of them all but faces the other body: a rod that lies on a rod and leans a
//! little. One point would let it roll until the next step finds that the face lies there; what the other edge nears along
//! the face belongs to the contact, with its gap.

use crate::contact::local_manifold::{LocalManifold, LocalPoint};
use crate::contact::narrow::clipping::Clipping;
use crate::contact::narrow::edge_search::EdgeAxis;
use crate::contact::narrow::scratch::NarrowScratch;
use crate::geometry::ConvexHull;
use crate::math::Plane;
use glam::Vec3;

/// Least cosine between the normal of a contact of edges and that of a face that is taken in with it.
const LEAST_COSINE: f32 = 0.98;

/// A face beside one of two edges that cross.
struct Beside {
    face: usize,
    /// Whether it is B's.
    is_of_b: bool,
    /// Its plane, A's frame.
    plane: Plane,
    /// How much it faces the other body along the normal of the contact.
    cosine: f32,
}

/// The contact of two edges that cross, with what else of them comes near along a face beside one of them; `None` if no such face
/// nearly faces the other body, or nothing more is within the margin.
pub(super) fn leaning_patch(
    clipping: &Clipping<'_>,
    edge: &EdgeAxis,
    scratch: &mut NarrowScratch,
) -> Option<LocalManifold> {
    let beside = facing(clipping, edge, scratch)?;
    let (incident, towards) = clipping.incident_hull(&beside.plane, beside.is_of_b, scratch);
    let outline = most_opposed(incident, edge.edges[usize::from(!beside.is_of_b)], towards);
    let patch =
        clipping.clipped_patch(beside.face, &beside.plane, outline, beside.is_of_b, scratch);
    let patch = along_axis(clipping, &patch, edge.normal, &beside);
    let gaps = patch.points().iter().map(|point| point.separation);
    let deepest = gaps.fold(f32::INFINITY, f32::min);
    let is_same = (deepest - edge.separation).abs() <= clipping.merge;
    let found = (patch.count > 1 && is_same).then_some(patch);
    let lower = scratch.beside.filter(|_| found.is_some());
    scratch.beside = lower.map(|lower| along_axis(clipping, &lower, edge.normal, &beside));
    found
}

/// Of the faces beside the two edges, the one that faces the other body most.
fn facing(clipping: &Clipping<'_>, edge: &EdgeAxis, scratch: &NarrowScratch) -> Option<Beside> {
    let pair = clipping.pair;
    let of_a = pair.a.edges()[edge.edges[0]].faces.map(|face| {
        let plane = pair.a.faces()[face as usize].plane;
        (face, false, plane, edge.normal)
    });
    let of_b = pair.b.edges()[edge.edges[1]].faces.map(|face| {
        let plane = scratch.plane_in_a(&pair.b.faces()[face as usize].plane);
        (face, true, plane, -edge.normal)
    });
    let all = of_a.into_iter().chain(of_b);
    let all = all.map(|(face, is_of_b, plane, towards)| Beside {
        face: face as usize,
        is_of_b,
        plane,
        cosine: plane.normal.dot(towards),
    });
    let best = all.reduce(|best, next| {
        if next.cosine > best.cosine {
            next
        } else {
            best
        }
    })?;
    (best.cosine >= LEAST_COSINE).then_some(best)
}

/// Outline of that face beside an edge which is most opposed to a direction.
fn most_opposed(hull: &ConvexHull, edge: usize, towards: Vec3) -> &[u32] {
    let [first, second] = hull.edges()[edge]
        .faces
        .map(|face| &hull.faces()[face as usize]);
    let opposed = if first.plane.normal.dot(towards) <= second.plane.normal.dot(towards) {
        first
    } else {
        second
    };
    hull.face_loop(opposed)
}

/// A patch on a face seen along the normal of the contact: gaps are as long as the way along it.
fn along_axis(
    clipping: &Clipping<'_>,
    patch: &LocalManifold,
    normal: Vec3,
    beside: &Beside,
) -> LocalManifold {
    let b_in_a = clipping.pair.b_in_a;
    let mut patch = LocalManifold {
        normal,
        normal_in_b: None,
        ..*patch
    };
    let count = patch.count as usize;
    for point in &mut patch.points[..count] {
        let separation = point.separation / beside.cosine;
        let (on_a, on_b) = if beside.is_of_b {
            (point.on_a, point.on_a + separation * normal)
        } else {
            let on_b = b_in_a.transform_point(point.on_b);
            (on_b - separation * normal, on_b)
        };
        *point = LocalPoint {
            on_a,
            on_b: b_in_a.inverse_transform_point(on_b),
            separation,
            ..*point
        };
    }
    patch
}
