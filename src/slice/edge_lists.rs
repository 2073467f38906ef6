//! The undirected edges of each vertex, with a number each, on dense arrays.

/// Marks the end of a list.
const NONE: u32 = u32::MAX;

/// One edge, in the list of its end with the smaller number.
#[derive(Clone, Copy, Debug)]
struct Entry {
    other: u32,
    value: u32,
    next: u32,
}

/// A table from undirected edges between densely numbered vertices to a `u32`, which also tells the edges of a vertex.
///
/// Each vertex heads a list of the edges to vertices of larger number; where nobody asks for the edges of a vertex,
/// [`EdgeTable`](crate::slice::edge_table::EdgeTable) finds one sooner.
#[derive(Clone, Debug, Default)]
pub(super) struct EdgeLists {
    head: Vec<u32>,
    entries: Vec<Entry>,
}

impl EdgeLists {
    /// Forgets all edges and makes room for vertices `0..vertices`; keeps the memory.
    pub(super) fn reset(&mut self, vertices: usize) {
        self.entries.clear();
        self.head.clear();
        self.head.resize(vertices, NONE);
    }

    /// The entry of the edge between `a` and `b`.
    #[inline]
    fn find(&self, a: u32, b: u32) -> Option<usize> {
        let (low, high) = (a.min(b), a.max(b));
        let mut at = self.head[low as usize];
        while at != NONE {
            let entry = self.entries[at as usize];
            if entry.other == high {
                return Some(at as usize);
            }
            at = entry.next;
        }
        None
    }

    /// The value of the edge between `a` and `b`.
    pub(super) fn get(&self, a: u32, b: u32) -> Option<u32> {
        self.find(a, b).map(|at| self.entries[at].value)
    }

    /// The value of the edge between `a` and `b`, to be changed.
    pub(super) fn get_mut(&mut self, a: u32, b: u32) -> Option<&mut u32> {
        self.find(a, b).map(|at| &mut self.entries[at].value)
    }

    /// Calls `each` with the other ends of all edges from `a` to vertices of larger number.
    pub(super) fn for_each_above(&self, a: u32, mut each: impl FnMut(u32)) {
        let mut at = self.head[a as usize];
        while at != NONE {
            each(self.entries[at as usize].other);
            at = self.entries[at as usize].next;
        }
    }

    /// Adds the edge between `a` and `b`, which is not in the table yet.
    pub(super) fn insert(&mut self, a: u32, b: u32, value: u32) {
        let (low, high) = (a.min(b), a.max(b));
        let head = &mut self.head[low as usize];
        self.entries.push(Entry {
            other: high,
            value,
            next: *head,
        });
        *head = self.entries.len() as u32 - 1;
    }
}
