//! The parts of a visual mesh in many cells.
//!
//! Each cell would have to go through the whole mesh. So its triangles are sorted first into overlapping lists for half of the cells
//! each, until a list is for one cell, which takes what it needs of these triangles (`cell_solid/`).
//!
//! Small meshes, and cells that are left over, are cut by one wall after the other. If there are many cells of these, the mesh is divided first, as
//! often as it is worth it, into overlapping parts around half of the cells each. The planes of these cuts touch no cell, so nothing of their caps is left in
//! the end, and the triangles that they divide are one face again after [`FaceMerger`](crate::slice::merge_faces::FaceMerger).

use crate::geometry::TriMesh;
use crate::geometry::predicates::{length_scale, plane_tolerance};
use crate::math::Plane;
use crate::slice::cell_solid::CellSolid;
use crate::slice::cell_solid::cell::Cell;
use crate::slice::cells::PieceCutter;
use crate::slice::cut::Cut;
use crate::slice::{Piece, SliceOptions};
use crate::tuning::{CELLS_OF_A_PART, SOLID_PASSES, TRIANGLES_OF_A_PART};
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
    /// Cells that planes have to cut out once there are no groups left.
    left: Vec<u32>,
    /// Half the thickness of a plane, m.
    tolerance: f32,
    /// How many topology numbers the mesh uses.
    topology_count: u32,
}

/// Cells to be cut out of a part of the mesh.
#[derive(Clone, Debug)]
struct CellGroup {
    part: Part,
    cells: Vec<u32>,
}

/// A part of a mesh that holds all that some cells have of it.
#[derive(Clone, Debug)]
enum Part {
    /// A closed part, or all of it, to be cut by planes.
    Mesh(Option<Arc<TriMesh>>),
    /// Those of its triangles that may reach into the cells, to be cut one by one.
    Triangles(Vec<u32>),
}

impl ClipQueue {
    /// For this number of cells of a mesh.
    pub(super) fn new(cells: usize, mesh: Option<&TriMesh>, options: SliceOptions) -> Self {
        let cells: Vec<u32> = (0..cells as u32).collect();
        // What has fewer triangles is mostly cap, and may have corners on the walls, as bricks have.
        let part = mesh.filter(|mesh| {
            mesh.triangles.len() > TRIANGLES_OF_A_PART && CellSolid::takes(mesh, options)
        });
        let part = part.map_or(Part::Mesh(None), |mesh| {
            Part::Triangles((0..mesh.triangles.len() as u32).collect())
        });
        Self {
            tolerance: mesh.map_or(0.0, |m| plane_tolerance(length_scale(&m.aabb()))),
            topology_count: mesh.map_or(0, |mesh| mesh.topology_count() as u32),
            groups: vec![CellGroup { part, cells }],
            left: Vec::new(),
        }
    }

    /// Whether nothing is left.
    pub(super) fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// Puts those cells into the queue again that are left to planes, once all others are done.
    fn take_up_left(&mut self) {
        if self.groups.is_empty() && !self.left.is_empty() {
            let cells = std::mem::take(&mut self.left);
            let part = Part::Mesh(None);
            self.groups.push(CellGroup { part, cells });
        }
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
        let mut queue = ClipQueue::new(pieces.len(), Some(mesh), options);
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
        let Some(CellGroup { part, cells }) = queue.groups.pop() else {
            return;
        };
        match part {
            Part::Triangles(triangles) => match cells[..] {
                [cell] => self.cut_solid((mesh, &triangles), cell, queue, pieces, options),
                _ => self.divide_triangles((mesh, &triangles), cells, queue, pieces),
            },
            Part::Mesh(part) => self.clip_group(mesh, part, cells, (queue, pieces), options),
        }
        queue.take_up_left();
    }

    /// Cuts a cell out of those triangles of a mesh that may reach into it, or leaves it to planes.
    fn cut_solid(
        &mut self,
        (mesh, triangles): (&TriMesh, &[u32]),
        number: u32,
        queue: &mut ClipQueue,
        pieces: &mut [Piece],
        options: SliceOptions,
    ) {
        let walls = self.walls_of(number as usize);
        self.gone_through += SOLID_PASSES * triangles.len();
        let piece = &mut pieces[number as usize];
        let cell = Cell {
            mesh,
            triangles,
            hull: &piece.hull,
            tolerance: queue.tolerance,
            topology_count: queue.topology_count,
            walls: &self.walls[walls],
            options,
        };
        match self.solid.cut(&cell, &mut self.meshes.caps) {
            Some(mut visual) => {
                self.merger.merge(&mut visual, None);
                piece.visual = Some(visual);
            }
            None => queue.left.push(number),
        }
    }

    /// Divides a group of cells in two, and sorts out which triangles may reach into which.
    fn divide_triangles(
        &mut self,
        (mesh, triangles): (&TriMesh, &[u32]),
        mut cells: Vec<u32>,
        queue: &mut ClipQueue,
        pieces: &[Piece],
    ) {
        if cells.is_empty() {
            return;
        }
        self.gone_through += triangles.len();
        let margin = queue.tolerance;
        let (axis, reaches) = sort_halves(&mut cells, pieces);
        let (below, above) = cells.split_at(cells.len() / 2);
        let reach = |triangle: u32| {
            let [a, b, c] = mesh.triangles[triangle as usize];
            let [a, b, c] = [a, b, c].map(|v| mesh.positions[v as usize][axis]);
            (a.min(b).min(c), a.max(b).max(c))
        };
        let [top, bottom] = [reaches[0] + margin, -reaches[1] - margin];
        let (mut low, mut high) = (Vec::new(), Vec::new());
        for &triangle in triangles {
            let (least, most) = reach(triangle);
            if least <= top {
                low.push(triangle);
            }
            if most >= bottom {
                high.push(triangle);
            }
        }
        for (cells, part) in [(above, high), (below, low)] {
            let (part, cells) = (Part::Triangles(part), cells.to_vec());
            queue.groups.push(CellGroup { part, cells });
        }
    }

    /// Cuts the one cell of a group out of its part of `mesh` by planes, or divides the part.
    fn clip_group(
        &mut self,
        mesh: &TriMesh,
        part: Option<Arc<TriMesh>>,
        mut cells: Vec<u32>,
        (queue, pieces): (&mut ClipQueue, &mut [Piece]),
        options: SliceOptions,
    ) {
        let whole = part.as_deref().unwrap_or(mesh);
        if let [cell] = cells[..] {
            let mut visual = self.clip_visual(whole, cell as usize, options);
            self.merger.merge(&mut visual, None);
            pieces[cell as usize].visual = Some(visual);
            return;
        }
        let mut push = |part: Option<Arc<TriMesh>>, cells: &[u32]| {
            let (part, cells) = (Part::Mesh(part), cells.to_vec());
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
