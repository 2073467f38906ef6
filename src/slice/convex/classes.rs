//! On which side of the plane vertices, edges and faces lie.
//!
//! Sides are bit masks: the mask of a set is the union of its members' masks, and a part has the bit of its number.

use crate::geometry::ConvexHull;
use crate::geometry::edge_tables::find_ends;
use crate::geometry::hull_lanes::LANES;
use crate::geometry::predicates::{Side, length_scale, plane_tolerance, side};
use crate::math::Plane;
use crate::simd::lanes::LaneWidth;
use crate::slice::convex::select;
use crate::slice::convex::select::{Bits, GROUP, Selection, both, neither, select};

/// Nearer to the plane than the tolerance: in neither part yet.
pub(super) const ON: u8 = 0;
/// In part 0.
pub(super) const BELOW: u8 = 1;
/// In part 1.
pub(super) const ABOVE: u8 = 2;
/// In both parts.
pub(super) const BOTH: u8 = BELOW | ABOVE;

/// Bound of the error of a distance that is computed in `f32`, over the numbers that go into it.
///
/// With `u = 2^-24`, `n . p - d` of three products and three sums is off by at most `4 u (|n| |p| + |d|)`, and `|p|` is at
/// most `sqrt(3)` length scales, so `4 u = 2.4e-7` times `(2 s + |d|)` is enough. The rest covers the rounding of the
/// margin itself.
const DISTANCE_ERROR: f32 = 3.0e-7;

/// The side of everything, and lists of what the plane meets.
#[derive(Clone, Debug, Default)]
pub(super) struct Classes {
    /// Side of each vertex.
    pub(super) sides: Vec<u8>,
    /// Parts that each vertex is in: its side, or for one on the plane, the parts of the faces around it.
    pub(super) members: Vec<u8>,
    /// The same as bits.
    pub(super) member_bits: Vec<Bits>,
    /// Parts that have an end of each edge.
    edge_bits: Vec<Bits>,
    /// Edges of each part that the plane leaves alone.
    pub(super) whole_edges: [Selection; 2],
    /// Edges with ends on both sides.
    pub(super) cut_edges: Vec<u32>,
    /// Edges that are cut or on the plane.
    met_edges: Selection,
    /// Parts of each face; a face on the plane bounds what is behind it.
    pub(super) faces: Vec<u8>,
    /// The same as bits.
    pub(super) face_bits: Vec<Bits>,
    /// Vertices that are near the plane or on it.
    near: Selection,
    /// Vertices on the plane.
    pub(super) on_vertices: Vec<u32>,
    /// Edges with both ends on the plane.
    pub(super) on_edges: Vec<PlaneEdge>,
    /// Faces with vertices on both sides.
    pub(super) cut_faces: Selection,
    /// Faces with vertices on the plane.
    touched_faces: Vec<u32>,
}

/// An edge on the plane, and the parts that its two faces are in along it.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlaneEdge {
    pub(super) edge: u32,
    pub(super) parts: [u8; 2],
}

impl Classes {
    /// Sides of the vertices, as [`side`] says; their union.
    ///
    /// Far from the plane the sign of an `f32` distance is certain; only near it the exact test is asked.
    pub(super) fn find_sides(&mut self, hull: &ConvexHull, plane: &Plane) -> u8 {
        let size = length_scale(&hull.aabb);
        let tolerance = plane_tolerance(size);
        let margin = tolerance + DISTANCE_ERROR * (2.0 * size + plane.offset.abs());
        let groups = &hull.lanes.points;
        self.sides.resize(groups.len() * LANES, ON);
        for (sides, group) in self.sides.as_chunks_mut::<LANES>().0.iter_mut().zip(groups) {
            let along = group.along(plane.normal);
            for l in 0..LANES {
                let height = along[l] - plane.offset;
                sides[l] = u8::from(height < -margin) | u8::from(height > margin) << 1;
            }
        }
        // The last group is filled up with copies of the first vertex.
        self.sides.truncate(hull.vertices.len());
        self.find_near_sides(hull, plane, tolerance);
        self.sides.iter().fold(0, |all, side| all | side)
    }

    /// Asks the exact test for the vertices that are on neither side for certain.
    fn find_near_sides(&mut self, hull: &ConvexHull, plane: &Plane, tolerance: f32) {
        self.on_vertices.clear();
        // What is not a member yet is near.
        select::collect(&self.sides, &mut self.member_bits);
        let count = self.sides.len();
        select([&mut self.near], count, &self.member_bits, |bits| {
            [neither(bits)]
        });
        for &vertex in self.near.indices() {
            let point = hull.vertices[vertex as usize];
            self.sides[vertex as usize] = match side(plane, point, tolerance) {
                Side::Below => BELOW,
                Side::Above => ABOVE,
                Side::On => {
                    self.on_vertices.push(vertex);
                    ON
                }
            };
        }
    }

    /// Sorts the edges by class, each class in the hull's order.
    pub(super) fn find_edges(&mut self, hull: &ConvexHull, width: LaneWidth) {
        let sides = self.sides.as_slice();
        (self.edge_bits).resize(hull.edges.len().div_ceil(GROUP), [0; 2]);
        find_ends(width, &hull.edges, sides, &mut self.edge_bits);
        let [below, above] = &mut self.whole_edges;
        let lists = [below, above, &mut self.met_edges];
        select(lists, hull.edges.len(), &self.edge_bits, select::each);
        self.cut_edges.clear();
        self.on_edges.clear();
        for &edge in self.met_edges.indices() {
            let [end, _] = hull.edges[edge as usize].vertices;
            if sides[end as usize] == ON {
                let parts = [0; 2];
                self.on_edges.push(PlaneEdge { edge, parts });
            } else {
                self.cut_edges.push(edge);
            }
        }
    }

    /// Classes of the faces, and then of the vertices and edges on the plane, which belong where their faces do.
    pub(super) fn find_faces(&mut self, hull: &ConvexHull, plane: &Plane) {
        let Self {
            sides,
            faces,
            face_bits,
            on_vertices,
            cut_edges,
            cut_faces,
            touched_faces,
            ..
        } = self;
        let sides = sides.as_slice();
        // A face that the plane does not meet has all its corners on the side of the first.
        faces.resize(hull.faces.len(), ON);
        if let Some(triangles) = hull.only_triangles() {
            for (parts, &[first, ..]) in faces.iter_mut().zip(triangles) {
                *parts = sides[first as usize];
            }
        } else {
            for (parts, face) in faces.iter_mut().zip(&hull.faces) {
                *parts = sides[hull.loops[face.first as usize] as usize];
            }
        }
        for &edge in cut_edges.iter() {
            for face in hull.edges[edge as usize].faces {
                faces[face as usize] = BOTH;
            }
        }
        touched_faces.clear();
        if !on_vertices.is_empty() {
            for (index, face) in (0..).zip(&hull.faces) {
                let corners = hull.face_loop(face).iter().map(|&v| sides[v as usize]);
                if !corners.clone().any(|side| side == ON) {
                    continue;
                }
                let parts = corners.fold(0, |all, side| all | side);
                let behind = if face.plane.normal.dot(plane.normal) > 0.0 {
                    BELOW
                } else {
                    ABOVE
                };
                faces[index as usize] = if parts == ON { behind } else { parts };
                touched_faces.push(index);
            }
        }
        select::collect(faces, face_bits);
        select([cut_faces], faces.len(), face_bits, |bits| [both(bits)]);
        self.find_members(hull);
    }

    fn find_members(&mut self, hull: &ConvexHull) {
        self.members.clone_from(&self.sides);
        for &face in &self.touched_faces {
            let corners = hull.face_loop(&hull.faces[face as usize]);
            for &vertex in corners.iter().filter(|&&v| self.sides[v as usize] == ON) {
                self.members[vertex as usize] |= self.parts_at(hull, face, vertex);
            }
        }
        select::collect(&self.members, &mut self.member_bits);
        for index in 0..self.on_edges.len() {
            let PlaneEdge { edge, .. } = self.on_edges[index];
            let edge = hull.edges[edge as usize];
            let [from, to] = edge.vertices;
            self.on_edges[index].parts = [
                self.part_after(hull, edge.faces[0], to),
                self.part_after(hull, edge.faces[1], from),
            ];
        }
    }

    /// The parts of a face that have its corner `vertex`, which is on the plane.
    ///
    /// Where a loop changes sides on the plane, it does so at the first corner there; so a corner is in the part that follows
    /// it, and in that of the corner right before it, if that one is off the plane.
    fn parts_at(&self, hull: &ConvexHull, face: u32, vertex: u32) -> u8 {
        let after = self.part_after(hull, face, vertex);
        if self.faces[face as usize] != BOTH {
            return after;
        }
        let corners = hull.face_loop(&hull.faces[face as usize]);
        let before = (place_of(vertex, corners) + corners.len() - 1) % corners.len();
        after | self.sides[corners[before] as usize]
    }

    /// The part of a face that follows its corner `vertex`, which is on the plane: what the next corner off the plane is in.
    fn part_after(&self, hull: &ConvexHull, face: u32, vertex: u32) -> u8 {
        match self.faces[face as usize] {
            BOTH => {
                let corners = hull.face_loop(&hull.faces[face as usize]);
                let (before, from) = corners.split_at(place_of(vertex, corners));
                let mut sides = from.iter().chain(before).map(|&v| self.sides[v as usize]);
                sides.find(|&side| side != ON).unwrap_or(ON)
            }
            part => part,
        }
    }
}

/// Where `vertex` stands in a loop that has it.
fn place_of(vertex: u32, corners: &[u32]) -> usize {
    corners.iter().position(|&v| v == vertex).unwrap_or(0)
}
