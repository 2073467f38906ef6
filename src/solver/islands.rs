//! Groups of bodies that touch each other: what can be solved on its own.
//!
//! Bodies that contacts do not move join nothing: two piles on one floor are two islands. Each island's bodies are
//! numbered from 0, so that its rows and bodies lie side by side in memory and no two islands share anything that is
//! written. A fixed body has a number of its own in every island that touches it.

use super::bodies::Bodies;
use crate::contact::manifold::Manifold;
use std::ops::Range;

/// Marks a body that has no number yet.
const NONE: u32 = u32::MAX;

/// One group.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Island {
    /// Its part of [`Islands::manifolds`].
    pub manifolds: Range<usize>,
    /// Its part of [`Islands::slots`].
    pub bodies: Range<usize>,
    /// Its part of the list of contact points, in the order of its manifolds.
    pub points: Range<usize>,
}

/// The islands of a step; buffers are reused.
#[derive(Debug, Default)]
pub struct Islands {
    /// The islands, in the order of their first manifolds.
    pub list: Vec<Island>,
    /// Indices of manifolds, island by island; ascending within an island.
    pub manifolds: Vec<u32>,
    /// The two bodies of each of `manifolds`, as numbers within the island.
    pub pairs: Vec<[u32; 2]>,
    /// Slots of bodies, island by island, in the order in which the manifolds name them.
    pub slots: Vec<u32>,
    /// Union-find over slots.
    parent: Vec<u32>,
    /// By slot of a root: index of its island.
    island_of: Vec<u32>,
    /// By slot: number within the island being filled.
    number: Vec<u32>,
}

impl Islands {
    /// Finds the islands of those of `manifolds`, which hold slots of `bodies`, that `is_open` tells. Manifolds of two fixed
    /// bodies are left out.
    pub fn find(
        &mut self,
        manifolds: &[Manifold],
        bodies: &Bodies,
        is_open: impl Fn(&Manifold) -> bool,
    ) {
        let moves = |slot: u32| bodies.velocity[slot as usize].inverse_mass > 0.0;
        self.parent.clear();
        self.parent.extend(0..bodies.slots() as u32);
        for m in manifolds {
            if moves(m.a) && moves(m.b) && is_open(m) {
                join(&mut self.parent, m.a, m.b);
            }
        }
        let root = |parent: &mut Vec<u32>, m: &Manifold| match (moves(m.a), moves(m.b)) {
            _ if !is_open(m) => None,
            (true, _) => Some(find(parent, m.a)),
            (_, true) => Some(find(parent, m.b)),
            _ => None,
        };
        self.count(manifolds, root);
        self.sort(manifolds, root);
        self.number_bodies(manifolds, bodies.slots());
    }

    /// Makes the islands and counts their manifolds and points.
    fn count(
        &mut self,
        manifolds: &[Manifold],
        root: impl Fn(&mut Vec<u32>, &Manifold) -> Option<u32>,
    ) {
        self.list.clear();
        self.island_of.clear();
        self.island_of.resize(self.parent.len(), NONE);
        for manifold in manifolds {
            let Some(root) = root(&mut self.parent, manifold) else {
                continue;
            };
            let island = &mut self.island_of[root as usize];
            if *island == NONE {
                *island = self.list.len() as u32;
                self.list.push(Island::default());
            }
            let island = &mut self.list[*island as usize];
            island.manifolds.end += 1;
            island.points.end += manifold.count as usize;
        }
        let (mut manifolds, mut points) = (0, 0);
        for island in &mut self.list {
            // Ends grow again as the manifolds are put in their places.
            let count = island.manifolds.end;
            island.manifolds = manifolds..manifolds;
            manifolds += count;
            island.points = points..points + island.points.end;
            points = island.points.end;
        }
    }

    /// Sorts the manifolds by island.
    fn sort(
        &mut self,
        manifolds: &[Manifold],
        root: impl Fn(&mut Vec<u32>, &Manifold) -> Option<u32>,
    ) {
        self.manifolds.clear();
        self.manifolds.resize(manifolds.len(), 0);
        let mut used = 0;
        for (index, manifold) in manifolds.iter().enumerate() {
            if let Some(root) = root(&mut self.parent, manifold) {
                let island = &mut self.list[self.island_of[root as usize] as usize];
                self.manifolds[island.manifolds.end] = index as u32;
                island.manifolds.end += 1;
                used += 1;
            }
        }
        self.manifolds.truncate(used);
    }

    /// Numbers the bodies of each island.
    fn number_bodies(&mut self, manifolds: &[Manifold], slots: usize) {
        self.slots.clear();
        self.pairs.clear();
        self.number.clear();
        self.number.resize(slots, NONE);
        for island in &mut self.list {
            let first = self.slots.len();
            for &index in &self.manifolds[island.manifolds.clone()] {
                let manifold = &manifolds[index as usize];
                let pair = [manifold.a, manifold.b].map(|slot| {
                    let number = &mut self.number[slot as usize];
                    if *number == NONE {
                        *number = (self.slots.len() - first) as u32;
                        self.slots.push(slot);
                    }
                    *number
                });
                self.pairs.push(pair);
            }
            island.bodies = first..self.slots.len();
            for &slot in &self.slots[island.bodies.clone()] {
                self.number[slot as usize] = NONE;
            }
        }
    }
}

/// Representative of a slot's group, the least slot in it; halves the path to it.
fn find(parent: &mut [u32], mut slot: u32) -> u32 {
    while parent[slot as usize] != slot {
        let above = parent[parent[slot as usize] as usize];
        parent[slot as usize] = above;
        slot = above;
    }
    slot
}

fn join(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (find(parent, a), find(parent, b));
    parent[a.max(b) as usize] = a.min(b);
}
