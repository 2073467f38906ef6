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
//! 5 x 10 mm, as `tests/it/contact_cache.rs` plays it:
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
//! `table.rs` is the sorted list of entries. `matching.rs` finds the points of a step among them, `update.rs` takes the impulses of the solve
//! in, `chunks.rs` splits both for several threads, and `transfer.rs` gives what a body that was cut bore to its
//! pieces. Must not know bodies or the solver. Read this file first, then `matching.rs`.
//!
//! # References
//! "Constraint-Based Physics With Real-Time Object Slicing": the key, the ages and the limit of ten steps.

mod chunks;
mod matching;
mod table;
mod transfer;
mod update;

pub(crate) use matching::TouchingBodies;
pub(crate) use transfer::{Child, Split};

use crate::contact::body_id::BodyId;
use crate::contact::manifolds::{ManifoldHead, Manifolds};
use crate::contact::point::ContactPoint;
use crate::geometry::{KdBox, KdCode};
use crate::math::rotate;
use crate::threads::team::Team;
use crate::tuning::PARTS_WORTH_HELP;
use bevy_ecs::resource::Resource;
use chunks::ChunkPlan;
use glam::{Quat, Vec3};
use matching::{Matched, WarmStart};
use table::{EntryTable, PairRecord, move_pairs};
use update::{ChunkUpdate, Solved};

/// An entry is evicted when it was not hit for more than this many steps.
pub const MAX_AGE: u32 = 10;

/// How far a point may move in a step and still count as the same, as a share of the smaller body's longest edge.
///
/// A rolling or spinning body that moves farther has other contacts; corners of one body are farther apart.
pub(crate) const NEAR_SHARE: f32 = 0.02;

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

/// `to / from`, or zero if `from` is.
fn ratio(to: f32, from: f32) -> f32 {
    if from > 0.0 { to / from } else { 0.0 }
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

/// Contact multipliers from step to step.
#[derive(Clone, Debug, Default, Resource)]
pub struct ContactCache {
    current: EntryTable,
    /// The table being written, and between steps a spare allocation.
    next: EntryTable,
    /// Length of the step whose impulses are stored, s; 0 while there are none.
    step_dt: f32,
    /// Pairs that neither age nor are matched, and the length of the step that their impulses belong to, s.
    parked: EntryTable,
    parked_step_dt: f32,
    /// Whether an entry is marked as taken.
    any_taken: bool,
    /// How the work of the present pass is split, and what comes of each part.
    plan: ChunkPlan,
    matched: Vec<Matched>,
    updates: Vec<ChunkUpdate>,
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
        self.step_dt = 0.0;
    }

    /// Entries of a pair, `a < b`: those hit last first.
    #[doc(hidden)]
    pub fn entries_of(&self, a: BodyId, b: BodyId) -> impl Iterator<Item = &CacheEntry> {
        let tables = [&self.current, &self.parked];
        tables.into_iter().flat_map(move |table| table.of((a, b)))
    }

    /// Pairs that have entries and are not parked, sorted.
    #[doc(hidden)]
    pub fn pairs(&self) -> impl Iterator<Item = (BodyId, BodyId)> {
        self.current.pairs.iter().map(|pair| pair.bodies)
    }

    /// Forgets all contacts of the bodies for which `is_gone` says so, in one pass.
    #[doc(hidden)]
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
    /// [fetched](Self::resume).
    #[doc(hidden)]
    pub fn suspend(&mut self, ids: &[BodyId]) {
        if self.parked.pairs.is_empty() {
            self.parked_step_dt = self.step_dt;
        }
        let scale = ratio(self.parked_step_dt, self.step_dt);
        let Self {
            current,
            next,
            parked,
            ..
        } = self;
        move_pairs(current, parked, next, ids, scale);
    }

    /// Takes back the pairs of the bodies in `ids` (ascending) as if they had been stored by the last step.
    #[doc(hidden)]
    pub fn resume(&mut self, ids: &[BodyId]) {
        if self.current.pairs.is_empty() {
            self.step_dt = self.parked_step_dt;
        }
        let scale = ratio(self.step_dt, self.parked_step_dt);
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
    /// `boxes` are indexed by slot; `step_dt` is the length of the coming step, s. A body without a box (a half-space) has
    /// code 0 and is matched on the other body's side alone.
    #[doc(hidden)]
    pub fn warm_start(
        &mut self,
        manifolds: &mut Manifolds,
        ids: &[BodyId],
        rotations: &[Quat],
        boxes: &[Option<KdBox>],
        step_dt: f32,
    ) -> CacheStats {
        Team::lead_if(is_worth_help(manifolds.len()), |team| {
            let bodies = TouchingBodies {
                ids,
                rotations,
                boxes,
                have_parts: true,
            };
            self.warm_start_by(team, manifolds, bodies, step_dt)
        })
    }

    /// [`Self::warm_start`] by a team that is there already.
    pub(crate) fn warm_start_by(
        &mut self,
        team: Option<&Team>,
        manifolds: &mut Manifolds,
        bodies: TouchingBodies<'_>,
        step_dt: f32,
    ) -> CacheStats {
        debug_assert!(is_sorted(manifolds.heads(), bodies.ids));
        self.plan
            .split(&self.current, manifolds.heads(), bodies.ids);
        let pass = WarmStart {
            bodies,
            // No step before (or one of no length): entries are matched, multipliers start at zero.
            scale: ratio(step_dt, self.step_dt),
            any_taken: self.any_taken,
        };
        let shares = self.plan.shares(&mut self.current);
        let runs = manifolds.runs(self.plan.manifolds());
        let matched = self.plan.one_each(&mut self.matched);
        Team::each_of_many(
            team,
            matched.iter_mut().zip(shares.zip(runs)),
            |(matched, (share, run))| *matched = pass.run(share, run),
        );
        let mut stats = CacheStats::default();
        matched.iter().for_each(|part| stats.add(&part.stats));
        self.any_taken = matched.iter().any(|part| part.any_taken);
        stats
    }

    /// Stores the impulses that the solver found, and ages what was not hit.
    ///
    /// Takes the same arguments as [`Self::warm_start`], after the solve. Every point of `manifolds` becomes an entry of
    /// age 0, in place of the entry it was matched to; all other entries grow one step older.
    #[doc(hidden)]
    pub fn store_and_age(
        &mut self,
        manifolds: &Manifolds,
        ids: &[BodyId],
        rotations: &[Quat],
        step_dt: f32,
    ) {
        debug_assert!(is_sorted(manifolds.heads(), ids));
        self.step_dt = step_dt;
        self.any_taken = false;
        self.plan.split(&self.current, manifolds.heads(), ids);
        let solved = Solved {
            manifolds,
            range: 0..manifolds.len(),
            ids,
            rotations,
        };
        Team::lead_if(is_worth_help(manifolds.len()), |team| {
            self.store(team, &solved)
        });
    }

    fn store(&mut self, team: Option<&Team>, solved: &Solved) {
        let updates = self.plan.one_each(&mut self.updates);
        let parts = self.plan.shares(&mut self.current);
        let parts = parts.zip(self.plan.manifolds());
        Team::each_of_many(
            team,
            updates.iter_mut().zip(parts),
            |(update, (share, range))| update.update(share, &solved.part(range)),
        );
        if updates.iter().all(ChunkUpdate::is_in_place) {
            return;
        }
        let writers = ChunkUpdate::writers(updates, &mut self.next);
        let parts = self.plan.shares(&mut self.current);
        let parts = parts.zip(self.plan.manifolds());
        Team::each_of_many(
            team,
            writers.zip(parts),
            |((update, writer), (share, range))| update.write(&share, &solved.part(range), writer),
        );
        std::mem::swap(&mut self.current, &mut self.next);
    }
}

/// Whether a pass over the entries of so many manifolds is worth a team.
fn is_worth_help(manifolds: usize) -> bool {
    manifolds >= PARTS_WORTH_HELP * crate::tuning::MANIFOLDS_PER_PART
}

/// Names of a manifold's bodies.
fn bodies_of(manifold: &ManifoldHead, ids: &[BodyId]) -> (BodyId, BodyId) {
    (ids[manifold.a as usize], ids[manifold.b as usize])
}

/// Whether manifolds come in the order that the merge relies on.
fn is_sorted(manifolds: &[ManifoldHead], ids: &[BodyId]) -> bool {
    // A body on a level of triangles has a manifold for each direction.
    manifolds.is_sorted_by(|l, r| bodies_of(l, ids) <= bodies_of(r, ids))
}

/// Whether the points are those of the entries, in the same order.
fn continues_as(points: &[ContactPoint], entries: &[CacheEntry]) -> bool {
    points.len() == entries.len() && points.iter().zip(entries).all(|(p, e)| is_exact(p, e))
}

/// Whether a point lies in an entry's cells on both bodies.
fn is_exact(point: &ContactPoint, entry: &CacheEntry) -> bool {
    point.code_a == entry.code_a && point.code_b == entry.code_b
}
