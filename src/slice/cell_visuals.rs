//! The parts of a visual mesh in many cells.
//!
//! Each cell would have to go through the whole mesh. So the mesh is divided first, as often as it is worth it, into overlapping
//! parts around half of the cells each. The planes of these cuts touch no cell, so nothing of their caps is left in the end, and the
//! triangles that they divide are one face again after [`FaceMerger`](crate::slice::merge_faces::FaceMerger).

use crate::geometry::TriMesh;
use crate::geometry::predicates::length_scale;
use crate::math::Plane;
use crate::slice::cells::PieceCutter;
use crate::slice::cut::Cut;
use crate::slice::{Piece, SliceOptions};
use crate::tuning::{CELLS_OF_A_PART, TRIANGLES_OF_A_PART};
use glam::Vec3;
use std::sync::Arc;

/// How far the cuts between parts stay off all cells, relative to the size of the mesh: far more than the thickness of a plane, so that also
/// at the tip of a sharp cell all of a cap is cut away.
const MARGIN: f32 = 0.01;

/// As many corners of a mesh, or some more, tell how much of it is above a wall.
const SAMPLES: usize = 128;

/// What is left to be cut out of a mesh, in an order that depends on the cells only.
#[derive(Clone, Debug, Default)]
pub(super) struct ClipQueue {
    /// The next one last.
    groups: Vec<CellGroup>,
}

/// Cells to be cut out of a part of the mesh.
#[derive(Clone, Debug)]
struct CellGroup {
    /// The part; none for the whole mesh.
    part: Option<Arc<TriMesh>>,
    cells: Vec<u32>,
}

impl ClipQueue {
    /// For this number of cells.
    pub(super) fn new(cells: usize) -> Self {
        let cells = (0..cells as u32).collect();
        Self {
            groups: vec![CellGroup { part: None, cells }],
        }
    }

    /// Whether nothing is left.
    pub(super) fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }
}

impl PieceCutter {
    /// Gives each piece what of `mesh` is in its cell. Pieces are in the order in which their walls were found.
    pub(super) fn clip_visuals(
        &mut self,
        mesh: &TriMesh,
        pieces: &mut [Piece],
        options: SliceOptions,
    ) {
        let mut queue = ClipQueue::new(pieces.len());
        while !queue.is_empty() {
            self.clip_next(mesh, &mut queue, pieces, options);
        }
    }

    /// Cuts the next cell out of its part of `mesh`, or divides the part of the next group.
    pub(super) fn clip_next(
        &mut self,
        mesh: &TriMesh,
        queue: &mut ClipQueue,
        pieces: &mut [Piece],
        options: SliceOptions,
    ) {
        let Some(CellGroup { part, mut cells }) = queue.groups.pop() else {
            return;
        };
        let whole = part.as_deref().unwrap_or(mesh);
        if let [cell] = cells[..] {
            let mut visual = self.clip_visual(whole, cell as usize, options);
            self.merger.merge(&mut visual, None);
            pieces[cell as usize].visual = Some(visual);
            return;
        }
        let mut push = |part: Option<Arc<TriMesh>>, cells: &[u32]| {
            let cells = cells.to_vec();
            queue.groups.push(CellGroup { part, cells });
        };
        if cells.len() <= CELLS_OF_A_PART || whole.triangles.len() <= TRIANGLES_OF_A_PART {
            for cell in cells.chunks(1).rev() {
                push(part.clone(), cell);
            }
            return;
        }
        let margin = MARGIN * length_scale(&whole.aabb());
        let (axis, reaches) = sort_halves(&mut cells, pieces);
        let (below, above) = cells.split_at(cells.len() / 2);
        let halves = [(below, 1.0), (above, -1.0)];
        let parts = [0, 1].map(|half| {
            let mut normal = Vec3::ZERO;
            normal[axis] = halves[half].1;
            let offset = reaches[half] + margin;
            let below = self.part_below(whole, &Plane { normal, offset }, options);
            below.map(Arc::new).or(part.clone())
        });
        for ((cells, _), part) in halves.into_iter().zip(parts).rev() {
            push(part, cells);
        }
    }

    /// The part of `mesh` below a plane; none if that is all.
    fn part_below(
        &mut self,
        mesh: &TriMesh,
        plane: &Plane,
        options: SliceOptions,
    ) -> Option<TriMesh> {
        self.gone_through += mesh.triangles.len();
        match self.meshes.divide(mesh, plane) {
            Cut::Below => None,
            Cut::Above => Some(TriMesh::default()),
            Cut::Cut(()) => {
                let mut part = TriMesh::default();
                self.meshes.collect_below(mesh, plane, options, &mut part);
                Some(part)
            }
        }
    }

    /// The part of `mesh` behind all walls of a cell.
    fn clip_visual(&mut self, mesh: &TriMesh, cell: usize, options: SliceOptions) -> TriMesh {
        let mut part: Option<TriMesh> = None;
        if mesh.triangles.is_empty() {
            return TriMesh::default();
        }
        self.sort_walls(mesh, cell);
        for index in self.walls_of(cell) {
            let plane = &self.walls[index];
            let whole = part.as_ref().unwrap_or(mesh);
            self.gone_through += whole.triangles.len();
            match self.meshes.divide(whole, plane) {
                Cut::Below => {}
                Cut::Above => return TriMesh::default(),
                Cut::Cut(()) => {
                    self.meshes
                        .collect_below(whole, plane, options, &mut self.spare);
                    let below = std::mem::take(&mut self.spare);
                    self.spare = part.replace(below).unwrap_or_default();
                }
            }
        }
        part.unwrap_or_else(|| mesh.clone())
    }

    /// Puts those walls of a cell first that most of the mesh is above of: what they take off, no other wall has to divide.
    fn sort_walls(&mut self, mesh: &TriMesh, cell: usize) {
        let own = self.walls_of(cell);
        let step = mesh.positions.len() / SAMPLES + 1;
        let samples = mesh.positions.iter().step_by(step);
        self.wall_order.clear();
        for &plane in &self.walls[own.clone()] {
            let above = samples.clone().filter(|&&p| plane.distance(p) > 0.0);
            self.wall_order.push((above.count(), plane));
        }
        // Stable: the nearest ones first where as much is above.
        self.wall_order
            .sort_by_key(|&(above, _)| std::cmp::Reverse(above));
        let sorted = self.wall_order.iter().map(|&(_, plane)| plane);
        for (wall, plane) in self.walls[own].iter_mut().zip(sorted) {
            *wall = plane;
        }
    }
}

/// Sorts cells along the axis on which they lie farthest apart. Returns that axis, and how far (m) the first half reaches up it and the
/// other half reaches down it.
fn sort_halves(cells: &mut [u32], pieces: &[Piece]) -> (usize, [f32; 2]) {
    let bounds = |cell: u32| pieces[cell as usize].hull.aabb();
    let middles = cells.iter().map(|&cell| bounds(cell).center());
    let (low, high) = middles.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| {
        (low.min(p), high.max(p))
    });
    let axis = (high - low).max_position();
    cells.sort_unstable_by(|&a, &b| {
        let [near, far] = [a, b].map(|cell| bounds(cell).center()[axis]);
        near.total_cmp(&far).then(a.cmp(&b))
    });
    let (below, above) = cells.split_at(cells.len() / 2);
    let top = below.iter().map(|&cell| bounds(cell).max[axis]);
    let bottom = above.iter().map(|&cell| -bounds(cell).min[axis]);
    let reaches = [
        top.fold(f32::NEG_INFINITY, f32::max),
        bottom.fold(f32::NEG_INFINITY, f32::max),
    ];
    (axis, reaches)
}
