//! Directed edges without a partner, joined into closed loops.

use crate::geometry::TriMesh;
use crate::slice::clip::Clip;
use std::ops::Range;

const NONE: u32 = u32::MAX;

/// The closed loops of the rim; keeps its working memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Border {
    /// Vertex numbers of all loops, one after the other.
    vertices: Vec<u32>,
    /// Where each loop ends.
    ends: Vec<usize>,
    /// By topology number: the first rim edge that leaves it and was not walked yet.
    first_out: Vec<u32>,
    /// By rim edge: the next one that leaves the same point.
    next_out: Vec<u32>,
    path: Vec<u32>,
    place_in_path: Vec<u32>,
}

impl Border {
    /// Number of loops.
    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    /// The loops, as vertex numbers.
    pub(super) fn loops(&self) -> impl Iterator<Item = &[u32]> + '_ {
        (0..self.ends.len()).map(|index| &self.vertices[self.range(index)])
    }

    fn range(&self, index: usize) -> Range<usize> {
        let first = index.checked_sub(1).map_or(0, |before| self.ends[before]);
        first..self.ends[index]
    }

    /// Joins the rim's directed edges into closed loops of vertex numbers.
    ///
    /// No loop visits a topology number twice: where several loops touch, the walk closes a loop as soon as it comes
    /// back to a point. The rim is the boundary of a set of triangles, so every point has as many edges in as out, and
    /// the walk never gets stuck. Two edges that are each other's reverse cancel.
    pub(super) fn run(&mut self, mesh: &TriMesh, clip: &Clip) {
        let number = |vertex: u32| clip.topology(mesh, vertex) as usize;
        self.reset(clip);
        for (edge, &[from, _]) in (0..).zip(&clip.rim) {
            let first = &mut self.first_out[number(from)];
            self.next_out.push(*first);
            *first = edge;
        }
        for &[start, _] in &clip.rim {
            let mut at = start;
            loop {
                let place = self.place_in_path[number(at)];
                if place != NONE {
                    self.close_loop(place as usize, number);
                }
                let edge = self.first_out[number(at)];
                if edge == NONE {
                    break;
                }
                self.first_out[number(at)] = self.next_out[edge as usize];
                self.place_in_path[number(at)] = self.path.len() as u32;
                self.path.push(at);
                at = clip.rim[edge as usize][1];
            }
            debug_assert!(self.path.is_empty(), "the rim of a closed mesh is closed");
        }
    }

    fn reset(&mut self, clip: &Clip) {
        self.vertices.clear();
        self.ends.clear();
        self.next_out.clear();
        self.path.clear();
        for table in [&mut self.first_out, &mut self.place_in_path] {
            table.clear();
            table.resize(clip.topology_count as usize, NONE);
        }
    }

    /// Takes the end of the path, from `place` on, as a loop.
    fn close_loop(&mut self, place: usize, number: impl Fn(u32) -> usize) {
        let first = self.vertices.len();
        self.vertices.extend(self.path.drain(place..));
        for &vertex in &self.vertices[first..] {
            self.place_in_path[number(vertex)] = NONE;
        }
        if self.vertices.len() - first >= 3 {
            self.ends.push(self.vertices.len());
        } else {
            self.vertices.truncate(first);
        }
    }
}
