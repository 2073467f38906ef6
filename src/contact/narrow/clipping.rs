//! Contact points of two hulls on the axis that separates best: a face clipped by another, or two edges that cross.
//!
//! Choosing the incident face among those at the support vertex is ours; it makes the answer independent of how exact
//! the axis is.

use crate::contact::local_manifold::{LocalManifold, LocalPoint};
use crate::contact::narrow::edge_search::EdgeAxis;
use crate::contact::narrow::scratch::{FaceAxis, HullPair, NarrowScratch};
use crate::contact::point::MAX_POINTS;
use crate::contact::reduce::{Candidate, CornerKind, SAG, reduce_uneven};
use crate::geometry::ConvexHull;
use crate::geometry::hull_lanes::point;
use crate::math::Plane;
use glam::Vec3;

/// The contact of two crossing edges: their closest points.
pub(crate) fn edge_patch(
    pair: &HullPair<'_>,
    axis: &EdgeAxis,
    scratch: &NarrowScratch,
) -> LocalManifold {
    let HullPair { a, b, b_in_a, .. } = *pair;
    let edge_a = a.edges()[axis.edges[0]]
        .vertices
        .map(|v| a.vertices()[v as usize]);
    let edge_b = b.edges()[axis.edges[1]]
        .vertices
        .map(|v| point(&scratch.b_in_a, v as usize));
    let (on_a, on_b) = closest_points(edge_a, edge_b);
    // At an end of an edge the shortest way is not along the normal. The contact is where it is half way, with the gap
    // along the normal only: both bodies must see the impulse at one point, or it would change angular momentum.
    let separation = axis.normal.dot(on_b - on_a);
    let slant = (on_b - on_a) - separation * axis.normal;
    let (middle, half_gap) = (0.5 * (on_a + on_b), 0.5 * separation * axis.normal);
    let (on_a, on_b) = (middle - half_gap, middle + half_gap);
    let mut patch = LocalManifold {
        normal: axis.normal,
        recycle_distance: f32::INFINITY,
        off_surface: 0.5 * slant.length(),
        ..LocalManifold::default()
    };
    patch.push(LocalPoint {
        on_a,
        on_b: b_in_a.inverse_transform_point(on_b),
        separation,
        share_b: 0.5,
        ..LocalPoint::default()
    });
    patch
}

/// Closest points of two segments that are not parallel; C. Ericson, "Real-Time Collision Detection", 5.1.9.
fn closest_points(p: [Vec3; 2], q: [Vec3; 2]) -> (Vec3, Vec3) {
    let (d1, d2, r) = (p[1] - p[0], q[1] - q[0], p[0] - q[0]);
    let (a, e, b) = (d1.length_squared(), d2.length_squared(), d1.dot(d2));
    let (c, f) = (d1.dot(r), d2.dot(r));
    let denominator = a * e - b * b;
    let s = if denominator > 0.0 {
        ((b * f - c * e) / denominator).clamp(0.0, 1.0)
    } else {
        0.5
    };
    let t = ((b * s + f) / e).clamp(0.0, 1.0);
    let s = ((b * t - c) / a).clamp(0.0, 1.0);
    (p[0] + s * d1, q[0] + t * d2)
}

/// A face contact being made.
#[derive(Debug)]
pub(crate) struct Clipping<'h> {
    pub(crate) pair: HullPair<'h>,
    pub(crate) merge: f32,
}

impl Clipping<'_> {
    /// Cuts the incident face by the planes through the reference face's edges and keeps what lies within the margin.
    pub(crate) fn face_patch(
        &self,
        axis: &FaceAxis,
        b_refers: bool,
        scratch: &mut NarrowScratch,
    ) -> LocalManifold {
        let reference = self.reference_plane(axis, b_refers, scratch);
        let incident = self.incident_face(axis, &reference, b_refers, scratch);
        self.clipped_patch(axis.face, &reference, incident, b_refers, scratch)
    }

    /// Cuts the outline of an incident face by the planes through the edges of the reference face `face`, whose plane is
    /// `reference` (A's frame), and keeps what lies within the margin. What four points do not tell is left in `scratch.beside`.
    pub(super) fn clipped_patch(
        &self,
        face: usize,
        reference: &Plane,
        incident: &[u32],
        b_refers: bool,
        scratch: &mut NarrowScratch,
    ) -> LocalManifold {
        self.load_incident_face(incident, b_refers, scratch);
        let NarrowScratch {
            b_in_a,
            polygon,
            clipped,
            lower,
            beside,
            ..
        } = scratch;
        let (hull, corners) = if b_refers {
            (self.pair.b, b_in_a.as_slice())
        } else {
            (self.pair.a, self.pair.a.lanes.points.as_slice())
        };
        let outline = hull.face_loop(&hull.faces()[face]);
        let mut from = point(corners, outline[outline.len() - 1] as usize);
        let mut recycle_distance = f32::INFINITY;
        let mut is_whole = true;
        for &to in outline {
            let to = point(corners, to as usize);
            let outward = (to - from).cross(reference.normal);
            let [nearest, highest] = heights(polygon, from, outward);
            recycle_distance = recycle_distance.min(nearest / outward.length());
            if highest > 0.0 {
                is_whole = false;
                clip(polygon, from, to - from, outward, clipped);
                std::mem::swap(polygon, clipped);
            }
            from = to;
        }
        let slide = if is_whole { recycle_distance } else { 0.0 };
        recycle_distance = recycle_distance.min(shortest_edge(polygon));
        for corner in polygon.iter_mut() {
            corner.separation = reference.distance(corner.at);
        }
        polygon.retain(|corner| corner.separation <= self.pair.margin);
        let extents = [self.pair.a, self.pair.b].map(|hull| hull.aabb().extents().min_element());
        let sag = SAG * extents[0].min(extents[1]);
        reduce_uneven(polygon, lower, reference.normal, self.merge, sag);
        let patch = |corners: &[Candidate]| LocalManifold {
            recycle_distance,
            slide,
            ..self.patch(face, reference, b_refers, corners)
        };
        *beside = (!lower.is_empty()).then(|| patch(lower));
        patch(polygon)
    }

    /// The support vertex alone, for an overlap so small that clipping lost it to rounding.
    pub(crate) fn support_patch(
        &self,
        axis: &FaceAxis,
        b_refers: bool,
        scratch: &NarrowScratch,
    ) -> LocalManifold {
        if axis.separation > 0.0 {
            return LocalManifold::default();
        }
        let reference = self.reference_plane(axis, b_refers, scratch);
        let at = if b_refers {
            self.pair.a.vertices()[axis.support]
        } else {
            point(&scratch.b_in_a, axis.support)
        };
        let vertex = Candidate {
            at,
            separation: axis.separation,
            kind: CornerKind::Incident,
            leaves_on_cut: false,
        };
        LocalManifold {
            // The other point is in the plane of the face, and may be beside it.
            off_surface: f32::INFINITY,
            ..self.patch(axis.face, &reference, b_refers, &[vertex])
        }
    }

    /// Plane of the reference face, A's frame.
    fn reference_plane(&self, axis: &FaceAxis, b_refers: bool, scratch: &NarrowScratch) -> Plane {
        if b_refers {
            scratch.plane_in_a(&axis.plane)
        } else {
            axis.plane
        }
    }

    /// Outline of the incident face: of the faces at the support vertex, the one most opposed to the reference face.
    ///
    /// A face elsewhere may be more opposed yet, but would miss the deepest point.
    fn incident_face(
        &self,
        axis: &FaceAxis,
        reference: &Plane,
        b_refers: bool,
        scratch: &NarrowScratch,
    ) -> &[u32] {
        let (incident, normal) = self.incident_hull(reference, b_refers, scratch);
        let face = incident.incident_face(axis.support, normal);
        face.map_or(&[][..], |face| incident.face_loop(face))
    }

    /// The incident hull, and the normal of the reference face in its frame.
    pub(super) fn incident_hull(
        &self,
        reference: &Plane,
        b_refers: bool,
        scratch: &NarrowScratch,
    ) -> (&ConvexHull, Vec3) {
        if b_refers {
            (self.pair.a, reference.normal)
        } else {
            (self.pair.b, scratch.turn.transpose() * reference.normal)
        }
    }

    /// Puts the incident face into `scratch.polygon`.
    fn load_incident_face(&self, outline: &[u32], b_refers: bool, scratch: &mut NarrowScratch) {
        let corners = if b_refers {
            self.pair.a.lanes.points.as_slice()
        } else {
            scratch.b_in_a.as_slice()
        };
        scratch.polygon.clear();
        scratch.polygon.extend(outline.iter().map(|&v| Candidate {
            at: point(corners, v as usize),
            separation: 0.0,
            kind: CornerKind::Incident,
            leaves_on_cut: false,
        }));
    }

    /// The patch of points on the incident hull, which are projected onto the reference plane for the other hull.
    fn patch(
        &self,
        face: usize,
        reference: &Plane,
        b_refers: bool,
        points: &[Candidate],
    ) -> LocalManifold {
        let mut patch = LocalManifold {
            normal: if b_refers {
                -reference.normal
            } else {
                reference.normal
            },
            normal_in_b: b_refers.then(|| -self.pair.b.faces()[face].plane.normal),
            ..LocalManifold::default()
        };
        for corner in points.iter().take(MAX_POINTS) {
            let projected = corner.at - corner.separation * reference.normal;
            let (on_a, on_b) = if b_refers {
                (corner.at, projected)
            } else {
                (projected, corner.at)
            };
            // A crossing stays on the reference face's edge and goes along it with the incident body.
            let (with_b, along) = match corner.kind {
                CornerKind::Incident => (!b_refers, Vec3::ZERO),
                CornerKind::Crossing(along) => (b_refers, along),
                CornerKind::Reference => (b_refers, Vec3::ZERO),
            };
            patch.push(LocalPoint {
                on_a,
                on_b: self.pair.b_in_a.inverse_transform_point(on_b),
                separation: corner.separation,
                share_b: if with_b { 1.0 } else { 0.0 },
                along,
                radii: [0.0; 2],
            });
        }
        patch
    }
}

/// Least distance of the incident body's vertices in `polygon` from the plane through `origin`, and the largest height of
/// any corner above it, both times the length of `outward`.
fn heights(polygon: &[Candidate], origin: Vec3, outward: Vec3) -> [f32; 2] {
    let (mut nearest, mut highest) = (f32::INFINITY, f32::NEG_INFINITY);
    for corner in polygon {
        let height = outward.dot(corner.at - origin);
        highest = highest.max(height);
        if matches!(corner.kind, CornerKind::Incident) {
            nearest = nearest.min(height.abs());
        }
    }
    [nearest, highest]
}

/// Length of the shortest edge of a polygon, m.
fn shortest_edge(polygon: &[Candidate]) -> f32 {
    let mut shortest = f32::INFINITY;
    let mut from = polygon.last();
    for to in polygon {
        shortest = from.map_or(shortest, |f| shortest.min(f.at.distance_squared(to.at)));
        from = Some(to);
    }
    shortest.sqrt()
}

/// One step of Sutherland and Hodgman's clipping: what of `polygon` lies behind the plane through `origin`.
///
/// The plane goes through an edge of the reference face that runs along `edge`; neither this nor `outward` need have unit
/// length.
fn clip(
    polygon: &[Candidate],
    origin: Vec3,
    edge: Vec3,
    outward: Vec3,
    result: &mut Vec<Candidate>,
) {
    result.clear();
    let Some(&last) = polygon.last() else {
        return;
    };
    let height = |corner: &Candidate| outward.dot(corner.at - origin);
    let (mut from, mut from_height) = (last, height(&last));
    for &to in polygon {
        let to_height = height(&to);
        if (from_height > 0.0) != (to_height > 0.0) {
            let share = from_height / (from_height - to_height);
            result.push(Candidate {
                at: from.at + share * (to.at - from.at),
                separation: 0.0,
                kind: if from.leaves_on_cut {
                    CornerKind::Reference
                } else {
                    CornerKind::Crossing(edge.normalize_or_zero())
                },
                leaves_on_cut: from.leaves_on_cut || to_height > 0.0,
            });
        }
        if to_height <= 0.0 {
            result.push(to);
        }
        (from, from_height) = (to, to_height);
    }
}
