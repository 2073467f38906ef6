//! Islands of one body, or of a few that touch one, that are solved side by side, each as if it were alone.
//!
//! What falls on a floor, rolls or slides there is an island of its own, and has impacts that islands of a batch would share: how many
//! sweeps there are, how fast the momentum of the sweeps grows. Here each island has these for itself, so that eight lanes do what one
//! did and every bit stays what it would be if the island were the only one. Where all contacts of an island share a body they are solved
//! one after the other anyway: they are in one lane of as many blocks. The sweeps that all need are made for all; islands that need more
//! are [taken out](crate::solver::batch::extra_lanes), lane by lane, and as soon as one is done the next takes its lane.
//!
//! What is not the same in all islands is left: where a contact hits, or sweeps end above the tolerance, the island is solved once more
//! in a batch of its own.

use crate::simd::lanes::F8;
use crate::solver::adaptivity::SweepBudget;
use crate::solver::batch::Batch;
use crate::solver::batch::extra_lanes::{ExtraLanes, OwnSweeps, WaitingIsland};
use crate::solver::batch::layout::Member;
use crate::solver::batch::sweeps::SweepKind;
use crate::solver::batch::targets::{Hits, MOVING_TOLERANCE, Targets};
use crate::solver::wide::pass::Pass;

/// What each island of a batch has for itself; empty where the islands are solved as one.
#[derive(Debug, Default)]
pub(crate) struct LoneIslands {
    own: OwnSweeps,
    /// By block: the largest velocity change of the last sweep in each lane, m/s.
    pub(crate) changes: Vec<F8>,
    /// Islands that need more sweeps.
    waiting: Vec<WaitingIsland>,
    lanes: ExtraLanes,
}

impl LoneIslands {
    /// Whether islands are solved each for itself.
    pub(crate) fn any(&self) -> bool {
        !self.own.budgets.is_empty()
    }

    /// What an island took, by its number; `None` where islands are solved as one.
    pub(crate) fn budget(&self, member: usize) -> Option<SweepBudget> {
        self.own.budgets.get(member).copied()
    }

    pub(crate) fn clear(&mut self) {
        self.own.budgets.clear();
        self.own.is_left.clear();
        self.changes.clear();
    }

    /// Begins a sub-step, with `to_go` of them left.
    pub(crate) fn begin_substep(&mut self, to_go: u32) {
        for budget in &mut self.own.budgets {
            budget.begin(to_go);
        }
    }
}

impl Batch {
    /// Takes note that each island is solved for itself.
    pub(super) fn begin_lone(&mut self) {
        let (lone, max) = (&mut self.lone, self.settings.max_extra_updates);
        let members = &self.layout.members;
        let budgets = members.iter().map(|m| SweepBudget::new(max, m.contacts));
        lone.own.budgets.extend(budgets);
        lone.own.is_left.resize(members.len(), false);
        lone.changes
            .resize(self.contacts.blocks.len(), F8::default());
    }

    /// Calls `leave` with the numbers of the islands that are to be solved alone, whose results here mean nothing, and forgets them.
    pub(crate) fn leave_out(&mut self, mut leave: impl FnMut(usize)) {
        let is_left = &self.lone.own.is_left;
        if !is_left.contains(&true) {
            return;
        }
        (0..is_left.len())
            .filter(|&m| is_left[m])
            .for_each(&mut leave);
        self.layout.leave_out(is_left);
        let mut left = is_left.iter();
        self.lone.own.budgets.retain(|_| left.next() != Some(&true));
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
            self.leave_hits(threshold);
            solve = SweepKind::Solve(softness);
        }
        Targets {
            solve,
            tolerance: None,
            hits: Hits::default(),
        }
    }

    /// Leaves the islands in which something hits.
    fn leave_hits(&mut self, threshold: f32) {
        let mut is_left = std::mem::take(&mut self.lone.own.is_left);
        for (is_left, member) in is_left.iter_mut().zip(&self.layout.members) {
            // If one manifold moves all do.
            let moving = self.contacts.moving.get(member.places.clone());
            let mut moving = moving.into_iter().flatten();
            *is_left |= moving.any(|moving| self.hits(moving, threshold));
            if self.impacts.has_restitution {
                let mut places = self.layout.places[member.places.clone()].iter();
                *is_left |= places.any(|(_, place)| self.bounces(*place));
            }
        }
        self.lone.own.is_left = is_left;
    }

    fn set_lone_tolerances(&mut self) {
        self.lone.own.tolerances.clear();
        let of_islands = self.bodies.fastest.iter().zip(&self.bodies.extents);
        if let Some(tolerance) = self.settings.tolerance {
            let of_islands = of_islands
                .map(|(square, extent)| tolerance.max(MOVING_TOLERANCE * (square / extent).sqrt()));
            self.lone.own.tolerances.extend(of_islands);
        }
    }

    /// As [`sweep`](Self::sweep).
    pub(super) fn sweep_lone(&mut self, least: u32, kind: SweepKind) {
        let has_tolerance = self.settings.tolerance.is_some();
        for done in 1..=least {
            let measure = has_tolerance && done == least;
            self.pass(kind.pass(done, measure), None);
        }
        let mut lone = std::mem::take(&mut self.lone);
        let is_asked = has_tolerance && least > 0;
        for (number, member) in self.layout.members.iter().enumerate() {
            if lone.own.is_left[number] {
                continue;
            }
            let is_done =
                !is_asked || self.last_change(&lone, member) <= lone.own.tolerances[number];
            let budget = &mut lone.own.budgets[number];
            if is_done {
                budget.note(least, 0, false);
            } else if budget.share() > 0 && least < self.settings.max_sweeps {
                lone.waiting.push(self.waiting_island(number));
            } else {
                lone.own.is_left[number] = true;
            }
        }
        lone.sweep_waiting(self, least, kind.pass(least + 1, true));
        self.lone = lone;
    }

    /// The largest velocity change that the last sweep has made in an island, m/s.
    fn last_change(&self, lone: &LoneIslands, member: &Member) -> f32 {
        let places = self.layout.places[member.places.clone()].iter();
        let changes =
            places.map(|(_, place)| lone.changes[place.block as usize].0[place.lane as usize]);
        changes.fold(0.0, f32::max)
    }
}

impl LoneIslands {
    /// Sweeps the islands that wait until each is done.
    fn sweep_waiting(&mut self, batch: &mut Batch, least: u32, pass: Pass) {
        let mut waiting = std::mem::take(&mut self.waiting);
        let mut lanes = std::mem::take(&mut self.lanes);
        waiting.sort_unstable();
        for alike in waiting.chunk_by(WaitingIsland::is_like) {
            lanes.sweep(&mut self.own, batch, alike, (least, pass));
        }
        waiting.clear();
        self.waiting = waiting;
        self.lanes = lanes;
    }
}
