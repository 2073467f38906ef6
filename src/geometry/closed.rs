//! Whether a surface is closed, in one pass over its edges, and remembering that it is.

use std::sync::OnceLock;

/// Marks the end of a list.
const NONE: u32 = u32::MAX;

/// Entries looked at per edge, on average, before the lists count as too long: where thousands of edges meet at one
/// vertex, sorting is faster.
const PATIENCE: usize = 32;

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

/// One undirected edge, in the list of its end with the smaller number.
#[derive(Clone, Copy, Debug)]
struct Entry {
    high: u32,
    /// Directions in which the edge was seen: 1 upwards, 2 downwards.
    seen: u32,
    next: u32,
}

/// Pairs directed edges with their reverses, keeping its working memory.
///
/// Each vertex heads a list of its edges to vertices of larger number; there are about three.
#[derive(Clone, Debug, Default)]
pub(crate) struct EdgeCensus {
    heads: Vec<u32>,
    entries: Vec<Entry>,
}

impl EdgeCensus {
    /// Whether each directed edge of `triangles` occurs exactly once and so does its reverse.
    ///
    /// `topology` numbers the positions of the vertices, all below `count`. A `false` may also mean that the lists got too
    /// long: only a sort can tell then.
    pub(crate) fn is_closed(
        &mut self,
        triangles: &[[u32; 3]],
        topology: &[u32],
        count: usize,
    ) -> bool {
        self.heads.clear();
        self.heads.resize(count, NONE);
        self.entries.clear();
        let edges = 3 * triangles.len();
        self.entries.reserve(edges / 2 + 1);
        let mut patience = PATIENCE * edges;
        for corners in triangles {
            let [a, b, c] = corners.map(|v| topology[v as usize]);
            let is_first_time = self.see(a, b, &mut patience)
                && self.see(b, c, &mut patience)
                && self.see(c, a, &mut patience);
            if !is_first_time {
                return false;
            }
        }
        // Each entry was seen once or twice; twice on average means that all were.
        2 * self.entries.len() == edges
    }

    /// Notes the edge from `from` to `to`; whether it is the first time.
    #[inline]
    fn see(&mut self, from: u32, to: u32, patience: &mut usize) -> bool {
        let (low, high) = (from.min(to), from.max(to));
        let seen = 1 + u32::from(from > to);
        let head = &mut self.heads[low as usize];
        let mut at = *head;
        while let Some(entry) = self.entries.get_mut(at as usize) {
            if entry.high == high {
                let is_first_time = entry.seen & seen == 0;
                entry.seen |= seen;
                return is_first_time;
            }
            at = entry.next;
            *patience -= 1;
            if *patience == 0 {
                return false;
            }
        }
        let next = std::mem::replace(head, self.entries.len() as u32);
        self.entries.push(Entry { high, seen, next });
        true
    }
}
