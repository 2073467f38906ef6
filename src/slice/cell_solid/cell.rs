//! A cell to be cut out of a mesh.

use crate::geometry::{ConvexHull, TriMesh};
use crate::math::Plane;
use crate::slice::SliceOptions;

/// A cell to be cut out of a mesh.
#[derive(Clone, Copy, Debug)]
pub(in crate::slice) struct Cell<'a> {
    pub(in crate::slice) mesh: &'a TriMesh,
    /// The triangles of the mesh that may reach into the cell, in ascending order.
    pub(in crate::slice) triangles: &'a [u32],
    pub(in crate::slice) hull: &'a ConvexHull,
    /// Half the thickness of a plane, m.
    pub(in crate::slice) tolerance: f32,
    /// How many topology numbers the mesh uses.
    pub(in crate::slice) topology_count: u32,
    /// The planes that were cut off the hull of the mesh, among them those of all faces that the hull does not have from there.
    pub(in crate::slice) walls: &'a [Plane],
    pub(in crate::slice) options: SliceOptions,
}

impl Cell<'_> {
    /// Whether its triangles have material slots.
    pub(super) fn has_slots(&self) -> bool {
        !self.mesh.materials.is_empty() || self.options.cap_material.is_some()
    }
}
