//! A body cut by several planes, with the visual mesh that rides in it.

use super::{HullHalves, HullSlice, HullSlicer};
use crate::geometry::predicates::check_plane;
use crate::geometry::{ConvexHull, TriMesh};
use crate::math::Plane;
use crate::slice::{Slice, SliceError, SliceOptions, slice_closed};

/// A piece of a body that was cut by several planes.
#[derive(Clone, Debug)]
pub struct Piece {
    /// The piece of the body's hull.
    pub hull: ConvexHull,
    /// The part of the body's visual mesh inside the piece, if the body has one. Without triangles if the piece holds
    /// nothing of it.
    pub visual: Option<TriMesh>,
    /// Volume of the hull, m3.
    pub volume: f64,
}

/// Cuts a hull, and the closed mesh that rides in it, by one plane after the other; every plane cuts every piece.
///
/// A visual mesh without triangles stays one: the piece of an earlier cut that held nothing of it.
///
/// The pieces come in an order that depends on hull and planes only: where a plane cuts a piece, the part below takes
/// its place and the part above follows it. A plane that misses a piece leaves it as it is.
///
/// # Errors
/// [`SliceError::Plane`] for the first plane that is not usable; [`SliceError::Mesh`] if the visual mesh is not closed.
pub fn cut_by_planes(
    hull: &ConvexHull,
    visual: Option<&TriMesh>,
    planes: &[Plane],
    options: SliceOptions,
) -> Result<Vec<Piece>, SliceError> {
    for plane in planes {
        check_plane(plane)?;
    }
    if let Some(mesh) = visual.filter(|mesh| !mesh.triangles.is_empty()) {
        mesh.check_closed()?;
    }
    let mut slicer = HullSlicer::default();
    let mut pieces = vec![Piece {
        hull: hull.clone(),
        visual: visual.cloned(),
        volume: hull.volume(),
    }];
    for &plane in planes {
        let mut cut = Vec::with_capacity(2 * pieces.len());
        for piece in pieces {
            match slicer.slice(&piece.hull, plane)? {
                HullSlice::Below | HullSlice::Above => cut.push(piece),
                HullSlice::Cut(halves) => cut.extend(divide_piece(piece, *halves, plane, options)),
            }
        }
        pieces = cut;
    }
    Ok(pieces)
}

/// The two pieces that a piece becomes, given the parts of its hull.
fn divide_piece(
    piece: Piece,
    halves: HullHalves,
    plane: Plane,
    options: SliceOptions,
) -> [Piece; 2] {
    let [below, above] = match piece.visual {
        None => [None, None],
        Some(mesh) if mesh.triangles.is_empty() => [Some(mesh.clone()), Some(mesh)],
        Some(mesh) => match slice_closed(&mesh, &plane, options) {
            Slice::Below => [Some(mesh), Some(TriMesh::default())],
            Slice::Above => [Some(TriMesh::default()), Some(mesh)],
            Slice::Cut(parts) => [Some(parts.below), Some(parts.above)],
        },
    };
    [(halves.below, below), (halves.above, above)].map(|(hull, visual)| Piece {
        volume: hull.volume(),
        hull,
        visual,
    })
}
