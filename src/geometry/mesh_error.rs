//! What can be wrong with a mesh.

use glam::Vec3;

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
    /// The list of material slots has neither zero nor one entry per triangle.
    #[error("{found} material slots for {triangles} triangles")]
    MaterialLength {
        /// Entries found.
        found: usize,
        /// Number of triangles.
        triangles: usize,
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
    /// More triangles are to be sheets than there are.
    #[error("{count} of {triangles} triangles cannot be sheets")]
    TooManySheets {
        /// How many were asked for.
        count: usize,
        /// Number of triangles.
        triangles: usize,
    },
    /// The mesh has no triangles.
    #[error("the mesh has no triangles")]
    Empty,
    /// A scale factor is zero, negative or not finite.
    #[error("a mesh cannot be scaled by {factor}")]
    BadScale {
        /// The factors along x, y and z.
        factor: Vec3,
    },
    /// The enclosed volume is zero, or negative because the triangles face inwards.
    #[error("the mesh encloses a volume of {volume} m3")]
    NoVolume {
        /// Signed volume, m3.
        volume: f64,
    },
}
