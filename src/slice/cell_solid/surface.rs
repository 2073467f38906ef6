//! The surface of a mesh within a cell: triangles that are whole, and polygons of those that walls divide.
//!
//! Neighbors agree because what they share is decided for both at once: the side of a corner by the corner, the place where a wall crosses an edge by
//! the ends of the edge in the mesh, and the side of such a place by these ends if both are on one.

use crate::geometry::TriMesh;
use crate::geometry::predicates::signed_distance;
use crate::math::Plane;
use crate::slice::attributes::{self, push_between};
use crate::slice::cell_solid::cell::Cell;
use crate::slice::cell_solid::walls::CellWalls;
use crate::slice::clip::{CutTriangle, crossing};
use crate::slice::edge_table::EdgeTable;
use glam::{Vec2, Vec3, Vec4};

/// No point.
const NONE: u32 = u32::MAX;

/// What is known of a corner of the mesh.
#[derive(Clone, Copy, Debug, Default)]
struct Sides {
    /// In which cell it was found.
    stamp: u32,
    is_on: bool,
    /// A bit for each wall that it is outside of.
    outside: u64,
}

/// What a vertex is that the mesh does not have.
#[derive(Clone, Copy, Debug)]
enum Origin {
    /// On the edge of the mesh between two vertices.
    Edge([u32; 2]),
    /// Where two walls meet within a triangle.
    Walls([u32; 2]),
}

/// Where a wall crosses an edge of the mesh.
#[derive(Clone, Copy, Debug)]
struct EdgePoint {
    wall: u32,
    ends: [u32; 2],
    vertex: u32,
    t: f32,
    /// The next one on the same edge.
    next: u32,
}

/// A corner of a polygon.
#[derive(Clone, Copy, Debug)]
struct Corner {
    vertex: u32,
    /// What the polygon's edge from here on lies on.
    along: Along,
    is_outside: bool,
}

#[derive(Clone, Copy, Debug)]
enum Along {
    /// An edge of the triangle, by its ends.
    Edge([u32; 2]),
    Wall(u32),
}

/// A directed edge of the rim of a cap.
#[derive(Clone, Copy, Debug)]
pub(super) struct RimEdge {
    pub(super) wall: u32,
    /// Places among the new vertices.
    pub(super) ends: [u32; 2],
}

/// The surface within the cell in work.
#[derive(Clone, Debug, Default)]
pub(super) struct CellSurface {
    sides: Vec<Sides>,
    stamp: u32,
    old_vertices: u32,
    topology_count: u32,
    /// Triangles of the mesh that are inside.
    pub(super) whole: Vec<u32>,
    /// Parts of those that are not; vertex numbers go on where those of the mesh end.
    pub(super) cut: Vec<CutTriangle>,
    /// The vertices that the mesh does not have.
    pub(super) new: TriMesh,
    origins: Vec<Origin>,
    pub(super) rim: Vec<RimEdge>,
    /// Edge of topology numbers -> its first point.
    point_of: EdgeTable,
    points: Vec<EdgePoint>,
    polygon: Vec<Corner>,
    next: Vec<Corner>,
    ends: TriMesh,
}

impl CellSurface {
    /// Number of the first new vertex.
    pub(super) fn old_vertices(&self) -> u32 {
        self.old_vertices
    }

    /// How many topology numbers old and new vertices use.
    pub(super) fn topology_count(&self) -> usize {
        self.topology_count as usize
    }

    /// Finds the surface. None if something lies on a wall.
    pub(super) fn clip(&mut self, cell: &Cell, walls: &CellWalls) -> Option<()> {
        self.reset(cell);
        for &triangle in cell.triangles {
            let corners = cell.mesh.triangles[triangle as usize];
            let sides = corners.map(|v| self.sides_of(cell.mesh, walls, v));
            let [a, b, c] = sides.map(|s| s.outside);
            if a & b & c != 0 {
                continue;
            }
            if sides.iter().any(|s| s.is_on) {
                return None;
            }
            if a | b | c == 0 {
                self.whole.push(triangle);
            } else {
                self.divide(cell.mesh, walls, triangle, a | b | c)?;
            }
        }
        Some(())
    }

    fn reset(&mut self, cell: &Cell) {
        let mesh = cell.mesh;
        self.old_vertices = mesh.positions.len() as u32;
        self.topology_count = cell.topology_count;
        self.sides.resize(mesh.positions.len(), Sides::default());
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.sides.fill(Sides::default());
            self.stamp = 1;
        }
        self.whole.clear();
        self.cut.clear();
        attributes::clear(&mut self.new);
        self.origins.clear();
        self.rim.clear();
        self.point_of.clear();
        self.points.clear();
    }

    fn sides_of(&mut self, mesh: &TriMesh, walls: &CellWalls, vertex: u32) -> Sides {
        let sides = &mut self.sides[vertex as usize];
        if sides.stamp != self.stamp {
            let tolerance = f64::from(walls.tolerance);
            let position = mesh.positions[vertex as usize];
            *sides = Sides {
                stamp: self.stamp,
                ..Sides::default()
            };
            for (wall, plane) in walls.planes() {
                let distance = signed_distance(plane, position);
                sides.is_on |= distance.abs() <= tolerance;
                sides.outside |= u64::from(distance > tolerance) << wall;
            }
        }
        *sides
    }

    /// Adds what of a triangle is inside of some walls; it is inside of all others.
    fn divide(
        &mut self,
        mesh: &TriMesh,
        walls: &CellWalls,
        triangle: u32,
        outside: u64,
    ) -> Option<()> {
        let corners = mesh.triangles[triangle as usize];
        self.polygon.clear();
        for k in 0..3 {
            self.polygon.push(Corner {
                vertex: corners[k],
                along: Along::Edge([corners[k], corners[(k + 1) % 3]]),
                is_outside: false,
            });
        }
        for wall in (0..walls.len() as u32).filter(|wall| outside >> wall & 1 != 0) {
            self.clip_polygon(mesh, walls, wall)?;
            if self.polygon.is_empty() {
                return Some(());
            }
        }
        let count = self.polygon.len();
        for k in 1..count - 1 {
            let corners = [0, k, k + 1].map(|k| self.polygon[k].vertex);
            let source = triangle;
            self.cut.push(CutTriangle { corners, source });
        }
        for k in 0..count {
            let (from, to) = (self.polygon[k], self.polygon[(k + 1) % count]);
            if let Along::Wall(wall) = from.along {
                let ends = [to.vertex, from.vertex].map(|v| v - self.old_vertices);
                self.rim.push(RimEdge { wall, ends });
            }
        }
        Some(())
    }

    /// Takes off what of the polygon is outside of a wall.
    fn clip_polygon(&mut self, mesh: &TriMesh, walls: &CellWalls, wall: u32) -> Option<()> {
        for place in 0..self.polygon.len() {
            let vertex = self.polygon[place].vertex;
            self.polygon[place].is_outside = self.is_outside(walls, wall, vertex)?;
        }
        let plane = walls.plane(wall);
        let mut crossings = 0;
        self.next.clear();
        for place in 0..self.polygon.len() {
            let at = self.polygon[place];
            let after = self.polygon[(place + 1) % self.polygon.len()];
            if !at.is_outside {
                self.next.push(at);
            }
            if at.is_outside != after.is_outside {
                crossings += 1;
                let vertex = match at.along {
                    Along::Edge(ends) => self.edge_point(mesh, plane, wall, ends),
                    Along::Wall(other) => {
                        let ends = [at.vertex, after.vertex];
                        self.walls_point(plane, [other, wall], ends)
                    }
                };
                self.next.push(Corner {
                    vertex,
                    along: if at.is_outside {
                        at.along
                    } else {
                        Along::Wall(wall)
                    },
                    is_outside: false,
                });
            }
        }
        std::mem::swap(&mut self.polygon, &mut self.next);
        let is_whole = self.polygon.is_empty() || self.polygon.len() > 2;
        (crossings <= 2 && is_whole).then_some(())
    }

    /// Whether a corner of the polygon is outside of a wall; none if it is on it.
    fn is_outside(&self, walls: &CellWalls, wall: u32, vertex: u32) -> Option<bool> {
        let bit = |vertex: u32| self.sides[vertex as usize].outside >> wall & 1 != 0;
        let Some(new) = vertex.checked_sub(self.old_vertices) else {
            return Some(bit(vertex));
        };
        if let Origin::Edge([a, b]) = self.origins[new as usize]
            && bit(a) == bit(b)
        {
            return Some(bit(a));
        }
        let distance = signed_distance(walls.plane(wall), self.new.positions[new as usize]);
        (distance.abs() > f64::from(walls.tolerance)).then_some(distance > 0.0)
    }

    /// The vertex where a wall crosses the edge between two vertices of the mesh: one for both triangles, unless a seam runs along
    /// the edge; then two at one point.
    fn edge_point(&mut self, mesh: &TriMesh, plane: &Plane, wall: u32, [a, b]: [u32; 2]) -> u32 {
        let ends = if mesh.topology[a as usize] < mesh.topology[b as usize] {
            [a, b]
        } else {
            [b, a]
        };
        let [low, high] = ends.map(|v| mesh.topology[v as usize]);
        let first = self.point_of.get(low, high);
        let (mut at, mut twin) = (first.unwrap_or(NONE), None);
        while let Some(&point) = self.points.get(at as usize) {
            if point.wall == wall {
                if point.ends == ends {
                    return point.vertex;
                }
                twin = Some(point);
            }
            at = point.next;
        }
        let (position, t, topology) = if let Some(twin) = twin {
            let place = (twin.vertex - self.old_vertices) as usize;
            let (position, topology) = (self.new.positions[place], self.new.topology[place]);
            (position, twin.t, topology)
        } else {
            let [a, b] = ends.map(|v| mesh.positions[v as usize]);
            let (position, t) = crossing(plane, a, b);
            (position, t, self.new_topology())
        };
        let vertex = self.old_vertices + self.new.positions.len() as u32;
        push_between(&mut self.new, mesh, ends, t, position, topology);
        self.origins.push(Origin::Edge(ends));
        let index = self.points.len() as u32;
        let next = match first {
            None => {
                self.point_of.insert(low, high, index);
                NONE
            }
            Some(first) => std::mem::replace(&mut self.points[first as usize].next, index),
        };
        self.points.push(EdgePoint {
            wall,
            ends,
            vertex,
            t,
            next,
        });
        vertex
    }

    /// The vertex where the second of two walls crosses what the first has made of a triangle.
    fn walls_point(&mut self, plane: &Plane, walls: [u32; 2], between: [u32; 2]) -> u32 {
        let between = between.map(|v| v - self.old_vertices);
        let [a, b] = between.map(|v| self.new.positions[v as usize]);
        let (position, t) = crossing(plane, a, b);
        let none = TriMesh::default();
        attributes::clear(&mut self.ends);
        attributes::extend_chosen(&mut self.ends, &self.new, &between, &none, [0, 0]);
        let topology = self.new_topology();
        push_between(&mut self.new, &self.ends, [0, 1], t, position, topology);
        self.origins.push(Origin::Walls(walls));
        self.old_vertices + self.new.positions.len() as u32 - 1
    }

    fn new_topology(&mut self) -> u32 {
        self.topology_count += 1;
        self.topology_count - 1
    }

    /// The other wall that a new vertex on a wall is on; none if it is on an edge of the mesh.
    pub(super) fn other_wall(&self, vertex: u32, wall: u32) -> Option<u32> {
        match self.origins.get(vertex as usize) {
            Some(&Origin::Walls([a, b])) => Some(if a == wall { b } else { a }),
            _ => None,
        }
    }

    /// Adds a corner of the cell, which only caps have; returns its place among the new vertices.
    pub(super) fn add_corner(&mut self, mesh: &TriMesh, position: Vec3) -> u32 {
        let place = self.new.positions.len() as u32;
        let topology = self.new_topology();
        self.new.positions.push(position);
        self.new.topology.push(topology);
        // Caps take nothing of them: see `CellSolid::takes`.
        if !mesh.normals.is_empty() {
            self.new.normals.push(Vec3::ZERO);
        }
        if !mesh.colors.is_empty() {
            self.new.colors.push(Vec4::ONE);
        }
        if !mesh.uvs.is_empty() {
            self.new.uvs.push(Vec2::ZERO);
        }
        place
    }
}
