//! Proximal multiplier iteration; each of its problems is solved by a semismooth Newton method on velocities.
//!
//! Around the multipliers `lambda` found so far, with `w` their constraint velocities, the next ones are
//!
//! ```text
//! lambda+ = P(lambda - R (w + K y)),   R = rho / A_ii on the diagonal, P the projection on the bounds
//! ```
//!
//! where the velocity change `y` minimises the convex, once differentiable function whose gradient is
//!
//! ```text
//! g(y) = y - K^T (lambda+ - lambda)
//! H(y) = I + K^T D K               D = R times a generalised derivative of P
//! ```
//!
//! Newton's method with line search finds it in finitely many steps when the bounds are boxes, since the function is
//! piecewise quadratic then. `H` is never smaller than the identity, whatever is redundant among the rows. Only
//! corrections go through the factor of `H`: `w` comes from the multipliers by multiplication alone, so the last digits
//! do not suffer from a large `rho`.
//!
//! Near the solution one or two factorisations are enough; far from it the set of free rows changes too often, and the
//! [interior point method](crate::solver::exact::interior) is several times faster.
//!
//! # References
//! Rockafellar, "Augmented Lagrangians and Applications of the Proximal Point Algorithm in Convex Programming", 1976;
//! Qi and Sun, "A Nonsmooth Version of Newton's Method", 1993; Alart and Curnier, "A Mixed Formulation for Frictional
//! Contact Problems Prone to Newton like Solution Methods", 1991.

use crate::solver::exact::rows::{ExactRows, Weight};
use crate::solver::exact::velocity::{VelocitySpace, add, dot, zeros};

/// Ratio of penalty to effective mass that a polish starts with.
const RHO_START: f64 = 1e4;
/// Factor between one update of the multipliers and the next.
const RHO_GROWTH: f64 = 100.0;
/// Largest ratio. The factor of `H` keeps five digits then, which is enough for corrections; with 1e12 size mixes of
/// 1 : 100 in length no longer converge, with 1e10 they take twice as long.
const RHO_MAX: f64 = 3e10;
/// Newton steps for one update of the multipliers.
const NEWTON_STEPS: u32 = 5;
/// Gradient, relative to the velocity change, at which the multipliers are updated.
const GRADIENT: f64 = 0.1;
/// Updates of one polish.
const UPDATES: u32 = 40;
/// An update must bring the residual below this share of the last one, once `rho` is as large as it gets.
const PAYS: f64 = 0.95;
/// A polish that makes the residual this many times worse has started too far from the solution.
const HOPELESS: f64 = 10.0;

/// State of the iteration: the best multipliers so far and buffers.
#[derive(Debug, Default)]
pub(crate) struct Polish {
    /// The best multipliers so far.
    pub(crate) best: Vec<f64>,
    /// Their residual.
    pub(crate) residual: f64,
    /// Factorisations made.
    pub(crate) factors: u32,
    /// `A lambda - b`.
    w: Vec<f64>,
    /// `K^T lambda`.
    impulse: Vec<f64>,
    y: Vec<f64>,
    step: Vec<f64>,
    gradient: Vec<f64>,
    /// `K y`.
    moved: Vec<f64>,
    /// `K step`.
    ahead: Vec<f64>,
    /// `lambda+`.
    next: Vec<f64>,
    change: Vec<f64>,
    weights: Vec<Weight>,
    /// What the factor at hand belongs to; empty if to something else.
    factored: Vec<Weight>,
}

impl Polish {
    /// Takes over another problem with `lambda` as its best multipliers.
    pub(crate) fn begin(&mut self, space: &impl VelocitySpace, rows: &ExactRows, lambda: &[f64]) {
        let (n, dimension) = (lambda.len(), space.dimension());
        [&mut self.w, &mut self.moved, &mut self.ahead]
            .into_iter()
            .for_each(|list| zeros(list, n));
        [&mut self.next, &mut self.change]
            .into_iter()
            .for_each(|list| zeros(list, n));
        [&mut self.impulse, &mut self.y]
            .into_iter()
            .for_each(|list| zeros(list, dimension));
        [&mut self.step, &mut self.gradient]
            .into_iter()
            .for_each(|list| zeros(list, dimension));
        self.factors = 0;
        // The factor of another problem would do, nearly: but the result must not depend on what was solved before.
        self.forget_factor();
        self.restart(space, rows, lambda);
    }

    /// Makes `lambda` the best multipliers, whatever was there before; the bounds may have changed.
    pub(crate) fn restart(&mut self, space: &impl VelocitySpace, rows: &ExactRows, lambda: &[f64]) {
        self.best.clear();
        self.best.extend_from_slice(lambda);
        self.residual = self.evaluate(space, rows, lambda);
    }

    /// The factor in the space is no longer ours.
    pub(crate) fn forget_factor(&mut self) {
        self.factored.clear();
    }

    /// Residual of `lambda` relative to the mass norm of what it does; refreshes `w`.
    pub(crate) fn evaluate(
        &mut self,
        space: &impl VelocitySpace,
        rows: &ExactRows,
        lambda: &[f64],
    ) -> f64 {
        space.effect(lambda, &mut self.impulse, &mut self.w);
        add(&mut self.w, 1.0, &rows.free);
        rows.residual(lambda, &self.w, dot(&self.impulse, &self.impulse).sqrt())
    }

    /// Updates the multipliers, starting from `lambda`, for as long as it pays and the residual is above `goal`.
    pub(crate) fn run(
        &mut self,
        space: &mut impl VelocitySpace,
        rows: &ExactRows,
        lambda: &mut [f64],
        goal: f64,
    ) {
        let mut rho = RHO_START;
        let mut last = self.evaluate(space, rows, lambda);
        for _ in 0..UPDATES {
            self.minimise(space, rows, lambda, rho, NEWTON_STEPS);
            lambda.copy_from_slice(&self.next);
            let residual = self.evaluate(space, rows, lambda);
            if residual < self.residual {
                self.residual = residual;
                self.best.copy_from_slice(lambda);
            }
            let dummy = rho >= RHO_MAX && residual > PAYS * last;
            let hopeless = residual > HOPELESS * last || residual.is_nan();
            if residual <= goal || dummy || hopeless {
                return;
            }
            last = residual;
            rho = f64::min(rho * RHO_GROWTH, RHO_MAX);
        }
    }

    /// What rows as stiff as `rho / A_ii` do from no impulse at all: bounded, even where no solution exists.
    pub(crate) fn stiff_springs(
        &mut self,
        space: &mut impl VelocitySpace,
        rows: &ExactRows,
        lambda: &mut [f64],
    ) {
        lambda.fill(0.0);
        self.w.copy_from_slice(&rows.free);
        self.minimise(space, rows, lambda, RHO_START, UPDATES);
        lambda.copy_from_slice(&self.next);
    }

    /// Newton's method for the velocity change `y`; leaves `lambda+` in `next`.
    fn minimise(
        &mut self,
        space: &mut impl VelocitySpace,
        rows: &ExactRows,
        lambda: &[f64],
        rho: f64,
        steps: u32,
    ) {
        self.y.fill(0.0);
        self.moved.fill(0.0);
        for step in 0..=steps {
            self.refresh(space, rows, lambda, rho);
            let square = |x: &[f64]| dot(x, x);
            let small = square(&self.gradient) <= GRADIENT * GRADIENT * square(&self.y);
            if step > 0 && small || step == steps {
                return;
            }
            if self.weights != self.factored {
                space.factor(&self.weights);
                self.factors += 1;
                std::mem::swap(&mut self.weights, &mut self.factored);
            }
            for (step, g) in self.step.iter_mut().zip(&self.gradient) {
                *step = -g;
            }
            space.solve(&mut self.step);
            space.velocities(&self.step, &mut self.ahead);
            let alpha = self.line_search(rows, lambda, rho);
            add(&mut self.y, alpha, &self.step);
            add(&mut self.moved, alpha, &self.ahead);
        }
    }

    /// `lambda+`, `D` and the gradient at `y`.
    fn refresh(&mut self, space: &impl VelocitySpace, rows: &ExactRows, lambda: &[f64], rho: f64) {
        for (i, wish) in self.next.iter_mut().enumerate() {
            *wish = lambda[i] - rho * rows.compliance[i] * (self.w[i] + self.moved[i]);
        }
        self.weights.clear();
        let contacts = self.next.chunks_exact(rows.per_contact).enumerate();
        self.weights
            .extend(contacts.map(|(c, wish)| rows.weight(c, wish, rho)));
        rows.project(&mut self.next);
        for ((change, next), old) in self.change.iter_mut().zip(&self.next).zip(lambda) {
            *change = next - old;
        }
        space.impulses(&self.change, &mut self.gradient);
        for (g, y) in self.gradient.iter_mut().zip(&self.y) {
            *g = y - *g;
        }
    }

    /// How far to go along `step`: near to where the derivative of the convex function changes its sign, at most 1.
    fn line_search(&mut self, rows: &ExactRows, lambda: &[f64], rho: f64) -> f64 {
        let at_start = dot(&self.step, &self.gradient);
        let (along, square) = (dot(&self.step, &self.y), dot(&self.step, &self.step));
        let mut derivative = |alpha: f64| {
            for (i, wish) in self.change.iter_mut().enumerate() {
                let w = self.w[i] + self.moved[i] + alpha * self.ahead[i];
                *wish = lambda[i] - rho * rows.compliance[i] * w;
            }
            rows.project(&mut self.change);
            let rows = self.ahead.iter().zip(self.change.iter().zip(lambda));
            let work: f64 = rows.map(|(ahead, (next, old))| ahead * (next - old)).sum();
            along + alpha * square - work
        };
        let at_end = derivative(1.0);
        let close = 0.01 * at_start.abs();
        if at_end <= close {
            return 1.0;
        }
        find_sign_change(derivative, at_start, at_end, close)
    }
}

/// Where in 0..1 an increasing function is within `close` of zero: regula falsi, kept away from the ends.
fn find_sign_change(mut f: impl FnMut(f64) -> f64, at_start: f64, at_end: f64, close: f64) -> f64 {
    let (mut low, mut high) = ((0.0, at_start), (1.0, at_end));
    for _ in 0..40 {
        let share = (low.1 / (low.1 - high.1)).clamp(0.05, 0.95);
        let middle = low.0 + share * (high.0 - low.0);
        let value = f(middle);
        if value.abs() <= close {
            return middle;
        }
        if value < 0.0 {
            low = (middle, value);
        } else {
            high = (middle, value);
        }
    }
    low.0
}
