//! Disjoint sets of numbers that grow together: who belongs to whom.
//!
//! # References
//! R. E. Tarjan, "Efficiency of a Good But Not Linear Set Union Algorithm", Journal of the ACM 22(2), 1975.

/// Disjoint sets of the numbers below a count. Each is named by one of its members, its root.
#[derive(Clone, Debug, Default)]
pub(crate) struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    /// Each number by itself.
    pub(crate) fn new(count: usize) -> Self {
        let mut sets = Self::default();
        sets.reset(count);
        sets
    }

    /// The same again, without an allocation if there were as many before.
    pub(crate) fn reset(&mut self, count: usize) {
        self.parent.clear();
        self.parent.extend(0..count as u32);
    }

    /// How many numbers there are.
    pub(crate) fn len(&self) -> usize {
        self.parent.len()
    }

    /// The member by which the set of another one is named; halves the path to it.
    #[inline]
    pub(crate) fn root(&mut self, mut member: u32) -> u32 {
        while self.parent[member as usize] != member {
            let above = self.parent[self.parent[member as usize] as usize];
            self.parent[member as usize] = above;
            member = above;
        }
        member
    }

    /// Makes two sets one. If all are joined so, the root is the least member, in whatever order they are joined.
    #[inline]
    pub(crate) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.put_under(a.min(b), a.max(b));
    }

    /// Makes two sets one that keeps the first one's root; both are given by their roots.
    #[inline]
    pub(crate) fn put_under(&mut self, root: u32, other: u32) {
        self.parent[other as usize] = root;
    }
}
