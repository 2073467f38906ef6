//! Writing the parts: what each has is copied as it stands in the hull, and renumbered when all is there.
//!
//! Until then, cut points are numbered after the hull's vertices, and the cap after its faces.

use super::Irregular;
use super::classes::{BELOW, Classes};
use super::numbers::PartNumbers;
use super::rim::Rim;
use crate::geometry::lanes::box_of;
use crate::geometry::lanes::wide::{Avx2, renumber, select_edges};
use crate::geometry::{ConvexHull, Edge, Face};
use crate::math::Plane;
use smallvec::SmallVec;

/// All that the writing of one part needs.
pub(super) struct Writer<'a> {
    pub(super) hull: &'a ConvexHull,
    pub(super) classes: &'a Classes,
    pub(super) rim: &'a Rim,
    pub(super) part: usize,
    pub(super) numbers: &'a PartNumbers,
    /// Plane of the cap.
    pub(super) plane: Plane,
    /// Registers to use.
    pub(super) wide: Option<Avx2>,
}

impl Writer<'_> {
    /// Writes the part; its moments stay to be found.
    pub(super) fn write(&self, out: &mut ConvexHull) -> Result<(), Irregular> {
        self.write_vertices(out);
        self.write_around(out)?;
        self.write_faces(out)?;
        self.write_edges(out);
        out.lanes.copy(&out.vertices, &out.faces);
        out.aabb = box_of(&out.lanes.points);
        let (vertices, faces) = self.numbers.tables();
        renumber(self.wide, &mut out.loops, vertices);
        renumber(self.wide, out.lanes.around.faces_mut(), faces);
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

    /// The faces around the vertices.
    fn write_around(&self, out: &mut ConvexHull) -> Result<(), Irregular> {
        let (from, old) = (&self.hull.lanes.around, self.numbers.vertices.indices());
        let mut around = (out.lanes.around).rewrite(out.vertices.len(), 2 * self.numbers.edges);
        let (mut has_room, mut written) = (true, 0);
        for &on in &self.classes.on_vertices {
            if self.classes.members[on as usize] & self.mask() == 0 {
                continue;
            }
            let place = self.numbers.tables().0[on as usize] as usize;
            has_room &= around.copy(from, &old[written..place]);
            let faces: SmallVec<[u32; 16]> = self.faces_around(on).collect();
            has_room &= around.push(&faces);
            written = place + 1;
        }
        has_room &= around.copy(from, &old[written..]);
        let of_cuts = self.rim.cut_edges.iter().map(|edge| {
            let [a, b] = edge.faces;
            [a.min(b), a.max(b), self.cap()]
        });
        has_room &= around.push_threes(of_cuts);
        if has_room { Ok(()) } else { Err(Irregular) }
    }

    /// The faces of the part around a vertex on the plane, ascending.
    fn faces_around(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let old = self.hull.lanes.faces_around(vertex as usize).iter();
        let kept = old
            .copied()
            .filter(move |&face| self.classes.parts_at(self.hull, face, vertex) & self.mask() != 0);
        let is_on_rim = self.rim.has(vertex);
        kept.chain(is_on_rim.then_some(self.cap()))
    }

    /// Faces and their loops, the cap last.
    fn write_faces(&self, out: &mut ConvexHull) -> Result<(), Irregular> {
        let old = self.numbers.faces.indices();
        let unwritten = Face {
            plane: self.plane,
            first: 0,
            count: 0,
        };
        out.faces.resize(old.len() + 1, unwritten);
        out.loops.resize(2 * self.numbers.edges, 0);
        let first = self.write_old_faces(old, &mut out.faces, &mut out.loops)?;
        // Reversed about the same first corner: where vertices on the plane leave the cap uneven, both parts have it as the
        // same triangle fan, and their volumes add up.
        let (cap, room) = (&self.rim.cap, &mut out.loops[first..]);
        if room.len() != cap.len() {
            return Err(Irregular);
        }
        room.copy_from_slice(cap);
        if self.mask() != BELOW {
            room[1..].reverse();
        }
        out.faces[old.len()] = Face {
            first: first as u32,
            count: cap.len() as u32,
            ..unwritten
        };
        Ok(())
    }

    /// Faces of the hull, or the pieces of those that are cut; says how many corners they have.
    fn write_old_faces(
        &self,
        old: &[u32],
        out: &mut [Face],
        room: &mut [u32],
    ) -> Result<usize, Irregular> {
        let writer = FaceWriter {
            faces: &self.hull.faces,
            loops: &self.hull.loops,
            old,
            out,
            room,
            place: 0,
            written: 0,
        };
        let cut = self.classes.cut_faces.indices().iter();
        let pieces = cut.zip(self.rim.pieces[self.part].iter());
        if self.hull.only_triangles().is_some() {
            writer.write_all::<3>(pieces, |face, _| (3 * face as usize, 3))
        } else {
            let loop_of = |_, old: &Face| (old.first as usize, old.count as usize);
            writer.write_all::<USUAL_CORNERS>(pieces, loop_of)
        }
    }

    /// Edges that the part has whole, halves of cut ones, edges on the plane, and chords.
    fn write_edges(&self, out: &mut ConvexHull) {
        let (edges, table) = (&mut out.edges, self.numbers.of_edges());
        let whole = self.classes.whole_edges[self.part].indices();
        edges.resize(whole.len(), self.hull.edges[0]);
        select_edges(self.wide, &self.hull.edges, whole, table, edges);
        edges.reserve_exact(self.numbers.edges - whole.len());
        let is_below = self.mask() == BELOW;
        let first_cut = self.hull.vertices.len() as u32;
        let halves = self.rim.cut_edges.iter().zip(first_cut..);
        edges.extend(halves.map(|(edge, cut)| {
            let end = edge.ends[self.part];
            let ends_at_cut = edge.goes_up == is_below;
            table.look_up(&Edge {
                vertices: if ends_at_cut { [end, cut] } else { [cut, end] },
                faces: edge.faces,
            })
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
        let chords = (self.classes.cut_faces.indices().iter()).zip(&self.rim.chords);
        edges.extend(chords.map(|(&face, &[up, down])| {
            table.look_up(&Edge {
                vertices: if is_below { [up, down] } else { [down, up] },
                faces: [face, self.cap()],
            })
        }));
    }
}

/// Writes faces, one after the other.
struct FaceWriter<'a> {
    /// All faces of the hull.
    faces: &'a [Face],
    /// Their loops.
    loops: &'a [u32],
    /// Those that are to be written.
    old: &'a [u32],
    /// Room for as many faces.
    out: &'a mut [Face],
    /// Room for all loops.
    room: &'a mut [u32],
    /// Faces written.
    place: usize,
    /// Corners written.
    written: u32,
}

impl<'a> FaceWriter<'a> {
    /// Writes all faces, and says how many corners they have. Some are in pieces: lists that begin with the corners of a
    /// piece, and how many it has. `loop_of` says where the loop of any other begins, and how many corners it has, mostly no
    /// more than `N`.
    ///
    /// Kept apart, so that all that the loop needs stays in registers.
    #[inline(never)]
    fn write_all<const N: usize>(
        mut self,
        pieces: impl Iterator<Item = (&'a u32, (&'a [u32], usize))>,
        loop_of: impl Fn(u32, &Face) -> (usize, usize),
    ) -> Result<usize, Irregular> {
        for (&face, (piece, count)) in pieces {
            self.write_whole::<N>(face, &loop_of)?;
            self.write::<USUAL_CORNERS>(face, piece, 0, count)?;
        }
        self.write_whole::<N>(u32::MAX, loop_of)?;
        Ok(self.written as usize)
    }

    /// Writes the faces before `end`.
    #[inline(always)]
    fn write_whole<const N: usize>(
        &mut self,
        end: u32,
        loop_of: impl Fn(u32, &Face) -> (usize, usize),
    ) -> Result<(), Irregular> {
        while let Some(&face) = self.old.get(self.place)
            && face != end
        {
            let (first, count) = loop_of(face, &self.faces[face as usize]);
            self.write::<N>(face, self.loops, first, count)?;
        }
        Ok(())
    }

    /// Writes a face with `count` corners, mostly no more than `N`, that stand in a list from `first` on.
    #[inline(always)]
    fn write<const N: usize>(
        &mut self,
        face: u32,
        from: &[u32],
        first: usize,
        count: usize,
    ) -> Result<(), Irregular> {
        let written = self.written as usize;
        if count <= N
            && let Some(from) = from.get(first..first + N)
            && let Some(to) = self.room.get_mut(written..written + N)
        {
            // More than there may be, which the next face writes over: there is no guessing how many corners it has.
            to.copy_from_slice(from);
        } else {
            copy_many_corners(&from[first..][..count], self.room, written)?;
        }
        *self.out.get_mut(self.place).ok_or(Irregular)? = Face {
            plane: self.faces[face as usize].plane,
            first: self.written,
            count: count as u32,
        };
        self.written += count as u32;
        self.place += 1;
        Ok(())
    }
}

/// Copies the corners of a face that has many, or that is near the end of a list.
#[inline(never)]
fn copy_many_corners(from: &[u32], room: &mut [u32], written: usize) -> Result<(), Irregular> {
    let to = room
        .get_mut(written..written + from.len())
        .ok_or(Irregular)?;
    to.copy_from_slice(from);
    Ok(())
}

/// Most faces of a hull have no more corners.
const USUAL_CORNERS: usize = 4;
