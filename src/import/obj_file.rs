//! Models from OBJ files.

use crate::import::error::ModelFileError;
use crate::import::model::{Model, ModelObject};
use glam::{Vec2, Vec3};

impl Model {
    /// A model from the text of an OBJ file. Of its materials only the slots are kept: how many the file has been through.
    ///
    /// # Errors
    /// [`ModelFileError::Damaged`] says why the text cannot be read.
    pub fn from_obj(text: &str) -> Result<Self, ModelFileError> {
        let options = tobj::LoadOptions {
            triangulate: true,
            single_index: true,
            ..tobj::LoadOptions::default()
        };
        // Materials are in another file, which shapes do not need.
        let no_materials = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
        let read = tobj::load_obj_buf(&mut text.as_bytes(), &options, no_materials);
        let (objects, _) = read.map_err(|error| ModelFileError::Damaged {
            reason: error.to_string(),
        })?;
        let objects = objects
            .into_iter()
            .map(object)
            .filter(|object| !object.triangles.is_empty());
        Ok(Self {
            objects: objects.collect(),
            ..Self::default()
        })
    }
}

fn object(tobj::Model { mesh, name, .. }: tobj::Model) -> ModelObject {
    let vectors = |flat: &[f32]| {
        flat.as_chunks()
            .0
            .iter()
            .copied()
            .map(Vec3::from_array)
            .collect()
    };
    let uvs = mesh.texcoords.as_chunks().0;
    let colors = mesh.vertex_color.as_chunks().0;
    let object = ModelObject {
        name,
        positions: vectors(&mesh.positions),
        normals: vectors(&mesh.normals),
        uvs: uvs.iter().copied().map(Vec2::from_array).collect(),
        colors: colors
            .iter()
            .map(|&c| Vec3::from_array(c).extend(1.0))
            .collect(),
        triangles: mesh.indices.as_chunks().0.to_vec(),
        materials: Vec::new(),
    };
    if object.normals.is_empty() {
        object.with_smooth_normals()
    } else {
        object
    }
}
