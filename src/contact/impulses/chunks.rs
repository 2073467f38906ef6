//! How the work on a table is split, so that several threads can do it.
//!
//! Manifolds, pairs and entries are in the same order, so a run of manifolds goes with a run of pairs and a run of entries.

use crate::contact::body_id::BodyId;
use crate::contact::impulses::table::{EntryTable, PairRecord};
use crate::contact::impulses::{CacheEntry, bodies_of};
use crate::contact::manifolds::ManifoldHead;
use crate::threads::parts::SizedParts;
use crate::tuning::MANIFOLDS_PER_PART;
use std::ops::Range;

/// Where the parts of a table begin and end. From pass to pass most stay where they are.
#[derive(Clone, Debug, Default)]
pub(crate) struct ChunkPlan {
    stretches: Vec<ChunkRange>,
}

#[derive(Clone, Debug, Default)]
struct ChunkRange {
    manifolds: Range<usize>,
    pairs: Range<usize>,
    entries: Range<usize>,
}

/// A part of a table.
#[derive(Debug)]
pub(crate) struct Chunk<'t> {
    pub(crate) pairs: &'t [PairRecord],
    pub(crate) entries: &'t mut [CacheEntry],
    /// Index of the first entry in the table.
    first: usize,
}

impl Chunk<'_> {
    /// Where the entries of a pair are within the part.
    pub(crate) fn range(&self, pair: &PairRecord) -> Range<usize> {
        let first = pair.first as usize - self.first;
        first..first + pair.count as usize
    }

    /// The same of all manifolds of two bodies.
    pub(crate) fn range_of_all(&self, bodies: (BodyId, BodyId)) -> Range<usize> {
        let first = self.pairs.partition_point(|pair| pair.bodies < bodies);
        let of_both = self.pairs[first..].partition_point(|pair| pair.bodies == bodies);
        match self.pairs[first..first + of_both] {
            [] => 0..0,
            [only] => self.range(&only),
            [first, .., last] => self.range(&first).start..self.range(&last).end,
        }
    }
}

impl ChunkPlan {
    /// Splits `manifolds` and, where their pairs belong, `table`; every pair is in one part, even if there are no manifolds.
    pub(crate) fn split(&mut self, table: &EntryTable, manifolds: &[ManifoldHead], ids: &[BodyId]) {
        let count = manifolds.len().div_ceil(MANIFOLDS_PER_PART).max(1);
        self.stretches.resize_with(count, ChunkRange::default);
        let (mut pair, mut entry, mut end) = (0, 0, 0);
        for (part, stretch) in self.stretches.iter_mut().enumerate() {
            let first = end;
            end = ((part + 1) * MANIFOLDS_PER_PART).max(first);
            // All manifolds of a pair belong to one part.
            while let Some([last, next]) = manifolds.get(end.max(1) - 1..end + 1)
                && (last.a, last.b) == (next.a, next.b)
            {
                end += 1;
            }
            let end_pair = manifolds.get(end).map_or(table.pairs.len(), |next| {
                table.first_from(pair, bodies_of(next, ids), stretch.pairs.end)
            });
            let next = table.pairs.get(end_pair);
            let end_entry = next.map_or(table.entries.len(), |pair| pair.first as usize);
            *stretch = ChunkRange {
                manifolds: first.min(manifolds.len())..end.min(manifolds.len()),
                pairs: pair..end_pair,
                entries: entry..end_entry,
            };
            (pair, entry) = (end_pair, end_entry);
        }
    }

    /// The parts' ranges of manifolds.
    pub(crate) fn manifolds(
        &self,
    ) -> impl ExactSizeIterator<Item = Range<usize>> + DoubleEndedIterator + Clone + Send {
        self.stretches.iter().map(|part| part.manifolds.clone())
    }

    /// The parts of the table.
    pub(crate) fn shares<'t>(
        &'t self,
        table: &'t mut EntryTable,
    ) -> impl ExactSizeIterator<Item = Chunk<'t>> + DoubleEndedIterator + Send {
        let EntryTable { pairs, entries } = table;
        let sizes = self.stretches.iter().map(|part| part.entries.len());
        let pieces = SizedParts::new(entries, sizes);
        let pairs: &[PairRecord] = pairs;
        self.stretches
            .iter()
            .zip(pieces)
            .map(move |(part, entries)| Chunk {
                pairs: &pairs[part.pairs.clone()],
                entries,
                first: part.entries.start,
            })
    }

    /// One item for each part; the list keeps those that are not needed now for their buffers.
    pub(crate) fn one_each<'l, T: Default>(&self, list: &'l mut Vec<T>) -> &'l mut [T] {
        let count = self.stretches.len();
        list.resize_with(list.len().max(count), T::default);
        &mut list[..count]
    }
}
