//! The order of methods: multipliers as they come, interior point, polish; friction bounds in an outer loop.

use crate::solver::exact::interior::Interior;
use crate::solver::exact::newton::Polish;
use crate::solver::exact::rows::{ExactRows, Law};
use crate::solver::exact::velocity::VelocitySpace;
use crate::solver::exact::{CERTIFIED, Certificate};

/// Residual at which nothing is left to gain.
const GOAL: f64 = 1e-14;
/// Residual from which a polish alone is tried first: resting contacts with the impulses of the step before.
const GOOD_START: f64 = 1e-3;
/// Complementarity gap relative to the energy at which the interior point method hands over.
const FIRST_GAP: f64 = 1e-8;
/// How much smaller the gap must be for the next attempt.
const NEXT_GAP: f64 = 1e-2;
/// The gap below which more steps only add rounding.
const LAST_GAP: f64 = 1e-16;
/// Steps of the interior point method.
const INTERIOR_STEPS: u32 = 50;
/// Residual of the coupled problem at which the bounds are no longer updated.
const COUPLED_GOAL: f64 = 1e-12;
/// Share of the residual before a polish that it must leave less of; else the interior point method takes over.
const NEAR: f64 = 0.1;
/// Steps of the interior point method with bounds that follow.
const APPROACH_STEPS: u32 = 25;
/// Updates of the bounds that do not improve the residual after which another start is tried.
const IDLE_UPDATES: u32 = 15;
/// Factorisations from one start.
const MAX_FACTORS: u32 = 500;
/// Residual above which the multipliers are worth nothing: no solution exists, or none was found.
const LOST: f64 = 1e-2;

/// What the methods keep between calls.
#[derive(Debug, Default)]
pub(crate) struct Driver {
    interior: Interior,
    polish: Polish,
    center: Vec<f64>,
    /// The best multipliers with bounds that agree, and their residual.
    coupled: Vec<f64>,
    coupled_residual: f64,
}

impl Driver {
    /// Improves `lambda`, which is also the start, until it solves the problem.
    pub(crate) fn solve(
        &mut self,
        space: &mut impl VelocitySpace,
        rows: &mut ExactRows,
        lambda: &mut [f64],
    ) -> Certificate {
        rows.follow(lambda);
        rows.project(lambda);
        self.polish.begin(space, rows, lambda);
        if self.polish.residual > GOAL {
            if rows.law == Law::Frozen {
                self.solve_frozen(space, rows, lambda);
            } else {
                self.solve_coupled(space, rows, lambda);
            }
        }
        let mut residual = self.polish.residual;
        if residual > LOST || residual.is_nan() {
            residual = self.fall_back(space, rows, lambda);
        }
        Certificate {
            residual,
            iterations: self.polish.factors,
            converged: residual <= CERTIFIED,
        }
    }

    /// Solves the problem with the bounds as they are.
    fn solve_frozen(
        &mut self,
        space: &mut impl VelocitySpace,
        rows: &mut ExactRows,
        lambda: &mut [f64],
    ) {
        if self.polish.residual <= GOOD_START {
            self.polish.run(space, rows, lambda, GOAL);
            lambda.copy_from_slice(&self.polish.best);
            if self.polish.residual <= CERTIFIED {
                return;
            }
        }
        self.center.clear();
        self.center.extend_from_slice(lambda);
        self.interior
            .begin(rows, &mut self.center, space.dimension());
        let mut handover = FIRST_GAP;
        for _ in 0..INTERIOR_STEPS {
            let gap = self.interior.advance(space, rows, &mut self.center);
            self.polish.factors += 1;
            self.polish.forget_factor();
            if gap.is_nan() {
                break;
            }
            if gap > handover {
                continue;
            }
            lambda.copy_from_slice(&self.center);
            rows.project(lambda);
            self.polish.run(space, rows, lambda, GOAL);
            if self.polish.residual <= CERTIFIED || gap <= LAST_GAP {
                break;
            }
            handover = NEXT_GAP * gap;
        }
        lambda.copy_from_slice(&self.polish.best);
    }

    /// Solves with friction bounds that agree with the normal multipliers, from `lambda` and, if that fails, from zero.
    fn solve_coupled(
        &mut self,
        space: &mut impl VelocitySpace,
        rows: &mut ExactRows,
        lambda: &mut [f64],
    ) {
        self.coupled.clear();
        self.coupled.extend_from_slice(lambda);
        self.coupled_residual = f64::INFINITY;
        if self.polish.residual > GOOD_START {
            self.approach_coupled(space, rows, lambda);
        }
        self.update_bounds(space, rows, lambda);
        if self.coupled_residual > CERTIFIED {
            lambda.fill(0.0);
            self.update_bounds(space, rows, lambda);
        }
        lambda.copy_from_slice(&self.coupled);
        rows.follow(lambda);
        self.polish.residual = self.coupled_residual;
    }

    /// Solves with bounds from the normal multipliers of the solution before, until they agree or it is no use.
    fn update_bounds(
        &mut self,
        space: &mut impl VelocitySpace,
        rows: &mut ExactRows,
        lambda: &mut [f64],
    ) {
        let (mut best, mut dummy) = (f64::INFINITY, 0);
        let most = self.polish.factors + MAX_FACTORS;
        while dummy < IDLE_UPDATES && self.polish.factors < most {
            rows.follow(lambda);
            rows.project(lambda);
            self.polish.restart(space, rows, lambda);
            let residual = self.polish.residual;
            if residual < self.coupled_residual {
                self.coupled_residual = residual;
                self.coupled.copy_from_slice(lambda);
            }
            if residual <= COUPLED_GOAL {
                return;
            }
            dummy = if residual < 0.99 * best { 0 } else { dummy + 1 };
            best = best.min(residual);
            let goal = GOAL.max(NEAR * NEAR * residual);
            self.polish.run(space, rows, lambda, goal);
            lambda.copy_from_slice(&self.polish.best);
            if self.polish.residual > NEAR * residual {
                self.solve_frozen(space, rows, lambda);
            }
        }
    }

    /// Interior point steps with friction bounds that follow the normal multipliers. Keeps `lambda` if that fails.
    fn approach_coupled(
        &mut self,
        space: &mut impl VelocitySpace,
        rows: &mut ExactRows,
        lambda: &mut [f64],
    ) {
        self.center.clear();
        self.center.extend_from_slice(lambda);
        self.interior
            .begin(rows, &mut self.center, space.dimension());
        for _ in 0..APPROACH_STEPS {
            let gap = self.interior.advance(space, rows, &mut self.center);
            self.interior.follow(rows, &mut self.center);
            self.polish.factors += 1;
            self.polish.forget_factor();
            if gap <= FIRST_GAP {
                lambda.copy_from_slice(&self.center);
                return;
            }
        }
    }

    /// A bounded answer that does not depend on the start, for problems without solution. Returns its residual.
    fn fall_back(
        &mut self,
        space: &mut impl VelocitySpace,
        rows: &mut ExactRows,
        lambda: &mut [f64],
    ) -> f64 {
        // Without friction first; then with bounds from the normal multipliers of the round before.
        lambda.fill(0.0);
        for _ in 0..4 {
            rows.follow(lambda);
            self.polish.stiff_springs(space, rows, lambda);
        }
        self.polish.evaluate(space, rows, lambda)
    }
}
