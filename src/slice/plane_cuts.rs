//! Pieces cut by one plane after the other, each of which cuts all that it meets.
//!
//! Hulls are cut first, then the visual meshes in the same way. Planes through one line would leave slivers along it: where two of them
//! meet at a small angle the line is off by their rounding over that angle, and every later plane misses it a little and cuts there once more.
//! If planes have cut what a piece was part of that it touches by no more than an edge, the meshes are cut as those of cells are: each out of
//! the whole, by the planes that bound its piece.

use crate::geometry::TriMesh;
use crate::geometry::predicates::{check_plane, length_scale, plane_tolerance};
use crate::math::Plane;
use crate::slice::cell_clip::is_missed;
use crate::slice::cells::piece_of;
use crate::slice::cut::Cut;
use crate::slice::cutting::CellPlanes;
use crate::slice::flat_faces::flat_faces;
use crate::slice::{Piece, PieceCutter, SliceError, SliceOptions};
use glam::Vec3;

/// How far from a plane corners of a piece are at it, in thicknesses of a plane: what planes at an angle of a tenth may be off.
const AT_PLANE: f32 = 8.0;

/// Width of a face of a piece below which it is no more than an edge, in thicknesses of a plane: what planes at an angle of a hundredth may leave
/// beside the line that they share.
const NARROW: f32 = 32.0;

/// A piece in work.
#[derive(Debug)]
struct Part {
    piece: Piece,
    /// Number of the piece that it is part of.
    source: usize,
    /// Planes that have cut what it was part of, their normals pointing out of it.
    planes: CellPlanes,
}

/// How a piece lies at a plane that has cut what it was part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wall {
    /// It has a face there.
    Face,
    /// It has an edge there, or a face as narrow as one.
    Edge,
    /// Others have cut off what was there.
    Away,
}

impl Part {
    fn new(piece: Piece, source: usize) -> Self {
        let planes = CellPlanes::new();
        Self {
            piece,
            source,
            planes,
        }
    }

    /// How it lies at one of its planes.
    fn wall(&self, plane: &Plane) -> Wall {
        let hull = &self.piece.hull;
        let thickness = plane_tolerance(length_scale(&hull.aabb()));
        let narrow = NARROW * thickness;
        let heights = hull.vertices().iter().map(|&p| plane.distance(p));
        // A splinter along the plane has no face there that is wider than the rest of it.
        if heights.fold(f32::INFINITY, f32::min) > -2.0 * narrow {
            return Wall::Face;
        }
        let near = hull.vertices().iter().copied();
        let near = near.filter(|&p| plane.distance(p).abs() <= AT_PLANE * thickness);
        let corners: CellCorners = near.collect();
        let farthest = |from: Vec3| {
            let far = corners.iter().copied();
            far.max_by(|a, b| from.distance(*a).total_cmp(&from.distance(*b)))
        };
        let a = corners.first().and_then(|&first| farthest(first));
        let (Some(a), Some(b)) = (a, a.and_then(farthest)) else {
            return Wall::Away;
        };
        let along = (b - a).normalize_or_zero();
        let width = |p: &Vec3| (p - a).reject_from_normalized(along).length();
        match a.distance(b) > narrow {
            false => Wall::Away,
            true if corners.iter().any(|p| width(p) > narrow) => Wall::Face,
            true => Wall::Edge,
        }
    }
}

/// Corners of a piece at a plane.
type CellCorners = smallvec::SmallVec<[Vec3; 8]>;

impl PieceCutter {
    /// Cuts pieces, whose visual meshes are closed, by one plane after the other, until there are `most`.
    ///
    /// Where a plane cuts a piece, the part below takes its place and the part above follows it.
    ///
    /// # Errors
    /// [`SliceError::Plane`] for the first plane that is not usable.
    pub fn cut_pieces(
        &mut self,
        pieces: &mut Vec<Piece>,
        planes: &[Plane],
        most: usize,
        options: SliceOptions,
    ) -> Result<(), SliceError> {
        for plane in planes {
            check_plane(plane)?;
        }
        if planes.is_empty() {
            return Ok(());
        }
        let visuals = pieces.iter_mut().filter_map(|piece| piece.visual.as_mut());
        for mesh in visuals.filter(|mesh| mesh.faces.0.is_empty()) {
            mesh.faces.0 = flat_faces(mesh);
        }
        for mesh in pieces.iter().filter_map(|piece| piece.visual.as_ref()) {
            let first_free = mesh.faces.first_free(mesh.triangles.len());
            self.meshes.caps.skip_to(first_free);
        }
        let visuals: Vec<_> = pieces.iter_mut().map(|p| p.visual.take()).collect();
        let (parts, cuts) = self.cut_hulls(std::mem::take(pieces), planes, most)?;
        let has_mesh = visuals.iter().any(Option::is_some);
        let is_crowded = |part: &Part| part.planes.iter().any(|p| part.wall(p) == Wall::Edge);
        // Any two planes go through one line.
        if has_mesh && planes.len() > 2 && parts.iter().any(is_crowded) {
            self.clip_parts(parts, visuals, pieces, options);
        } else {
            pieces.extend(parts.into_iter().map(|part| part.piece));
            if has_mesh {
                self.cut_visuals(pieces, visuals, (planes, &cuts), options);
            }
        }
        Ok(())
    }

    /// The parts of the hulls of pieces, and of each plane and what there was then whether it has cut that.
    fn cut_hulls(
        &mut self,
        pieces: Vec<Piece>,
        planes: &[Plane],
        most: usize,
    ) -> Result<(Vec<Part>, Vec<bool>), SliceError> {
        let parts = pieces.into_iter().enumerate();
        let mut parts: Vec<Part> = parts.map(|(source, p)| Part::new(p, source)).collect();
        let mut cuts = Vec::new();
        for plane in planes {
            let mut count = parts.len();
            let mut next = Vec::with_capacity(2 * count);
            for part in parts {
                let is_left = count >= most || is_missed(&part.piece.hull, plane);
                let verdict = match is_left {
                    true => Cut::Below,
                    false => self.hulls.slice(&part.piece.hull, *plane)?,
                };
                let Cut::Cut(halves) = verdict else {
                    cuts.push(false);
                    next.push(part);
                    continue;
                };
                count += 1;
                cuts.push(true);
                for (hull, wall) in [(halves.below, *plane), (halves.above, plane.flipped())] {
                    let mut half = Part::new(piece_of(hull, None), part.source);
                    half.planes
                        .extend(part.planes.iter().copied().chain([wall]));
                    next.push(half);
                }
            }
            parts = next;
        }
        Ok((parts, cuts))
    }

    /// Cuts the visual meshes of pieces as their hulls were cut.
    fn cut_visuals(
        &mut self,
        pieces: &mut [Piece],
        mut visuals: Vec<Option<TriMesh>>,
        (planes, cuts): (&[Plane], &[bool]),
        options: SliceOptions,
    ) {
        let mut cuts = cuts.iter();
        for plane in planes {
            let mut next = Vec::with_capacity(2 * visuals.len());
            for visual in visuals {
                match cuts.next() {
                    Some(true) => next.extend(self.divide_visual(visual, plane, options)),
                    _ => next.push(visual),
                }
            }
            visuals = next;
        }
        for (piece, visual) in pieces.iter_mut().zip(visuals) {
            piece.visual = visual;
        }
        self.merge_faces(pieces);
    }

    /// Cuts the visual mesh of each part out of that of its piece, by the planes that bound it.
    fn clip_parts(
        &mut self,
        parts: Vec<Part>,
        visuals: Vec<Option<TriMesh>>,
        pieces: &mut Vec<Piece>,
        options: SliceOptions,
    ) {
        let mut parts = parts.into_iter().peekable();
        for (source, visual) in visuals.into_iter().enumerate() {
            let first = pieces.len();
            self.walls.clear();
            self.wall_ends.clear();
            while let Some(part) = parts.next_if(|part| part.source == source) {
                let bounds = |plane: &&Plane| part.wall(plane) == Wall::Face;
                self.walls.extend(part.planes.iter().filter(bounds));
                self.wall_ends.push(self.walls.len());
                pieces.push(part.piece);
            }
            if let Some(mesh) = visual {
                self.clip_visuals(&mesh, &mut pieces[first..], options);
            }
        }
    }

    /// The parts of a visual mesh below and above a plane.
    fn divide_visual(
        &mut self,
        visual: Option<TriMesh>,
        plane: &Plane,
        options: SliceOptions,
    ) -> [Option<TriMesh>; 2] {
        let Some(mesh) = visual else {
            return [None, None];
        };
        if mesh.triangles.is_empty() {
            return [Some(mesh.clone()), Some(mesh)];
        }
        self.gone_through += mesh.triangles.len();
        match self.meshes.slice_closed(&mesh, plane, options) {
            Cut::Below => [Some(mesh), Some(TriMesh::default())],
            Cut::Above => [Some(TriMesh::default()), Some(mesh)],
            Cut::Cut(parts) => [Some(parts.below), Some(parts.above)],
        }
    }
}
