//! The rims of the caps of a cell, and what fills them.
//!
//! Where the surface crosses an edge between two walls, it goes on on the other one, and the material begins or ends along the edge. So
//! the crossings of an edge, in order, tell which parts of it are within the mesh, and so whether its ends are; the
//! ends tell it for edges that nothing crosses.

use crate::geometry::TriMesh;
use crate::math::Plane;
use crate::slice::cell_solid::cell::Cell;
use crate::slice::cell_solid::surface::CellSurface;
use crate::slice::cell_solid::walls::{CellWalls, WallEdge};
use crate::slice::cell_solid::winding::is_inside;
use crate::slice::rim_fill::{RimCorner, RimFill};

/// Not met yet.
const NONE: u32 = u32::MAX;

/// Whether a corner of the cell is in the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    Unknown,
    Inside,
    Outside,
}

impl Place {
    fn of(is_inside: bool) -> Self {
        if is_inside {
            Self::Inside
        } else {
            Self::Outside
        }
    }
}

/// Where the surface crosses an edge between two walls.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    edge: u32,
    /// m along the edge.
    along: f64,
    vertex: u32,
    /// Whether the material begins there, along the edge.
    begins: bool,
}

/// The caps of the cell in work.
#[derive(Clone, Debug, Default)]
pub(super) struct CellCaps {
    crossings: Vec<Crossing>,
    /// By corner of the cell.
    places: Vec<Place>,
    /// By corner of the cell: its vertex.
    corner_vertices: Vec<u32>,
    /// By wall: directed edges as its cap will have them.
    rims: Vec<Vec<[u32; 2]>>,
    filler: RimFill,
    triangles: Vec<[u32; 3]>,
}

impl CellCaps {
    /// Finds all rims. None if what crosses edges does not fit together.
    pub(super) fn find_rims(
        &mut self,
        cell: &Cell,
        walls: &CellWalls,
        surface: &mut CellSurface,
    ) -> Option<()> {
        self.rims.iter_mut().for_each(Vec::clear);
        self.rims
            .resize(walls.len().max(self.rims.len()), Vec::new());
        for edge in &surface.rim {
            self.rims[edge.wall as usize].push(edge.ends);
        }
        self.find_crossings(cell, walls, surface)?;
        self.place_corners(cell, walls)?;
        let mut first = 0;
        for (number, edge) in (0..).zip(&walls.edges) {
            let own = self.crossings[first..].partition_point(|c| c.edge <= number);
            let own = first..first + own;
            first = own.end;
            self.add_edge(cell, edge, own, surface);
        }
        Some(())
    }

    /// The crossings edge by edge, in order along each.
    fn find_crossings(
        &mut self,
        cell: &Cell,
        walls: &CellWalls,
        surface: &CellSurface,
    ) -> Option<()> {
        self.crossings.clear();
        for rim in &surface.rim {
            for (vertex, begins) in [(rim.ends[1], true), (rim.ends[0], false)] {
                let Some(other) = surface.other_wall(vertex, rim.wall) else {
                    continue;
                };
                let is_edge = |edge: &WallEdge| {
                    edge.walls == [rim.wall, other] || edge.walls == [other, rim.wall]
                };
                let edge = walls.edges.iter().position(is_edge)?;
                // The other wall tells the same.
                if walls.edges[edge].walls[0] != rim.wall {
                    continue;
                }
                let [a, b] = (walls.edges[edge].ends)
                    .map(|corner| cell.hull.vertices()[corner as usize].as_dvec3());
                let position = surface.new.positions[vertex as usize].as_dvec3();
                self.crossings.push(Crossing {
                    edge: edge as u32,
                    along: (position - a).dot((b - a).normalize_or_zero()),
                    vertex,
                    begins,
                });
            }
        }
        self.crossings.sort_unstable_by(|a, b| {
            (a.edge.cmp(&b.edge))
                .then(a.along.total_cmp(&b.along))
                .then(a.vertex.cmp(&b.vertex))
        });
        let mut pairs = self.crossings.windows(2);
        let alternate =
            pairs.all(|pair| pair[0].edge != pair[1].edge || pair[0].begins != pair[1].begins);
        alternate.then_some(())
    }

    /// Finds which corners of the cell are in the mesh.
    fn place_corners(&mut self, cell: &Cell, walls: &CellWalls) -> Option<()> {
        self.places.clear();
        self.places
            .resize(cell.hull.vertices().len(), Place::Unknown);
        self.corner_vertices.clear();
        self.corner_vertices
            .resize(cell.hull.vertices().len(), NONE);
        for run in self.crossings.chunk_by(|a, b| a.edge == b.edge) {
            let ends = walls.edges[run[0].edge as usize].ends;
            let is_inside = [!run[0].begins, run[run.len() - 1].begins];
            for (end, is_inside) in ends.into_iter().zip(is_inside) {
                let place = Place::of(is_inside);
                let known = &mut self.places[end as usize];
                if *known != Place::Unknown && *known != place {
                    return None;
                }
                *known = place;
            }
        }
        self.spread_places(walls)?;
        // Nothing of the mesh is outside of its hull.
        for corner in 0..self.places.len() {
            if walls.is_outer[corner] && self.places[corner] == Place::Unknown {
                self.places[corner] = Place::Outside;
            }
        }
        self.spread_places(walls)?;
        for corner in 0..self.places.len() {
            if walls.is_used[corner] && self.places[corner] == Place::Unknown {
                let position = cell.hull.vertices()[corner];
                let is_inside = is_inside(cell.mesh, position, 4.0 * walls.tolerance)?;
                self.places[corner] = Place::of(is_inside);
                self.spread_places(walls)?;
            }
        }
        Some(())
    }

    /// Both ends of an edge that nothing crosses are at the same side of the surface. None if they cannot be.
    fn spread_places(&mut self, walls: &CellWalls) -> Option<()> {
        loop {
            let mut has_changed = false;
            let mut crossings = self.crossings.iter().peekable();
            for (number, edge) in (0..).zip(&walls.edges) {
                let mut is_crossed = false;
                while crossings.next_if(|c| c.edge == number).is_some() {
                    is_crossed = true;
                }
                let [a, b] = edge.ends.map(|end| self.places[end as usize]);
                if is_crossed || a == b {
                    continue;
                }
                match (a, b) {
                    (Place::Unknown, known) => self.places[edge.ends[0] as usize] = known,
                    (known, Place::Unknown) => self.places[edge.ends[1] as usize] = known,
                    _ => return None,
                }
                has_changed = true;
            }
            if !has_changed {
                return Some(());
            }
        }
    }

    /// Adds the parts of an edge between two walls that are within the mesh to the rims of both.
    fn add_edge(
        &mut self,
        cell: &Cell,
        edge: &WallEdge,
        own: std::ops::Range<usize>,
        surface: &mut CellSurface,
    ) {
        let mut from = (self.places[edge.ends[0] as usize] == Place::Inside)
            .then(|| self.corner_vertex(cell, edge.ends[0], surface));
        let [a, b] = edge.walls.map(|wall| wall as usize);
        for place in own {
            let vertex = self.crossings[place].vertex;
            match from.take() {
                None => from = Some(vertex),
                Some(from) => {
                    self.rims[a].push([from, vertex]);
                    self.rims[b].push([vertex, from]);
                }
            }
        }
        if let Some(from) = from {
            let to = self.corner_vertex(cell, edge.ends[1], surface);
            self.rims[a].push([from, to]);
            self.rims[b].push([to, from]);
        }
    }

    /// The vertex of a corner of the cell.
    fn corner_vertex(&mut self, cell: &Cell, corner: u32, surface: &mut CellSurface) -> u32 {
        let vertex = &mut self.corner_vertices[corner as usize];
        if *vertex == NONE {
            let position = cell.hull.vertices()[corner as usize];
            *vertex = surface.add_corner(cell.mesh, position);
        }
        *vertex
    }

    /// The triangles that fill the rim of a wall, over new vertices. None if it takes others.
    pub(super) fn fill(
        &mut self,
        wall: usize,
        plane: &Plane,
        new: &TriMesh,
    ) -> Option<&[[u32; 3]]> {
        self.triangles.clear();
        let rim = &self.rims[wall];
        if rim.is_empty() {
            return Some(&[]);
        }
        self.filler.load(new, rim.iter().copied());
        self.filler.run(plane.normal);
        for corners in self.filler.triangles() {
            let mut vertices = [NONE; 3];
            for (vertex, corner) in vertices.iter_mut().zip(corners) {
                let RimCorner::Vertex(number) = corner else {
                    return None;
                };
                *vertex = number;
            }
            self.triangles.push(vertices);
        }
        Some(&self.triangles)
    }
}
