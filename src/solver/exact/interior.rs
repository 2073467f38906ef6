//! Interior point method: from any start to near the solution in about ten factorisations.
//!
//! For rows with `lo <= lambda <= hi`, distances `p = lambda - lo`, `q = hi - lambda` and multipliers `s, u >= 0` of the
//! two bounds:
//!
//! ```text
//! A lambda - b - s + u = 0,   p s = mu,   q u = mu
//! ```
//!
//! and for a pair of friction rows in the disc of radius `r`, with one multiplier `z >= 0`:
//!
//! ```text
//! A lambda - b + z lambda = 0,   z h = mu,   h = (r^2 - |lambda|^2) / 2
//! ```
//!
//! Newton's method on these equations while `mu` goes to zero, with Mehrotra's predictor and corrector. Each step solves
//! `(Sigma + A) x = c` with
//!
//! ```text
//! Sigma = s / p + u / q   of a row,     Sigma = z I + (z / h) lambda lambda^T   of a disc
//! ```
//!
//! which is done on velocities: with `D = Sigma^-1`, `x = D (c - K (I + K^T D K)^-1 K^T D c)`.
//!
//! # References
//! Mehrotra, "On the Implementation of a Primal-Dual Interior Point Method", SIAM J. Optim. 2(4), 1992; Nocedal and
//! Wright, "Numerical Optimization", 2006, chapter 16.6.

use crate::solver::exact::rows::{ExactRows, Law, Weight};
use crate::solver::exact::velocity::{VelocitySpace, add, dot, zeros};

/// Largest `D` in units of effective masses, so that enough digits are left in the linear systems.
const STIFFEST: f64 = 1e9;
/// Share of the way to the nearest bound that a step may go.
const TO_BOUND: f64 = 0.99;
/// Share of half the width of its bounds by which a row is inside them at the start.
const START_MARGIN: f64 = 0.1;
/// Least share of `mu` that a step aims at.
const MIN_CENTRING: f64 = 1e-6;

/// Distances, multipliers and the direction of the step.
#[derive(Debug, Default)]
pub(crate) struct Interior {
    /// Distance to the lower bound, 0 where the two bounds are one; `h` in the first row of a disc.
    p: Vec<f64>,
    /// Distance to the upper bound, 0 where there is none.
    q: Vec<f64>,
    /// Multiplier of the lower bound; `z` in the first row of a disc.
    s: Vec<f64>,
    /// Multiplier of the upper bound.
    u: Vec<f64>,
    step: Vec<f64>,
    step_s: Vec<f64>,
    step_u: Vec<f64>,
    /// Products of the predictor's changes: what the corrector makes up for.
    second_p: Vec<f64>,
    second_q: Vec<f64>,
    w: Vec<f64>,
    y: Vec<f64>,
    right: Vec<f64>,
    moved: Vec<f64>,
    weights: Vec<Weight>,
}

impl Interior {
    /// Starts near `lambda`, which is moved inside its bounds. `dimension`: number of velocity coordinates.
    pub(crate) fn begin(&mut self, rows: &ExactRows, lambda: &mut [f64], dimension: usize) {
        for list in [
            &mut self.p,
            &mut self.q,
            &mut self.s,
            &mut self.u,
            &mut self.step,
            &mut self.step_s,
            &mut self.step_u,
            &mut self.second_p,
            &mut self.second_q,
            &mut self.w,
            &mut self.right,
            &mut self.moved,
        ] {
            zeros(list, lambda.len());
        }
        zeros(&mut self.y, dimension);
        let mu = rows.row_energy();
        for i in rows.singles() {
            self.start_row(rows, lambda, i, mu);
        }
        for i in rows.discs() {
            let radius = rows.hi[i];
            let limit = (1.0 - START_MARGIN) * radius;
            let length = (lambda[i] * lambda[i] + lambda[i + 1] * lambda[i + 1]).sqrt();
            if length > limit {
                lambda[i] *= limit / length;
                lambda[i + 1] *= limit / length;
            }
            self.p[i] = disc_slack(radius, lambda[i], lambda[i + 1]);
            self.s[i] = over(mu, self.p[i]);
        }
    }

    /// A row is as far inside as an impulse of mean energy, or a share of the width between its bounds.
    fn start_row(&mut self, rows: &ExactRows, lambda: &mut [f64], i: usize, mu: f64) {
        let (lo, hi) = (rows.lo[i], rows.hi[i]);
        let margin = (mu * rows.compliance[i])
            .sqrt()
            .min(0.5 * START_MARGIN * (hi - lo));
        lambda[i] = lambda[i].max(lo + margin).min(hi - margin);
        if rows.diagonal[i] > 0.0 && hi > lo {
            self.p[i] = lambda[i] - lo;
            self.s[i] = over(mu, self.p[i]);
            if hi.is_finite() {
                self.q[i] = hi - lambda[i];
                self.u[i] = over(mu, self.q[i]);
            }
        }
    }

    /// One step of predictor and corrector. Returns the complementarity gap after it, relative to the energy.
    pub(crate) fn advance(
        &mut self,
        space: &mut impl VelocitySpace,
        rows: &ExactRows,
        lambda: &mut [f64],
    ) -> f64 {
        space.effect(lambda, &mut self.y, &mut self.w);
        add(&mut self.w, 1.0, &rows.free);
        self.set_weights(rows, lambda);
        space.factor(&self.weights);
        [&mut self.second_p, &mut self.second_q]
            .into_iter()
            .for_each(|list| list.fill(0.0));
        let (gap, count) = self.gap(rows, lambda, 0.0);
        self.find_step(space, rows, lambda, 0.0);
        let share = self.gap(rows, lambda, self.step_length(rows, lambda)).0 / gap;
        let centering = (share * share * share).clamp(MIN_CENTRING, 1.0);
        self.note_second_order(rows, lambda);
        self.find_step(space, rows, lambda, centering * gap / count);
        let length = self.step_length(rows, lambda);
        self.move_by(rows, lambda, length);
        space.impulses(lambda, &mut self.y);
        let least = 1e-8 * lambda.len() as f64 * rows.row_energy();
        self.gap(rows, lambda, 0.0).0 / dot(&self.y, &self.y).max(least)
    }

    /// Sum and number of the complementarity products after going `length` along the step.
    fn gap(&self, rows: &ExactRows, lambda: &[f64], length: f64) -> (f64, f64) {
        let (mut sum, mut count) = (0.0, 0.0);
        for i in rows.singles() {
            let change = length * self.step[i];
            if self.p[i] > 0.0 {
                sum += (self.p[i] + change) * (self.s[i] + length * self.step_s[i]);
                count += 1.0;
            }
            if self.q[i] > 0.0 {
                sum += (self.q[i] - change) * (self.u[i] + length * self.step_u[i]);
                count += 1.0;
            }
        }
        for i in rows.discs().filter(|&i| self.p[i] > 0.0) {
            let [x, y] = [i, i + 1].map(|k| lambda[k] + length * self.step[k]);
            sum += disc_slack(rows.hi[i], x, y) * (self.s[i] + length * self.step_s[i]);
            count += 1.0;
        }
        (sum, count)
    }

    /// `D = Sigma^-1`, no larger than [`STIFFEST`] allows.
    fn set_weights(&mut self, rows: &ExactRows, lambda: &[f64]) {
        let single = |i: usize| {
            let sigma = over(self.s[i], self.p[i]) + over(self.u[i], self.q[i]);
            over(1.0, sigma + rows.diagonal[i] / STIFFEST)
        };
        let disc = |i: usize| {
            let (x, y) = (lambda[i], lambda[i + 1]);
            let z = self.s[i] + over(1.0, STIFFEST * rows.compliance[i]);
            let k = over(self.s[i], self.p[i]);
            let determinant = z * (z + k * (x * x + y * y));
            [z + k * y * y, -k * x * y, z + k * x * x].map(|entry| over(entry, determinant))
        };
        let active = |i: usize| self.p[i] > 0.0;
        self.weights.clear();
        for first in (0..lambda.len()).step_by(rows.per_contact) {
            let mut weight = Weight::default();
            if active(first) {
                weight.normal = single(first);
            }
            if rows.law == Law::Disc {
                if active(first + 1) {
                    weight.tangents = disc(first + 1);
                }
            } else {
                for k in (1..rows.per_contact).filter(|k| active(first + k)) {
                    weight.tangents[2 * (k - 1)] = single(first + k);
                }
            }
            self.weights.push(weight);
        }
    }

    /// The step that aims at complementarity products of `mu`.
    fn find_step(&mut self, space: &impl VelocitySpace, rows: &ExactRows, lambda: &[f64], mu: f64) {
        for i in rows.singles() {
            let lower = over(mu - self.second_p[i], self.p[i]);
            let upper = over(mu - self.second_q[i], self.q[i]);
            self.right[i] = lower - upper - self.w[i];
        }
        for i in rows.discs() {
            let z = over(mu - self.second_p[i], self.p[i]);
            for k in [i, i + 1] {
                self.right[k] = -self.w[k] - lambda[k] * z;
            }
        }
        self.solve_system(space, rows.per_contact);
        for i in rows.singles() {
            let lower = mu - self.second_p[i] - self.s[i] * self.step[i];
            let upper = mu - self.second_q[i] + self.u[i] * self.step[i];
            self.step_s[i] = over(lower, self.p[i]) - self.s[i];
            self.step_u[i] = over(upper, self.q[i]) - self.u[i];
        }
        for i in rows.discs() {
            let along = lambda[i] * self.step[i] + lambda[i + 1] * self.step[i + 1];
            let product = mu - self.second_p[i] + self.s[i] * along;
            self.step_s[i] = over(product, self.p[i]) - self.s[i];
        }
    }

    /// `step = (Sigma + A)^-1 right`.
    fn solve_system(&mut self, space: &impl VelocitySpace, per_contact: usize) {
        weigh(&self.weights, per_contact, &self.right, &mut self.step);
        space.impulses(&self.step, &mut self.y);
        space.solve(&mut self.y);
        space.velocities(&self.y, &mut self.moved);
        add(&mut self.right, -1.0, &self.moved);
        weigh(&self.weights, per_contact, &self.right, &mut self.step);
    }

    fn note_second_order(&mut self, rows: &ExactRows, lambda: &[f64]) {
        for i in rows.singles() {
            self.second_p[i] = self.step[i] * self.step_s[i];
            self.second_q[i] = -self.step[i] * self.step_u[i];
        }
        for i in rows.discs() {
            let along = lambda[i] * self.step[i] + lambda[i + 1] * self.step[i + 1];
            self.second_p[i] = -along * self.step_s[i];
        }
    }

    /// How far the step may go, at most 1.
    fn step_length(&self, rows: &ExactRows, lambda: &[f64]) -> f64 {
        let mut length: f64 = 1.0 / TO_BOUND;
        let mut keep_positive = |value: f64, change: f64| {
            if value > 0.0 && change < 0.0 {
                length = length.min(-value / change);
            }
        };
        for i in rows.singles() {
            keep_positive(self.p[i], self.step[i]);
            keep_positive(self.s[i], self.step_s[i]);
            keep_positive(self.q[i], -self.step[i]);
            keep_positive(self.u[i], self.step_u[i]);
        }
        for i in rows.discs() {
            keep_positive(self.s[i], self.step_s[i]);
            let (x, y, dx, dy) = (lambda[i], lambda[i + 1], self.step[i], self.step[i + 1]);
            let along = x * dx + y * dy;
            let square = dx * dx + dy * dy;
            // 2 h = 2 t along + t^2 square, in the form that does not cancel.
            let root = (along * along + 2.0 * square * self.p[i]).max(0.0).sqrt();
            let to_edge = if along > 0.0 {
                over(2.0 * self.p[i], along + root)
            } else {
                over(root - along, square)
            };
            keep_positive(to_edge, -1.0);
        }
        length * TO_BOUND
    }

    fn move_by(&mut self, rows: &ExactRows, lambda: &mut [f64], length: f64) {
        for i in rows.singles() {
            if self.p[i] <= 0.0 {
                continue;
            }
            let change = length * self.step[i];
            lambda[i] += change;
            self.p[i] += change;
            if self.q[i] > 0.0 {
                self.q[i] -= change;
            }
        }
        for i in rows.discs() {
            if self.p[i] <= 0.0 {
                continue;
            }
            lambda[i] += length * self.step[i];
            lambda[i + 1] += length * self.step[i + 1];
            self.p[i] = disc_slack(rows.hi[i], lambda[i], lambda[i + 1]);
        }
        add(&mut self.s, length, &self.step_s);
        add(&mut self.u, length, &self.step_u);
    }

    /// Takes the friction bounds from the normal multipliers, and scales the friction multipliers with them, so that they
    /// stay as far inside as they were. For coupled rows, after each step.
    pub(crate) fn follow(&mut self, rows: &mut ExactRows, lambda: &mut [f64]) {
        let d = rows.per_contact;
        for c in 0..rows.friction.len() {
            let (first, tangents) = (c * d, c * d + 1..(c + 1) * d);
            let bound = rows.friction_bound(c, lambda[first]);
            let share = over(bound, rows.hi[first + 1]);
            // The slack of a disc is an area.
            let of_slack = if rows.law == Law::Disc { share } else { 1.0 };
            for i in tangents {
                rows.lo[i] = -bound;
                rows.hi[i] = bound;
                lambda[i] *= share;
                self.p[i] *= share * of_slack;
                self.q[i] *= share;
            }
        }
    }
}

/// `h = (r^2 - |lambda|^2) / 2`.
fn disc_slack(radius: f64, x: f64, y: f64) -> f64 {
    0.5 * (radius * radius - x * x - y * y)
}

/// `x / y`, or 0 where there is no bound.
fn over(x: f64, y: f64) -> f64 {
    if y > 0.0 { x / y } else { 0.0 }
}

/// `out = D x`.
fn weigh(weights: &[Weight], per_contact: usize, x: &[f64], out: &mut [f64]) {
    let contacts = x
        .chunks_exact(per_contact)
        .zip(out.chunks_exact_mut(per_contact));
    for (weight, (x, out)) in weights.iter().zip(contacts) {
        for (i, out) in out.iter_mut().enumerate() {
            *out = (0..per_contact).map(|j| weight.entry(i, j) * x[j]).sum();
        }
    }
}
