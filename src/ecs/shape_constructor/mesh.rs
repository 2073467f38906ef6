//! Meshes as data.

use crate::geometry::{MeshError, TriMesh};
use bevy_math::{Vec2, Vec3, Vec4};

/// A [`TriMesh`] as data. Attributes have one entry per vertex or none, slots one per triangle or none.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct MeshDescription {
    /// m.
    pub positions: Vec<Vec3>,
    /// Unit vectors.
    pub normals: Vec<Vec3>,
    /// Linear RGBA.
    pub colors: Vec<Vec4>,
    /// Texture coordinates.
    pub uvs: Vec<Vec2>,
    /// Vertex numbers, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Material slots.
    pub materials: Vec<u16>,
    /// How many triangles, the first ones, are sheets.
    pub sheets: u32,
}

impl MeshDescription {
    /// The description of a mesh.
    pub fn of(mesh: &TriMesh) -> Self {
        Self {
            positions: mesh.positions().to_vec(),
            normals: mesh.normals().to_vec(),
            colors: mesh.colors().to_vec(),
            uvs: mesh.uvs().to_vec(),
            triangles: mesh.triangles().to_vec(),
            materials: mesh.materials().to_vec(),
            sheets: mesh.sheets() as u32,
        }
    }

    /// The mesh.
    ///
    /// # Errors
    /// As [`TriMesh::new`] and the functions that set attributes.
    pub fn build(&self) -> Result<TriMesh, MeshError> {
        let mut mesh = TriMesh::new(self.positions.clone(), self.triangles.clone())?;
        if !self.normals.is_empty() {
            mesh = mesh.with_normals(self.normals.clone())?;
        }
        if !self.colors.is_empty() {
            mesh = mesh.with_colors(self.colors.clone())?;
        }
        if !self.uvs.is_empty() {
            mesh = mesh.with_uvs(self.uvs.clone())?;
        }
        if !self.materials.is_empty() {
            mesh = mesh.with_materials(self.materials.clone())?;
        }
        mesh.with_sheets(self.sheets as usize)
    }
}
