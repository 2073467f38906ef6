//! Buffers of the narrow phase, and what its parts tell each other.

use crate::contact::local_manifold::LocalManifold;
use crate::contact::reduce::Candidate;
use crate::geometry::ConvexHull;
use crate::geometry::hull_lanes::{LANES, Points4, bounds, lowest, move_points};
use crate::math::{Aabb, Plane, Pose};
use glam::{Mat3, Vec3};

/// Points nearer than this share of the smaller hull's diagonal are one contact point.
pub(crate) const MERGE: f32 = 1e-4;

/// Two hulls that may touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HullPair<'h> {
    pub(crate) a: &'h ConvexHull,
    pub(crate) b: &'h ConvexHull,
    /// B's pose in A's frame.
    pub(crate) b_in_a: &'h Pose,
    /// How far they may be apart and touch, m.
    pub(crate) margin: f32,
}

/// Buffers of the narrow phase, one per thread; they grow to the largest hulls seen and are then reused.
#[derive(Clone, Debug, Default)]
pub struct NarrowScratch {
    /// B's vertices in A's frame, and the box around them.
    pub(crate) b_in_a: Vec<Points4>,
    pub(crate) aabb: Aabb,
    /// A's vertices in B's frame.
    pub(crate) a_in_b: Vec<Points4>,
    /// Pose of B in A's frame.
    pub(crate) turn: Mat3,
    shift: Vec3,
    /// Polygon being clipped, and the result of the last cut.
    pub(crate) polygon: Vec<Candidate>,
    pub(crate) clipped: Vec<Candidate>,
    /// Corners that bear beside those that were chosen.
    pub(crate) lower: Vec<Candidate>,
    /// What bears beside the patch of the last pair, if something does.
    pub(crate) beside: Option<LocalManifold>,
    /// Edges of either hull that may be the best axis.
    pub(crate) near_a: Vec<NearEdge>,
    pub(crate) near_b: Vec<NearEdge>,
    /// The numbers of `near_b` that rule out most pairs, in lanes.
    pub(crate) arcs_b: Vec<Arcs4>,
    /// What `Vicinity::classify` says of each vertex.
    pub(crate) classes: Vec<[u8; LANES]>,
    /// The faces of A and B that separate best, of the last pair whose faces were compared.
    pub(crate) best_faces: [u32; 2],
}

impl NarrowScratch {
    /// Empty buffers.
    pub fn new() -> Self {
        Self::default()
    }

    /// Brings B into A's frame and A into B's.
    pub(crate) fn load(&mut self, a: &ConvexHull, b: &ConvexHull, b_in_a: &Pose) {
        self.turn = Mat3::from_quat(b_in_a.rotation);
        self.shift = b_in_a.position;
        let back = self.turn.transpose();
        move_points(&mut self.b_in_a, &b.lanes.points, &self.turn, self.shift);
        let origin = -(back * self.shift);
        move_points(&mut self.a_in_b, &a.lanes.points, &back, origin);
        self.aabb = bounds(&b.lanes.points, &self.turn, self.shift);
    }

    /// A plane of B in A's frame.
    pub(crate) fn plane_in_a(&self, plane: &Plane) -> Plane {
        let normal = self.turn * plane.normal;
        Plane {
            normal,
            offset: plane.offset + normal.dot(self.shift),
        }
    }
}

/// The face of one hull that separates best from the other hull.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceAxis {
    pub(crate) face: usize,
    /// Its plane, in its own hull's frame.
    pub(crate) plane: Plane,
    /// Vertex of the other hull that lies deepest below the face.
    pub(crate) support: usize,
    pub(crate) separation: f32,
}

impl FaceAxis {
    /// A face of `hull`, with how far it separates from the points of the other hull, same frame.
    #[inline]
    pub(crate) fn new(hull: &ConvexHull, face: usize, points: &[Points4]) -> Self {
        let plane = hull.faces()[face].plane;
        let (support, height) = lowest(points.iter(), plane.normal);
        Self {
            face,
            plane,
            support,
            separation: height - plane.offset,
        }
    }
}

/// What the test of a pair found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "it is handed up at once, and never kept"
)]
pub(crate) enum SatResult {
    /// The hulls are at least `distance` (m) apart, which is more than the margin, along `axis`.
    Separated {
        /// Unit vector from A to B, A's frame.
        axis: Vec3,
        /// Distance along it, m.
        distance: f32,
    },
    /// No axis separates by more than the margin. The patch may be empty, where two corners pass each other.
    Touching(LocalManifold),
}

/// What is known of two hulls before they are tested. It changes the effort, never the answer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SatCache {
    /// They are not farther apart than this, m.
    pub(crate) gap: f32,
    /// Unit vector from A to B, A's frame, that may separate better than any face.
    pub(crate) axis: Option<Vec3>,
    /// Faces of A and B that may separate best.
    pub(crate) faces: Option<[u32; 2]>,
}

impl SatCache {
    /// Nothing is known.
    pub(crate) const NONE: Self = Self {
        gap: f32::INFINITY,
        axis: None,
        faces: None,
    };
}

/// An edge as the edge test reads it, A's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearEdge {
    pub(crate) index: usize,
    pub(crate) from: Vec3,
    pub(crate) along: Vec3,
    /// Outward normals of its two faces.
    pub(crate) normals: [Vec3; 2],
}

/// Directions of four edges and the normals of their faces: arcs on the Gauss map.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Arcs4 {
    pub(crate) along: Points4,
    pub(crate) normals: [Points4; 2],
}

impl Arcs4 {
    /// For each of the four arcs, a number below zero if it and the arc of `edge` each cross the great circle of the other;
    /// see [`edge_axis`].
    pub(crate) fn crossing(&self, edge: &NearEdge) -> [f32; LANES] {
        let sides = [
            self.normals[0].along(edge.along),
            self.normals[1].along(edge.along),
            self.along.along(edge.normals[0]),
            self.along.along(edge.normals[1]),
        ];
        let mut crossing = [0.0; LANES];
        for l in 0..LANES {
            let (here, there) = (sides[0][l] * sides[1][l], sides[2][l] * sides[3][l]);
            crossing[l] = if here > there { here } else { there };
        }
        crossing
    }
}
