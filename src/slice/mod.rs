//! Cutting: a plane against a closed triangle mesh, and against a convex hull.
//!
//! Works in the body's frame on plain data. Both sides are made from the same classification of the same vertices, so
//! they are exactly complementary: no gap, no overlap, no crack.
//!
//! Vertices nearer to the plane than `plane_tolerance` (`geometry/predicates.rs`) are on it and stay
//! where they are. From then on every decision follows from the three-way side of each vertex, never from a second look at
//! coordinates. A closed mesh therefore gives closed parts, whatever its shape; only the shape of the cap's triangles
//! depends on geometry.
//!
//! The cut of meshes (`clip.rs`, `border.rs`, `cap.rs`) follows the paper step by step and takes any closed surface; the tests hold the
//! cuts of convex hulls (`convex.rs`) and of cells (`cells.rs`), which know more and are faster, against it and against each other.
//! Flat faces that cuts divide are few triangles again afterwards (`merge_faces.rs`); what a face is goes with its triangles, and is
//! found once (`flat_faces.rs`).
//! How an impact divides a body is a pattern (`pattern.rs`), which gives planes, cells or sites (`cutting.rs`, `tilings.rs`, `even_sites.rs`); another pattern goes
//! there. What makes a body breakable is `fracturable.rs`.
//!
//! Where it is asked for, faces of cuts get relief afterwards (`relief/`).
//!
//! What is not convex becomes convex parts in `decomposition/`; bodies of such parts are cut in `compound.rs`.
//!
//! Must not know bodies or contacts. Read `clip.rs` first.
//!
//! # References
//! - The steps (old-vertex table, undirected-edge table, border from directed edges without partner, fan cap) are those
//!   of "Constraint-Based Physics With Real-Time Object Slicing".

pub(crate) mod attributes;
mod border;
mod cap;
mod cap_planes;
mod cell_clip;
mod cell_solid;
mod cell_visuals;
pub(crate) mod cells;
mod clip;
pub(crate) mod components;
pub(crate) mod compound;
pub(crate) mod convex;
pub(crate) mod crack_area;
mod cut;
pub(crate) mod cut_job;
pub(crate) mod cutting;
mod decomposition;
mod edge_lists;
mod edge_table;
mod even_sites;
pub(crate) mod flat_faces;
pub(crate) mod fracturable;
mod merge_faces;
mod mesh_slicer;
pub(crate) mod pattern;
mod plane_cuts;
mod random;
mod relief;
pub(crate) mod rim_fill;
pub(crate) mod roughen;
pub(crate) mod separate;
mod tilings;

pub use cells::{Piece, PieceCutter, cut_by_planes};
pub use components::split_components;
pub use convex::{HullHalves, HullSlicer, slice_hull};
pub use crack_area::cells_for_energy;
pub use cut::Cut;
pub use cutting::{CellPlanes, Cutting, Planes};
pub use decomposition::{ConvexPart, DecompositionError, DecompositionOptions, decompose};
pub use fracturable::{Fracturable, FracturableError};
pub use mesh_slicer::MeshSlicer;
pub use pattern::{FracturePattern, Impact};
pub use relief::settings::Relief;

use crate::geometry::{HullError, MeshError, PlaneError, TriMesh};
use crate::math::Plane;
use glam::Vec4;

/// The two parts of a mesh that a plane cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Halves {
    /// The part on the side that the plane's normal points away from.
    pub below: TriMesh,
    /// The part on the side that the normal points to.
    pub above: TriMesh,
    /// The new surface, which both parts have.
    pub cap: Cap,
}

/// The new surface of a cut.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cap {
    /// Area, m2.
    pub area: f64,
    /// Number of closed border loops.
    pub loops: usize,
    /// Number of triangles; they are the last ones of each part.
    pub triangles: usize,
}

/// Choices for [`slice_mesh`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SliceOptions {
    /// Linear RGBA color of the cap. Without one the cap takes the colors of its rim. If the mesh has no colors, the
    /// old surface becomes white, which leaves a texture or material as it was.
    pub cap_color: Option<Vec4>,
    /// Material slot of the cap's triangles. If the mesh has no slots, those of the old surface become 0. Without one,
    /// the cap of a mesh that has slots gets 0.
    pub cap_material: Option<u16>,
    /// Normals of the cap, if the mesh has normals.
    pub cap_normals: CapNormals,
}

/// Which normals the vertices of a cap have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CapNormals {
    /// That of the plane: a flat face with a crease at its rim.
    #[default]
    Flat,
    /// Those of the surface at the rim: shading runs on over the rim without a crease.
    Smooth,
}

/// Why something was not cut.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SliceError {
    /// The plane is not usable.
    #[error(transparent)]
    Plane(#[from] PlaneError),
    /// The mesh is not usable; for an open mesh, names the open edge.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A part is not a convex hull.
    #[error(transparent)]
    Hull(#[from] HullError),
}

/// Cuts a closed mesh by a plane into two closed meshes.
///
/// `plane` is in the mesh's frame (m). Seams stay seams, attributes are interpolated on cut edges, and each part gets a
/// cap with the plane's normal, texture coordinates in metres along the plane's tangents, and vertices of its own.
/// The parts share the positions of the cut bit for bit, and their volumes add up to that of the mesh.
/// What earlier cuts of the mesh made of one flat face is merged again, so that triangles do not multiply.
///
/// # Errors
/// [`SliceError::Plane`] if the plane has NaN or infinite numbers or no unit normal; [`SliceError::Mesh`] if the mesh is
/// open, non-manifold or empty.
pub fn slice_mesh(
    mesh: &TriMesh,
    plane: Plane,
    options: SliceOptions,
) -> Result<Cut<Box<Halves>>, SliceError> {
    MeshSlicer::default().slice(mesh, plane, options)
}
