//! Finds the points of a step among the entries of the step before.

use crate::contact::body_id::BodyId;
use crate::contact::impulses::chunks::Chunk;
use crate::contact::impulses::{
    CacheEntry, CacheStats, NEAR_SHARE, bodies_of, continues_as, is_exact,
};
use crate::contact::manifolds::ManifoldHead;
use crate::contact::manifolds::Run;
use crate::contact::point::ContactPoint;
use crate::contact::point::MAX_POINTS;
use crate::geometry::{KdBox, KdCode};
use crate::math::rotate;
use crate::merge::merge;
use glam::{Quat, Vec3};
use std::cmp::Ordering;

/// What a warm start reads of bodies, by slot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TouchingBodies<'s> {
    pub(crate) ids: &'s [BodyId],
    /// World from body.
    pub(crate) rotations: &'s [Quat],
    /// What contact codes refer to; none for a half-space.
    pub(crate) boxes: &'s [Option<KdBox>],
    /// Whether a pair may have several manifolds.
    pub(crate) have_parts: bool,
}

/// What all parts of a warm start read.
#[derive(Debug)]
pub(crate) struct WarmStart<'s> {
    pub(crate) bodies: TouchingBodies<'s>,
    /// What stored impulses are multiplied with.
    pub(crate) scale: f32,
    /// Whether entries may be marked as taken from an earlier look.
    pub(crate) any_taken: bool,
}

/// What came of a part of a warm start.
#[derive(Clone, Debug, Default)]
pub(crate) struct Matched {
    pub(crate) stats: CacheStats,
    /// Whether an entry is marked as taken.
    pub(crate) any_taken: bool,
}

impl WarmStart<'_> {
    /// Fills the impulses of a run of manifolds.
    pub(crate) fn run(&self, share: Chunk, run: Run) -> Matched {
        if self.any_taken {
            share
                .entries
                .iter_mut()
                .for_each(|entry| entry.taken = false);
        }
        let mut matched = Matched::default();
        let manifolds =
            (run.each()).map(|(head, points)| (bodies_of(head, self.bodies.ids), head, points));
        for pair in merge(share.pairs, manifolds, |pair, (bodies, ..)| {
            pair.bodies.cmp(bodies)
        }) {
            let (pair, manifold) = pair.into_options();
            if let Some((_, head, points)) = manifold {
                let range = pair.map_or(0..0, |pair| share.range(pair));
                let misses = matched.stats.misses;
                self.fill(head, points, &mut share.entries[range], &mut matched);
                if self.bodies.have_parts && matched.stats.misses > misses {
                    let pool = share.range_of_all(bodies_of(head, self.bodies.ids));
                    self.fill_from_others(head, points, &mut share.entries[pool], &mut matched);
                }
            }
        }
        matched
    }

    /// Fills the impulses of one manifold from its entries.
    fn fill(
        &self,
        head: &ManifoldHead,
        points: &mut [ContactPoint],
        entries: &mut [CacheEntry],
        matched: &mut Matched,
    ) {
        let rotation = self.bodies.rotations[head.a as usize];
        let normal = head.normal;
        let stats = &mut matched.stats;
        if continues(points, entries) {
            stats.points += head.count;
            stats.exact_hits += head.count;
            for (point, entry) in points.iter_mut().zip(entries) {
                let entry = Some(&*entry).filter(|entry| entry.is_finite());
                apply(point, entry, normal, rotation, self.scale);
            }
            return;
        }
        let [a, b] = [head.a, head.b].map(|slot| self.bodies.boxes[slot as usize].as_ref());
        let measure = Nearness::of(a, b);
        matched.any_taken = true;
        let found = match_points(points, entries, &measure, stats);
        for (point, found) in points.iter_mut().zip(found) {
            let entry = found
                .map(|index| entries[index])
                .filter(|entry| entry.age == 0 && entry.is_finite());
            apply(point, entry.as_ref(), normal, rotation, self.scale);
        }
    }
}

/// Where a manifold came or went, those behind it have the entries of others of the same pair.
impl WarmStart<'_> {
    /// Fills the impulses of points that found nothing from the entries of all manifolds of the pair.
    fn fill_from_others(
        &self,
        head: &ManifoldHead,
        points: &mut [ContactPoint],
        pool: &mut [CacheEntry],
        matched: &mut Matched,
    ) {
        let rotation = self.bodies.rotations[head.a as usize];
        for point in points.iter_mut().filter(|p| p.normal_impulse == 0.0) {
            let is_own =
                |e: &&mut CacheEntry| !e.taken && e.age == 0 && e.is_finite() && is_exact(point, e);
            if let Some(entry) = pool.iter_mut().find(is_own) {
                entry.taken = true;
                apply(point, Some(entry), head.normal, rotation, self.scale);
                matched.any_taken = true;
                matched.stats.misses = matched.stats.misses.saturating_sub(1);
                matched.stats.exact_hits += 1;
            }
        }
    }
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

/// Whether the points are those of the step before, in the same order: then there is nothing to search for.
fn continues(points: &[ContactPoint], entries: &[CacheEntry]) -> bool {
    let fresh = entries.get(..points.len());
    fresh.is_some_and(|e| continues_as(points, e) && e.iter().all(|e| e.age == 0 && !e.taken))
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
        let mut couples = MatchMatrix::new(points, &matches, entries, measure);
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
struct MatchMatrix {
    /// Row: point; column: entry. `None`: taken, or not near.
    distances: [[Option<Distance>; MAX_FRESH]; MAX_POINTS],
}

impl MatchMatrix {
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
