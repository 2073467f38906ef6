//! A large island cut into subdomains, so that several threads sweep over it at a time without touching each other's bodies.
//!
//! Bodies are halved by planes, and the halves again. What joins two bodies of one leaf belongs to it, what crosses a cut
//! belongs to the separator there:
//!
//! ```text
//! stage 0   leaf 0   leaf 1   leaf 2   leaf 3      side by side
//! stage 1     separator 0|1     separator 2|3      side by side
//! stage 2         separator 01|23                  alone
//! ```
//!
//! A sweep goes through the subdomains in this order on any number of threads: which subdomains there are follows from the scene
//! alone. Each subdomain keeps the order of its manifolds. A thread keeps to its leaves, whose data stay in its cache; stages of
//! a coloring would hand half of all bodies to the other core dozens of times per sweep.

use crate::solver::graph::bisection::Bisection;
use crate::solver::graph::indices::BodyNumber;
use crate::threads::team::Team;
use crate::tuning::{MAX_LEAVES, MIN_LEAF_MANIFOLDS};
use glam::Vec3;
use std::ops::Range;

/// Number of leaves of an island with `manifolds` manifolds: a power of two.
pub fn leaves(manifolds: usize) -> usize {
    let most = (manifolds / MIN_LEAF_MANIFOLDS).clamp(1, MAX_LEAVES);
    1 << most.ilog2()
}

/// Which bodies are in which leaf; buffers are reused.
#[derive(Debug, Default)]
pub struct Partition {
    /// Bodies of the leaves, once they are [sorted](Self::sort).
    leaves: Vec<Range<usize>>,
    /// By number of a body; for those that contacts do not move, the number of leaves.
    leaf: Vec<u8>,
    /// The same by the numbers that the bodies had when they were cut, and what a new cut makes of it.
    old_leaf: Vec<u8>,
    new_leaf: Vec<u8>,
    /// By old number of a body: its new one.
    renamed: Vec<BodyNumber>,
    old_slots: Vec<u32>,
    halves: Bisection,
}

impl Partition {
    /// Leaves all bodies together; whether that is what was done before.
    pub fn keep_whole(&mut self) -> bool {
        let is_same = self.leaves.is_empty();
        self.leaves.clear();
        is_same
    }

    /// Cuts `count` bodies into `leaves` leaves, more than one, by their centers of mass, m; those that contacts do not move
    /// have none, and are in no leaf. Whether they were cut the same way before; then they keep the numbers that
    /// [`sort`](Self::sort) gave them.
    pub fn cut(
        &mut self,
        count: usize,
        center: impl Fn(usize) -> Option<Vec3> + Sync,
        gravity: Vec3,
        leaves: usize,
        team: Option<&Team>,
    ) -> bool {
        self.new_leaf.clear();
        let leaf_by_body = self.halves.cut(count, center, gravity, leaves, team);
        self.new_leaf.extend(leaf_by_body);
        if !self.leaves.is_empty() && self.new_leaf == self.old_leaf {
            return true;
        }
        std::mem::swap(&mut self.new_leaf, &mut self.old_leaf);
        self.leaf.clone_from(&self.old_leaf);
        let mut ends = [0; MAX_LEAVES + 1];
        for leaf in &self.leaf {
            ends[*leaf as usize] += 1;
        }
        self.leaves.clear();
        let mut first = 0;
        self.leaves.extend(ends[..leaves].iter().map(|count| {
            first += count;
            first - count..first
        }));
        false
    }

    /// Gives the bodies new numbers, leaf by leaf, those that contacts do not move behind all others: what one thread writes
    /// lies together. `slots` are those of the bodies by number, `pairs` hold numbers.
    pub fn sort(&mut self, slots: &mut [u32], pairs: &mut [[BodyNumber; 2]]) {
        if self.leaves.is_empty() {
            return;
        }
        let mut next = [0; MAX_LEAVES + 1];
        for (next, leaf) in next.iter_mut().zip(&self.leaves) {
            *next = leaf.start as u32;
        }
        next[self.leaves.len()] = self.leaves.last().map_or(0, |leaf| leaf.end) as u32;
        self.old_slots.clear();
        self.old_slots.extend_from_slice(slots);
        self.renamed.clear();
        for (leaf, slot) in self.old_leaf.iter().zip(&self.old_slots) {
            let number = &mut next[*leaf as usize];
            slots[*number as usize] = *slot;
            self.renamed.push(BodyNumber(*number));
            *number += 1;
        }
        for pair in pairs {
            *pair = pair.map(|body| self.renamed(body));
        }
        self.leaf.fill(self.leaves.len() as u8);
        for (number, leaf) in (0..).zip(&self.leaves) {
            self.leaf[leaf.clone()].fill(number);
        }
    }

    /// The number that a body has got by sorting.
    pub(crate) fn renamed(&self, body: BodyNumber) -> BodyNumber {
        if self.leaves.is_empty() {
            return body;
        }
        self.renamed[body.index()]
    }

    /// Bodies of the leaves, after they have been sorted; none if all are together.
    pub fn leaves(&self) -> &[Range<usize>] {
        &self.leaves
    }

    /// Parts of `count` bodies that a team works on at a time: the leaves, of which the last has the rest with it.
    pub(crate) fn slices_of_bodies(&self, count: usize) -> impl Iterator<Item = Range<usize>> {
        let (last, others) = match self.leaves.split_last() {
            Some((last, others)) => (last.start..count, others),
            None => (0..count, &[][..]),
        };
        others.iter().cloned().chain(std::iter::once(last))
    }

    /// Number of the first body that contacts do not move, after the bodies have been sorted: all behind it are of that kind.
    pub fn first_fixed(&self) -> usize {
        self.leaves.last().map_or(0, |leaf| leaf.end)
    }

    /// The subdomain of a manifold of these bodies, of which contacts move one at least.
    pub fn of(&self, bodies: [BodyNumber; 2]) -> u32 {
        if self.leaves.is_empty() {
            return 0;
        }
        let count = self.leaves.len() as u32;
        let [a, b] = bodies.map(|body| u32::from(self.leaf[body.index()]));
        // What contacts do not move is in no leaf.
        let [a, b] = match [a == count, b == count] {
            [true, _] => [b, b],
            [_, true] => [a, a],
            _ => [a, b],
        };
        // The stage that brings both together; before it come `n + n / 2 + ...` subdomains.
        let stage = u32::BITS - (a ^ b).leading_zeros();
        2 * count - ((2 * count) >> stage) + (a >> stage)
    }

    /// Number of subdomains.
    pub fn count(&self) -> usize {
        (2 * self.leaves.len()).max(2) - 1
    }
}

/// Number of subdomains of each stage of an island with `subdomains` subdomains.
pub fn stages(subdomains: usize) -> impl Iterator<Item = usize> {
    let leaves = subdomains.div_ceil(2);
    (0..=leaves.ilog2()).map(move |stage| leaves >> stage)
}
