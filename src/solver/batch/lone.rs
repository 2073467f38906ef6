//! Islands of one contact that are solved side by side, each as if it were alone.
//!
//! What falls on a floor, rolls or slides there is an island of its own, and has impacts that islands of a batch would share: how many
//! sweeps there are, how fast the momentum of the sweeps grows. Here each island has these for itself, so that eight lanes do what one
//! did and every bit stays what it would be if the island were the only one. The sweeps that all need are made for all; those that
//! need more are taken out, lane by lane, and as soon as one is done the next takes its lane.
//!
//! What is not the same in all islands is left: where a contact hits, or sweeps end above the tolerance, the island is solved once more
//! in a batch of its own.

use crate::bodies::solver_body::SolverBody;
use crate::contact::point::MAX_POINTS;
use crate::simd::dispatch::run;
use crate::simd::lanes::{F8, WIDTH};
use crate::solver::adaptivity::SweepBudget;
use crate::solver::batch::Batch;
use crate::solver::batch::sweeps::SweepKind;
use crate::solver::batch::targets::{Hits, MOVING_TOLERANCE, Targets};
use crate::solver::graph::indices::BodyNumber;
use crate::solver::rows::acceleration::AccelerationWeight;
use crate::solver::wide::block::{Block, Point};
use crate::solver::wide::contacts::{ContactBlocks, cells};
use crate::solver::wide::extrapolate::Extrapolate;
use crate::solver::wide::pass::Pass;

/// What each island of a batch has for itself; empty where the islands are solved as one.
#[derive(Debug, Default)]
pub(crate) struct LoneIslands {
    /// By island: what it took.
    budgets: Vec<SweepBudget>,
    /// By island: largest velocity change that a sweep may still make, m/s.
    tolerances: Vec<f32>,
    /// By island: whether it is to be solved alone after all.
    is_left: Vec<bool>,
    /// By block: the largest velocity change of the last sweep in each lane, m/s.
    pub(crate) changes: Vec<F8>,
    /// Islands that need more sweeps, by number of points.
    waiting: [Vec<u32>; MAX_POINTS + 1],
    lanes: ExtraLanes,
}

impl LoneIslands {
    /// Whether islands are solved each for itself.
    pub(crate) fn any(&self) -> bool {
        !self.budgets.is_empty()
    }

    /// What an island took, by its number; `None` where islands are solved as one.
    pub(crate) fn budget(&self, member: usize) -> Option<SweepBudget> {
        self.budgets.get(member).copied()
    }

    pub(crate) fn clear(&mut self) {
        self.budgets.clear();
        self.is_left.clear();
        self.changes.clear();
    }

    /// Begins a sub-step, with `to_go` of them left.
    pub(crate) fn begin_substep(&mut self, to_go: u32) {
        for budget in &mut self.budgets {
            budget.begin(to_go);
        }
    }
}

/// Eight islands that are swept until each is done; buffers are reused.
#[derive(Debug, Default)]
struct ExtraLanes {
    block: Block,
    points: [Point; MAX_POINTS],
    /// Two of each lane, one after the other.
    velocities: [SolverBody; 2 * WIDTH],
    last_velocities: [SolverBody; 2 * WIDTH],
    last_impulses: [[F8; 3]; MAX_POINTS],
    changes: [F8; 1],
    lanes: [Option<ExtraLane>; WIDTH],
}

/// An island that is swept.
#[derive(Clone, Copy, Debug)]
struct ExtraLane {
    member: u32,
    acceleration: AccelerationWeight<f32>,
    /// Sweeps that it has had, and may have at most.
    done: u32,
    most: u32,
}

impl Batch {
    /// Takes note that each island is solved for itself.
    pub(super) fn begin_lone(&mut self) {
        let (lone, max) = (&mut self.lone, self.settings.max_extra_updates);
        let members = &self.layout.members;
        let budgets = members.iter().map(|m| SweepBudget::new(max, m.contacts));
        lone.budgets.extend(budgets);
        lone.is_left.resize(members.len(), false);
        lone.changes
            .resize(self.contacts.blocks.len(), F8::default());
    }

    /// Calls `leave` with the numbers of the islands that are to be solved alone, whose results here mean nothing, and forgets them.
    pub(crate) fn leave_out(&mut self, mut leave: impl FnMut(usize)) {
        let is_left = &self.lone.is_left;
        if !is_left.contains(&true) {
            return;
        }
        (0..is_left.len())
            .filter(|&m| is_left[m])
            .for_each(&mut leave);
        self.layout.leave_out(is_left);
        let mut left = is_left.iter();
        self.lone.budgets.retain(|_| left.next() != Some(&true));
    }

    /// As [`set_targets`](Self::set_targets).
    pub(super) fn set_lone_targets(&mut self, is_first: bool) -> Targets {
        let (bias, softness) = (self.settings.bias(), self.settings.softness());
        self.set_lone_tolerances();
        let mut solve = SweepKind::SolveFrom {
            bias,
            is_first,
            softness,
        };
        let threshold = self.settings.restitution_threshold;
        let has_restitution = self.impacts.has_restitution;
        if self.settings.sweeps == 0 || has_restitution || self.any_closes(threshold) {
            self.pass(Pass::UpdateBias { bias, is_first }, None);
            self.find_hits();
            // Each island has one manifold, and if one moves all do.
            let mut is_left = std::mem::take(&mut self.lone.is_left);
            for (is_left, moving) in is_left.iter_mut().zip(&self.contacts.moving) {
                *is_left |= self.hits(moving, threshold);
            }
            if has_restitution {
                for (is_left, (_, place)) in is_left.iter_mut().zip(&self.layout.places) {
                    *is_left |= self.bounces(*place);
                }
            }
            self.lone.is_left = is_left;
            solve = SweepKind::Solve(softness);
        }
        Targets {
            solve,
            tolerance: None,
            hits: Hits::default(),
        }
    }

    fn set_lone_tolerances(&mut self) {
        self.lone.tolerances.clear();
        let of_islands = self.bodies.fastest.iter().zip(&self.bodies.extents);
        if let Some(tolerance) = self.settings.tolerance {
            let of_islands = of_islands
                .map(|(square, extent)| tolerance.max(MOVING_TOLERANCE * (square / extent).sqrt()));
            self.lone.tolerances.extend(of_islands);
        }
    }

    /// As [`sweep`](Self::sweep).
    pub(super) fn sweep_lone(&mut self, least: u32, kind: SweepKind) {
        let has_tolerance = self.settings.tolerance.is_some();
        for done in 1..=least {
            let measure = has_tolerance && done == least;
            self.pass(kind.pass(done, measure), None);
        }
        let lone = &mut self.lone;
        let is_asked = has_tolerance && least > 0;
        for (member, budget) in lone.budgets.iter_mut().enumerate() {
            if lone.is_left[member] {
                continue;
            }
            let place = self.layout.places[member].1;
            let change = lone.changes[place.block as usize].0[place.lane as usize];
            if !is_asked || change.max(0.0) <= lone.tolerances[member] {
                budget.note(least, 0, false);
            } else if budget.share() > 0 && least < self.settings.max_sweeps {
                lone.waiting[usize::from(place.count)].push(member as u32);
            } else {
                lone.is_left[member] = true;
            }
        }
        let pass = kind.pass(least + 1, true);
        let mut lone = std::mem::take(&mut self.lone);
        for count in 0..=MAX_POINTS {
            lone.sweep_waiting(self, count, least, pass);
        }
        self.lone = lone;
    }
}

impl LoneIslands {
    /// Sweeps the islands of so many points that wait until each is done.
    fn sweep_waiting(&mut self, batch: &mut Batch, count: usize, least: u32, pass: Pass) {
        let mut used = 0;
        while used < WIDTH && self.load_next(batch, used, count, least) {
            used += 1;
        }
        if used == 0 {
            return;
        }
        self.lanes.block.used = used;
        self.lanes.block.points = 0..count;
        let mut left = used;
        while left > 0 {
            self.lanes.accelerate(batch, used);
            self.lanes.contacts(batch).pass(pass, &mut []);
            for at in 0..used {
                let Some(lane) = &mut self.lanes.lanes[at] else {
                    continue;
                };
                let change = self.lanes.changes[0].0[at].max(0.0);
                lane.acceleration.note(change);
                lane.done += 1;
                let member = lane.member as usize;
                let is_above = change > self.tolerances[member];
                if is_above && lane.done < lane.most {
                    continue;
                }
                self.budgets[member].note(lane.done, lane.done - least, is_above);
                self.is_left[member] |= is_above;
                self.lanes.store(batch, at, count);
                if !self.load_next(batch, at, count, least) {
                    self.lanes.lanes[at] = None;
                    left -= 1;
                }
            }
        }
    }

    /// Gives a lane to the next island that waits, if there is one.
    fn load_next(&mut self, batch: &Batch, at: usize, count: usize, least: u32) -> bool {
        let Some(member) = self.waiting[count].pop() else {
            return false;
        };
        let share = self.budgets[member as usize].share();
        self.lanes.load(batch, at, member);
        self.lanes.lanes[at] = Some(ExtraLane {
            member,
            acceleration: AccelerationWeight::default(),
            done: least,
            most: batch.settings.max_sweeps.min(least + share),
        });
        true
    }
}

impl ExtraLanes {
    /// Copies an island into a lane.
    fn load(&mut self, batch: &Batch, at: usize, member: u32) {
        let (member, pair) = (member as usize, [2 * at, 2 * at + 1]);
        let place = batch.layout.places[member].1;
        let from = &batch.contacts.blocks[place.block as usize];
        let lanes = [place.lane as usize, at];
        self.block.copy_lane(from, lanes);
        self.block.bodies[0][at] = pair[0] as u32;
        self.block.bodies[1][at] = pair[1] as u32;
        let points = &batch.contacts.points[from.points.clone()];
        for (to, from) in self.points.iter_mut().zip(points) {
            to.copy_lane(from, lanes);
        }
        for (to, number) in pair.into_iter().zip(batch.layout.pairs[member]) {
            self.velocities[to] = batch.bodies.velocities[number.index()];
        }
    }

    /// Takes what has become of an island back.
    fn store(&self, batch: &mut Batch, at: usize, count: usize) {
        let Some(lane) = self.lanes[at] else { return };
        let member = lane.member as usize;
        let place = batch.layout.places[member].1;
        let first = batch.contacts.blocks[place.block as usize].points.start;
        let points = &mut batch.contacts.points[first..first + count];
        for (to, from) in points.iter_mut().zip(&self.points) {
            for (to, from) in to.impulse.iter_mut().zip(&from.impulse) {
                to.0[place.lane as usize] = from.0[at];
            }
        }
        let pair: [BodyNumber; 2] = batch.layout.pairs[member];
        for (side, number) in pair.into_iter().enumerate() {
            batch.bodies.velocities[number.index()] = self.velocities[2 * at + side];
        }
    }

    /// As [`accelerate`](Batch::accelerate), each lane by a weight of its own.
    fn accelerate(&mut self, batch: &Batch, used: usize) {
        let weights = self
            .lanes
            .map(|lane| lane.and_then(|l| l.acceleration.weight()));
        let (before, last) = (self.velocities, self.last_velocities);
        self.last_velocities = before;
        if weights == [None; WIDTH] {
            for (last, now) in self.last_impulses.iter_mut().zip(&self.points) {
                *last = now.impulse;
            }
            return;
        }
        for (body, weight) in weights.into_iter().enumerate().flat_map(|(lane, weight)| {
            [2 * lane, 2 * lane + 1].map(|body| (body, weight.unwrap_or(0.0)))
        }) {
            let (now, last) = (before[body], last[body]);
            self.velocities[body].linear = now.linear + weight * (now.linear - last.linear);
            self.velocities[body].angular = now.angular + weight * (now.angular - last.angular);
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
            for (now, last) in self.points.iter_mut().zip(&self.last_impulses) {
                for (now, last) in now.impulse.iter_mut().zip(last) {
                    now.0[lane] = last.0[lane];
                }
            }
            for body in [2 * lane, 2 * lane + 1] {
                self.velocities[body] = before[body];
            }
        }
    }

    fn contacts(&mut self, batch: &Batch) -> ContactBlocks<'_> {
        let points = self.block.points.end;
        ContactBlocks {
            blocks: std::slice::from_ref(&self.block),
            points: &mut self.points[..points],
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
