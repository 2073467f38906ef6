//! Models from glTF and GLB files: the nodes of a scene become objects.
//!
//! # References
//! - Khronos Group, *glTF 2.0 Specification*, section 3.7 (meshes, skins).

use crate::import::error::ModelFileError;
use crate::import::gltf_data::File;
use crate::import::gltf_skin::Skeleton;
use crate::import::model::{Model, ModelObject};
use glam::Mat4;
use gltf::Node;

impl Model {
    /// A model from the bytes of a .gltf or .glb file: the nodes of its scene, each an object in the scene's frame, skins as
    /// they are at rest. `read` gives the bytes of a file that is named by the document, relative to it; data within the
    /// document is read without it.
    ///
    /// # Errors
    /// [`ModelFileError`] says what is missing, damaged or compressed.
    pub fn from_gltf(
        bytes: &[u8],
        read: impl Fn(&str) -> std::io::Result<Vec<u8>>,
    ) -> Result<Self, ModelFileError> {
        let file = File::open(bytes, read)?;
        let mut model = Self {
            materials: (file.document.materials())
                .map(|material| material.name().unwrap_or("unnamed").to_string())
                .collect(),
            ..Self::default()
        };
        model.note_extensions(&file.extensions);
        let skeleton = Skeleton::of(&file)?;
        for (node, scene_from_node) in skeleton.nodes() {
            model.append_node(&file, &skeleton, node, *scene_from_node)?;
        }
        Ok(model)
    }

    fn note_extensions(&mut self, extensions: &[String]) {
        for extension in extensions {
            if extension != "KHR_mesh_quantization" {
                self.notes.push(format!(
                    "the extension {extension} is left out; it does not change shapes"
                ));
            }
        }
    }

    fn append_node(
        &mut self,
        file: &File,
        skeleton: &Skeleton<'_>,
        node: &Node<'_>,
        scene_from_node: Mat4,
    ) -> Result<(), ModelFileError> {
        let Some(mesh) = node.mesh() else {
            return Ok(());
        };
        let unnamed = || format!("node {}", node.index());
        let name = node
            .name()
            .or(mesh.name())
            .map_or_else(unnamed, str::to_string);
        let mut object = ModelObject {
            name,
            ..ModelObject::default()
        };
        for primitive in mesh.primitives() {
            let Some(triangles) = file.triangles(&primitive)? else {
                self.notes
                    .push(format!("points or lines of '{}' are left out", object.name));
                continue;
            };
            let mut part = file.vertices(&primitive)?;
            let mirrored = skeleton.place(file, node, &primitive, scene_from_node, &mut part)?;
            let turn = |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
            part.triangles = triangles.into_iter().map(turn).collect();
            let slot = primitive.material().index().unwrap_or(self.materials.len());
            part.materials = vec![slot as u16; part.triangles.len()];
            if part.normals.is_empty() {
                part = part.with_smooth_normals();
            }
            object.append(part);
        }
        if !object.triangles.is_empty() {
            self.objects.push(object);
        }
        Ok(())
    }
}
