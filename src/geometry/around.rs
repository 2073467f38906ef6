//! The faces that meet in each vertex of a hull.

use super::convex::Face;

/// Faces around each vertex, ascending, one vertex after the other.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FacesAround {
    faces: Vec<u32>,
    /// Where each vertex's run begins in `faces`, and where the last one ends.
    first: Vec<u32>,
}

impl Default for FacesAround {
    /// Of no vertex.
    fn default() -> Self {
        Self {
            faces: Vec::new(),
            first: vec![0],
        }
    }
}

impl FacesAround {
    /// Counting sort of all corners by vertex.
    pub(crate) fn sort_corners(&mut self, vertices: usize, faces: &[Face], loops: &[u32]) {
        self.first.resize(vertices + 1, 0);
        loops.iter().for_each(|&v| self.first[v as usize + 1] += 1);
        for v in 0..vertices {
            self.first[v + 1] += self.first[v];
        }
        let mut next = self.first.clone();
        self.faces.resize(loops.len(), 0);
        for (index, face) in (0..).zip(faces) {
            for &v in &loops[face.first as usize..][..face.count as usize] {
                self.faces[next[v as usize] as usize] = index;
                next[v as usize] += 1;
            }
        }
    }

    /// Makes room for so many vertices with so many corners, to be written in order.
    pub(crate) fn rewrite(&mut self, vertices: usize, corners: usize) -> AroundWriter<'_> {
        self.first.resize(vertices + 1, 0);
        self.faces.resize(corners, 0);
        AroundWriter {
            ends: &mut self.first[1..],
            faces: &mut self.faces,
            written: 0,
        }
    }

    /// The faces around all vertices, one vertex after the other.
    pub(crate) fn faces_mut(&mut self) -> &mut [u32] {
        // Room that nothing was written to is no vertex's.
        let end = self.first.last().map_or(0, |&end| end as usize);
        &mut self.faces[..end]
    }

    /// The faces that meet in a vertex, ascending.
    pub(crate) fn of(&self, vertex: usize) -> &[u32] {
        &self.faces[self.first[vertex] as usize..self.first[vertex + 1] as usize]
    }
}

/// Most vertices of a hull have no more faces around them.
const USUALLY_AROUND: usize = 8;

/// Vertices that are copied as one block where they follow one another. Neighbours in the list of a hull are mostly neighbours
/// in space, so that a plane leaves long runs of them on one side.
const RUN: usize = 8;

/// Whether the first of ascending vertices are a run.
#[inline(always)]
fn begins_with_run(vertices: &[u32]) -> bool {
    let last = vertices.get(RUN - 1);
    last.is_some_and(|&last| last - vertices[0] == RUN as u32 - 1)
}

/// Writes the faces around vertices, one vertex after the other.
#[derive(Debug)]
pub(crate) struct AroundWriter<'a> {
    /// Of the vertices that are still to come.
    ends: &'a mut [u32],
    faces: &'a mut [u32],
    written: usize,
}

impl AroundWriter<'_> {
    /// Writes the faces around `vertices` of `other`. False if there is no room left.
    pub(crate) fn copy(&mut self, other: &FacesAround, vertices: &[u32]) -> bool {
        let Some((ends, rest)) =
            std::mem::take(&mut self.ends).split_at_mut_checked(vertices.len())
        else {
            return false;
        };
        self.ends = rest;
        let (firsts, all) = (&other.first[..], &other.faces[..]);
        let (room, mut written) = (&mut *self.faces, self.written);
        let (mut has_room, mut place) = (true, 0);
        while let Some(&vertex) = vertices.get(place) {
            let vertex = vertex as usize;
            let first = firsts[vertex] as usize;
            if begins_with_run(&vertices[place..])
                && let Some(run) = firsts[vertex + 1..].first_chunk::<RUN>()
                && let Some(ends) = ends[place..].first_chunk_mut::<RUN>()
                && let Some(to) = room.get_mut(written..written + run[RUN - 1] as usize - first)
            {
                to.copy_from_slice(&all[first..run[RUN - 1] as usize]);
                let shift = (written as u32).wrapping_sub(first as u32);
                *ends = run.map(|end| end.wrapping_add(shift));
                written += to.len();
                place += RUN;
                continue;
            }
            let count = firsts[vertex + 1] as usize - first;
            if count <= USUALLY_AROUND
                && let Some(from) = all.get(first..first + USUALLY_AROUND)
                && let Some(to) = room.get_mut(written..written + USUALLY_AROUND)
            {
                // More than are there, which the next vertex writes over: there is no guessing how many it will be.
                to.copy_from_slice(from);
            } else if let Some(to) = room.get_mut(written..written + count) {
                to.copy_from_slice(&all[first..][..count]);
            } else {
                has_room = false;
            }
            written += count;
            ends[place] = written as u32;
            place += 1;
        }
        self.written = written;
        has_room
    }

    /// Writes the faces around vertices that have three each. False if there is no room left.
    #[inline(always)]
    pub(crate) fn push_threes(&mut self, threes: impl ExactSizeIterator<Item = [u32; 3]>) -> bool {
        let to = (self.faces).get_mut(self.written..self.written + 3 * threes.len());
        let ends = std::mem::take(&mut self.ends).split_at_mut_checked(threes.len());
        let (Some(to), Some((ends, rest))) = (to, ends) else {
            return false;
        };
        for ((three, to), end) in threes.zip(to.as_chunks_mut().0).zip(ends) {
            *to = three;
            self.written += 3;
            *end = self.written as u32;
        }
        self.ends = rest;
        true
    }

    /// Writes the faces around the next vertex, ascending. False if there is no room left.
    #[inline(always)]
    pub(crate) fn push(&mut self, faces: &[u32]) -> bool {
        let to = (self.faces).get_mut(self.written..self.written + faces.len());
        let ends = std::mem::take(&mut self.ends);
        let (Some(to), Some((end, rest))) = (to, ends.split_first_mut()) else {
            return false;
        };
        to.copy_from_slice(faces);
        self.written += faces.len();
        *end = self.written as u32;
        self.ends = rest;
        true
    }
}

#[cfg(test)]
mod tests {
    use crate::geometry::primitives::icosphere;

    #[test]
    fn faces_around_a_vertex_are_those_whose_loops_name_it() {
        let hull = icosphere(1.0, 1).expect("a ball is valid");
        for vertex in 0..hull.vertices().len() {
            let expected: Vec<u32> = (0..)
                .zip(hull.faces())
                .filter(|(_, face)| hull.face_loop(face).contains(&(vertex as u32)))
                .map(|(index, _)| index)
                .collect();
            assert_eq!(hull.lanes.faces_around(vertex), expected);
        }
    }
}
