//! A body divided into many pieces over several steps, because its mesh is large.
//!
//! The cells are found at once; then their parts of the mesh are cut out one after the other, in the same order and with the same pieces as
//! in one go.

use crate::geometry::{ConvexHull, TriMesh};
use crate::slice::cell_visuals::ClipQueue;
use crate::slice::cutting::Cutting;
use crate::slice::{Piece, PieceCutter, SliceError, SliceOptions};

/// A cut that is being made.
#[derive(Clone, Debug, Default)]
pub(crate) struct CutJob {
    cutter: PieceCutter,
    mesh: TriMesh,
    options: SliceOptions,
    queue: ClipQueue,
    pieces: Vec<Piece>,
}

impl CutJob {
    /// Finds the cells of a hull; see [`PieceCutter::cut`], also for the errors.
    ///
    /// Planes do not divide into cells: the pieces are then none.
    pub(crate) fn begin(
        hull: &ConvexHull,
        visual: &TriMesh,
        (cutting, most): (&Cutting, usize),
        options: SliceOptions,
    ) -> Result<Self, SliceError> {
        visual.check_closed()?;
        let mut cutter = PieceCutter::default();
        let (pieces, mesh) = cutter.begin_cells(hull, Some(visual), cutting, most)?;
        let queue = ClipQueue::new(pieces.len(), mesh.as_deref(), options);
        Ok(Self {
            cutter,
            mesh: mesh.map_or_else(TriMesh::default, |mesh| mesh.into_owned()),
            options,
            queue,
            pieces,
        })
    }

    /// Goes on until planes were held against so many triangles, or a part more; whether it is done.
    pub(crate) fn work(&mut self, triangles: usize) -> bool {
        let Self {
            cutter,
            mesh,
            options,
            queue,
            pieces,
        } = self;
        let end = cutter.gone_through.saturating_add(triangles.max(1));
        while !queue.is_empty() && cutter.gone_through < end {
            cutter.clip_next(mesh, queue, pieces, *options);
        }
        queue.is_empty()
    }

    /// Number of pieces that it will make.
    pub(crate) fn len(&self) -> usize {
        self.pieces.len()
    }

    /// Triangles that planes were held against since this was asked last.
    pub(crate) fn take_gone_through(&mut self) -> usize {
        self.cutter.take_gone_through()
    }

    /// The pieces, once it is done, and who made them.
    pub(crate) fn finish(self) -> (Vec<Piece>, PieceCutter) {
        (self.pieces, self.cutter)
    }
}

impl PieceCutter {
    /// Triangles of meshes that planes were held against since this was asked last.
    pub(crate) fn take_gone_through(&mut self) -> usize {
        std::mem::take(&mut self.gone_through)
    }

    /// Counts what another one has gone through.
    pub(crate) fn add_gone_through(&mut self, triangles: usize) {
        self.gone_through += triangles;
    }
}
