//! What of a closed mesh is in a convex cell, found in one go: each triangle becomes the polygon of it that all walls leave, and each wall
//! gets its cap once.
//!
//! Cut wall by wall, a mesh gets a cap for each wall that most of the next ones cut away again, and what stays is copied as often as
//! there are walls. Here the corners of the mesh are held against all walls first; triangles with corners behind one wall go,
//! those in front of all stay, and only the others are divided (`surface.rs`). What the polygons leave open on a wall, and those parts of the edges of the
//! cell that are within the mesh, are the rim of its cap (`caps.rs`).
//!
//! Where a corner lies on a wall, or what is found does not fit together, the cell is left to the cuts by planes
//! (`slice/cell_visuals.rs`), which take any case: nothing is guessed here, and a part counts only once it is known to be closed.

mod caps;
pub(super) mod cell;
mod surface;
mod walls;
mod winding;

use crate::geometry::{EdgeCensus, TriMesh};
use crate::math::tangents;
use crate::slice::attributes::{self, CapStyle};
use crate::slice::cap_planes::CapPlanes;
use crate::slice::cell_solid::caps::CellCaps;
use crate::slice::cell_solid::cell::Cell;
use crate::slice::cell_solid::surface::CellSurface;
use crate::slice::cell_solid::walls::CellWalls;
use crate::slice::mesh_slicer::VertexNumbers;
use crate::slice::{CapNormals, SliceOptions};
use glam::Vec4;

/// Not met yet.
const NONE: u32 = u32::MAX;

/// Cuts cells out of meshes, keeping its working memory.
#[derive(Clone, Debug, Default)]
pub(super) struct CellSolid {
    walls: CellWalls,
    surface: CellSurface,
    caps: CellCaps,
    numbers: VertexNumbers,
    census: EdgeCensus,
    /// By vertex of the surface that the mesh does not have: its number in the part, and then in the cap in work.
    renumber: Vec<u32>,
    /// Those of them that the part uses.
    chosen: Vec<u32>,
}

impl CellSolid {
    /// Whether meshes of this kind are cut here: sheets ride along with cuts by planes only, and so do caps that take attributes of their rim.
    pub(super) fn takes(mesh: &TriMesh, options: SliceOptions) -> bool {
        let is_plain = mesh.colors.is_empty() || options.cap_color.is_some();
        let is_flat = mesh.normals.is_empty() || options.cap_normals == CapNormals::Flat;
        mesh.sheets == 0 && is_plain && is_flat
    }

    /// The part of the closed mesh in a cell; none where planes have to find it.
    pub(super) fn cut(&mut self, cell: &Cell, caps: &mut CapPlanes) -> Option<TriMesh> {
        let Self { walls, surface, .. } = self;
        walls.find(cell)?;
        surface.clip(cell, walls)?;
        self.caps.find_rims(cell, walls, surface)?;
        let mut part = self.collect_surface(cell);
        self.collect_caps(cell, caps, &mut part)?;
        if part.triangles.is_empty() {
            return Some(TriMesh::default());
        }
        let count = part.topology_count();
        let is_closed = (self.census).is_closed(&part.triangles, &part.topology, count);
        is_closed.then(|| {
            part.known_closed.set();
            part
        })
    }

    /// The triangles between the caps, and their vertices.
    fn collect_surface(&mut self, cell: &Cell) -> TriMesh {
        let mesh = cell.mesh;
        let mut part = TriMesh::default();
        self.number_triangles(mesh, &mut part);
        let (surface, numbers) = (&self.surface, &mut self.numbers);
        let none = TriMesh::default();
        let room = [0, 2 * self.chosen.len()];
        attributes::extend_chosen(&mut part, mesh, numbers.chosen(), &none, room);
        attributes::extend_chosen(&mut part, &surface.new, &self.chosen, &none, [0, 0]);
        let new: Vec<u32> = (self.chosen.iter())
            .map(|&v| surface.new.topology[v as usize])
            .collect();
        numbers.extend_topology(&mut part, mesh, &new, surface.topology_count());
        let sources = (surface.whole.iter().copied()).chain(surface.cut.iter().map(|c| c.source));
        part.faces
            .0
            .extend(sources.clone().map(|t| mesh.faces.of(t)));
        if cell.has_slots() {
            let slot = |t: u32| mesh.materials.get(t as usize).copied().unwrap_or(0);
            part.materials.extend(sources.map(slot));
        }
        if cell.options.cap_color.is_some() && mesh.colors.is_empty() {
            part.colors.resize(part.positions.len(), Vec4::ONE);
        }
        part
    }

    /// The triangles in numbers of the part: first those of the vertices of the mesh, then those of new ones.
    fn number_triangles(&mut self, mesh: &TriMesh, part: &mut TriMesh) {
        let surface = &self.surface;
        let old_vertices = surface.old_vertices();
        part.triangles
            .reserve(surface.whole.len() + surface.cut.len());
        let numbers = &mut self.numbers;
        numbers.reset(mesh.positions.len());
        for &triangle in &surface.whole {
            let corners = mesh.triangles[triangle as usize];
            part.triangles.push(corners.map(|v| numbers.of(v)));
        }
        self.renumber.clear();
        self.renumber.resize(surface.new.positions.len(), NONE);
        self.chosen.clear();
        for corner in surface.cut.iter().flat_map(|cut| cut.corners) {
            match corner.checked_sub(old_vertices) {
                None => {
                    numbers.of(corner);
                }
                Some(new) if self.renumber[new as usize] == NONE => {
                    self.renumber[new as usize] = self.chosen.len() as u32;
                    self.chosen.push(new);
                }
                Some(_) => {}
            }
        }
        let first_new = numbers.chosen().len() as u32;
        part.triangles.extend(surface.cut.iter().map(|cut| {
            cut.corners
                .map(|corner| match corner.checked_sub(old_vertices) {
                    None => numbers.of(corner),
                    Some(new) => first_new + self.renumber[new as usize],
                })
        }));
    }

    /// Closes what the walls have left open.
    fn collect_caps(
        &mut self,
        cell: &Cell,
        caps: &mut CapPlanes,
        part: &mut TriMesh,
    ) -> Option<()> {
        let new = &self.surface.new;
        for (wall, plane) in self.walls.planes() {
            let triangles = self.caps.fill(wall, plane, new)?;
            if triangles.is_empty() {
                continue;
            }
            let style = CapStyle {
                normal: plane.normal,
                normals: CapNormals::Flat,
                tangents: tangents(plane.normal),
                color: cell.options.cap_color,
            };
            self.renumber.clear();
            self.renumber.resize(new.positions.len(), NONE);
            for corners in triangles {
                let corners = corners.map(|vertex| {
                    let number = &mut self.renumber[vertex as usize];
                    if *number == NONE {
                        *number = part.positions.len() as u32;
                        let topology = self.numbers.position(new.topology[vertex as usize]);
                        attributes::push_cap(part, new, vertex as usize, topology, &style);
                    }
                    *number
                });
                part.triangles.push(corners);
            }
            let face = caps.add(plane, triangles.len());
            part.faces.0.resize(part.triangles.len(), face);
            if cell.has_slots() {
                let slot = cell.options.cap_material.unwrap_or(0);
                part.materials.resize(part.triangles.len(), slot);
            }
        }
        Some(())
    }
}
