//! A body divided into many convex pieces at once.
//!
//! A cell is clipped out of the body's hull plane by plane, keeping the inside only, in `f64`: neighbors that share a wall
//! find its corners from the same planes, and agree about them to rounding. For cells that are given by points (Voronoi
//! cells) the walls are the bisectors with the other points, nearest first; a point more than twice as far away as the
//! farthest corner of what is left cannot cut it any more.
//!
//! # References
//! - C. H. Rycroft, "VORO++: A three-dimensional Voronoi cell library in C++", Chaos 19, 041111, 2009 (cells by clipping).
//! - B. Levy, N. Bonneel, "Variational Anisotropic Surface Meshing with Voronoi Parallel Linear Enumeration", Proceedings of
//!   the 21st International Meshing Roundtable, 2013 (the radius of security).

use crate::geometry::predicates::check_plane;
use crate::geometry::{ConvexHull, TriMesh};
use crate::math::Plane;
use crate::slice::cell_clip::{CellClipper, CutPlane};
use crate::slice::cell_solid::CellSolid;
use crate::slice::convex::HullSlicer;
use crate::slice::cut::Cut;
use crate::slice::cutting::CellPlanes;
use crate::slice::cutting::Cutting;
use crate::slice::flat_faces::flat_faces;
use crate::slice::merge_faces::FaceMerger;
use crate::slice::mesh_slicer::MeshSlicer;
use crate::slice::relief::ReliefMaker;
use crate::slice::separate::{fit_hulls, separate};
use crate::slice::{SliceError, SliceOptions};
use crate::tuning::NEAREST_SITES;
use glam::Vec3;
use std::borrow::Cow;
use std::ops::Range;

/// A piece of a body.
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

impl Piece {
    /// Whether it has a part that is seen.
    pub(crate) fn is_seen(&self) -> bool {
        let visual = self.visual.as_ref();
        visual.is_some_and(|mesh| !mesh.triangles().is_empty())
    }
}

/// Cuts a hull, and the closed mesh that rides in it, by one plane after the other; every plane cuts every piece.
///
/// The order of the pieces, and what is refused, are those of [`PieceCutter::cut`] for [`Cutting::Planes`].
///
/// # Errors
/// As [`PieceCutter::cut`].
pub fn cut_by_planes(
    hull: &ConvexHull,
    visual: Option<&TriMesh>,
    planes: &[Plane],
    options: SliceOptions,
) -> Result<Vec<Piece>, SliceError> {
    let cutting = Cutting::Planes(planes.iter().copied().collect());
    PieceCutter::default().cut(hull, visual, &cutting, usize::MAX, options)
}

/// Makes pieces of bodies, one after the other, keeping its working memory.
#[derive(Clone, Debug, Default)]
pub struct PieceCutter {
    pub(super) hulls: HullSlicer,
    pub(super) meshes: MeshSlicer,
    clipper: CellClipper,
    pub(super) solid: CellSolid,
    /// Planes that cut the hulls of the cells, cell by cell.
    pub(super) walls: Vec<Plane>,
    /// Where the walls of each cell that is no longer in work end.
    pub(super) wall_ends: Vec<usize>,
    /// How many corners of a mesh are above the walls of a cell.
    pub(super) wall_order: Vec<(usize, Plane)>,
    /// Squared distance (m2) from the point in work to the others, and their numbers.
    nearest: Vec<(f64, u32)>,
    pub(super) spare: TriMesh,
    pub(super) merger: FaceMerger,
    pub(super) relief: ReliefMaker,
    /// Triangles of meshes that planes were held against, since somebody asked last.
    pub(super) gone_through: usize,
}

impl PieceCutter {
    /// Divides a hull, and the closed mesh that rides in it, into at most `most` pieces.
    ///
    /// The order of the pieces depends on hull and cutting only. Planes leave a piece alone once there are enough; of
    /// cells and points the first ones are taken, so that a list of cells that is longer than `most` does not fill the
    /// body. A visual mesh without triangles stays one: the piece of an earlier cut that held nothing of it.
    ///
    /// # Errors
    /// [`SliceError::Plane`] for the first plane that is not usable; [`SliceError::Mesh`] if the visual mesh is not
    /// closed; [`SliceError::Hull`] if a piece does not make a hull although it is not flat.
    pub fn cut(
        &mut self,
        hull: &ConvexHull,
        visual: Option<&TriMesh>,
        cutting: &Cutting,
        most: usize,
        options: SliceOptions,
    ) -> Result<Vec<Piece>, SliceError> {
        if let Some(mesh) = visual.filter(|mesh| !mesh.triangles.is_empty()) {
            mesh.check_closed()?;
        }
        if let Cutting::Planes(planes) = cutting {
            self.begin_caps(visual);
            let mut pieces = vec![Piece {
                hull: hull.clone(),
                visual: visual.cloned(),
                volume: hull.volume(),
            }];
            self.cut_pieces(&mut pieces, planes, most, options)?;
            return Ok(pieces);
        }
        let (mut pieces, marked) = self.begin_cells(hull, visual, cutting, most)?;
        if let Some(mesh) = marked {
            self.clip_visuals(&mesh, &mut pieces, options);
        }
        Ok(pieces)
    }

    fn begin_caps(&mut self, visual: Option<&TriMesh>) {
        let first_cap = visual.map_or(0, |mesh| mesh.faces.first_free(mesh.triangles.len()));
        self.meshes.caps.begin(first_cap);
    }

    /// The cells as pieces that have no meshes yet, and the mesh with its faces known.
    pub(super) fn begin_cells<'m>(
        &mut self,
        hull: &ConvexHull,
        visual: Option<&'m TriMesh>,
        cutting: &Cutting,
        most: usize,
    ) -> Result<(Vec<Piece>, Option<Cow<'m, TriMesh>>), SliceError> {
        self.begin_caps(visual);
        let marked = visual.map(|mesh| {
            let mut mesh = Cow::Borrowed(mesh);
            if mesh.faces.0.is_empty() {
                let faces = flat_faces(&mesh);
                mesh.to_mut().faces.0 = faces;
            }
            mesh
        });
        self.walls.clear();
        self.wall_ends.clear();
        let pieces = match cutting {
            Cutting::Planes(_) => Vec::new(),
            Cutting::Cells(cells) => {
                for plane in cells.iter().flatten() {
                    check_plane(plane)?;
                }
                self.clip_cells(hull, cells, most)?
            }
            Cutting::Sites(sites) => self.clip_sites(hull, sites, most)?,
        };
        Ok((pieces, marked))
    }

    /// Merges the triangles of flat faces that cuts have divided.
    pub(super) fn merge_faces(&mut self, pieces: &mut [Piece]) {
        for mesh in pieces.iter_mut().filter_map(|piece| piece.visual.as_mut()) {
            self.merger.merge(mesh, None);
        }
    }

    /// Takes pieces apart whose visual meshes are in several parts: a piece for each part, with the convex hull around it,
    /// in the order of the parts' first triangles.
    ///
    /// A cut through the legs of a table leaves stumps that hold together only because their half of the hull does; apart,
    /// each falls on its own. The new hulls hold less than the old one: the air between the parts, which had counted as
    /// material, is lost. Parts whose hulls reach into each other would push each other away; they stay one piece with the
    /// hull around them, and a part too thin for a hull goes with the largest one. A cavity is no part of its own.
    ///
    /// # Errors
    /// [`SliceError::Hull`] if a part does not make a hull although it is not flat.
    pub fn separate(&mut self, pieces: &mut Vec<Piece>) -> Result<(), SliceError> {
        separate(pieces, &mut self.clipper)
    }

    /// Gives each piece whose hull holds air the hull around its visual mesh; whether there was one. A mesh too flat for a hull
    /// leaves its piece as it is.
    ///
    /// # Errors
    /// [`SliceError::Hull`] if a mesh does not make a hull although it is not flat.
    pub fn fit_hulls(pieces: &mut [Piece]) -> Result<bool, SliceError> {
        fit_hulls(pieces, 0.0)
    }

    fn clip_cells(
        &mut self,
        hull: &ConvexHull,
        cells: &[CellPlanes],
        most: usize,
    ) -> Result<Vec<Piece>, SliceError> {
        let mut pieces = Vec::with_capacity(cells.len().min(most));
        for cell in cells {
            if pieces.len() == most {
                break;
            }
            self.begin(hull);
            if cell.iter().all(|&plane| self.clip(CutPlane::from(plane))) {
                pieces.extend(self.finish()?);
            }
        }
        Ok(pieces)
    }

    fn clip_sites(
        &mut self,
        hull: &ConvexHull,
        sites: &[Vec3],
        most: usize,
    ) -> Result<Vec<Piece>, SliceError> {
        let sites = &sites[..sites.len().min(most)];
        let mut pieces = Vec::with_capacity(sites.len());
        for index in 0..sites.len() {
            self.begin(hull);
            if self.clip_to_site(sites, index) {
                pieces.extend(self.finish()?);
            }
        }
        Ok(pieces)
    }

    /// Clips the cell in work to what is nearest to point number `index`; whether anything is left.
    ///
    /// Of several points at one place the first has the cell.
    fn clip_to_site(&mut self, sites: &[Vec3], index: usize) -> bool {
        let site = sites[index].as_dvec3();
        let mut nearest = std::mem::take(&mut self.nearest);
        nearest.clear();
        let others = (0..).zip(sites).filter(|&(other, _)| other != index as u32);
        nearest.extend(others.map(|(other, p)| (p.as_dvec3().distance_squared(site), other)));
        let order = |a: &(f64, u32), b: &(f64, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        let mut rest = nearest.as_mut_slice();
        let mut security = self.clipper.security_radius_squared(site);
        let mut is_left = true;
        'chunks: while !rest.is_empty() {
            let count = rest.len().min(NEAREST_SITES);
            if count < rest.len() {
                rest.select_nth_unstable_by(count, order);
            }
            let (chunk, others) = rest.split_at_mut(count);
            rest = others;
            chunk.sort_unstable_by(order);
            for &(distance_squared, other) in &*chunk {
                if distance_squared > security {
                    break 'chunks;
                }
                let Some(plane) = CutPlane::bisector(sites, index, other as usize) else {
                    is_left = index < other as usize;
                    if is_left {
                        continue;
                    }
                    break 'chunks;
                };
                let walls = self.walls.len();
                is_left = self.clip(plane);
                if !is_left {
                    break 'chunks;
                }
                if self.walls.len() > walls {
                    security = self.clipper.security_radius_squared(site);
                }
            }
        }
        self.nearest = nearest;
        is_left
    }

    /// Takes the whole hull as the cell in work.
    fn begin(&mut self, hull: &ConvexHull) {
        self.clipper.load(hull);
        let first = self.wall_ends.last().copied().unwrap_or(0);
        self.walls.truncate(first);
    }

    /// Takes off what of the cell in work is above a plane; whether anything is left.
    fn clip(&mut self, plane: CutPlane) -> bool {
        match self.clipper.clip(plane) {
            Cut::Below => true,
            Cut::Above => false,
            Cut::Cut(()) => {
                self.walls.push(plane.rounded());
                true
            }
        }
    }

    /// The piece that the cell in work becomes, without a visual mesh; none if it is flat.
    fn finish(&mut self) -> Result<Option<Piece>, SliceError> {
        let Some(hull) = self.clipper.hull()? else {
            return Ok(None);
        };
        self.wall_ends.push(self.walls.len());
        Ok(Some(piece_of(hull, None)))
    }

    /// Which of the walls are those of a piece.
    pub(super) fn walls_of(&self, piece: usize) -> Range<usize> {
        let first = piece
            .checked_sub(1)
            .map_or(0, |before| self.wall_ends[before]);
        first..self.wall_ends[piece]
    }
}

pub(super) fn piece_of(hull: ConvexHull, visual: Option<TriMesh>) -> Piece {
    Piece {
        volume: hull.volume(),
        hull,
        visual,
    }
}
