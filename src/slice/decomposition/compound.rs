//! A compound of a mesh that is not convex.

use crate::geometry::{Compound, CompoundPart, ConvexMesh, TriMesh};
use crate::slice::decomposition::{
    ConvexPart, DecompositionError, DecompositionOptions, decompose,
};

impl From<ConvexPart> for CompoundPart {
    fn from(part: ConvexPart) -> Self {
        ConvexMesh::from_hull(part.hull).into()
    }
}

impl Compound {
    /// The convex parts of a closed mesh, which is what is drawn. The mass is that of the parts, which may stick out of the mesh as far as
    /// the options say.
    ///
    /// # Errors
    /// As [`decompose`].
    pub fn from_mesh(
        mesh: TriMesh,
        options: DecompositionOptions,
    ) -> Result<Self, DecompositionError> {
        let parts = decompose(&mesh, options)?;
        let compound = Self::new(parts).map_err(|_| DecompositionError::Options {
            max_concavity: options.max_concavity,
            max_parts: options.max_parts,
        })?;
        Ok(compound.with_visual(mesh))
    }
}
