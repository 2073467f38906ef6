//! Writing the parts: new numbers, and copies of runs of what the plane leaves alone.

use super::Irregular;
use super::classes::{ABOVE, BELOW, BOTH, Classes};
use super::rim::Rim;
use crate::geometry::lanes::box_of;
use crate::geometry::{ConvexHull, Edge, Face};
use crate::math::Plane;
use smallvec::SmallVec;

/// The numbers that a hull's vertices and faces have in each part, and what each part has of everything.
#[derive(Clone, Debug, Default)]
pub(super) struct Numbers {
    /// The cut points are numbered after the vertices.
    vertices: [Selection; 2],
    faces: [Selection; 2],
    edges: [usize; 2],
}

/// Some of a list, numbered in order.
#[derive(Clone, Debug, Default)]
struct Selection {
    /// New numbers; those of what is not selected mean nothing.
    numbers: Vec<u32>,
    /// What is selected, and behind so many nothing of use.
    selected: Vec<u32>,
    count: usize,
}

/// Selects for each part what has its bit.
///
/// Without branches, because there is no guessing what is selected: what is not is written over by the next.
fn select(masks: &[u8], parts: &mut [Selection; 2]) {
    for part in parts.iter_mut() {
        part.numbers.resize(masks.len(), 0);
        if part.selected.len() < masks.len() {
            part.selected.resize(masks.len(), 0);
        }
    }
    let [below, above] = parts;
    let numbers = below.numbers.iter_mut().zip(&mut above.numbers);
    let selected = [&mut below.selected, &mut above.selected].map(|list| &mut list[..masks.len()]);
    let [in_below, in_above] = selected;
    let (mut count_below, mut count_above) = (0_u32, 0_u32);
    for (index, (&mask, (number_below, number_above))) in masks.iter().zip(numbers).enumerate() {
        *number_below = count_below;
        *number_above = count_above;
        in_below[count_below as usize] = index as u32;
        in_above[count_above as usize] = index as u32;
        count_below += u32::from(mask & BELOW);
        count_above += u32::from(mask / ABOVE);
    }
    below.count = count_below as usize;
    above.count = count_above as usize;
}

impl Selection {
    /// Old numbers of what is selected, ascending.
    fn selected(&self) -> &[u32] {
        &self.selected[..self.count]
    }
}

impl Numbers {
    /// Numbers vertices and faces, and checks that both parts fulfil Euler's formula.
    ///
    /// Each edge of a part has one face on either side, because it inherits them from the hull or is on the rim, which is one
    /// simple loop; so the formula says that the part is one closed surface without handles.
    pub(super) fn count(&mut self, classes: &Classes, rim: &Rim) -> Result<(), Irregular> {
        select(&classes.members, &mut self.vertices);
        select(&classes.faces, &mut self.faces);
        for part in 0..2 {
            let (vertices, faces) = (&mut self.vertices[part], &self.faces[part]);
            let cuts = rim.points.len();
            let total = vertices.count + cuts;
            vertices.numbers.extend(vertices.count as u32..total as u32);
            let mask = BELOW << part;
            let on = classes.on_edges.iter().filter(|e| e.parts.contains(&mask));
            let edges = classes.edges(mask).len() + on.count() + cuts + rim.chords.len();
            if total + faces.count + 1 != edges + 2 {
                return Err(Irregular);
            }
            self.edges[part] = edges;
        }
        Ok(())
    }

    /// The hull's faces that are whole or in pieces in a part.
    pub(super) fn old_faces(&self, part: usize) -> &[u32] {
        self.faces[part].selected()
    }

    /// Numbers of the cut faces in a part.
    pub(super) fn cut_faces<'a>(
        &'a self,
        classes: &'a Classes,
        part: usize,
    ) -> impl Iterator<Item = u32> + 'a {
        let numbers = &self.faces[part].numbers;
        let cut = classes.cut_faces.iter();
        cut.map(|&face| numbers[face as usize])
    }

    /// Writes a part; its moments stay to be found.
    pub(super) fn emit(
        &self,
        hull: &ConvexHull,
        classes: &Classes,
        rim: &Rim,
        part: usize,
        cap: Plane,
        out: &mut ConvexHull,
    ) -> Result<(), Irregular> {
        let writer = Writer {
            hull,
            classes,
            rim,
            part,
            mask: BELOW << part,
            vertices: &self.vertices[part],
            faces: &self.faces[part],
            edges: self.edges[part],
        };
        writer.write_vertices(out)?;
        writer.write_faces(out, cap)?;
        writer.write_edges(out);
        out.lanes.copy(&out.vertices, &out.faces);
        out.aabb = box_of(&out.lanes.points);
        Ok(())
    }
}

/// All that the writing of one part needs.
struct Writer<'a> {
    hull: &'a ConvexHull,
    classes: &'a Classes,
    rim: &'a Rim,
    part: usize,
    /// Bit of the part.
    mask: u8,
    vertices: &'a Selection,
    faces: &'a Selection,
    edges: usize,
}

impl Writer<'_> {
    fn cap(&self) -> u32 {
        self.faces.count as u32
    }

    fn vertex(&self, old: u32) -> u32 {
        self.vertices.numbers[old as usize]
    }

    fn face(&self, old: u32) -> u32 {
        self.faces.numbers[old as usize]
    }

    /// Vertices, and the faces around them.
    fn write_vertices(&self, out: &mut ConvexHull) -> Result<(), Irregular> {
        let (hull, old) = (self.hull, self.vertices.selected());
        let count = old.len() + self.rim.points.len();
        out.vertices.clear();
        out.vertices.reserve_exact(count);
        out.vertices
            .extend(old.iter().map(|&v| hull.vertices[v as usize]));
        out.vertices.extend_from_slice(&self.rim.points);
        let mut around = out.lanes.around.rewrite(count, 2 * self.edges);
        let numbers = &self.faces.numbers[..];
        let mut has_room = true;
        let mut written = 0;
        for &on in &self.classes.on_vertices {
            if self.classes.members[on as usize] & self.mask == 0 {
                continue;
            }
            let place = self.vertex(on) as usize;
            has_room &= around.copy(&hull.lanes.around, &old[written..place], numbers);
            let faces: SmallVec<[u32; 16]> = self.faces_around(on).collect();
            has_room &= around.push(&faces);
            written = place + 1;
        }
        has_room &= around.copy(&hull.lanes.around, &old[written..], numbers);
        for edge in &self.rim.cut_edges {
            let [a, b] = edge.faces.map(|face| numbers[face as usize]);
            has_room &= around.push(&[a.min(b), a.max(b), self.cap()]);
        }
        if has_room { Ok(()) } else { Err(Irregular) }
    }

    /// The faces of the part around a vertex on the plane, ascending.
    fn faces_around(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let old = self.hull.lanes.faces_around(vertex as usize).iter();
        let kept = old
            .filter(move |&&face| self.classes.parts_at(self.hull, face, vertex) & self.mask != 0);
        let is_on_rim = self.rim.has(vertex);
        kept.map(|&face| self.face(face))
            .chain(is_on_rim.then_some(self.cap()))
    }

    /// Faces and their loops, the cap last.
    fn write_faces(&self, out: &mut ConvexHull, cap: Plane) -> Result<(), Irregular> {
        let (hull, old, numbers) = (self.hull, self.faces.selected(), &self.vertices.numbers[..]);
        let unwritten = Face {
            plane: cap,
            first: 0,
            count: 0,
        };
        out.faces.resize(old.len() + 1, unwritten);
        out.loops.resize(2 * self.edges, 0);
        let mut writer = LoopWriter {
            room: &mut out.loops,
            written: 0,
        };
        let (classes, faces, loops) = (&self.classes.faces[..], &hull.faces[..], &hull.loops[..]);
        let mut pieces = self.rim.pieces[self.part].iter();
        for (&index, out) in old.iter().zip(&mut out.faces) {
            let Face {
                plane,
                first,
                count,
            } = faces[index as usize];
            let corners = if classes[index as usize] == BOTH {
                pieces.next().ok_or(Irregular)?
            } else {
                &loops[first as usize..][..count as usize]
            };
            *out = Face {
                plane,
                first: writer.written,
                count: corners.len() as u32,
            };
            if let [a, b, c] = *corners {
                // By far the most common one in a hull with many faces.
                writer.push_triangle([a, b, c], numbers)?;
            } else {
                writer.push(corners.iter().copied(), numbers)?;
            }
        }
        let first = writer.written;
        // Reversed about the same first corner: where vertices on the plane leave the cap uneven, both parts have it as the
        // same triangle fan, and their volumes add up.
        let (start, rest) = self.rim.cap.split_at(1);
        writer.push(start.iter().copied(), numbers)?;
        if self.mask == BELOW {
            writer.push(rest.iter().copied(), numbers)?;
        } else {
            writer.push(rest.iter().rev().copied(), numbers)?;
        }
        out.faces[old.len()] = Face {
            first,
            count: writer.written - first,
            ..unwritten
        };
        if writer.room.is_empty() {
            Ok(())
        } else {
            Err(Irregular)
        }
    }

    /// Edges that the part has whole, halves of cut ones, edges on the plane, and chords.
    fn write_edges(&self, out: &mut ConvexHull) {
        let edges = &mut out.edges;
        edges.clear();
        edges.reserve_exact(self.edges);
        let (vertices, faces) = (&self.vertices.numbers[..], &self.faces.numbers[..]);
        edges.extend(self.classes.edges(self.mask).iter().map(|&index| {
            let Edge {
                vertices: [a, b],
                faces: [f, g],
            } = self.hull.edges[index as usize];
            Edge {
                vertices: [vertices[a as usize], vertices[b as usize]],
                faces: [faces[f as usize], faces[g as usize]],
            }
        }));
        let first_cut = self.vertices.count as u32;
        edges.extend(
            (self.rim.cut_edges.iter().zip(first_cut..)).map(|(edge, cut)| {
                let end = vertices[edge.ends[self.part] as usize];
                let ends_at_cut = edge.goes_up == (self.mask == BELOW);
                let [f, g] = edge.faces;
                Edge {
                    vertices: if ends_at_cut { [end, cut] } else { [cut, end] },
                    faces: [faces[f as usize], faces[g as usize]],
                }
            }),
        );
        for on_edge in &self.classes.on_edges {
            let is_inside = on_edge.parts.map(|part| part == self.mask);
            if is_inside != [false; 2] {
                let edge = &self.hull.edges[on_edge.edge as usize];
                let face = |k: usize| {
                    if is_inside[k] {
                        self.face(edge.faces[k])
                    } else {
                        self.cap()
                    }
                };
                edges.push(Edge {
                    vertices: edge.vertices.map(|v| self.vertex(v)),
                    faces: [face(0), face(1)],
                });
            }
        }
        let chords = self.classes.cut_faces.iter().zip(&self.rim.chords);
        edges.extend(chords.map(|(&face, &[up, down])| {
            let [up, down] = [vertices[up as usize], vertices[down as usize]];
            Edge {
                vertices: if self.mask == BELOW {
                    [up, down]
                } else {
                    [down, up]
                },
                faces: [faces[face as usize], self.cap()],
            }
        }));
    }
}

/// Writes face loops, one after the other.
struct LoopWriter<'a> {
    /// Room for those that are still to come.
    room: &'a mut [u32],
    written: u32,
}

impl LoopWriter<'_> {
    #[inline]
    fn push_triangle(&mut self, [a, b, c]: [u32; 3], numbers: &[u32]) -> Result<(), Irregular> {
        let room = std::mem::take(&mut self.room);
        let (out, rest) = room.split_first_chunk_mut().ok_or(Irregular)?;
        *out = [
            numbers[a as usize],
            numbers[b as usize],
            numbers[c as usize],
        ];
        self.room = rest;
        self.written += 3;
        Ok(())
    }

    #[inline]
    fn push(
        &mut self,
        corners: impl ExactSizeIterator<Item = u32>,
        numbers: &[u32],
    ) -> Result<(), Irregular> {
        let count = corners.len();
        let room = std::mem::take(&mut self.room);
        let (out, rest) = room.split_at_mut_checked(count).ok_or(Irregular)?;
        for (out, corner) in out.iter_mut().zip(corners) {
            *out = numbers[corner as usize];
        }
        self.room = rest;
        self.written += count as u32;
        Ok(())
    }
}
