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

/// How far the cuts between parts stay off all cells, relative to the size of the mesh: far more than the thickness of a plane, so that also
/// at the tip of a sharp cell all of a cap is cut away.
const MARGIN: f32 = 0.01;

/// As many corners of a mesh, or some more, tell how much of it is above a wall.
const SAMPLES: usize = 128;

impl PieceCutter {
    /// Gives each piece what of `mesh` is in its cell. Pieces are in the order in which their walls were found.
    pub(super) fn clip_visuals(
        &mut self,
        mesh: &TriMesh,
        pieces: &mut [Piece],
        options: SliceOptions,
    ) {
        let mut cells: Vec<u32> = (0..pieces.len() as u32).collect();
        self.clip_group(mesh, &mut cells, pieces, options);
    }

    fn clip_group(
        &mut self,
        mesh: &TriMesh,
        cells: &mut [u32],
        pieces: &mut [Piece],
        options: SliceOptions,
    ) {
        if cells.len() <= CELLS_OF_A_PART || mesh.triangles.len() <= TRIANGLES_OF_A_PART {
            for &cell in &*cells {
                let part = self.clip_visual(mesh, cell as usize, options);
                pieces[cell as usize].visual = Some(part);
            }
            return;
        }
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
        let margin = MARGIN * length_scale(&mesh.aabb());
        let (below, above) = cells.split_at_mut(cells.len() / 2);
        let top = below.iter().map(|&cell| bounds(cell).max[axis]);
        let bottom = above.iter().map(|&cell| -bounds(cell).min[axis]);
        let reaches = [
            top.fold(f32::NEG_INFINITY, f32::max),
            bottom.fold(f32::NEG_INFINITY, f32::max),
        ];
        for (half, (sign, reach)) in [below, above]
            .into_iter()
            .zip([1.0, -1.0].into_iter().zip(reaches))
        {
            let mut normal = Vec3::ZERO;
            normal[axis] = sign;
            let offset = reach + margin;
            match self.part_below(mesh, &Plane { normal, offset }, options) {
                Some(part) => self.clip_group(&part, half, pieces, options),
                None => self.clip_group(mesh, half, pieces, options),
            }
        }
    }

    /// The part of `mesh` below a plane; none if that is all.
    fn part_below(
        &mut self,
        mesh: &TriMesh,
        plane: &Plane,
        options: SliceOptions,
    ) -> Option<TriMesh> {
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
