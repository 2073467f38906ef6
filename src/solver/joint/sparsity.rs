//! In which order the bodies of joints are eliminated, and which pairs of them have a block then.
//!
//! The matrix `M + J^T K J` has a block for each body and for each pair of bodies that a joint joins. To eliminate a body couples
//! all those that it is still coupled with. Least degree first: along a tree the leaves go before what they hang on, nothing
//! couples that was not coupled before, and the work is linear in the number of joints. A loop costs what it fills in.
//!
//! Of equal degree, what holds on to nothing fixed goes first, so that along a tree the one that does is the last. If it went before, it would be
//! held by more rows than it can move along, and hand on the stiffness of those to what hangs on it: impulses would come out of that with half of their digits,
//! and a joint of 0.3 kg on 300 kg would break by what is only rounding.

use crate::disjoint_sets::DisjointSets;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A block beside the diagonal: of a body with one that is eliminated later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Column {
    /// Place of the later one in the order.
    pub(crate) to: u32,
    /// Number of the block.
    pub(crate) block: u32,
}

/// Where a pair of bodies has its block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct EdgeBlock {
    pub(crate) block: u32,
    /// Whether the second of the pair is eliminated first, so that the block's rows are its.
    pub(crate) is_flipped: bool,
}

/// How a body is eliminated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Elimination {
    /// As a block, with what fills in.
    Block,
    /// By the rows that hold it to the one at this place, the only one that it is coupled with, and that by joints alone; or to none.
    Rows(Option<u32>),
}

/// The order, and what it makes.
#[derive(Debug, Default)]
pub(crate) struct Sparsity {
    /// Pairs of bodies that it was made for, and which bodies joints hold to what they do not move.
    edges: Vec<[u32; 2]>,
    held: Vec<bool>,
    /// Bodies in their order.
    pub(crate) order: Vec<u32>,
    /// By body: its place in the order.
    pub(crate) position: Vec<u32>,
    /// By place: where its columns begin, and the end of all.
    pub(crate) starts: Vec<u32>,
    pub(crate) columns: Vec<Column>,
    /// By place, for each pair of its columns, of which the first is the earlier one: the block that both couple.
    pub(crate) updates: Vec<u32>,
    /// By place.
    pub(crate) eliminations: Vec<Elimination>,
    /// By edge.
    pub(crate) edge_blocks: Vec<EdgeBlock>,
    /// By body: number of the component, of bodies that joints connect, that it is in.
    pub(crate) components: Vec<u32>,
    /// Number of components.
    pub(crate) component_count: usize,
}

impl Sparsity {
    /// Orders bodies with these pairs, unless that is done. `held`: by body, whether joints hold it to what they do not move.
    pub(crate) fn analyse(&mut self, held: &[bool], edges: &[[u32; 2]]) {
        let count = held.len();
        if self.held == held && self.edges == edges {
            return;
        }
        self.edges.clear();
        self.edges.extend_from_slice(edges);
        self.held.clear();
        self.held.extend_from_slice(held);
        self.find_components(count);
        let neighbors = self.eliminate(count);
        self.number(&neighbors);
        self.find_updates();
        self.edge_blocks.clear();
        for &[a, b] in edges {
            let at = [a, b].map(|node| self.position[node as usize]);
            let is_flipped = at[1] < at[0];
            let block = self.block_of(at[0].min(at[1]), at[0].max(at[1]));
            self.edge_blocks.push(EdgeBlock { block, is_flipped });
        }
        self.find_eliminations();
    }

    fn find_eliminations(&mut self) {
        let mut eliminations = std::mem::take(&mut self.eliminations);
        eliminations.clear();
        eliminations.extend((0..self.order.len()).map(|at| match self.columns_of(at) {
            [] => Elimination::Rows(None),
            [column] if !self.updates.contains(&column.block) => Elimination::Rows(Some(column.to)),
            _ => Elimination::Block,
        }));
        self.eliminations = eliminations;
    }

    /// Numbers the components by the first body of each.
    fn find_components(&mut self, count: usize) {
        let mut sets = DisjointSets::new(count);
        for &[a, b] in &self.edges {
            sets.join(a, b);
        }
        self.components.clear();
        self.components.resize(count, u32::MAX);
        self.component_count = 0;
        for body in 0..count {
            let root = sets.root(body as u32) as usize;
            if self.components[root] == u32::MAX {
                self.components[root] = self.component_count as u32;
                self.component_count += 1;
            }
            self.components[body] = self.components[root];
        }
    }

    /// Finds the order; by body, those that it is coupled with when its turn comes.
    fn eliminate(&mut self, count: usize) -> Vec<Vec<u32>> {
        let mut neighbors: Vec<Vec<u32>> = vec![Vec::new(); count];
        for &[a, b] in &self.edges {
            insert(&mut neighbors[a as usize], b);
            insert(&mut neighbors[b as usize], a);
        }
        let (components, held) = (&self.components, &self.held);
        let key = |node: u32, degree: usize| {
            let i = node as usize;
            Reverse((components[i], degree, held[i], node))
        };
        let mut heap: BinaryHeap<_> = (0..)
            .zip(&neighbors)
            .map(|(node, list)| key(node, list.len()))
            .collect();
        self.order.clear();
        self.position.clear();
        self.position.resize(count, u32::MAX);
        while let Some(Reverse((_, degree, _, node))) = heap.pop() {
            let i = node as usize;
            // What it was listed with before its neighbors went.
            if self.position[i] != u32::MAX || degree != neighbors[i].len() {
                continue;
            }
            self.position[i] = self.order.len() as u32;
            self.order.push(node);
            let list = neighbors[i].clone();
            for &other in &list {
                let of_other = &mut neighbors[other as usize];
                of_other.retain(|&n| n != node);
                list.iter()
                    .filter(|&&n| n != other)
                    .for_each(|&n| insert(of_other, n));
                heap.push(key(other, of_other.len()));
            }
        }
        neighbors
    }

    fn number(&mut self, neighbors: &[Vec<u32>]) {
        self.starts.clear();
        self.columns.clear();
        for &node in &self.order {
            let first = self.columns.len();
            self.starts.push(first as u32);
            let list = neighbors[node as usize].iter();
            let columns = list.zip(first as u32..).map(|(&n, block)| Column {
                to: self.position[n as usize],
                block,
            });
            self.columns.extend(columns);
            self.columns[first..].sort_by_key(|column| column.to);
        }
        self.starts.push(self.columns.len() as u32);
    }

    fn find_updates(&mut self) {
        let mut updates = std::mem::take(&mut self.updates);
        updates.clear();
        for at in 0..self.order.len() {
            let columns = self.columns_of(at);
            for (k, first) in columns.iter().enumerate() {
                for second in &columns[k + 1..] {
                    let block = self.block_of(first.to, second.to);
                    updates.push(block);
                }
            }
        }
        self.updates = updates;
    }

    /// The component of the body at a place.
    #[inline(always)]
    pub(super) fn component_at(&self, at: usize) -> usize {
        self.components[self.order[at] as usize] as usize
    }

    /// Columns of the body at a place.
    pub(crate) fn columns_of(&self, at: usize) -> &[Column] {
        &self.columns[self.starts[at] as usize..self.starts[at + 1] as usize]
    }

    /// The block of two places.
    fn block_of(&self, first: u32, second: u32) -> u32 {
        let columns = self.columns_of(first as usize);
        let at = columns.binary_search_by_key(&second, |column| column.to);
        at.map_or(0, |at| columns[at].block)
    }
}

/// Puts a number into a sorted list that has it not.
fn insert(list: &mut Vec<u32>, number: u32) {
    if let Err(at) = list.binary_search(&number) {
        list.insert(at, number);
    }
}
