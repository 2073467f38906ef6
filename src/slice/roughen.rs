//! Pieces with relief on the faces that cuts have made, as a step of its own after the cuts.

use crate::geometry::{ConvexMesh, TriMesh};
use crate::slice::cutting::Cutting;
use crate::slice::relief::settings::Relief;
use crate::slice::{Piece, PieceCutter, SliceError, SliceOptions};
use std::borrow::Cow;

/// What the faces of cuts look like.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct CutLooks {
    pub(crate) options: SliceOptions,
    /// Their relief, and its seed.
    pub(crate) relief: Option<(Relief, u64)>,
    /// Whether pieces whose visual meshes are in several parts stay in one: see [`Fracturable::separate_parts`].
    ///
    /// [`Fracturable::separate_parts`]: crate::slice::fracturable::Fracturable::separate_parts
    pub(crate) keeps_parts: bool,
}

impl CutLooks {
    /// Whether the faces are told from the rest by what no hull has.
    fn needs_mesh(&self) -> bool {
        self.relief.is_some() || self.options.cap_material.is_some()
    }

    /// The mesh of a shape that is cut with it: the one that rides inside, or, if there is none and faces get relief or a slot, that of
    /// its hull.
    pub(crate) fn visual_of<'a>(&self, shape: &'a ConvexMesh) -> Option<Cow<'a, TriMesh>> {
        match shape.visual() {
            Some(mesh) => Some(Cow::Borrowed(mesh)),
            None => self.needs_mesh().then(|| shape.render_mesh()),
        }
    }

    /// Whether [`visual_of`](Self::visual_of) a shape has anything to see.
    pub(crate) fn has_visual(&self, shape: &ConvexMesh) -> bool {
        let visual = shape.visual();
        visual.map_or(self.needs_mesh(), |mesh| !mesh.triangles().is_empty())
    }

    /// Farthest that a face is from where it was cut, m.
    pub(crate) fn amplitude(&self) -> f64 {
        self.relief
            .map_or(0.0, |(relief, _)| relief.amplitude.into())
    }
}

impl PieceCutter {
    /// Gives the faces of visual meshes that the last [`cut`](Self::cut), and all [`cut_pieces`](Self::cut_pieces) since, have made
    /// a relief; hulls and volumes stay. The same pieces and seed give the same relief, and pieces that were made together fit each
    /// other. A relief whose lengths are not positive and finite leaves the pieces as they are.
    pub fn roughen(&mut self, pieces: &mut [Piece], relief: &Relief, seed: u64) {
        let meshes = pieces.iter_mut().filter_map(|piece| piece.visual.as_mut());
        let mut meshes: Vec<&mut TriMesh> = meshes.collect();
        if relief.is_usable() {
            self.relief
                .run(&mut meshes, &self.meshes.caps, relief, seed);
        }
    }

    /// As [`cut`](Self::cut), of a shape, with faces that look as is said.
    pub(super) fn cut_shape(
        &mut self,
        shape: &ConvexMesh,
        cutting: &Cutting,
        most: usize,
        looks: &CutLooks,
    ) -> Result<Vec<Piece>, SliceError> {
        let visual = looks.visual_of(shape);
        let visual = visual.as_deref();
        let mut pieces = self.cut(shape.hull(), visual, cutting, most, looks.options)?;
        if let Some((relief, seed)) = looks.relief {
            self.roughen(&mut pieces, &relief, seed);
        }
        Ok(pieces)
    }
}
