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
        for edge in &self.rim.cut_edges {
            let [a, b] = edge.faces;
            has_room &= around.push(&[a.min(b), a.max(b), self.cap()]);
        }
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
        let (_, numbers) = self.numbers.tables();
        let mut writer = FaceWriter {
            hull: self.hull,
            triangles: self.hull.only_triangles(),
            room,
            written: 0,
        };
        let mut next = 0;
        let cut = self.classes.cut_faces.indices().iter();
        for (&face, (piece, count)) in cut.zip(self.rim.pieces[self.part].iter()) {
            let place = numbers[face as usize] as usize;
            writer.write_whole(&old[next..place], &mut out[next..place])?;
            out[place] = writer.write_face(face, piece, count)?;
            next = place + 1;
        }
        writer.write_whole(&old[next..], &mut out[next..])?;
        Ok(writer.written)
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
    hull: &'a ConvexHull,
    /// The loops of the hull, if all of them are triangles.
    triangles: Option<&'a [[u32; 3]]>,
    /// Room for all loops.
    room: &'a mut [u32],
    /// Corners written.
    written: usize,
}

impl FaceWriter<'_> {
    /// Writes a face of the hull with other corners, which stand at the front of a list.
    #[inline]
    fn write_face(&mut self, face: u32, from: &[u32], count: usize) -> Result<Face, Irregular> {
        let first = self.written;
        copy_corners(from, count, self.room, first)?;
        self.written += count;
        Ok(Face {
            plane: self.hull.faces[face as usize].plane,
            first: first as u32,
            count: count as u32,
        })
    }

    /// Writes faces of the hull.
    #[inline]
    fn write_whole(&mut self, faces: &[u32], out: &mut [Face]) -> Result<(), Irregular> {
        let Some(triangles) = self.triangles else {
            return self.write_polygons(faces, out);
        };
        let range = self.written..self.written + 3 * faces.len();
        let room = self.room.get_mut(range).ok_or(Irregular)?;
        let (old, mut first) = (&self.hull.faces[..], self.written as u32);
        let room = room.as_chunks_mut().0;
        for ((&face, out), corners) in faces.iter().zip(out).zip(room) {
            *corners = triangles[face as usize];
            *out = Face {
                plane: old[face as usize].plane,
                first,
                count: 3,
            };
            first += 3;
        }
        self.written = first as usize;
        Ok(())
    }

    /// Writes faces of the hull with any number of corners.
    fn write_polygons(&mut self, faces: &[u32], out: &mut [Face]) -> Result<(), Irregular> {
        for (&face, out) in faces.iter().zip(out) {
            let old = &self.hull.faces[face as usize];
            let corners = &self.hull.loops[old.range().start..];
            *out = self.write_face(face, corners, old.count as usize)?;
        }
        Ok(())
    }
}

/// Copies as many corners as said from the front of a list to place `written` of another.
#[inline(always)]
fn copy_corners(
    from: &[u32],
    count: usize,
    room: &mut [u32],
    written: usize,
) -> Result<(), Irregular> {
    let to = room.get_mut(written..).ok_or(Irregular)?;
    if count <= USUAL_CORNERS
        && let Some(from) = from.first_chunk::<USUAL_CORNERS>()
        && let Some(to) = to.first_chunk_mut()
    {
        // More than there may be, which the next face writes over: there is no guessing how many corners it has.
        *to = *from;
        return Ok(());
    }
    copy_many_corners(&from[..count], to)
}

/// As [`copy_corners`], of a face with many corners or near the end of a list.
#[inline(never)]
fn copy_many_corners(from: &[u32], to: &mut [u32]) -> Result<(), Irregular> {
    let to = to.get_mut(..from.len()).ok_or(Irregular)?;
    to.copy_from_slice(from);
    Ok(())
}

/// Most faces of a hull have no more corners.
const USUAL_CORNERS: usize = 4;
