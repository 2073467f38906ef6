//! Where two convex hulls touch: separating-axis test, face clipping, edge contact; and a hull against a half-space.
//!
//! Everything happens in A's frame with B's pose relative to A, so results do not depend on where in the world the
//! pair is; all tolerances are relative to the size of the smaller hull.
//!
//! # References
//! D. Gregorius, "The Separating Axis Test between Convex Polyhedra", GDC 2013: face queries, and edge queries pruned
//! on the Gauss map. Verifying each edge axis by its supports and choosing the incident face among those at the support
//! vertex are ours; they make the answer independent of how exact the axis is.

use super::manifold::{MAX_POINTS, Patch, PatchPoint, reduce};
use crate::geometry::{ConvexHull, Face};
use crate::math::{Aabb, Plane, Pose};
use glam::{Mat3, Vec3};

/// A face is preferred over an edge pair, and the first face over the second, unless the other separates better by
/// this share of the smaller hull's diagonal.
///
/// Larger values make the kind of contact steadier from step to step and the separation less exact (0.5 mm for 1 m).
const PREFER_ABSOLUTE: f32 = 5e-4;

/// The same as a share of the separation itself, for deep overlaps.
const PREFER_RELATIVE: f32 = 0.02;

/// Sine below which two edges count as parallel: their cross product is then too rounded to be an axis, and the faces
/// beside the edges bound the overlap to within this angle.
const PARALLEL: f32 = 1e-3;

/// Points nearer than this share of the smaller hull's diagonal are one contact point.
const MERGE: f32 = 1e-4;

/// Buffers of the narrow phase, one per thread; they grow to the largest hulls seen and are then reused.
#[derive(Clone, Debug, Default)]
pub struct NarrowScratch {
    /// B's vertices in A's frame, and the box around them.
    vertices: Vec<Vec3>,
    aabb: Aabb,
    /// B's face planes in A's frame.
    planes: Vec<Plane>,
    /// Polygon being clipped, and the result of the last cut.
    polygon: Vec<Vec3>,
    clipped: Vec<Vec3>,
    /// Points and separations before reduction.
    candidates: Vec<(Vec3, f32)>,
    /// Edges of either hull that are near enough to the other one to touch it, A's frame.
    near_a: Vec<NearEdge>,
    near_b: Vec<NearEdge>,
}

/// An edge as the edge test reads it, A's frame.
#[derive(Clone, Copy, Debug)]
struct NearEdge {
    index: usize,
    from: Vec3,
    along: Vec3,
    /// Outward normals of its two faces.
    normals: [Vec3; 2],
}

impl NarrowScratch {
    /// Empty buffers.
    pub fn new() -> Self {
        Self::default()
    }

    /// Brings B into A's frame.
    fn load(&mut self, b: &ConvexHull, b_in_a: &Pose) {
        let turn = Mat3::from_quat(b_in_a.rotation);
        let moved = b.vertices().iter().map(|&v| turn * v + b_in_a.position);
        self.vertices.clear();
        self.vertices.extend(moved);
        self.aabb = Aabb::of_points(self.vertices.iter().copied());
        self.planes.clear();
        self.planes.extend(b.faces().iter().map(|face| {
            let normal = turn * face.plane.normal;
            Plane {
                normal,
                offset: face.plane.offset + normal.dot(b_in_a.position),
            }
        }));
    }

    /// Collects the edges that come within `reach` (m) of the other hull's box.
    ///
    /// Where an edge pair is the best axis, the closest points of the two edges are as far apart as the hulls: by the
    /// gap, or by the depth of the overlap, which the best face bounds. Farther edges cannot be the best axis.
    fn load_near_edges(&mut self, a: &ConvexHull, b: &ConvexHull, reach: f32) {
        let (box_a, box_b) = (a.aabb(), self.aabb);
        // Rounding of the boxes and of the reach itself is far below a thousandth.
        let reach = reach + 1e-3 * (reach + box_a.diagonal().min(box_b.diagonal()));
        let (box_a, box_b) = (box_a.fattened(reach), box_b.fattened(reach));
        let normal_of_a = |face: u32| a.faces()[face as usize].plane.normal;
        let normal_of_b = |face: u32| self.planes[face as usize].normal;
        collect_near(&mut self.near_a, a, a.vertices(), normal_of_a, &box_b);
        collect_near(&mut self.near_b, b, &self.vertices, normal_of_b, &box_a);
    }
}

/// Fills `near` with the edges of `hull` that meet the box `other`; corners, normals and box along the same axes.
fn collect_near(
    near: &mut Vec<NearEdge>,
    hull: &ConvexHull,
    corners: &[Vec3],
    normal_of: impl Fn(u32) -> Vec3,
    other: &Aabb,
) {
    near.clear();
    for (index, edge) in hull.edges().iter().enumerate() {
        let [from, to] = edge.vertices.map(|v| corners[v as usize]);
        if other.overlaps(&Aabb::of_points([from, to])) {
            near.push(NearEdge {
                index,
                from,
                along: to - from,
                normals: edge.faces.map(&normal_of),
            });
        }
    }
}

/// The face of one hull that separates best from the other hull.
#[derive(Clone, Copy, Debug)]
struct FaceAxis {
    face: usize,
    /// Vertex of the other hull that lies deepest below the face.
    support: usize,
    separation: f32,
}

/// The pair of edges whose common perpendicular separates best.
#[derive(Clone, Copy, Debug)]
struct EdgeAxis {
    edges: [usize; 2],
    /// Unit vector from A to B, A's frame.
    normal: Vec3,
    separation: f32,
}

/// Contact of hull `a` with hull `b`, whose pose in A's frame is `b_in_a`; in A's frame, normal from A to B.
///
/// `None` if the hulls are farther apart than `margin` (m), or if an argument is not finite. The separation is the
/// largest over all axes of the separating-axis test, less at most a preference for faces of 0.05 % of the smaller
/// hull's diagonal; for hulls that overlap, minus the least translation that parts them.
pub fn collide_hulls(
    a: &ConvexHull,
    b: &ConvexHull,
    b_in_a: Pose,
    margin: f32,
    scratch: &mut NarrowScratch,
) -> Option<Patch> {
    if !b_in_a.is_finite() || !margin.is_finite() {
        return None;
    }
    scratch.load(b, &b_in_a);
    if centres_separate(a, scratch, margin) {
        return None;
    }
    let face_a = best_face(a.faces().iter().map(|f| f.plane), &scratch.vertices, margin)?;
    let face_b = best_face(scratch.planes.iter().copied(), a.vertices(), margin)?;
    let floor = face_a.separation.max(face_b.separation);
    let gap = gap_at_most(a, b, [&face_a, &face_b], scratch);
    scratch.load_near_edges(a, b, gap.max(-floor));
    let edge = best_edge_pair(a, scratch, floor);
    if edge.is_some_and(|e| e.separation > margin) {
        return None;
    }

    let size = a.aabb().diagonal().min(b.aabb().diagonal());
    let slack = |separation: f32| PREFER_ABSOLUTE * size + PREFER_RELATIVE * separation.abs();
    // On a tie the larger hull offers the reference face, so that the points sit on the smaller one's corners.
    let b_is_larger = b.aabb().diagonal() > a.aabb().diagonal() * (1.0 + PREFER_RELATIVE);
    let b_refers = if b_is_larger {
        face_b.separation >= face_a.separation - slack(face_a.separation)
    } else {
        face_b.separation > face_a.separation + slack(face_a.separation)
    };
    let face = if b_refers { face_b } else { face_a };

    if let Some(edge) = edge
        && edge.separation > face.separation + slack(face.separation)
    {
        return Some(edge_patch(a, b, &edge, &b_in_a, scratch));
    }
    let contact = Clipping {
        a,
        b,
        b_in_a,
        margin,
        merge: MERGE * size,
    };
    contact
        .face_patch(&face, b_refers, scratch)
        .or_else(|| edge.map(|edge| edge_patch(a, b, &edge, &b_in_a, scratch)))
        .or_else(|| contact.support_patch(&face, b_refers, scratch))
}

/// Whether the line through the middles of the two boxes separates the hulls by more than `margin`: true for most pairs
/// that do not touch, and much cheaper to find out than by the faces.
fn centres_separate(a: &ConvexHull, scratch: &NarrowScratch, margin: f32) -> bool {
    let Some(axis) = (scratch.aabb.centre() - a.aabb().centre()).try_normalize() else {
        return false;
    };
    lowest(&scratch.vertices, axis).1 + lowest(a.vertices(), -axis).1 > margin
}

/// The plane with the largest separation from `vertices`; `None` if that exceeds `margin` or nothing is comparable.
fn best_face(
    planes: impl Iterator<Item = Plane>,
    vertices: &[Vec3],
    margin: f32,
) -> Option<FaceAxis> {
    let mut best: Option<FaceAxis> = None;
    // The vertex that ruled out the last face rules out most of its neighbours too.
    let mut hint = 0;
    for (face, plane) in planes.enumerate() {
        let bar = best.map_or(f32::NEG_INFINITY, |b| b.separation);
        let height = |i: usize| plane.normal.dot(vertices[i]) - plane.offset;
        if height(hint) <= bar {
            continue;
        }
        let depth = bar + plane.offset;
        if let Some(below) = vertices.iter().position(|v| plane.normal.dot(*v) <= depth) {
            hint = below;
            continue;
        }
        let (support, separation) = lowest(vertices, plane.normal);
        let separation = separation - plane.offset;
        if separation > margin {
            return None;
        }
        if separation > bar && separation.is_finite() {
            best = Some(FaceAxis {
                face,
                support,
                separation,
            });
        }
    }
    best
}

/// An upper bound of the distance of two hulls, m: the least distance from a support vertex to a corner of its face.
fn gap_at_most(
    a: &ConvexHull,
    b: &ConvexHull,
    [face_a, face_b]: [&FaceAxis; 2],
    scratch: &NarrowScratch,
) -> f32 {
    let nearest = |hull: &ConvexHull, corners: &[Vec3], face: usize, point: Vec3| {
        let outline = hull.face_loop(&hull.faces()[face]).iter();
        let distances = outline.map(|&v| corners[v as usize].distance_squared(point));
        distances.fold(f32::INFINITY, f32::min)
    };
    let (on_a, on_b) = (a.vertices(), &scratch.vertices);
    let from_a = nearest(a, on_a, face_a.face, on_b[face_a.support]);
    let from_b = nearest(b, on_b, face_b.face, on_a[face_b.support]);
    from_a.min(from_b).sqrt()
}

/// The vertex with the smallest coordinate along `axis`, and that coordinate; the first one on a tie.
fn lowest(vertices: &[Vec3], axis: Vec3) -> (usize, f32) {
    let mut best = (0, f32::INFINITY);
    for (i, vertex) in vertices.iter().enumerate() {
        let height = axis.dot(*vertex);
        if height < best.1 {
            best = (i, height);
        }
    }
    best
}

/// The edge pair that separates better than every face (`floor`, m) and every other pair, if there is one.
///
/// An edge is an arc on the Gauss map, between the normals of its two faces. Only pairs whose arcs cross (B's being
/// mirrored) are edges of the Minkowski difference; the others cannot be the best axis and are skipped.
fn best_edge_pair(a: &ConvexHull, scratch: &NarrowScratch, floor: f32) -> Option<EdgeAxis> {
    let mut best: Option<EdgeAxis> = None;
    let mut floor = floor;
    for edge_a in &scratch.near_a {
        for edge_b in &scratch.near_b {
            let Some(normal) = edge_axis(edge_a, edge_b) else {
                continue;
            };
            if normal.dot(edge_b.from - edge_a.from) <= floor {
                continue;
            }
            // The supports say what this axis is worth, whatever rounding did to it.
            let separation = lowest(&scratch.vertices, normal).1 + lowest(a.vertices(), -normal).1;
            if separation > floor {
                floor = separation;
                best = Some(EdgeAxis {
                    edges: [edge_a.index, edge_b.index],
                    normal,
                    separation,
                });
            }
        }
    }
    best
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

/// The contact of two crossing edges: their closest points.
fn edge_patch(
    a: &ConvexHull,
    b: &ConvexHull,
    axis: &EdgeAxis,
    b_in_a: &Pose,
    scratch: &NarrowScratch,
) -> Patch {
    let edge_a = a.edges()[axis.edges[0]]
        .vertices
        .map(|v| a.vertices()[v as usize]);
    let edge_b = b.edges()[axis.edges[1]]
        .vertices
        .map(|v| scratch.vertices[v as usize]);
    let (on_a, on_b) = closest_points(edge_a, edge_b);
    // At an end of an edge the shortest way is not along the normal. The contact is where it is half way, with the gap
    // along the normal only: both bodies must see the impulse at one point, or it would change angular momentum.
    let separation = axis.normal.dot(on_b - on_a);
    let (middle, half_gap) = (0.5 * (on_a + on_b), 0.5 * separation * axis.normal);
    let (on_a, on_b) = (middle - half_gap, middle + half_gap);
    let mut patch = Patch {
        normal: axis.normal,
        ..Patch::default()
    };
    patch.push(PatchPoint {
        on_a,
        on_b: b_in_a.inverse_transform_point(on_b),
        separation,
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
struct Clipping<'h> {
    a: &'h ConvexHull,
    b: &'h ConvexHull,
    b_in_a: Pose,
    margin: f32,
    merge: f32,
}

impl Clipping<'_> {
    /// Cuts the incident face by the planes through the reference face's edges and keeps what lies within the margin.
    fn face_patch(
        &self,
        axis: &FaceAxis,
        b_refers: bool,
        scratch: &mut NarrowScratch,
    ) -> Option<Patch> {
        let reference = self.reference_plane(axis, b_refers, scratch);
        self.load_incident_face(axis, b_refers, scratch);
        let NarrowScratch {
            vertices,
            polygon,
            clipped,
            candidates,
            ..
        } = scratch;
        let (hull, corners) = if b_refers {
            (self.b, vertices.as_slice())
        } else {
            (self.a, self.a.vertices())
        };
        let outline = hull.face_loop(&hull.faces()[axis.face]);
        let mut from = corners[outline[outline.len() - 1] as usize];
        for &to in outline {
            let to = corners[to as usize];
            clip(polygon, from, (to - from).cross(reference.normal), clipped);
            std::mem::swap(polygon, clipped);
            from = to;
        }
        candidates.clear();
        candidates.extend(
            polygon
                .iter()
                .map(|&point| (point, reference.distance(point)))
                .filter(|&(_, separation)| separation <= self.margin),
        );
        reduce(candidates, reference.normal, self.merge);
        self.patch(&reference, b_refers, candidates)
    }

    /// The support vertex alone, for an overlap so small that clipping lost it to rounding.
    fn support_patch(
        &self,
        axis: &FaceAxis,
        b_refers: bool,
        scratch: &mut NarrowScratch,
    ) -> Option<Patch> {
        if axis.separation > 0.0 {
            return None;
        }
        let reference = self.reference_plane(axis, b_refers, scratch);
        let vertex = if b_refers {
            self.a.vertices()[axis.support]
        } else {
            scratch.vertices[axis.support]
        };
        self.patch(&reference, b_refers, &[(vertex, axis.separation)])
    }

    /// Plane of the reference face, A's frame.
    fn reference_plane(&self, axis: &FaceAxis, b_refers: bool, scratch: &NarrowScratch) -> Plane {
        if b_refers {
            scratch.planes[axis.face]
        } else {
            self.a.faces()[axis.face].plane
        }
    }

    /// Puts the incident face into `scratch.polygon`: of the faces at the support vertex, the one most opposed to the
    /// reference face.
    ///
    /// A face elsewhere may be more opposed yet, but would miss the deepest point.
    fn load_incident_face(&self, axis: &FaceAxis, b_refers: bool, scratch: &mut NarrowScratch) {
        let normal = self.reference_plane(axis, b_refers, scratch).normal;
        let NarrowScratch {
            vertices,
            planes,
            polygon,
            ..
        } = scratch;
        let incident = if b_refers { self.a } else { self.b };
        let height = |index: usize, face: &Face| {
            if b_refers {
                normal.dot(face.plane.normal)
            } else {
                normal.dot(planes[index].normal)
            }
        };
        let mut best: Option<(f32, &Face)> = None;
        for (index, face) in incident.faces().iter().enumerate() {
            let height = height(index, face);
            if best.is_none_or(|b| height < b.0)
                && incident.face_loop(face).contains(&(axis.support as u32))
            {
                best = Some((height, face));
            }
        }
        let corners = if b_refers {
            self.a.vertices()
        } else {
            vertices.as_slice()
        };
        polygon.clear();
        if let Some((_, face)) = best {
            polygon.extend(
                incident
                    .face_loop(face)
                    .iter()
                    .map(|&v| corners[v as usize]),
            );
        }
    }

    /// The patch of points on the incident hull, which are projected onto the reference plane for the other hull.
    fn patch(&self, reference: &Plane, b_refers: bool, points: &[(Vec3, f32)]) -> Option<Patch> {
        let mut patch = Patch {
            normal: if b_refers {
                -reference.normal
            } else {
                reference.normal
            },
            ..Patch::default()
        };
        for &(point, separation) in points.iter().take(MAX_POINTS) {
            let projected = point - separation * reference.normal;
            let (on_a, on_b) = if b_refers {
                (point, projected)
            } else {
                (projected, point)
            };
            patch.push(PatchPoint {
                on_a,
                on_b: self.b_in_a.inverse_transform_point(on_b),
                separation,
            });
        }
        (patch.count > 0).then_some(patch)
    }
}

/// One step of Sutherland and Hodgman's clipping: what of `polygon` lies behind the plane through `origin`.
///
/// `outward` need not have unit length.
fn clip(polygon: &[Vec3], origin: Vec3, outward: Vec3, result: &mut Vec<Vec3>) {
    result.clear();
    let Some(&last) = polygon.last() else {
        return;
    };
    let height = |point: Vec3| outward.dot(point - origin);
    let (mut from, mut from_height) = (last, height(last));
    for &to in polygon {
        let to_height = height(to);
        if (from_height > 0.0) != (to_height > 0.0) {
            let share = from_height / (from_height - to_height);
            result.push(from + share * (to - from));
        }
        if to_height <= 0.0 {
            result.push(to);
        }
        (from, from_height) = (to, to_height);
    }
}

/// Contact of a hull (A) with a half-space (B) whose surface is `plane`, given in the hull's frame.
///
/// The half-space is what lies below the plane; the patch's normal, from A to B, is minus the plane's. `on_b` is in the
/// half-space's frame, whose pose in the hull's frame is `b_in_a`. `None` if the hull is higher than `margin` (m) above
/// the plane, or if an argument is not finite.
pub fn collide_half_space(
    hull: &ConvexHull,
    plane: Plane,
    b_in_a: Pose,
    margin: f32,
    scratch: &mut NarrowScratch,
) -> Option<Patch> {
    if !b_in_a.is_finite() || !margin.is_finite() {
        return None;
    }
    let (support, deepest) = lowest(hull.vertices(), plane.normal);
    let deepest = deepest - plane.offset;
    if !deepest.is_finite() || deepest > margin {
        return None;
    }
    let size = hull.aabb().diagonal();
    scratch.candidates.clear();
    scratch.candidates.extend(
        lowest_face(hull, support, plane.normal)
            .iter()
            .map(|&v| hull.vertices()[v as usize])
            .map(|vertex| (vertex, plane.distance(vertex)))
            .filter(|&(_, separation)| separation <= margin),
    );
    reduce(&mut scratch.candidates, plane.normal, MERGE * size);
    let mut patch = Patch {
        normal: -plane.normal,
        ..Patch::default()
    };
    for &(on_a, separation) in &scratch.candidates {
        patch.push(PatchPoint {
            on_a,
            on_b: b_in_a.inverse_transform_point(on_a - separation * plane.normal),
            separation,
        });
    }
    (patch.count > 0).then_some(patch)
}

/// Outline of the face that looks down most, of those at the lowest vertex: the one that a falling hull lands on. Vertices
/// off it do not count, however large the margin, or four points would be spread over the whole height of a flat hull.
fn lowest_face(hull: &ConvexHull, support: usize, up: Vec3) -> &[u32] {
    let mut best: (f32, &[u32]) = (f32::INFINITY, &[]);
    for face in hull.faces() {
        let height = up.dot(face.plane.normal);
        let outline = hull.face_loop(face);
        if height < best.0 && outline.contains(&(support as u32)) {
            best = (height, outline);
        }
    }
    best.1
}
