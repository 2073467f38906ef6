//! The numbers that a hull's vertices and faces have in the parts.

use crate::geometry::ConvexHull;
use crate::geometry::edge_tables::EdgeRenumbering;
use crate::simd::lanes::LaneWidth;
use crate::slice::convex::IrregularCut;
use crate::slice::convex::classes::{BELOW, Classes};
use crate::slice::convex::rim::Rim;
use crate::slice::convex::select::{Selection, select_and_number};
use std::ops::Range;

/// What each part has of everything, and under which numbers.
#[derive(Clone, Debug, Default)]
pub(super) struct Renumbering {
    pub(super) parts: [PartNumbers; 2],
}

/// What one part has.
#[derive(Clone, Debug, Default)]
pub(super) struct PartNumbers {
    /// New numbers of the hull's vertices, the cut points, the hull's faces and the cap, one after the other. Those of
    /// what the part does not have mean nothing.
    table: Vec<u32>,
    /// Where the faces begin in the table.
    first_face: usize,
    /// The hull's vertices that the part has.
    pub(super) vertices: Selection,
    /// The hull's faces that the part has whole. Pieces of cut faces follow them, and then the cap.
    pub(super) whole_faces: Selection,
    /// How many faces the part has.
    faces: usize,
    /// How many edges the part has.
    pub(super) edges: usize,
}

impl PartNumbers {
    /// New numbers of the hull's vertices and the cut points.
    pub(super) fn of_vertices(&self) -> &[u32] {
        &self.table[..self.first_face]
    }

    /// The same, and new numbers of the hull's faces and the cap.
    pub(super) fn of_edges(&self) -> EdgeRenumbering<'_> {
        EdgeRenumbering {
            numbers: &self.table,
            first_face: self.first_face,
        }
    }

    /// New number of the first cut point. The others follow.
    pub(super) fn first_cut(&self) -> u32 {
        self.vertices.len() as u32
    }

    /// Which of the part's faces are pieces of cut ones; the cap follows them.
    pub(super) fn pieces(&self) -> Range<usize> {
        self.whole_faces.len()..self.faces - 1
    }

    fn count(
        &mut self,
        hull: &ConvexHull,
        classes: &Classes,
        cuts: usize,
        part: usize,
        width: LaneWidth,
    ) {
        let vertices = hull.vertices.len();
        self.first_face = vertices + cuts;
        let last = self.first_face + hull.faces.len();
        self.table.resize(last + 1, 0);
        let (of_vertices, of_faces) = self.table.split_at_mut(self.first_face);
        let (of_vertices, of_cuts) = of_vertices.split_at_mut(vertices);
        let of_hull = &mut of_faces[..hull.faces.len()];
        select_and_number(
            width,
            &mut self.vertices,
            &classes.member_bits,
            |bits| bits[part],
            of_vertices,
        );
        select_and_number(
            width,
            &mut self.whole_faces,
            &classes.face_bits,
            |bits| bits[part] & !bits[1 - part],
            of_hull,
        );
        let mut next_face = self.whole_faces.len() as u32;
        for &face in classes.cut_faces.indices() {
            of_hull[face as usize] = next_face;
            next_face += 1;
        }
        let first_cut = self.vertices.len() as u32;
        for (number, cut) in of_cuts.iter_mut().zip(first_cut..) {
            *number = cut;
        }
        of_faces[hull.faces.len()] = next_face;
    }
}

impl Renumbering {
    /// Numbers vertices and faces, and checks that both parts fulfil Euler's formula.
    ///
    /// Each edge of a part has one face on either side, because it inherits them from the hull or is on the rim, which is one
    /// simple loop; so the formula says that the part is one closed surface without handles.
    pub(super) fn count(
        &mut self,
        hull: &ConvexHull,
        classes: &Classes,
        rim: &Rim,
        width: LaneWidth,
    ) -> Result<(), IrregularCut> {
        let cuts = rim.points.len();
        for (part, numbers) in self.parts.iter_mut().enumerate() {
            numbers.count(hull, classes, cuts, part, width);
            let vertices = numbers.vertices.len() + cuts;
            numbers.faces = numbers.whole_faces.len() + rim.chords.len() + 1;
            let mask = BELOW << part;
            let on = classes.on_edges.iter().filter(|e| e.parts.contains(&mask));
            numbers.edges = classes.whole_edges[part].len() + on.count() + cuts + rim.chords.len();
            if vertices + numbers.faces != numbers.edges + 2 {
                return Err(IrregularCut);
            }
        }
        Ok(())
    }
}
