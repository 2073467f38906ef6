//! Writing the parts: what each has is copied as it stands in the hull, and renumbered when all is there.
//!
//! Until then, cut points are numbered after the hull's vertices, and the cap after its faces.

use crate::geometry::edge_tables::{renumber, select_edges};
use crate::geometry::hull_lanes::box_of;
use crate::geometry::{ConvexHull, Edge, Face};
use crate::math::Plane;
use crate::simd::lanes::LaneWidth;
use crate::slice::convex::IrregularCut;
use crate::slice::convex::classes::{BELOW, Classes};
use crate::slice::convex::numbers::PartNumbers;
use crate::slice::convex::rim::Rim;

/// All that the writing of one part needs.
pub(super) struct HullWriter<'a> {
    pub(super) hull: &'a ConvexHull,
    pub(super) classes: &'a Classes,
    pub(super) rim: &'a Rim,
    pub(super) part: usize,
    pub(super) numbers: &'a PartNumbers,
    /// Plane of the cap.
    pub(super) plane: Plane,
    /// Registers to use.
    pub(super) width: LaneWidth,
}

impl HullWriter<'_> {
    /// Writes the part; its moments stay to be found.
    pub(super) fn write(&self, out: &mut ConvexHull) -> Result<(), IrregularCut> {
        self.write_vertices(out);
        self.write_faces(out)?;
        self.write_edges(out);
        out.lanes.copy(&out.vertices, &out.faces);
        out.aabb = box_of(&out.lanes.points);
        renumber(self.width, &mut out.loops, self.numbers.of_vertices());
        Ok(())
    }

    /// Bit of the part.
    fn mask(&self) -> u8 {
        BELOW << self.part
    }

    /// The cap's number for now.
    fn cap(&self) -> u32 {
        self.hull.faces.len() as u32
    }

    fn write_vertices(&self, out: &mut ConvexHull) {
        let old = self.numbers.vertices.indices();
        out.vertices.clear();
        (out.vertices).reserve_exact(old.len() + self.rim.points.len());
        (out.vertices).extend(old.iter().map(|&v| self.hull.vertices[v as usize]));
        out.vertices.extend_from_slice(&self.rim.points);
    }

    /// Faces and their loops: those that the part has whole, pieces of those that are cut, and the cap.
    fn write_faces(&self, out: &mut ConvexHull) -> Result<(), IrregularCut> {
        let whole = self.numbers.whole_faces.indices();
        let cut = self.classes.cut_faces.indices();
        let mut cap = Face {
            plane: self.plane,
            first: 0,
            count: self.rim.cap.len() as u32,
        };
        out.faces.resize(whole.len() + cut.len() + 1, cap);
        out.loops.resize(2 * self.numbers.edges, 0);
        let (of_whole, rest) = out.faces.split_at_mut(whole.len());
        let mut writer = LoopWriter {
            room: &mut out.loops,
            written: 0,
        };
        match self.hull.only_triangles() {
            Some(triangles) => writer.write_triangles(self.hull, triangles, whole, of_whole)?,
            None => writer.write_polygons(self.hull, whole, of_whole)?,
        }
        let pieces = self.rim.pieces[self.part].iter();
        for ((&face, (from, count)), out) in cut.iter().zip(pieces).zip(rest) {
            *out = writer.write(self.hull.faces[face as usize].plane, from, count)?;
        }
        cap.first = writer.written as u32;
        out.faces[whole.len() + cut.len()] = cap;
        self.write_cap(&mut out.loops[cap.first as usize..])
    }

    /// The loop of the cap, which fills the room that is left.
    fn write_cap(&self, room: &mut [u32]) -> Result<(), IrregularCut> {
        let cap = &self.rim.cap;
        if room.len() != cap.len() {
            return Err(IrregularCut);
        }
        room.copy_from_slice(cap);
        // Reversed about the same first corner: where vertices on the plane leave the cap uneven, both parts have it as the
        // same triangle fan, and their volumes add up.
        if self.mask() != BELOW {
            room[1..].reverse();
        }
        Ok(())
    }

    /// Edges that the part has whole, halves of cut ones, edges on the plane, and chords.
    fn write_edges(&self, out: &mut ConvexHull) {
        let (edges, table) = (&mut out.edges, self.numbers.of_edges());
        let whole = self.classes.whole_edges[self.part].indices();
        edges.resize(whole.len(), self.hull.edges[0]);
        select_edges(self.width, &self.hull.edges, whole, table, edges);
        edges.reserve_exact(self.numbers.edges - whole.len());
        let is_below = self.mask() == BELOW;
        let (vertices, faces) = table.split();
        let halves = self.rim.cut_edges.iter().zip(self.numbers.first_cut()..);
        edges.extend(halves.map(|(edge, cut)| {
            let end = vertices[edge.ends[self.part] as usize];
            let ends_at_cut = edge.goes_up == is_below;
            Edge {
                vertices: if ends_at_cut { [end, cut] } else { [cut, end] },
                faces: edge.faces.map(|face| faces[face as usize]),
            }
        }));
        for on_edge in &self.classes.on_edges {
            let is_inside = on_edge.parts.map(|part| part == self.mask());
            if is_inside != [false; 2] {
                let Edge { vertices, faces } = self.hull.edges[on_edge.edge as usize];
                let face = |k: usize| if is_inside[k] { faces[k] } else { self.cap() };
                let faces = [face(0), face(1)];
                edges.push(table.look_up(&Edge { vertices, faces }));
            }
        }
        let pieces = self.numbers.pieces();
        let cap = pieces.end as u32;
        let chords = self.rim.chords.iter().zip(pieces.start as u32..);
        edges.extend(chords.map(|(&[up, down], piece)| {
            let ends = if is_below { [up, down] } else { [down, up] };
            Edge {
                vertices: ends.map(|end| vertices[end as usize]),
                faces: [piece, cap],
            }
        }));
    }
}

/// Writes loops, one after the other.
struct LoopWriter<'a> {
    /// Room for all loops.
    room: &'a mut [u32],
    /// Corners written.
    written: usize,
}

impl LoopWriter<'_> {
    /// Writes the first faces of a part: those with these indices, of a hull that has only triangles.
    ///
    /// Kept apart, as the next, so that all that the loop needs stays in registers.
    #[inline(never)]
    fn write_triangles(
        &mut self,
        hull: &ConvexHull,
        triangles: &[[u32; 3]],
        indices: &[u32],
        out: &mut [Face],
    ) -> Result<(), IrregularCut> {
        self.written = 3 * indices.len();
        let room = self.room.get_mut(..self.written).ok_or(IrregularCut)?;
        let room = room.as_chunks_mut().0.iter_mut();
        let places = (0..).step_by(3);
        for (((&index, out), corners), first) in indices.iter().zip(out).zip(room).zip(places) {
            *corners = triangles[index as usize];
            *out = Face {
                plane: hull.faces[index as usize].plane,
                first,
                count: 3,
            };
        }
        Ok(())
    }

    /// Writes those of a hull's faces that have these indices.
    #[inline(never)]
    fn write_polygons(
        &mut self,
        hull: &ConvexHull,
        indices: &[u32],
        out: &mut [Face],
    ) -> Result<(), IrregularCut> {
        let (faces, loops) = (hull.faces.as_slice(), hull.loops.as_slice());
        for (&index, out) in indices.iter().zip(out) {
            let face = &faces[index as usize];
            let (first, count) = (face.first as usize, face.count as usize);
            out.plane = face.plane;
            (out.first, out.count) = (self.written as u32, face.count);
            self.copy_corners(loops, first, count)?;
        }
        Ok(())
    }

    /// Writes a face whose loop is the first `count` corners of a list.
    #[inline(always)]
    fn write(&mut self, plane: Plane, from: &[u32], count: usize) -> Result<Face, IrregularCut> {
        let first = self.written as u32;
        self.copy_corners(from, 0, count)?;
        Ok(Face {
            plane,
            first,
            count: count as u32,
        })
    }

    /// Writes `count` corners that begin at `first` in a list.
    #[inline(always)]
    fn copy_corners(
        &mut self,
        from: &[u32],
        first: usize,
        count: usize,
    ) -> Result<(), IrregularCut> {
        let to = self.written;
        if count <= USUAL_CORNERS
            && let Some(from) = from.get(first..first + USUAL_CORNERS)
            && let Some(to) = self.room.get_mut(to..to + USUAL_CORNERS)
        {
            // More than there may be, which the next face writes over: there is no guessing how many corners it has.
            to.copy_from_slice(from);
        } else {
            copy_many_corners(&from[first..first + count], self.room, to)?;
        }
        self.written += count;
        Ok(())
    }
}

/// Copies the corners of a face that has many, or that is near the end of a list.
#[inline(never)]
fn copy_many_corners(from: &[u32], room: &mut [u32], written: usize) -> Result<(), IrregularCut> {
    let to = room
        .get_mut(written..written + from.len())
        .ok_or(IrregularCut)?;
    to.copy_from_slice(from);
    Ok(())
}

/// Most faces of a hull have no more corners.
const USUAL_CORNERS: usize = 4;
