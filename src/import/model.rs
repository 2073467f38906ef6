//! A model as a file or an artist's tool has it.

use glam::{Vec2, Vec3, Vec4};

/// Objects with triangles, as a file has them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// The objects, all in one frame, m.
    pub objects: Vec<ModelObject>,
    /// Names of the materials that triangles name by number, if the source has names.
    pub materials: Vec<String>,
    /// What its reader has to say; becomes part of the report.
    pub notes: Vec<String>,
}

/// One object of a model. An attribute has one entry for each vertex or none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelObject {
    /// What the artist calls it.
    pub name: String,
    /// m.
    pub positions: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Texture coordinates.
    pub uvs: Vec<Vec2>,
    /// Linear RGBA.
    pub colors: Vec<Vec4>,
    /// Vertex numbers, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Material slots of the triangles, one for each; empty for slot 0.
    pub materials: Vec<u16>,
}

impl Model {
    /// A model of one object.
    pub fn from_object(object: ModelObject) -> Self {
        Self {
            objects: vec![object],
            ..Self::default()
        }
    }
}
