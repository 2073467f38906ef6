//! Where two convex hulls touch: separating-axis test over faces and edges.
//!
//! Everything happens in A's frame with B's pose relative to A, so results do not depend on where in the world the
//! pair is; all tolerances are relative to the size of the smaller hull.
//!
//! # References
//! D. Gregorius, "The Separating Axis Test between Convex Polyhedra", GDC 2013: face queries, and edge queries pruned
//! on the Gauss map. Verifying each edge axis by its supports, and leaving out the edges that the best faces rule out,
//! are ours.

pub use super::half_space::collide_half_space;

use super::clipping::{Clipping, edge_patch};
use super::manifold::{Candidate, Patch};
use crate::geometry::ConvexHull;
use crate::geometry::lanes::{LANES, Points4, bounds, lowest, lowest_height, move_points, point};
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
pub(super) const MERGE: f32 = 1e-4;

/// Buffers of the narrow phase, one per thread; they grow to the largest hulls seen and are then reused.
#[derive(Clone, Debug, Default)]
pub struct NarrowScratch {
    /// B's vertices in A's frame, and the box around them.
    pub(super) b_in_a: Vec<Points4>,
    aabb: Aabb,
    /// A's vertices in B's frame.
    a_in_b: Vec<Points4>,
    /// Pose of B in A's frame.
    pub(super) turn: Mat3,
    shift: Vec3,
    /// Polygon being clipped, and the result of the last cut.
    pub(super) polygon: Vec<Candidate>,
    pub(super) clipped: Vec<Candidate>,
    /// Edges of either hull that may be the best axis.
    near_a: Vec<NearEdge>,
    near_b: Vec<NearEdge>,
    /// The numbers of `near_b` that rule out most pairs, in lanes.
    arcs_b: Vec<Arcs4>,
    /// What [`Vicinity::classify`] says of each vertex.
    classes: Vec<[u8; LANES]>,
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

/// Directions of four edges and the normals of their faces: arcs on the Gauss map.
#[derive(Clone, Copy, Debug, Default)]
struct Arcs4 {
    along: Points4,
    normals: [Points4; 2],
}

impl Arcs4 {
    /// Which of the four arcs and the arc of `edge` each cross the great circle of the other; see [`edge_axis`].
    fn crossing(&self, edge: &NearEdge) -> [bool; LANES] {
        let sides = [
            self.normals[0].along(edge.along),
            self.normals[1].along(edge.along),
            self.along.along(edge.normals[0]),
            self.along.along(edge.normals[1]),
        ];
        let mut crossing = [false; LANES];
        for l in 0..LANES {
            let (here, there) = (sides[0][l] * sides[1][l], sides[2][l] * sides[3][l]);
            crossing[l] = (here < 0.0) & (there < 0.0);
        }
        crossing
    }
}

impl NarrowScratch {
    /// Empty buffers.
    pub fn new() -> Self {
        Self::default()
    }

    /// Brings B into A's frame and A into B's.
    fn load(&mut self, a: &ConvexHull, b: &ConvexHull, b_in_a: &Pose) {
        self.turn = Mat3::from_quat(b_in_a.rotation);
        self.shift = b_in_a.position;
        let back = self.turn.transpose();
        move_points(&mut self.b_in_a, &b.lanes.points, &self.turn, self.shift);
        let origin = -(back * self.shift);
        move_points(&mut self.a_in_b, &a.lanes.points, &back, origin);
        self.aabb = bounds(&b.lanes.points, &self.turn, self.shift);
    }

    /// A plane of B in A's frame.
    pub(super) fn plane_in_a(&self, plane: &Plane) -> Plane {
        let normal = self.turn * plane.normal;
        Plane {
            normal,
            offset: plane.offset + normal.dot(self.shift),
        }
    }

    /// Collects the edges that can be the best axis, given that no axis separates by more than `reach` (m) nor by less
    /// than `-reach`.
    ///
    /// Where an edge pair is the best axis, a point of the one edge and a point of the other are as far apart as the
    /// hulls, by the gap or by the depth of the overlap: at most `reach`. Each point lies in its own hull. So either
    /// edge comes within `reach` of the other hull's box. And of a face that separates by `s`, its own hull being below
    /// and the other one above `s`, the edge of its own hull has a point above `s - reach`, the other below `reach`.
    fn load_near_edges(
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
        for (index, edge) in hull.edges().iter().enumerate() {
            let (v, w) = (edge.vertices[0] as usize, edge.vertices[1] as usize);
            if classes[v / LANES][v % LANES] | classes[w / LANES][w % LANES] != 3 {
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

/// The face of one hull that separates best from the other hull.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceAxis {
    pub(super) face: usize,
    /// Its plane, in its own hull's frame.
    pub(super) plane: Plane,
    /// Vertex of the other hull that lies deepest below the face.
    pub(super) support: usize,
    pub(super) separation: f32,
}

/// The pair of edges whose common perpendicular separates best.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeAxis {
    pub(super) edges: [usize; 2],
    /// Unit vector from A to B, A's frame.
    pub(super) normal: Vec3,
    pub(super) separation: f32,
}

/// What the test of a pair found.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Found {
    /// The hulls are at least `distance` (m) apart, which is more than the margin, along `axis`.
    Apart {
        /// Unit vector from A to B, A's frame.
        axis: Vec3,
        /// Distance along it, m.
        distance: f32,
    },
    /// No axis separates by more than the margin. The patch may be empty, where two corners pass each other.
    Near(Patch),
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
    match examine_hulls(a, b, b_in_a, margin, scratch) {
        Found::Near(patch) if patch.count > 0 => Some(patch),
        _ => None,
    }
}

/// As [`collide_hulls`], which it does the work of, and says by which axis hulls are apart.
pub(crate) fn examine_hulls(
    a: &ConvexHull,
    b: &ConvexHull,
    b_in_a: Pose,
    margin: f32,
    scratch: &mut NarrowScratch,
) -> Found {
    if !b_in_a.is_finite() || !margin.is_finite() {
        return Found::Near(Patch::default());
    }
    // The line through the middles of the two boxes separates most pairs that do not touch.
    let middles = b_in_a.transform_point(b.aabb().centre()) - a.aabb().centre();
    if let Some(axis) = middles.try_normalize() {
        let distance = distance_along(a, b, &b_in_a, axis);
        if distance > margin {
            return Found::Apart { axis, distance };
        }
    }
    scratch.load(a, b, &b_in_a);
    match Axes::find(a, b, middles, margin, scratch) {
        Err(apart) => apart,
        Ok(None) => Found::Near(Patch::default()),
        Ok(Some(axes)) => axes.choose(a, b, &b_in_a, margin, scratch),
    }
}

/// Distance of two hulls along a unit vector from A to B (A's frame), m.
pub(crate) fn distance_along(a: &ConvexHull, b: &ConvexHull, b_in_a: &Pose, axis: Vec3) -> f32 {
    let axis_in_b = Mat3::from_quat(b_in_a.rotation).transpose() * axis;
    lowest_height(&b.lanes.points, axis_in_b)
        + axis.dot(b_in_a.position)
        + lowest_height(&a.lanes.points, -axis)
}

/// The best faces of a pair that no face separates by more than the margin.
#[derive(Debug)]
struct Axes {
    face_a: FaceAxis,
    face_b: FaceAxis,
}

impl Axes {
    /// `Err` if a face separates the hulls, `None` if nothing is comparable. `middles` points from A's middle to B's.
    #[allow(
        clippy::result_large_err,
        reason = "what it holds is the answer, and goes up one call"
    )]
    fn find(
        a: &ConvexHull,
        b: &ConvexHull,
        middles: Vec3,
        margin: f32,
        scratch: &NarrowScratch,
    ) -> Result<Option<Self>, Found> {
        let face_a = best_face(a, &scratch.b_in_a, middles);
        let apart = |axis: Vec3, face: &FaceAxis| Found::Apart {
            axis,
            distance: face.separation,
        };
        if face_a.separation > margin {
            return Err(apart(face_a.plane.normal, &face_a));
        }
        let back = -(scratch.turn.transpose() * middles);
        let face_b = best_face(b, &scratch.a_in_b, back);
        if face_b.separation > margin {
            return Err(apart(-(scratch.turn * face_b.plane.normal), &face_b));
        }
        let comparable = face_a.separation.is_finite() && face_b.separation.is_finite();
        Ok(comparable.then_some(Self { face_a, face_b }))
    }

    /// Weighs the faces against each other and against the edges, and makes the contact.
    fn choose(
        &self,
        a: &ConvexHull,
        b: &ConvexHull,
        b_in_a: &Pose,
        margin: f32,
        scratch: &mut NarrowScratch,
    ) -> Found {
        let Self { face_a, face_b } = self;
        let (extent_a, extent_b) = (a.aabb().diagonal(), b.aabb().diagonal());
        let size = extent_a.min(extent_b);
        let slack = |separation: f32| PREFER_ABSOLUTE * size + PREFER_RELATIVE * separation.abs();
        // On a tie the larger hull offers the reference face, so that the points sit on the smaller one's corners.
        let b_is_larger = extent_b > extent_a * (1.0 + PREFER_RELATIVE);
        let b_refers = if b_is_larger {
            face_b.separation >= face_a.separation - slack(face_a.separation)
        } else {
            face_b.separation > face_a.separation + slack(face_a.separation)
        };
        let face = if b_refers { face_b } else { face_a };

        // Edges matter if they separate by more than this. No axis separates by more than the distance of the hulls.
        let bar = face.separation + slack(face.separation);
        let best_of_faces = face_a.separation.max(face_b.separation);
        let threshold = bar.min(margin.max(best_of_faces));
        let gap = self.gap_at_most(a, b, scratch);
        let reach = gap.max(-best_of_faces);
        let search = |floor: f32, scratch: &mut NarrowScratch| {
            scratch.load_near_edges(a, b, [face_a, face_b], reach);
            best_edge_pair(a, scratch, floor)
        };
        let edge = (gap > threshold)
            .then(|| search(threshold, scratch))
            .flatten();
        if let Some(edge) = edge {
            if edge.separation > margin {
                return Found::Apart {
                    axis: edge.normal,
                    distance: edge.separation,
                };
            }
            if edge.separation > bar {
                return Found::Near(edge_patch(a, b, &edge, b_in_a, scratch));
            }
        }
        let contact = Clipping {
            a,
            b,
            b_in_a,
            margin,
            merge: MERGE * size,
        };
        let patch = contact.face_patch(face, b_refers, scratch);
        if patch.count > 0 {
            return Found::Near(patch);
        }
        Found::Near(match search(best_of_faces, scratch) {
            Some(edge) if edge.separation <= margin => edge_patch(a, b, &edge, b_in_a, scratch),
            _ => contact.support_patch(face, b_refers, scratch),
        })
    }

    /// An upper bound of the distance of two hulls, m: from a support vertex to the face that it supports.
    fn gap_at_most(&self, a: &ConvexHull, b: &ConvexHull, scratch: &NarrowScratch) -> f32 {
        let Self { face_a, face_b } = self;
        let from_a = distance_from_face(a, face_a, point(&scratch.b_in_a, face_a.support));
        if from_a <= face_a.separation.max(0.0) {
            return from_a;
        }
        let from_b = distance_from_face(b, face_b, point(&scratch.a_in_b, face_b.support));
        from_a.min(from_b)
    }
}

/// Distance of a point from a face, m; 0 for a point behind the face, which may be inside the hull.
fn distance_from_face(hull: &ConvexHull, axis: &FaceAxis, place: Vec3) -> f32 {
    let outline = hull.face_loop(&hull.faces()[axis.face]);
    let mut is_beside = false;
    let mut nearest = f32::INFINITY;
    let mut from = hull.vertices()[outline[outline.len() - 1] as usize];
    for &to in outline {
        let to = hull.vertices()[to as usize];
        let (along, offset) = (to - from, place - from);
        is_beside |= along.cross(axis.plane.normal).dot(offset) > 0.0;
        let share = (along.dot(offset) / along.length_squared()).clamp(0.0, 1.0);
        nearest = nearest.min((offset - share * along).length_squared());
        from = to;
    }
    if is_beside {
        nearest.sqrt()
    } else {
        axis.separation.max(0.0)
    }
}

/// The face of `hull` with the largest separation from `points`, the first one on a tie; same frame.
///
/// The search starts with the face that looks most towards the other hull (`towards`): that changes the effort, never the
/// answer.
fn best_face(hull: &ConvexHull, points: &[Points4], towards: Vec3) -> FaceAxis {
    let evaluate = |face: usize| {
        let plane = hull.faces()[face].plane;
        let (support, height) = lowest(points.iter(), plane.normal);
        FaceAxis {
            face,
            plane,
            support,
            separation: height - plane.offset,
        }
    };
    let normals = hull.lanes.planes.iter().map(|planes| &planes.normals);
    let (start, _) = lowest(normals, -towards);
    let mut best = evaluate(start.min(hull.faces().len() - 1));
    // A vertex of the other hull bounds the separation of every face from above: most are ruled out by the one that
    // supports the best face so far.
    let mut witness = point(points, best.support);
    for (group, planes) in hull.lanes.planes.iter().enumerate() {
        let heights = planes.heights(witness);
        if heights.iter().all(|&h| h < best.separation) {
            continue;
        }
        for (l, &height) in heights.iter().enumerate() {
            let face = group * LANES + l;
            if height < best.separation || face >= hull.faces().len() || face == best.face {
                continue;
            }
            let axis = evaluate(face);
            let is_first = axis.separation == best.separation && face < best.face;
            if axis.separation > best.separation || is_first {
                best = axis;
                witness = point(points, axis.support);
            }
        }
    }
    best
}

/// The edge pair that separates better than `floor` (m) and every other pair, if there is one.
///
/// An edge is an arc on the Gauss map, between the normals of its two faces. Only pairs whose arcs cross (B's being
/// mirrored) are edges of the Minkowski difference; the others cannot be the best axis and are skipped.
fn best_edge_pair(a: &ConvexHull, scratch: &NarrowScratch, floor: f32) -> Option<EdgeAxis> {
    let mut best: Option<EdgeAxis> = None;
    let mut floor = floor;
    for edge_a in &scratch.near_a {
        for (edges, arcs) in scratch.near_b.chunks(LANES).zip(&scratch.arcs_b) {
            let crossing = arcs.crossing(edge_a);
            if crossing == [false; LANES] {
                continue;
            }
            for (edge_b, crosses) in edges.iter().zip(crossing) {
                let candidate = crosses.then(|| weigh(a, scratch, edge_a, edge_b, floor));
                if let Some(Some(axis)) = candidate {
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
