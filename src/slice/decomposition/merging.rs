//! Convex parts are put together again where the hull of both stays near the solid.
//!
//! A hull of two parts may reach through other parts, where there is no air to see: parts would be in the same place twice. So what it has
//! in common with the other parts must stay small, too.

use crate::geometry::ConvexHull;
use crate::math::Plane;
use crate::slice::convex::HullSlicer;
use crate::slice::cut::Cut;
use crate::slice::decomposition::concavity::{Question, concavity};
use crate::slice::decomposition::solid::Solid;
use crate::slice::decomposition::{ConvexPart, hull_of};
use glam::Vec3;

/// Most of the smaller one that two parts may have in common, besides what they had.
const MOST_SHARED: f64 = 0.02;

/// Two parts that may become one.
struct Pair {
    /// Numbers of the parts, which are never given twice.
    parts: [usize; 2],
    hull: ConvexHull,
    /// What the hull has more than both, m3.
    excess: f64,
}

/// Parts that are put together.
pub(super) struct Merging<'s> {
    solid: &'s Solid,
    /// m
    max_concavity: f64,
    max_parts: usize,
    /// By number; none of those that went into others.
    parts: Vec<Option<ConvexPart>>,
}

impl<'s> Merging<'s> {
    pub(super) fn new(solid: &'s Solid, max_concavity: f64, max_parts: usize) -> Self {
        Self {
            solid,
            max_concavity,
            max_parts,
            parts: Vec::new(),
        }
    }

    /// Puts together what may be, and then what adds least until there are no more parts than allowed.
    pub(super) fn run(mut self, parts: Vec<ConvexPart>) -> Vec<ConvexPart> {
        self.parts = parts.into_iter().map(Some).collect();
        for is_forced in [false, true] {
            let mut pairs = self.all_pairs(is_forced);
            while !is_forced || self.count() > self.max_parts {
                let Some(at) = least_excess(&pairs) else {
                    break;
                };
                let pair = pairs.swap_remove(at);
                if self.parts_of(&pair).is_none() {
                    continue;
                }
                if is_forced {
                    self.join(pair, f64::INFINITY);
                } else if self.shares_too_much(&pair) {
                    continue;
                } else {
                    let question = Question::Within(self.max_concavity);
                    let sticks_out = concavity(&pair.hull, self.solid, question);
                    if sticks_out > self.max_concavity {
                        continue;
                    }
                    self.join(pair, sticks_out);
                }
                pairs.extend(self.pairs_of(self.parts.len() - 1, is_forced));
            }
        }
        self.parts.into_iter().flatten().collect()
    }

    fn count(&self) -> usize {
        self.parts.iter().flatten().count()
    }

    fn parts_of(&self, pair: &Pair) -> Option<[&ConvexPart; 2]> {
        let [a, b] = pair.parts.map(|at| self.parts[at].as_ref());
        Some([a?, b?])
    }

    fn all_pairs(&self, any: bool) -> Vec<Pair> {
        let numbers = 0..self.parts.len();
        numbers.flat_map(|at| self.pairs_of(at, any)).collect()
    }

    /// Pairs of a part and those before it: neighbors, or `any`.
    fn pairs_of(&self, last: usize, any: bool) -> Vec<Pair> {
        let Some(own) = &self.parts[last] else {
            return Vec::new();
        };
        let near = own.hull.aabb().fattened(self.max_concavity as f32);
        let others = (0..last).filter_map(|at| Some((at, self.parts[at].as_ref()?)));
        let others = others.filter(|(_, other)| any || near.overlaps(&other.hull.aabb()));
        let pairs = others.filter_map(|(at, other)| {
            let corners = [own, other].map(|part| part.hull.vertices());
            let points: Vec<Vec3> = corners.concat();
            let hull = hull_of(&points)?;
            Some(Pair {
                parts: [at, last],
                excess: hull.volume() - own.hull.volume() - other.hull.volume(),
                hull,
            })
        });
        pairs.collect()
    }

    /// Whether the hull of a pair reaches into other parts.
    fn shares_too_much(&self, pair: &Pair) -> bool {
        let Some(both) = self.parts_of(pair) else {
            return true;
        };
        let others = self.parts.iter().enumerate();
        let mut others = others
            .filter(|(at, _)| !pair.parts.contains(at))
            .filter_map(|(_, part)| part.as_ref());
        others.any(|other| {
            let before: f64 = both
                .map(|part| shared(&part.hull, &other.hull))
                .iter()
                .sum();
            let least = both.map(|part| part.hull.volume());
            let least = least.into_iter().fold(other.hull.volume(), f64::min);
            shared(&pair.hull, &other.hull) > before + MOST_SHARED * least
        })
    }

    fn join(&mut self, pair: Pair, sticks_out: f64) {
        let [a, b] = pair.parts.map(|at| self.parts[at].take());
        let volume = [a, b].into_iter().flatten().map(|part| part.volume).sum();
        self.parts.push(Some(ConvexPart {
            hull: pair.hull,
            concavity: sticks_out as f32,
            volume,
        }));
    }
}

fn least_excess(pairs: &[Pair]) -> Option<usize> {
    let order = |&a: &usize, &b: &usize| {
        let [a, b] = [a, b].map(|at| &pairs[at]);
        let share = |pair: &Pair| pair.excess / pair.hull.volume();
        share(a).total_cmp(&share(b)).then(a.parts.cmp(&b.parts))
    };
    (0..pairs.len()).min_by(order)
}

/// Volume that two hulls have in common, m3.
fn shared(a: &ConvexHull, b: &ConvexHull) -> f64 {
    if !a.aabb().overlaps(&b.aabb()) {
        return 0.0;
    }
    let mut slicer = HullSlicer::default();
    let mut rest = a.clone();
    for face in b.faces() {
        let plane: Plane = face.plane;
        match slicer.slice(&rest, plane) {
            Ok(Cut::Cut(halves)) => rest = halves.below,
            Ok(Cut::Below) => {}
            // A hull that is nearly flat is refused: nothing to speak of.
            Ok(Cut::Above) | Err(_) => return 0.0,
        }
    }
    rest.volume()
}
