//! Models from files by the ending of their names.

use crate::import::error::ModelFileError;
use crate::import::model::Model;
use std::path::Path;

impl Model {
    /// Reads a model file: `.glb` and `.gltf` with the cargo feature `gltf`, `.obj` with `obj`. Normals that the file lacks are
    /// computed, with creases kept.
    ///
    /// # Errors
    /// [`ModelFileError`] says what is wrong with the file, and what to do.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, ModelFileError> {
        let path = path.as_ref();
        let extension = path
            .extension()
            .and_then(|e| e.to_str())
            .unwrap_or("")
            .to_ascii_lowercase();
        match extension.as_str() {
            #[cfg(feature = "gltf")]
            "glb" | "gltf" => {
                Self::from_gltf(&bytes(path)?, |uri| std::fs::read(path.with_file_name(uri)))
            }
            #[cfg(feature = "obj")]
            "obj" => Self::from_obj(&String::from_utf8_lossy(&bytes(path)?)),
            _ => Err(ModelFileError::UnknownFormat { extension }),
        }
    }
}

#[cfg(any(feature = "gltf", feature = "obj"))]
fn bytes(path: &Path) -> Result<Vec<u8>, ModelFileError> {
    let unreadable = |error| ModelFileError::Unreadable {
        path: path.display().to_string(),
        error,
    };
    std::fs::read(path).map_err(unreadable)
}
