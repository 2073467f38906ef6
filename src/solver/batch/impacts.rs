//! Bodies that hit each other within a sub-step, and what becomes of the impulses of their contacts.
//!
//! The impulse that stops a body says nothing about the next sub-step; what its contacts bore before the impact does, and is
//! what they are warm started from, as are contacts that the impact has gone through. All others keep what they have found. In
//! a large pile something hits something in nearly every sub-step: if every contact of the island went back each time, none
//! would ever get to bear its load; and if only those of the bodies that were hit did, what they stand on would push back
//! with the impact in the next sub-step.

use crate::solver::batch::targets::{Hits, Targets};
use crate::solver::batch::{Batch, MovingManifold};
use crate::solver::graph::indices::{BodyNumber, LaneSlot};
use crate::solver::wide::block::{Point, vector};

impl Batch {
    /// Finds the bodies that hit something faster than `threshold` (m/s) in this sub-step, whose target velocities are known,
    /// and remembers the impulses of their contacts.
    pub(crate) fn note_impacts(&mut self, threshold: f32) -> Hits {
        let mut is_hit = std::mem::take(&mut self.impacts.is_hit);
        is_hit.clear();
        is_hit.resize(self.bodies.velocities.len(), false);
        let mut hits = Hits::default();
        let mut note = |pair: [BodyNumber; 2], is_fast: bool| {
            hits.any = true;
            hits.any_fast |= is_fast;
            for body in pair {
                let body = body.index();
                is_hit[body] = self.bodies.velocities[body].inverse_mass > 0.0;
            }
        };
        for moving in self
            .contacts
            .moving
            .iter()
            .filter(|m| self.hits(m, threshold))
        {
            note(moving.bodies, moving.ccd_radius.is_some());
        }
        if self.impacts.has_restitution {
            let places = self.layout.places.iter().zip(&self.layout.pairs);
            let bouncing = places.filter(|((_, place), _)| self.bounces(*place));
            bouncing.for_each(|(_, pair)| note(*pair, false));
        }
        if hits.any {
            for (point, impact) in self.contacts.points.iter().zip(&mut self.impacts.points) {
                impact.before = point.impulse;
            }
        }
        self.impacts.is_hit = is_hit;
        hits
    }

    /// Whether two bodies approach each other faster than `threshold`, m/s.
    pub(crate) fn any_closes(&self, threshold: f32) -> bool {
        let closes = |moving: &MovingManifold| self.closes(moving, |_| threshold);
        self.contacts.moving.iter().any(closes)
    }

    /// Whether the two bodies close their gap so fast that the impulses between them are those of an impact.
    pub(super) fn hits(&self, moving: &MovingManifold, threshold: f32) -> bool {
        let lane = moving.place.lane as usize;
        self.closes(moving, |point| {
            threshold.max(-point.target_velocity.0[lane])
        })
    }

    /// Whether a point of a manifold closes faster than `bound`, m/s.
    fn closes(&self, moving: &MovingManifold, bound: impl Fn(&Point) -> f32) -> bool {
        let LaneSlot { block, lane, count } = moving.place;
        let (block, lane) = (&self.contacts.blocks[block as usize], lane as usize);
        let normal = vector(&block.normal, lane);
        let pair = moving.bodies.map(|b| &self.bodies.velocities[b.index()]);
        let mut points = self.contacts.points[block.points.clone()][..count as usize].iter();
        points.any(|point| -point.normal_velocity(lane, normal, pair) > bound(point))
    }

    /// Whether a point of a manifold rebounds in this sub-step.
    pub(super) fn bounces(&self, place: LaneSlot) -> bool {
        let (block, lane) = (
            &self.contacts.blocks[place.block as usize],
            place.lane as usize,
        );
        let mut impacts = self.impacts.points[block.points.clone()][..place.count as usize].iter();
        impacts.any(|impact| impact.rebound.0[lane] > 0.0)
    }

    /// Ends a sub-step in which bodies hit each other.
    pub(crate) fn restore_hits(&mut self, targets: &Targets) {
        if targets.hits.any {
            self.restore_warm_start(self.settings.restitution_threshold);
            self.forget_contact_velocity_changes();
        }
    }

    /// Takes the impulses of an impact back to the remembered ones, without losing what they add to the total: those of the bodies
    /// that were hit, and those that changed as if theirs had been, by `threshold` (m/s) at the point, because an impact goes on
    /// through what stands behind.
    fn restore_warm_start(&mut self, threshold: f32) {
        let is_hit = &self.impacts.is_hit;
        for block in &self.contacts.blocks {
            for lane in 0..block.used {
                let is_of_hit = block.pair(lane).iter().any(|&body| is_hit[body as usize]);
                for i in block.points.clone() {
                    let (point, impact) = (&mut self.contacts.points[i], &self.impacts.points[i]);
                    let change = point.impulse[0].0[lane] - impact.before[0].0[lane];
                    let is_struck = change.abs() > threshold * point.normal_mass.0[lane];
                    if is_of_hit || is_struck {
                        point.total_normal_impulse.0[lane] += change;
                        for (now, before) in point.impulse.iter_mut().zip(&impact.before) {
                            now.0[lane] = before.0[lane];
                        }
                    }
                }
            }
        }
    }
}
