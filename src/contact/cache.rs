//! `ContactCache`: last step's multipliers, found again by (body A, code A, body B, code B).
//!
//! A contact that persists starts the solve from the impulse it ended with. The key of an entry is the pair of bodies
//! and, in each body's own box, the [`KdCode`] of the contact point. A hit resets an entry's age, every step adds one,
//! and an entry that was not hit for more than [`MAX_AGE`] steps is evicted.
//!
//! Entries are stored per pair in one sorted list, and the step's manifolds are sorted the same way, so that one merge
//! of the two lists finds all pairs: no hash, one look-up per pair. Where the plain scheme loses a multiplier or applies
//! a wrong one, this one differs:
//! - a point that slid over a cell border is matched to the nearest decoded cell within [`NEAR_SHARE`] of the smaller
//!   body, one to one. It is enough that the point kept its place on one of the two bodies: a corner that slides over
//!   a floor stays itself, however far it moves on the floor;
//! - a multiplier is applied only if its entry was hit in the step before; an older one would be a kick, because the
//!   bodies have been apart since. It is found (and renewed) all the same;
//! - impulses are scaled by the ratio of step lengths, since a resting contact's impulse is force times step;
//! - the friction impulse is kept as a vector in A's frame and projected anew on the tangent plane.
//!
//! Share of points found, 60 Hz, unit cube (or 16-sided prism of radius 0.5 m) on a floor of 10 m with cells of
//! 5 x 10 mm, as `tests/contact_cache.rs` plays it:
//!
//! | motion | own codes only | with nearest cell |
//! |---|---|---|
//! | rest, 10 um of jitter | 0.998 | 1 |
//! | slide at 0.05 m/s | 0.82 | 1 |
//! | slide at 0.5 or 2 m/s | 0 | 1 |
//! | spin at 5 rad/s | 0 | 1 |
//! | roll at 0.2 m/s | 0.986 | 0.989 |
//! | roll at 1 m/s | 0.931 | 0.944 |
//!
//! No found point had moved by more than 5 mm on both bodies. What a rolling body misses are edges new to the contact.
//!
//! # References
//! "Constraint-Based Physics With Real-Time Object Slicing": the key, the ages and the limit of ten steps.

mod inherit;

pub use inherit::{Family, Heir};

use super::{BodyId, Manifold};
use crate::contact::manifold::{ContactPoint, MAX_POINTS};
use crate::geometry::{KdBox, KdCode};
use crate::math::rotate;
use bevy_ecs::resource::Resource;
use glam::{Quat, Vec3};
use std::cmp::Ordering;
use std::iter::Peekable;

/// An entry is evicted when it was not hit for more than this many steps.
pub const MAX_AGE: u32 = 10;

/// How far a point may move in a step and still count as the same, as a share of the smaller body's longest edge.
///
/// A rolling or spinning body that moves farther has other contacts; corners of one body are farther apart.
pub const NEAR_SHARE: f32 = 0.02;

/// What the cache knows of one contact point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CacheEntry {
    /// Cell of the point in A's box.
    pub code_a: KdCode,
    /// Cell of the point in B's box.
    pub code_b: KdCode,
    /// Normal impulse, N s.
    pub normal_impulse: f32,
    /// Friction impulse on B, in A's body frame, N s.
    pub friction_impulse: Vec3,
    /// Steps since the entry was last hit.
    pub age: u32,
    /// Whether a point of the current step took this entry.
    taken: bool,
}

impl CacheEntry {
    /// The entry of a point after a solve; `to_a` turns world axes into A's frame.
    fn of(point: &ContactPoint, to_a: Quat) -> Self {
        Self {
            code_a: point.code_a,
            code_b: point.code_b,
            normal_impulse: point.normal_impulse,
            friction_impulse: rotate(to_a, point.friction_impulse),
            age: 0,
            taken: false,
        }
    }

    /// Whether the impulses are numbers; others are stored, but never applied.
    fn is_finite(&self) -> bool {
        self.normal_impulse.is_finite() && self.friction_impulse.is_finite()
    }
}

/// A run of entries that belong to one pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct PairRecord {
    bodies: (BodyId, BodyId),
    first: u32,
    count: u32,
}

impl PairRecord {
    fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// Pairs sorted by bodies, and their entries one after the other.
#[derive(Clone, Debug, Default)]
struct Table {
    pairs: Vec<PairRecord>,
    entries: Vec<CacheEntry>,
}

impl Table {
    fn clear(&mut self) {
        self.pairs.clear();
        self.entries.clear();
    }

    /// Entries of a pair.
    fn of(&self, bodies: (BodyId, BodyId)) -> &[CacheEntry] {
        let found = self.pairs.binary_search_by_key(&bodies, |pair| pair.bodies);
        &self.entries[found.map_or(0..0, |i| self.pairs[i].range())]
    }

    /// Appends a pair of another table with its impulses scaled.
    fn copy_pair(&mut self, other: &Table, pair: &PairRecord, scale: f32) {
        let first = self.entries.len();
        let entries = other.entries[pair.range()].iter();
        self.entries.extend(entries.map(|entry| CacheEntry {
            normal_impulse: scale * entry.normal_impulse,
            friction_impulse: scale * entry.friction_impulse,
            ..*entry
        }));
        self.close_pair(pair.bodies, first);
    }

    /// Renews pairs where they are, from the first one on as long as none gets or loses an entry, and takes their
    /// manifolds. Returns their number.
    fn renew_front(
        &mut self,
        manifolds: &mut Peekable<std::slice::Iter<Manifold>>,
        ids: &[BodyId],
        rotations: &[Quat],
    ) -> usize {
        for (index, pair) in self.pairs.iter().enumerate() {
            let entries = &mut self.entries[pair.range()];
            let next = manifolds.peek().map(|m| bodies_of(m, ids));
            if next.is_some_and(|bodies| bodies < pair.bodies) {
                return index;
            }
            let is_same = |_: &&Manifold| next == Some(pair.bodies);
            let same = manifolds.peek().copied().filter(is_same);
            let points = same.map_or(&[][..], Manifold::points);
            let (fresh, old) = entries.split_at_mut(points.len().min(entries.len()));
            let stays = |e: &CacheEntry| e.age < MAX_AGE && !is_replaced(e, points);
            if !continues_as(points, fresh) || !old.iter().all(stays) {
                return index;
            }
            old.iter_mut().for_each(|entry| entry.age += 1);
            if let Some(manifold) = same {
                let to_a = rotations[manifold.a as usize].inverse();
                for (entry, point) in fresh.iter_mut().zip(points) {
                    *entry = CacheEntry::of(point, to_a);
                }
                manifolds.next();
            }
        }
        self.pairs.len()
    }

    /// Appends the first pairs of another table.
    fn copy_front(&mut self, other: &Self, count: usize) {
        let end = count
            .checked_sub(1)
            .map_or(0, |last| other.pairs[last].range().end);
        self.pairs.extend_from_slice(&other.pairs[..count]);
        self.entries.extend_from_slice(&other.entries[..end]);
    }

    /// Ends a pair whose entries have been pushed since `first`; a pair without entries is not recorded.
    fn close_pair(&mut self, bodies: (BodyId, BodyId), first: usize) {
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

/// `to / from`, or zero if `from` is.
fn ratio(to: f32, from: f32) -> f32 {
    if from > 0.0 { to / from } else { 0.0 }
}

/// Moves the pairs of the bodies in `ids` (ascending) and scales their impulses. `spare` is for the use of this function.
fn move_pairs(from: &mut Table, to: &mut Table, spare: &mut Table, ids: &[BodyId], scale: f32) {
    let moves = |pair: &PairRecord| {
        let (a, b) = pair.bodies;
        ids.binary_search(&a).is_ok() || ids.binary_search(&b).is_ok()
    };
    spare.clear();
    let mut rest = to.pairs.iter().peekable();
    for pair in from.pairs.iter().filter(|pair| moves(pair)) {
        while let Some(other) = rest.next_if(|other| other.bodies < pair.bodies) {
            spare.copy_pair(to, other, 1.0);
        }
        spare.copy_pair(from, pair, scale);
    }
    rest.for_each(|other| spare.copy_pair(to, other, 1.0));
    std::mem::swap(to, spare);
    spare.clear();
    for pair in from.pairs.iter().filter(|pair| !moves(pair)) {
        spare.copy_pair(from, pair, 1.0);
    }
    std::mem::swap(from, spare);
}

/// How the points of a step were matched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct CacheStats {
    /// Contact points asked for.
    pub points: u32,
    /// Points that found an entry of the step before under their own codes.
    pub exact_hits: u32,
    /// Points that took an entry of the step before from a nearby cell.
    pub near_hits: u32,
    /// Points that found only an older entry under their own codes, whose multiplier is not applied.
    pub stale_hits: u32,
    /// Points that found nothing.
    pub misses: u32,
}

impl CacheStats {
    /// Share of points that were warm started, 0 to 1; 1 if there were no points.
    pub fn hit_rate(&self) -> f32 {
        if self.points == 0 {
            return 1.0;
        }
        (self.exact_hits + self.near_hits) as f32 / self.points as f32
    }

    /// Adds another step's counts.
    pub fn add(&mut self, other: &Self) {
        self.points += other.points;
        self.exact_hits += other.exact_hits;
        self.near_hits += other.near_hits;
        self.stale_hits += other.stale_hits;
        self.misses += other.misses;
    }
}

/// Contact multipliers from step to step; see the [module](self).
#[derive(Clone, Debug, Default, Resource)]
pub struct ContactCache {
    current: Table,
    /// The table being written, and between steps a spare allocation.
    next: Table,
    /// Length of the step whose impulses are stored, s; 0 while there are none.
    h: f32,
    /// Pairs that neither age nor are matched, and the length of the step that their impulses belong to, s.
    parked: Table,
    parked_h: f32,
    /// Whether an entry is marked as taken.
    any_taken: bool,
}

impl ContactCache {
    /// An empty cache.
    pub fn new() -> Self {
        Self::default()
    }

    /// Number of entries.
    pub fn len(&self) -> usize {
        self.current.entries.len() + self.parked.entries.len()
    }

    /// Whether there are no entries.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.current.clear();
        self.next.clear();
        self.parked.clear();
        self.h = 0.0;
    }

    /// Entries of a pair, `a < b`: those hit last first.
    pub fn entries_of(&self, a: BodyId, b: BodyId) -> impl Iterator<Item = &CacheEntry> {
        let tables = [&self.current, &self.parked];
        tables.into_iter().flat_map(move |table| table.of((a, b)))
    }

    /// Pairs that have entries and are not parked, sorted.
    pub fn pairs(&self) -> impl Iterator<Item = (BodyId, BodyId)> {
        self.current.pairs.iter().map(|pair| pair.bodies)
    }

    /// Forgets all contacts of the bodies for which `is_gone` says so, in one pass.
    pub fn remove_bodies(&mut self, is_gone: impl Fn(BodyId) -> bool) {
        let lives = |pair: &PairRecord| !is_gone(pair.bodies.0) && !is_gone(pair.bodies.1);
        for table in [&mut self.current, &mut self.parked] {
            self.next.clear();
            for pair in table.pairs.iter().filter(|pair| lives(pair)) {
                self.next.copy_pair(table, pair, 1.0);
            }
            std::mem::swap(table, &mut self.next);
        }
    }

    /// Sets aside all pairs of the bodies in `ids` (ascending): they neither age nor are matched until they are
    /// [fetched](Self::unpark).
    pub fn park(&mut self, ids: &[BodyId]) {
        if self.parked.pairs.is_empty() {
            self.parked_h = self.h;
        }
        let scale = ratio(self.parked_h, self.h);
        let Self {
            current,
            next,
            parked,
            ..
        } = self;
        move_pairs(current, parked, next, ids, scale);
    }

    /// Takes back the pairs of the bodies in `ids` (ascending) as if they had been stored by the last step.
    pub fn unpark(&mut self, ids: &[BodyId]) {
        if self.current.pairs.is_empty() {
            self.h = self.parked_h;
        }
        let scale = ratio(self.h, self.parked_h);
        let Self {
            current,
            next,
            parked,
            ..
        } = self;
        move_pairs(parked, current, next, ids, scale);
    }

    /// Fills the impulses of all contact points: last step's where the contact persists, zero elsewhere.
    ///
    /// `manifolds` are sorted by the ids of `(a, b)`, with `id(a) < id(b)`; `ids`, `rotations` (world from body) and
    /// `boxes` are indexed by slot; `h` is the length of the coming step, s. A body without a box (a half-space) has
    /// code 0 and is matched on the other body's side alone.
    pub fn warm_start(
        &mut self,
        manifolds: &mut [Manifold],
        ids: &[BodyId],
        rotations: &[Quat],
        boxes: &[Option<KdBox>],
        h: f32,
    ) -> CacheStats {
        debug_assert!(is_sorted(manifolds, ids));
        let mut stats = CacheStats::default();
        // No step before (or one of no length): entries are matched, multipliers start at zero.
        let scale = ratio(h, self.h);
        let Table { pairs, entries } = &mut self.current;
        if std::mem::take(&mut self.any_taken) {
            entries.iter_mut().for_each(|entry| entry.taken = false);
        }
        let mut pairs = pairs.iter().peekable();
        for manifold in manifolds {
            let bodies = bodies_of(manifold, ids);
            while pairs.next_if(|pair| pair.bodies < bodies).is_some() {}
            let range = pairs
                .peek()
                .filter(|pair| pair.bodies == bodies)
                .map_or(0..0, |pair| pair.range());
            let rotation = rotations[manifold.a as usize];
            let entries = &mut entries[range];
            let normal = manifold.normal;
            if continues(manifold.points(), entries) {
                stats.points += manifold.count;
                stats.exact_hits += manifold.count;
                for (point, entry) in manifold.points_mut().iter_mut().zip(entries) {
                    let entry = Some(&*entry).filter(|entry| entry.is_finite());
                    apply(point, entry, normal, rotation, scale);
                }
                continue;
            }
            let measure = Nearness::of(
                boxes[manifold.a as usize].as_ref(),
                boxes[manifold.b as usize].as_ref(),
            );
            self.any_taken = true;
            let matches = match_points(manifold.points(), entries, &measure, &mut stats);
            for (point, found) in manifold.points_mut().iter_mut().zip(matches) {
                let entry = found
                    .map(|index| entries[index])
                    .filter(|entry| entry.age == 0 && entry.is_finite());
                apply(point, entry.as_ref(), normal, rotation, scale);
            }
        }
        stats
    }

    /// Stores the impulses that the solver found, and ages what was not hit.
    ///
    /// Takes the same arguments as [`Self::warm_start`], after the solve. Every point of `manifolds` becomes an entry of
    /// age 0, in place of the entry it was matched to; all other entries grow one step older.
    pub fn store_and_age(
        &mut self,
        manifolds: &[Manifold],
        ids: &[BodyId],
        rotations: &[Quat],
        h: f32,
    ) {
        debug_assert!(is_sorted(manifolds, ids));
        self.h = h;
        self.any_taken = false;
        let Self { current, next, .. } = self;
        let mut manifolds = manifolds.iter().peekable();
        let renewed = current.renew_front(&mut manifolds, ids, rotations);
        if renewed == current.pairs.len() && manifolds.peek().is_none() {
            return;
        }
        next.clear();
        next.copy_front(current, renewed);
        for pair in &current.pairs[renewed..] {
            while let Some(new) = manifolds.next_if(|m| bodies_of(m, ids) < pair.bodies) {
                store_pair(next, Some(new), &[], bodies_of(new, ids), rotations);
            }
            let same = manifolds.next_if(|m| bodies_of(m, ids) == pair.bodies);
            let old = &current.entries[pair.range()];
            store_pair(next, same, old, pair.bodies, rotations);
        }
        for new in manifolds {
            store_pair(next, Some(new), &[], bodies_of(new, ids), rotations);
        }
        std::mem::swap(current, next);
    }
}

/// Names of a manifold's bodies.
fn bodies_of(manifold: &Manifold, ids: &[BodyId]) -> (BodyId, BodyId) {
    (ids[manifold.a as usize], ids[manifold.b as usize])
}

/// Whether manifolds come in the order that the merge relies on.
fn is_sorted(manifolds: &[Manifold], ids: &[BodyId]) -> bool {
    manifolds.is_sorted_by(|l, r| bodies_of(l, ids) < bodies_of(r, ids))
}

/// Sets a point's impulses to an entry's, or to zero.
fn apply(
    point: &mut ContactPoint,
    entry: Option<&CacheEntry>,
    normal: Vec3,
    rotation_a: Quat,
    scale: f32,
) {
    let Some(entry) = entry else {
        point.normal_impulse = 0.0;
        point.friction_impulse = Vec3::ZERO;
        return;
    };
    let friction = rotate(rotation_a, entry.friction_impulse);
    point.normal_impulse = scale * entry.normal_impulse;
    point.friction_impulse = scale * (friction - normal * normal.dot(friction));
}

/// Writes one pair: the points of its manifold, then the old entries that live on.
fn store_pair(
    next: &mut Table,
    manifold: Option<&Manifold>,
    old: &[CacheEntry],
    bodies: (BodyId, BodyId),
    rotations: &[Quat],
) {
    let first = next.entries.len();
    let points = manifold.map_or(&[][..], Manifold::points);
    if let Some(manifold) = manifold {
        let to_a = rotations[manifold.a as usize].inverse();
        let new = points.iter().map(|point| CacheEntry::of(point, to_a));
        next.entries.extend(new);
    }
    next.entries.extend(
        old.iter()
            .filter(|entry| entry.age < MAX_AGE && !is_replaced(entry, points))
            .map(|entry| CacheEntry {
                age: entry.age + 1,
                taken: false,
                ..*entry
            }),
    );
    next.close_pair(bodies, first);
}

/// Whether a point took the entry's place.
fn is_replaced(entry: &CacheEntry, points: &[ContactPoint]) -> bool {
    entry.taken || points.iter().any(|point| is_exact(point, entry))
}

/// Whether the points are those of the entries, in the same order.
fn continues_as(points: &[ContactPoint], entries: &[CacheEntry]) -> bool {
    points.len() == entries.len() && points.iter().zip(entries).all(|(p, e)| is_exact(p, e))
}

/// Whether the points are those of the step before, in the same order: then there is nothing to search for.
fn continues(points: &[ContactPoint], entries: &[CacheEntry]) -> bool {
    let fresh = entries.get(..points.len());
    fresh.is_some_and(|e| continues_as(points, e) && e.iter().all(|e| e.age == 0 && !e.taken))
}

/// Whether a point lies in an entry's cells on both bodies.
fn is_exact(point: &ContactPoint, entry: &CacheEntry) -> bool {
    point.code_a == entry.code_a && point.code_b == entry.code_b
}

/// Pairs the points of a manifold with entries, one to one: for each point the index of its entry.
///
/// Fresh entries under the point's own codes first; then fresh entries nearby, the closest couple first; then old
/// entries under the point's own codes. Any tie goes to the first point and the first entry.
fn match_points(
    points: &[ContactPoint],
    entries: &mut [CacheEntry],
    measure: &Nearness,
    stats: &mut CacheStats,
) -> [Option<usize>; MAX_POINTS] {
    let mut matches = [None; MAX_POINTS];
    let take = |found: &mut Option<usize>, entries: &mut [CacheEntry], index: usize| {
        entries[index].taken = true;
        *found = Some(index);
    };
    for (point, found) in points.iter().zip(&mut matches) {
        let exact = |e: &CacheEntry| !e.taken && e.age == 0 && is_exact(point, e);
        if let Some(index) = entries.iter().position(exact) {
            take(found, entries, index);
            stats.exact_hits += 1;
        }
    }
    if matches[..points.len()].contains(&None) {
        let mut couples = Couples::new(points, &matches, entries, measure);
        while let Some((i, index)) = couples.take_closest() {
            take(&mut matches[i], entries, index);
            stats.near_hits += 1;
        }
    }
    for (point, found) in points.iter().zip(&mut matches) {
        if found.is_some() {
            continue;
        }
        let exact = |e: &CacheEntry| !e.taken && is_exact(point, e);
        match entries.iter().position(exact) {
            Some(index) => {
                take(found, entries, index);
                stats.stale_hits += 1;
            }
            None => stats.misses += 1,
        }
    }
    stats.points += points.len() as u32;
    matches
}

/// Most fresh entries of a pair that nearness looks at; a step stores [`MAX_POINTS`], a cut may leave more.
const MAX_FRESH: usize = 8;

/// Distances between the points without entry and the fresh entries without point of one pair.
#[derive(Debug)]
struct Couples {
    /// Row: point; column: entry. `None`: taken, or not near.
    distances: [[Option<Distance>; MAX_FRESH]; MAX_POINTS],
}

impl Couples {
    fn new(
        points: &[ContactPoint],
        matches: &[Option<usize>],
        entries: &[CacheEntry],
        measure: &Nearness,
    ) -> Self {
        let mut distances = [[None; MAX_FRESH]; MAX_POINTS];
        for (column, entry) in entries.iter().take(MAX_FRESH).enumerate() {
            if entry.taken || entry.age > 0 {
                continue;
            }
            let there = measure.place(entry.code_a, entry.code_b);
            for (row, point) in points.iter().enumerate() {
                if matches[row].is_none() {
                    let here = measure.place(point.code_a, point.code_b);
                    distances[row][column] = measure.distance(here, there);
                }
            }
        }
        Self { distances }
    }

    /// Removes the closest couple: point and entry.
    fn take_closest(&mut self) -> Option<(usize, usize)> {
        let mut best: Option<(Distance, usize, usize)> = None;
        for (row, distances) in self.distances.iter().enumerate() {
            for (column, distance) in distances.iter().enumerate() {
                if let Some(distance) = distance
                    && best.is_none_or(|b| distance.order(&b.0) == Ordering::Less)
                {
                    best = Some((*distance, row, column));
                }
            }
        }
        let (_, row, column) = best?;
        self.distances[row] = [None; MAX_FRESH];
        for distances in &mut self.distances {
            distances[column] = None;
        }
        Some((row, column))
    }
}

/// How far a point and an entry are apart, on the body where they are closer and on the other one; squared, m2.
#[derive(Clone, Copy, Debug)]
struct Distance {
    closer: f32,
    farther: f32,
}

impl Distance {
    fn order(&self, other: &Self) -> Ordering {
        self.closer
            .total_cmp(&other.closer)
            .then(self.farther.total_cmp(&other.farther))
    }
}

/// Measures distances between cells of two bodies' boxes.
#[derive(Debug)]
struct Nearness {
    /// Edge lengths of the cells (m) of those boxes whose cells are fine enough to tell points apart.
    cell_sizes: [Option<Vec3>; 2],
    /// Largest distance that counts as near, m.
    bound: f32,
}

impl Nearness {
    /// The bound is a share of the smaller box. A box with cells larger than that does not count: two corners of a
    /// small body on a kilometre of terrain would both be "in the same cell" there.
    fn of(a: Option<&KdBox>, b: Option<&KdBox>) -> Self {
        let longest = |b: Option<&KdBox>| b.map_or(f32::INFINITY, |b| b.extents.max_element());
        let bound = NEAR_SHARE * longest(a).min(longest(b));
        let fine = |b: Option<&KdBox>| {
            b.map(KdBox::cell_size)
                .filter(|size| 2.0 * size.max_element() <= bound)
        };
        Self {
            cell_sizes: [fine(a), fine(b)],
            bound,
        }
    }

    /// Where two cells are on A and on B, from the corner of each box, m.
    fn place(&self, code_a: KdCode, code_b: KdCode) -> [Option<Vec3>; 2] {
        let on = |size: Option<Vec3>, code: KdCode| size.map(|size| code.cell().as_vec3() * size);
        [
            on(self.cell_sizes[0], code_a),
            on(self.cell_sizes[1], code_b),
        ]
    }

    /// Distance between two places; `None` if not near on either body.
    fn distance(&self, here: [Option<Vec3>; 2], there: [Option<Vec3>; 2]) -> Option<Distance> {
        let on = |side: usize| match (here[side], there[side]) {
            (Some(p), Some(q)) => p.distance_squared(q),
            _ => f32::INFINITY,
        };
        let (d_a, d_b) = (on(0), on(1));
        let distance = Distance {
            closer: d_a.min(d_b),
            farther: d_a.max(d_b),
        };
        // Without any box the bound is infinite too, and nothing is near.
        let near = distance.closer.is_finite() && distance.closer <= self.bound * self.bound;
        near.then_some(distance)
    }
}
