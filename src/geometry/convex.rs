//! `ConvexHull`: planes, face loops and edges of a convex polyhedron.

use crate::math::{Aabb, Plane};
use glam::Vec3;

/// A face of a convex hull: a planar convex polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Plane of the face, its normal pointing outwards.
    pub plane: Plane,
    /// First entry of the face's loop in [`ConvexHull::loops`].
    pub first: u32,
    /// Number of vertices of the loop.
    pub count: u32,
}

/// An undirected edge of a convex hull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// End points, in the order in which `faces[0]` runs through them.
    pub vertices: [u32; 2],
    /// The two faces that share the edge.
    pub faces: [u32; 2],
}

/// A convex polyhedron as polygon faces, in the body's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexHull {
    pub(crate) vertices: Vec<Vec3>,
    pub(crate) faces: Vec<Face>,
    pub(crate) loops: Vec<u32>,
    pub(crate) edges: Vec<Edge>,
    pub(crate) aabb: Aabb,
}

/// Why points or faces do not make a convex hull.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HullError {
    /// A coordinate is NaN or infinite.
    #[error("point {point} is not finite")]
    NotFinite {
        /// Index of the point.
        point: usize,
    },
    /// Fewer than four points.
    #[error("a body needs at least 4 points, got {found}")]
    TooFewPoints {
        /// Number of points.
        found: usize,
    },
    /// All points lie on one plane, line or point, within the tolerance.
    #[error("the points are flat: thickness {thickness} m at size {size} m")]
    Flat {
        /// Smallest extent found, m.
        thickness: f64,
        /// Diagonal of the bounding box, m.
        size: f64,
    },
    /// The mesh that the hull was to be made from is not usable.
    #[error(transparent)]
    Mesh(#[from] super::MeshError),
    /// The result does not pass [`ConvexHull::validate`].
    #[error("the hull is not valid: {0}")]
    Invalid(#[from] HullDefect),
}

/// What is wrong with a hull; see [`ConvexHull::validate`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HullDefect {
    /// Vertices - edges + faces is not 2.
    #[error("Euler's formula fails: {vertices} - {edges} + {faces} is not 2")]
    Euler {
        /// Number of vertices.
        vertices: usize,
        /// Number of edges.
        edges: usize,
        /// Number of faces.
        faces: usize,
    },
    /// A face's edge has no partner in another face.
    #[error("edge {from}-{to} of face {face} has no partner")]
    Open {
        /// First vertex.
        from: u32,
        /// Second vertex.
        to: u32,
        /// Face.
        face: usize,
    },
    /// A vertex lies outside the plane of a face.
    #[error("vertex {vertex} lies {distance} m outside face {face}")]
    NotConvex {
        /// Vertex.
        vertex: usize,
        /// Face.
        face: usize,
        /// Distance, m.
        distance: f32,
    },
    /// The volume is zero or negative, so the faces do not point outwards.
    #[error("the faces enclose {volume} m3")]
    Inward {
        /// Signed volume, m3.
        volume: f64,
    },
}

impl ConvexHull {
    /// Vertices, m.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// Faces.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// Vertex indices of all face loops, one after the other.
    pub fn loops(&self) -> &[u32] {
        &self.loops
    }

    /// Undirected edges, each once.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Bounding box in the body's frame.
    pub fn aabb(&self) -> Aabb {
        self.aabb
    }

    /// Vertex indices of one face, counter-clockwise seen from outside.
    pub fn face_loop(&self, face: &Face) -> &[u32] {
        &self.loops[face.first as usize..(face.first + face.count) as usize]
    }

    /// The faces as triangle fans.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        self.faces.iter().flat_map(|face| {
            let corners = self.face_loop(face);
            corners[1..]
                .windows(2)
                .map(move |pair| [corners[0], pair[0], pair[1]])
        })
    }
}
