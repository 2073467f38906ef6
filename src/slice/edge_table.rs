//! A table from undirected edges to numbers.

/// Marks the end of a list.
const NONE: u32 = u32::MAX;

/// Lists that an empty table begins with, a power of two.
const MIN_LISTS: usize = 64;

/// Spreads the numbers of an edge's ends: 2^64 over the golden ratio (D. E. Knuth, The Art of Computer Programming, volume 3, 6.4).
const SPREAD: u64 = 0x9e37_79b9_7f4a_7c15;

/// One edge, in the list of those whose ends spread to the same number.
#[derive(Clone, Copy, Debug)]
struct Entry {
    ends: [u32; 2],
    value: u32,
    next: u32,
}

/// A table from undirected edges between vertices to a `u32`.
///
/// Edges are spread over as many lists as there are edges. Lists by vertex would be long where many edges leave one vertex, as the
/// diagonals of a cap that is a fan do, all of which the next plane may cut.
#[derive(Clone, Debug, Default)]
pub(super) struct EdgeTable {
    /// First entry of each list; their number is a power of two.
    head: Vec<u32>,
    entries: Vec<Entry>,
}

impl EdgeTable {
    /// Forgets all edges; keeps the memory.
    pub(super) fn clear(&mut self) {
        self.entries.clear();
        self.head.fill(NONE);
    }

    /// The list of an edge, if there is one.
    #[inline]
    fn list(&self, [low, high]: [u32; 2]) -> usize {
        let spread = (u64::from(low) << 32 | u64::from(high)).wrapping_mul(SPREAD);
        (spread >> 32) as usize & self.head.len().wrapping_sub(1)
    }

    /// The value of the edge between `a` and `b`.
    #[inline]
    pub(super) fn get(&self, a: u32, b: u32) -> Option<u32> {
        let ends = [a.min(b), a.max(b)];
        let mut at = *self.head.get(self.list(ends))?;
        while let Some(entry) = self.entries.get(at as usize) {
            if entry.ends == ends {
                return Some(entry.value);
            }
            at = entry.next;
        }
        None
    }

    /// Adds the edge between `a` and `b`, which is not in the table yet.
    pub(super) fn insert(&mut self, a: u32, b: u32, value: u32) {
        if self.entries.len() == self.head.len() {
            self.spread_out();
        }
        let ends = [a.min(b), a.max(b)];
        let list = self.list(ends);
        self.entries.push(Entry {
            ends,
            value,
            next: self.head[list],
        });
        self.head[list] = self.entries.len() as u32 - 1;
    }

    /// Doubles the number of lists.
    #[cold]
    fn spread_out(&mut self) {
        let lists = (2 * self.head.len()).max(MIN_LISTS);
        self.head.clear();
        self.head.resize(lists, NONE);
        for place in 0..self.entries.len() {
            let list = self.list(self.entries[place].ends);
            self.entries[place].next = self.head[list];
            self.head[list] = place as u32;
        }
    }
}
