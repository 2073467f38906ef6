//! The walls of a cell that are faces of its hull, and the edges between them.

use crate::geometry::predicates::signed_distance;
use crate::math::Plane;
use crate::slice::cell_solid::cell::Cell;

/// No wall.
const NONE: u32 = u32::MAX;

/// Walls that a cell may have: one bit each.
const MAX_WALLS: usize = 64;

/// An edge of the cell between two walls.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallEdge {
    /// Corners of the hull, in the order in which the face of the first wall runs through them.
    pub(super) ends: [u32; 2],
    pub(super) walls: [u32; 2],
}

/// The walls of the cell in work.
#[derive(Clone, Debug, Default)]
pub(super) struct CellWalls {
    planes: Vec<Plane>,
    pub(super) edges: Vec<WallEdge>,
    /// By corner of the hull: whether a face ends there that is no wall.
    pub(super) is_outer: Vec<bool>,
    /// By corner of the hull: whether a wall ends there.
    pub(super) is_used: Vec<bool>,
    /// By face of the hull.
    wall_of: Vec<u32>,
    /// Half the thickness of a plane, m.
    pub(super) tolerance: f32,
}

impl CellWalls {
    /// Finds which faces of the hull are walls. None if there are too many, or if a face may be that of a wall whose plane it does not have.
    pub(super) fn find(&mut self, cell: &Cell) -> Option<()> {
        let hull = cell.hull;
        self.tolerance = cell.tolerance;
        self.planes.clear();
        self.wall_of.clear();
        self.wall_of.resize(hull.faces().len(), NONE);
        for plane in cell.walls {
            if self.planes.contains(plane) {
                continue;
            }
            match hull.faces().iter().position(|face| face.plane == *plane) {
                Some(face) => {
                    self.wall_of[face] = self.planes.len() as u32;
                    self.planes.push(*plane);
                }
                // Later walls have cut all of it away, or noise has made another face of it.
                None => {
                    let reach = 4.0 * f64::from(self.tolerance);
                    let corners = hull.vertices().iter();
                    let near = corners.filter(|&&v| signed_distance(plane, v) > -reach);
                    if near.count() > 2 {
                        return None;
                    }
                }
            }
        }
        if self.planes.len() > MAX_WALLS {
            return None;
        }
        self.find_edges(cell);
        Some(())
    }

    fn find_edges(&mut self, cell: &Cell) {
        let hull = cell.hull;
        for flags in [&mut self.is_outer, &mut self.is_used] {
            flags.clear();
            flags.resize(hull.vertices().len(), false);
        }
        self.edges.clear();
        for edge in hull.edges() {
            let walls = edge.faces.map(|face| self.wall_of[face as usize]);
            let ends = edge.vertices;
            for end in ends {
                self.is_outer[end as usize] |= walls.contains(&NONE);
                self.is_used[end as usize] |= walls != [NONE; 2];
            }
            if !walls.contains(&NONE) {
                self.edges.push(WallEdge { ends, walls });
            }
        }
    }

    /// The walls by their numbers.
    pub(super) fn planes(&self) -> impl Iterator<Item = (usize, &Plane)> + '_ {
        self.planes.iter().enumerate()
    }

    pub(super) fn plane(&self, wall: u32) -> &Plane {
        &self.planes[wall as usize]
    }

    pub(super) fn len(&self) -> usize {
        self.planes.len()
    }
}
