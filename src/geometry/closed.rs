//! Whether a surface is closed, in one pass over its edges, and remembering that it is.

use std::sync::OnceLock;

/// No vertex.
const NONE: u32 = u32::MAX;

/// Set once a mesh was found closed, or was made so. No part of the mesh's value: all are equal.
#[derive(Clone, Debug, Default)]
pub(crate) struct KnownClosed(OnceLock<()>);

impl KnownClosed {
    pub(crate) fn set(&self) {
        self.0.get_or_init(|| ());
    }

    pub(crate) fn is_set(&self) -> bool {
        self.0.get().is_some()
    }

    /// Forgets it.
    pub(crate) fn clear(&mut self) {
        self.0.take();
    }
}

impl PartialEq for KnownClosed {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// A corner of a triangle: the corners after and before it.
#[derive(Clone, Copy, Debug, Default)]
struct Corner {
    next: u32,
    last: u32,
}

/// Pairs directed edges with their reverses, keeping its working memory.
///
/// The corners are sorted by vertex, by counting. At each vertex the corners after it have to be different, or an edge
/// leaves it twice; and each corner before it has to be one of them, or an edge comes in and does not go back. That holds
/// for all vertices if and only if each directed edge occurs once and so does its reverse.
#[derive(Clone, Debug, Default)]
pub(crate) struct EdgeCensus {
    corners: Vec<Corner>,
    /// Where the corners of each vertex end; while they are written, where the next one goes.
    ends: Vec<u32>,
    /// By vertex: the last one that an edge was seen to come from.
    reached_from: Vec<u32>,
}

impl EdgeCensus {
    /// Whether each directed edge of `triangles` occurs exactly once and so does its reverse.
    ///
    /// `topology` numbers the positions of the vertices, all below `count`.
    pub(crate) fn is_closed(
        &mut self,
        triangles: &[[u32; 3]],
        topology: &[u32],
        count: usize,
    ) -> bool {
        self.sort_corners(triangles, topology, count);
        self.reached_from.clear();
        self.reached_from.resize(count, NONE);
        let mut first = 0;
        for (vertex, &end) in (0_u32..).zip(&self.ends) {
            let corners = &self.corners[first as usize..end as usize];
            first = end;
            // An edge from the vertex to itself is none.
            self.reached_from[vertex as usize] = vertex;
            for corner in corners {
                let from = &mut self.reached_from[corner.next as usize];
                if std::mem::replace(from, vertex) == vertex {
                    return false;
                }
            }
            let returns = |corner: &Corner| self.reached_from[corner.last as usize] == vertex;
            if !corners.iter().all(returns) {
                return false;
            }
        }
        true
    }

    /// Counting sort of the corners by vertex.
    fn sort_corners(&mut self, triangles: &[[u32; 3]], topology: &[u32], count: usize) {
        self.ends.clear();
        self.ends.resize(count, 0);
        for corner in triangles.iter().flatten() {
            self.ends[topology[*corner as usize] as usize] += 1;
        }
        let mut sum = 0;
        for end in &mut self.ends {
            let corners = std::mem::replace(end, sum);
            sum += corners;
        }
        self.corners.resize(3 * triangles.len(), Corner::default());
        for corners in triangles {
            let [a, b, c] = corners.map(|v| topology[v as usize]);
            for [at, next, last] in [[a, b, c], [b, c, a], [c, a, b]] {
                let place = &mut self.ends[at as usize];
                self.corners[*place as usize] = Corner { next, last };
                *place += 1;
            }
        }
    }
}
