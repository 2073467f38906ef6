//! The velocities that the rows of a sub-step should have, what hits in it, and how precisely it is solved.

use crate::solver::batch::Batch;
use crate::solver::batch::sweeps::SweepKind;
use crate::solver::rows::soft_step::RowSoftness;
use crate::solver::wide::pass::Pass;
use crate::threads::team::Team;

/// Rebounds are solved until no row changes by more than this share of the fastest one.
const REBOUND_TOLERANCE: f32 = 1e-5;

/// Share of the fastest body's speed that a sub-step need not be more precise than.
pub(super) const MOVING_TOLERANCE: f32 = 0.01;

/// The same where bodies hit each other that may pass through each other in the step: what is left of their speeds is large.
const FAST_TOLERANCE: f32 = 1e-4;

/// Whether bodies hit each other in a sub-step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Hits {
    /// Any.
    pub(crate) any: bool,
    /// Any that may pass through each other in the step.
    pub(crate) any_fast: bool,
}

/// What the sweeps of a sub-step are told.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Targets {
    /// How they begin: the first one may set the target velocities on the way.
    pub(crate) solve: SweepKind,
    /// Largest velocity change that a sweep may still make when they end, m/s.
    pub(crate) tolerance: Option<f32>,
    /// Whether bodies hit each other.
    pub(crate) hits: Hits,
}

impl Batch {
    /// Sets the target velocities or, where nothing hits anything and nothing is bonded, leaves it to the first sweep.
    pub(crate) fn set_targets(&mut self, is_first: bool, team: Option<&Team>) -> Targets {
        if self.lone.any() {
            return self.set_lone_targets(is_first);
        }
        let (bias, softness) = (self.settings.bias(), self.softness());
        let update = Pass::UpdateBias { bias, is_first };
        if !self.is_calm() {
            self.pass(update, team);
            let fastest = self.find_hits();
            let hits = self.note_impacts(self.settings.restitution_threshold);
            let share = if hits.any_fast {
                FAST_TOLERANCE
            } else {
                MOVING_TOLERANCE
            };
            return Targets {
                solve: SweepKind::Solve(softness),
                tolerance: self.tolerance(share, fastest),
                hits,
            };
        }
        let mut solve = SweepKind::SolveFrom {
            bias,
            is_first,
            softness,
        };
        if self.settings.sweeps == 0 || self.bonds.any() {
            self.pass(update, team);
            solve = SweepKind::Solve(softness);
        }
        Targets {
            solve,
            tolerance: self.tolerance(MOVING_TOLERANCE, 0.0),
            hits: Hits::default(),
        }
    }

    /// The compliance of the rows, whose friction is cautious where an earlier sub-step of the step ended above the tolerance.
    fn softness(&self) -> RowSoftness {
        let mut softness = self.settings.softness();
        if self.budget.is_unconverged && self.settings.is_relaxed() {
            softness.friction = RowSoftness::UNCONVERGED_FRICTION;
        }
        softness
    }

    /// Whether nothing hits anything in this sub-step, so that targets need not be known before the warm start.
    fn is_calm(&self) -> bool {
        let threshold = self.settings.restitution_threshold;
        let may_hit = || self.impacts.has_restitution || self.any_closes(threshold);
        !(self.settings.is_exact() || self.impacts.can_hit() && may_hit())
    }

    /// The tolerance of a sub-step, m/s: the user's or, where bodies move, a `share` of the speed of the fastest, whichever
    /// island is the strictest; or that of rebounds, the fastest of which has the speed `rebound`.
    fn tolerance(&self, share: f32, rebound: f32) -> Option<f32> {
        let asked = self.settings.tolerance.map(|tolerance| {
            let islands = self.bodies.fastest.iter().zip(&self.bodies.extents);
            let of_islands =
                islands.map(|(square, extent)| tolerance.max(share * (square / extent).sqrt()));
            of_islands.fold(f32::INFINITY, f32::min)
        });
        let of_rebounds = (rebound > 0.0).then_some(REBOUND_TOLERANCE * rebound);
        match (asked, of_rebounds) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        }
    }
}
