//! Takes the impulses that the solver found into a table, part by part.
//!
//! From step to step most pairs keep their points. They are renewed where they are; those that get or lose an entry are
//! noted, and if there are any, the parts are written anew, with these in their places.

use crate::contact::body_id::BodyId;
use crate::contact::impulses::chunks::Chunk;
use crate::contact::impulses::table::{EntryTable, PairRecord};
use crate::contact::impulses::{CacheEntry, MAX_AGE, bodies_of, continues_as, is_exact};
use crate::contact::manifolds::{ManifoldRef, Manifolds};
use crate::contact::point::ContactPoint;
use crate::merge::{Merged, merge};
use crate::threads::parts::{SizedParts, front_mut};
use glam::Quat;
use std::ops::Range;

/// A run of the manifolds after the solve.
#[derive(Clone, Debug)]
pub(crate) struct Solved<'s> {
    pub(crate) manifolds: &'s Manifolds,
    pub(crate) range: Range<usize>,
    pub(crate) ids: &'s [BodyId],
    pub(crate) rotations: &'s [Quat],
}

impl<'s> Solved<'s> {
    /// Those of a part.
    pub(crate) fn part(&self, range: Range<usize>) -> Self {
        Self { range, ..*self }
    }

    /// By index within the run: the bodies of each manifold.
    fn names(&self) -> impl Iterator<Item = (usize, (BodyId, BodyId))> {
        let heads = self.manifolds.heads()[self.range.clone()].iter();
        heads.map(|head| bodies_of(head, self.ids)).enumerate()
    }

    /// The manifold with this index within the run.
    fn manifold(&self, index: usize) -> ManifoldRef<'s> {
        self.manifolds.at(self.range.start + index)
    }
}

/// The points of a manifold, if there is one.
fn points_of(manifold: Option<ManifoldRef<'_>>) -> &[ContactPoint] {
    manifold.map_or(&[], ManifoldRef::points)
}

/// The entries of the points of a manifold, if there is one.
fn fresh<'s>(
    manifold: Option<ManifoldRef<'s>>,
    rotations: &[Quat],
) -> impl Iterator<Item = CacheEntry> + use<'s> {
    let to_a = manifold.map_or(Quat::IDENTITY, |m| rotations[m.a as usize].inverse());
    let points = points_of(manifold).iter();
    points.map(move |point| CacheEntry::of(point, to_a))
}

/// A pair that gets or loses an entry.
#[derive(Clone, Copy, Debug)]
struct Change {
    /// Index of the pair within the part; for a new pair, of the one that it comes before.
    pair: usize,
    is_new: bool,
    /// Index of its manifold within the part.
    manifold: Option<usize>,
}

/// What becomes of a part.
#[derive(Clone, Debug, Default)]
pub(crate) struct ChunkUpdate {
    changes: Vec<Change>,
    /// Number of pairs and entries after the changes.
    pairs: usize,
    entries: usize,
    /// Index of its first entry in the table after the changes.
    first: usize,
}

impl ChunkUpdate {
    /// Renews the pairs that keep their entries, and notes the others.
    pub(crate) fn update(&mut self, share: Chunk, solved: &Solved) {
        self.changes.clear();
        (self.pairs, self.entries) = (share.pairs.len(), share.entries.len());
        let mut index = 0;
        for found in merge(share.pairs, solved.names(), |pair, (_, name)| {
            pair.bodies.cmp(name)
        }) {
            let (pair, manifold) = match found {
                Merged::Left(pair) => (pair, None),
                Merged::Both(pair, (manifold, _)) => (pair, Some(manifold)),
                Merged::Right((new, _)) => {
                    self.note_new(index, new, solved);
                    continue;
                }
            };
            let same = manifold.map(|manifold| solved.manifold(manifold));
            let range = share.range(pair);
            let entries = &mut share.entries[range];
            if !renew_in_place(entries, same, solved.rotations) {
                self.note_changed(index, entries, manifold.zip(same));
            }
            index += 1;
        }
    }

    fn note_new(&mut self, pair: usize, manifold: usize, solved: &Solved) {
        let count = solved.manifold(manifold).points().len();
        // A pair without entries is not recorded.
        if count > 0 {
            self.pairs += 1;
            self.entries += count;
            self.changes.push(Change {
                pair,
                is_new: true,
                manifold: Some(manifold),
            });
        }
    }

    fn note_changed(
        &mut self,
        pair: usize,
        old: &[CacheEntry],
        manifold: Option<(usize, ManifoldRef<'_>)>,
    ) {
        let points = points_of(manifold.map(|(_, manifold)| manifold));
        let count = points.len() + old.iter().filter(|entry| survives(entry, points)).count();
        self.entries = self.entries - old.len() + count;
        self.pairs -= usize::from(count == 0);
        self.changes.push(Change {
            pair,
            is_new: false,
            manifold: manifold.map(|(index, _)| index),
        });
    }

    /// Whether the part has been renewed where it is.
    pub(crate) fn is_in_place(&self) -> bool {
        self.changes.is_empty()
    }

    /// Makes room in `table` for what the parts will be, and a writer for each.
    pub(crate) fn writers<'t>(
        parts: &'t mut [Self],
        table: &'t mut EntryTable,
    ) -> impl ExactSizeIterator<Item = (&'t Self, EntryWriter<'t>)> + DoubleEndedIterator + Send
    {
        let (mut pairs, mut entries) = (0, 0);
        for part in parts.iter_mut() {
            part.first = entries;
            pairs += part.pairs;
            entries += part.entries;
        }
        table.pairs.resize(pairs, PairRecord::default());
        table.entries.resize(entries, CacheEntry::default());
        let parts: &[Self] = parts;
        let pairs = SizedParts::new(&mut table.pairs, parts.iter().map(|part| part.pairs));
        let entries = SizedParts::new(&mut table.entries, parts.iter().map(|part| part.entries));
        let pieces = parts.iter().zip(pairs.zip(entries));
        pieces.map(|(part, (pairs, entries))| {
            let writer = EntryWriter {
                pairs: pairs.iter_mut(),
                entries,
                next: part.first,
            };
            (part, writer)
        })
    }

    /// Writes the part: the pairs that were renewed, and between them those that change.
    pub(crate) fn write(&self, share: &Chunk, solved: &Solved, mut writer: EntryWriter) {
        let mut done = 0;
        for change in &self.changes {
            writer.copy(share, done..change.pair);
            let pair = share.pairs.get(change.pair).filter(|_| !change.is_new);
            let old = pair.map_or(0..0, |pair| share.range(pair));
            let new = change.manifold.map(|index| solved.manifold(index));
            let name = new.map(|new| bodies_of(new.head(), solved.ids));
            if let Some(bodies) = pair.map(|pair| pair.bodies).or(name) {
                writer.push(bodies, new, &share.entries[old], solved.rotations);
            }
            done = change.pair + usize::from(!change.is_new);
        }
        writer.copy(share, done..share.pairs.len());
    }
}

/// Renews a pair where it is, unless it gets or loses an entry; whether it did.
fn renew_in_place(
    entries: &mut [CacheEntry],
    same: Option<ManifoldRef<'_>>,
    rotations: &[Quat],
) -> bool {
    let points = points_of(same);
    let (now, old) = entries.split_at_mut(points.len().min(entries.len()));
    if !continues_as(points, now) || !old.iter().all(|entry| survives(entry, points)) {
        return false;
    }
    old.iter_mut().for_each(|entry| entry.age += 1);
    for (entry, new) in now.iter_mut().zip(fresh(same, rotations)) {
        *entry = new;
    }
    true
}

/// Whether an entry lives on beside the points of its pair: it is not too old, and no point took its place.
fn survives(entry: &CacheEntry, points: &[ContactPoint]) -> bool {
    let is_replaced = entry.taken || points.iter().any(|point| is_exact(point, entry));
    entry.age < MAX_AGE && !is_replaced
}

/// Writes a part of a table.
#[derive(Debug)]
pub(crate) struct EntryWriter<'t> {
    /// Room that is left.
    pairs: std::slice::IterMut<'t, PairRecord>,
    entries: &'t mut [CacheEntry],
    /// Index in the table of the next entry.
    next: usize,
}

impl EntryWriter<'_> {
    /// Copies a run of pairs.
    fn copy(&mut self, share: &Chunk, pairs: Range<usize>) {
        let pairs = &share.pairs[pairs];
        let (Some(first), Some(last)) = (pairs.first(), pairs.last()) else {
            return;
        };
        let shift = (self.next as u32).wrapping_sub(first.first);
        for (pair, to) in pairs.iter().zip(&mut self.pairs) {
            *to = PairRecord {
                first: pair.first.wrapping_add(shift),
                ..*pair
            };
        }
        let run = &share.entries[share.range(first).start..share.range(last).end];
        self.take_room(run.len()).copy_from_slice(run);
    }

    /// Adds a pair, unless it has no entries: those of its points, then the old ones that live on.
    fn push(
        &mut self,
        bodies: (BodyId, BodyId),
        manifold: Option<ManifoldRef<'_>>,
        old: &[CacheEntry],
        rotations: &[Quat],
    ) {
        let first = self.next;
        let points = points_of(manifold);
        let room = self.take_room(points.len());
        for (to, new) in room.iter_mut().zip(fresh(manifold, rotations)) {
            *to = new;
        }
        for entry in old.iter().filter(|entry| survives(entry, points)) {
            for to in self.take_room(1) {
                *to = CacheEntry {
                    age: entry.age + 1,
                    taken: false,
                    ..*entry
                };
            }
        }
        if self.next > first
            && let Some(to) = self.pairs.next()
        {
            *to = PairRecord {
                bodies,
                first: first as u32,
                count: (self.next - first) as u32,
            };
        }
    }

    /// Takes the room of the next `count` entries.
    fn take_room(&mut self, count: usize) -> &mut [CacheEntry] {
        self.next += count;
        front_mut(&mut self.entries, count)
    }
}
