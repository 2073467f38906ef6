//! Entries by pair of bodies, sorted.

use crate::contact::body_id::BodyId;
use crate::contact::impulses::CacheEntry;
use crate::merge::merge;

/// A run of entries that belong to one pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct PairRecord {
    pub(super) bodies: (BodyId, BodyId),
    pub(super) first: u32,
    pub(super) count: u32,
}

impl PairRecord {
    #[inline]
    pub(super) fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// Pairs sorted by bodies, and their entries one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct EntryTable {
    pub(super) pairs: Vec<PairRecord>,
    pub(super) entries: Vec<CacheEntry>,
}

impl EntryTable {
    pub(super) fn clear(&mut self) {
        self.pairs.clear();
        self.entries.clear();
    }

    /// Entries of a pair.
    #[inline]
    pub(super) fn of(&self, bodies: (BodyId, BodyId)) -> &[CacheEntry] {
        let found = self.pairs.binary_search_by_key(&bodies, |pair| pair.bodies);
        &self.entries[found.map_or(0..0, |i| self.pairs[i].range())]
    }

    /// Index of the first pair, from `start` on, that is not before `bodies`. Looks at `guess` first.
    #[inline]
    pub(super) fn first_from(&self, start: usize, bodies: (BodyId, BodyId), guess: usize) -> usize {
        let is_before = |pair: &PairRecord| pair.bodies < bodies;
        if guess > start
            && let Some([before, from]) = self.pairs.get(guess - 1..=guess)
            && is_before(before)
            && !is_before(from)
        {
            return guess;
        }
        start + self.pairs[start..].partition_point(is_before)
    }

    /// Appends a pair of another table with its impulses scaled.
    pub(super) fn copy_pair(&mut self, other: &EntryTable, pair: &PairRecord, scale: f32) {
        let first = self.entries.len();
        let entries = other.entries[pair.range()].iter();
        self.entries.extend(entries.map(|entry| CacheEntry {
            normal_impulse: scale * entry.normal_impulse,
            friction_impulse: scale * entry.friction_impulse,
            ..*entry
        }));
        self.close_pair(pair.bodies, first);
    }

    /// Ends a pair whose entries have been pushed since `first`; a pair without entries is not recorded.
    pub(super) fn close_pair(&mut self, bodies: (BodyId, BodyId), first: usize) {
        let count = (self.entries.len() - first) as u32;
        if count > 0 {
            self.pairs.push(PairRecord {
                bodies,
                first: first as u32,
                count,
            });
        }
    }
}

/// Moves the pairs of the bodies in `ids` (ascending) and scales their impulses. `spare` is for the use of this function.
pub(super) fn move_pairs(
    from: &mut EntryTable,
    to: &mut EntryTable,
    spare: &mut EntryTable,
    ids: &[BodyId],
    scale: f32,
) {
    let moves = |pair: &PairRecord| {
        let (a, b) = pair.bodies;
        ids.binary_search(&a).is_ok() || ids.binary_search(&b).is_ok()
    };
    spare.clear();
    let moved = from.pairs.iter().filter(|pair| moves(pair));
    for pair in merge(moved, &to.pairs, |moved, other| {
        moved.bodies.cmp(&other.bodies)
    }) {
        let (moved, other) = pair.into_options();
        moved
            .into_iter()
            .for_each(|pair| spare.copy_pair(from, pair, scale));
        other
            .into_iter()
            .for_each(|pair| spare.copy_pair(to, pair, 1.0));
    }
    std::mem::swap(to, spare);
    spare.clear();
    for pair in from.pairs.iter().filter(|pair| !moves(pair)) {
        spare.copy_pair(from, pair, 1.0);
    }
    std::mem::swap(from, spare);
}
