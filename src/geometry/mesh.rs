//! `TriMesh`: triangles with per-vertex attributes, and what can be wrong with them.

use crate::math::Aabb;
use glam::{Vec2, Vec3, Vec4};

/// A triangle mesh with per-vertex attributes.
///
/// A vertex is a position with its attributes; vertices that differ only in attributes (a seam) share a position.
/// `topology[v]` numbers the distinct positions, so that closedness and connectivity are judged on positions while
/// seams stay seams. An attribute array is either empty or has one entry per vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) colours: Vec<Vec4>,
    pub(crate) uvs: Vec<Vec2>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) topology: Vec<u32>,
}

/// Why a mesh was refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A coordinate or attribute is NaN or infinite.
    #[error("vertex {vertex} is not finite")]
    NotFinite {
        /// Index of the vertex.
        vertex: usize,
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} names vertex {index}, but there are {vertices}")]
    IndexOutOfRange {
        /// Index of the triangle.
        triangle: usize,
        /// The vertex it names.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// An attribute array has neither zero nor one entry per vertex.
    #[error("{attribute} has {found} entries for {vertices} vertices")]
    AttributeLength {
        /// Which attribute.
        attribute: &'static str,
        /// Entries found.
        found: usize,
        /// Number of vertices.
        vertices: usize,
    },
    /// A directed edge has no partner: the surface has a hole, or its triangles disagree about outside.
    #[error("the mesh is open: edge {from}-{to} of triangle {triangle} has no partner")]
    Open {
        /// First vertex of the edge.
        from: u32,
        /// Second vertex of the edge.
        to: u32,
        /// The triangle the edge belongs to.
        triangle: usize,
    },
    /// A directed edge is used by more than one triangle.
    #[error("edge {from}-{to} is used more than once, again by triangle {triangle}")]
    NonManifold {
        /// First vertex of the edge.
        from: u32,
        /// Second vertex of the edge.
        to: u32,
        /// A triangle that uses it again.
        triangle: usize,
    },
    /// The mesh has no triangles.
    #[error("the mesh has no triangles")]
    Empty,
    /// The enclosed volume is zero, or negative because the triangles face inwards.
    #[error("the mesh encloses a volume of {volume} m3")]
    NoVolume {
        /// Signed volume, m3.
        volume: f64,
    },
}

impl TriMesh {
    /// Positions, m.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Unit normals, one per vertex, or empty.
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Linear RGBA colours, one per vertex, or empty.
    pub fn colours(&self) -> &[Vec4] {
        &self.colours
    }

    /// Texture coordinates, one per vertex, or empty.
    pub fn uvs(&self) -> &[Vec2] {
        &self.uvs
    }

    /// Triangles as vertex indices, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// For each vertex the number of its position; vertices at the same position have the same number.
    pub fn topology(&self) -> &[u32] {
        &self.topology
    }

    /// The smallest box around the vertices.
    pub fn aabb(&self) -> Aabb {
        Aabb::of_points(self.positions.iter().copied())
    }
}
