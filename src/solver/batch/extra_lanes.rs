//! Eight [lone islands](crate::solver::batch::lone) that are swept until each is done: its lane goes to the next.

use crate::bodies::solver_body::SolverBody;
use crate::contact::point::MAX_POINTS;
use crate::simd::dispatch::run;
use crate::simd::lanes::{F8, WIDTH};
use crate::solver::adaptivity::SweepBudget;
use crate::solver::batch::Batch;
use crate::solver::graph::indices::LaneSlot;
use crate::solver::rows::acceleration::AccelerationWeight;
use crate::solver::wide::block::{Block, Point};
use crate::solver::wide::contacts::{ContactBlocks, cells};
use crate::solver::wide::extrapolate::Extrapolate;
use crate::solver::wide::pass::Pass;

/// What the sweeps of each island are, by its number in the batch.
#[derive(Debug, Default)]
pub(super) struct OwnSweeps {
    /// What it took.
    pub(super) budgets: Vec<SweepBudget>,
    /// Largest velocity change that a sweep may still make, m/s.
    pub(super) tolerances: Vec<f32>,
    /// Whether it is to be solved alone after all.
    pub(super) is_left: Vec<bool>,
}

/// An island that needs more sweeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct WaitingIsland {
    /// Number of its manifolds, and points of the largest.
    manifolds: usize,
    points: u16,
    /// Its number in the batch.
    member: usize,
}

impl WaitingIsland {
    /// Whether two islands take as many blocks and about as many rows.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        self.manifolds == other.manifolds && self.points == other.points
    }
}

/// The blocks of eight islands; buffers are reused.
#[derive(Debug, Default)]
pub(super) struct ExtraLanes {
    /// By manifold of an island.
    blocks: Vec<Block>,
    /// As many of each block as a manifold may have.
    points: Vec<Point>,
    /// By block: points of the manifold in each lane.
    counts: Vec<[u16; WIDTH]>,
    /// Most bodies of an island.
    bodies: usize,
    /// Those of each lane, one after the other.
    velocities: Vec<SolverBody>,
    before: Vec<SolverBody>,
    last_velocities: Vec<SolverBody>,
    last_impulses: Vec<[F8; 3]>,
    changes: Vec<F8>,
    lanes: [Option<ExtraLane>; WIDTH],
}

/// An island that is swept.
#[derive(Clone, Copy, Debug)]
struct ExtraLane {
    member: usize,
    acceleration: AccelerationWeight<f32>,
    /// Sweeps that it has had, and may have at most.
    done: u32,
    most: u32,
}

impl Batch {
    /// An island as one that needs more sweeps.
    pub(super) fn waiting_island(&self, member: usize) -> WaitingIsland {
        let places = &self.layout.places[self.layout.members[member].places.clone()];
        let counts = places.iter().map(|(_, place)| place.count);
        WaitingIsland {
            manifolds: places.len(),
            points: counts.max().unwrap_or(0),
            member,
        }
    }
}

impl ExtraLanes {
    /// Sweeps islands of a batch, which are alike and have had the `least` sweeps, until each is done.
    pub(super) fn sweep(
        &mut self,
        own: &mut OwnSweeps,
        batch: &mut Batch,
        alike: &[WaitingIsland],
        (least, pass): (u32, Pass),
    ) {
        let mut waiting = alike.iter();
        let used = alike.len().min(WIDTH);
        self.resize(alike[0].manifolds, used);
        let mut next = |lanes: &mut Self, own: &OwnSweeps, batch: &Batch, at: usize| {
            lanes.lanes[at] = waiting.next().map(|island| {
                let member = island.member;
                lanes.load(batch, at, member);
                ExtraLane {
                    member,
                    acceleration: AccelerationWeight::default(),
                    done: least,
                    most: (batch.settings.max_sweeps).min(least + own.budgets[member].share()),
                }
            });
        };
        for at in 0..used {
            next(self, own, batch, at);
        }
        while self.lanes.iter().any(Option::is_some) {
            self.accelerate(batch, used);
            self.contacts(batch).pass(pass, &mut []);
            for at in 0..used {
                let change = self.changes.iter().map(|change| change.0[at]);
                let change = change.fold(0.0, f32::max);
                let Some(lane) = &mut self.lanes[at] else {
                    continue;
                };
                lane.acceleration.note(change);
                lane.done += 1;
                let member = lane.member;
                let is_above = change > own.tolerances[member];
                if is_above && lane.done < lane.most {
                    continue;
                }
                own.budgets[member].note(lane.done, lane.done - least, is_above);
                own.is_left[member] |= is_above;
                self.store(batch, at, member);
                next(self, own, batch, at);
            }
        }
    }

    /// Makes room for islands of so many manifolds, of which each has one body of its own at most, in as many lanes.
    fn resize(&mut self, manifolds: usize, used: usize) {
        self.blocks.resize_with(manifolds, Block::default);
        for (number, block) in self.blocks.iter_mut().enumerate() {
            let first = MAX_POINTS * number;
            block.clear(0, first..first);
            block.used = used;
        }
        self.points.resize(MAX_POINTS * manifolds, Point::default());
        self.counts.clear();
        self.counts.resize(manifolds, [0; WIDTH]);
        self.bodies = manifolds + 1;
        let bodies = WIDTH * self.bodies;
        self.velocities.resize(bodies, SolverBody::default());
        self.last_velocities.resize(bodies, SolverBody::default());
        let points = self.points.len();
        self.last_impulses.resize(points, Default::default());
        self.changes.clear();
        self.changes.resize(manifolds, F8::default());
    }

    /// Copies an island into a lane.
    fn load(&mut self, batch: &Batch, at: usize, member: usize) {
        let member = &batch.layout.members[member];
        let pairs = &batch.layout.pairs[member.places.clone()];
        let places = &batch.layout.places[member.places.clone()];
        let no_point = Point::default();
        for (number, (pair, &(_, place))) in pairs.iter().zip(places).enumerate() {
            let LaneSlot { block, lane, count } = place;
            let (block, from) = (
                &mut self.blocks[number],
                &batch.contacts.blocks[block as usize],
            );
            let lanes = [lane as usize, at];
            block.copy_lane(from, lanes);
            for (side, body) in pair.iter().enumerate() {
                let body = self.bodies * at + body.index() - member.bodies.start;
                block.bodies[side][at] = body as u32;
            }
            let first = block.points.start;
            let from = &batch.contacts.points[from.points.start..][..usize::from(count)];
            for (k, to) in self.points[first..][..MAX_POINTS].iter_mut().enumerate() {
                match from.get(k) {
                    Some(from) => to.copy_lane(from, lanes),
                    None => to.copy_lane(&no_point, lanes),
                }
            }
            self.counts[number][at] = count;
            let most = self.counts[number].iter().fold(0, |a, &b| a.max(b));
            block.points.end = first + usize::from(most);
        }
        let bodies = &batch.bodies.velocities[member.bodies.clone()];
        self.velocities[self.bodies * at..][..bodies.len()].copy_from_slice(bodies);
    }

    /// Takes what has become of an island back.
    fn store(&self, batch: &mut Batch, at: usize, member: usize) {
        let member = &batch.layout.members[member];
        let places = &batch.layout.places[member.places.clone()];
        for (from, (_, place)) in self.blocks.iter().zip(places) {
            let first = batch.contacts.blocks[place.block as usize].points.start;
            let points = &mut batch.contacts.points[first..][..usize::from(place.count)];
            for (to, from) in points.iter_mut().zip(&self.points[from.points.clone()]) {
                for (to, from) in to.impulse.iter_mut().zip(&from.impulse) {
                    to.0[place.lane as usize] = from.0[at];
                }
            }
        }
        let bodies = &mut batch.bodies.velocities[member.bodies.clone()];
        bodies.copy_from_slice(&self.velocities[self.bodies * at..][..bodies.len()]);
    }

    /// As [`accelerate`](Batch::accelerate), each lane by a weight of its own.
    fn accelerate(&mut self, batch: &Batch, used: usize) {
        let weights = self
            .lanes
            .map(|lane| lane.and_then(|l| l.acceleration.weight()));
        if weights == [None; WIDTH] {
            self.last_velocities.copy_from_slice(&self.velocities);
            for (last, now) in self.last_impulses.iter_mut().zip(&self.points) {
                *last = now.impulse;
            }
            return;
        }
        self.before.clone_from(&self.velocities);
        let lanes = self.velocities.chunks_mut(self.bodies);
        let last = self.last_velocities.chunks_mut(self.bodies);
        for (weight, (bodies, last)) in weights.into_iter().zip(lanes.zip(last)) {
            let weight = weight.unwrap_or(0.0);
            for (body, last) in bodies.iter_mut().zip(last) {
                let now = *body;
                body.linear = now.linear + weight * (now.linear - last.linear);
                body.angular = now.angular + weight * (now.angular - last.angular);
                *last = now;
            }
        }
        let mut impulses = std::mem::take(&mut self.last_impulses);
        let extrapolate = Extrapolate::<false> {
            contacts: &mut self.contacts(batch),
            bond_constraints: &[],
            last: &mut impulses,
            weight: F8(weights.map(|weight| weight.unwrap_or(0.0))),
        };
        run(batch.settings.lane_width, extrapolate);
        self.last_impulses = impulses;
        // Without momentum a lane stays as it is, to the bit.
        for lane in (0..used).filter(|&lane| weights[lane].is_none()) {
            for block in &self.blocks {
                let points = block.points.clone();
                let last = &self.last_impulses[points.clone()];
                for (now, last) in self.points[points].iter_mut().zip(last) {
                    for (now, last) in now.impulse.iter_mut().zip(last) {
                        now.0[lane] = last.0[lane];
                    }
                }
            }
            let bodies = self.bodies * lane..self.bodies * (lane + 1);
            self.velocities[bodies.clone()].copy_from_slice(&self.before[bodies]);
        }
    }

    fn contacts(&mut self, batch: &Batch) -> ContactBlocks<'_> {
        ContactBlocks {
            blocks: &self.blocks,
            points: &mut self.points,
            first_point: 0,
            impacts: &[],
            lane_changes: &mut self.changes,
            bodies: cells(&mut self.velocities),
            displacements: &[],
            friction: batch.settings.friction,
            width: batch.settings.lane_width,
            is_far: false,
        }
    }
}
