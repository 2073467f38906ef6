//! Bounds of the rows, the projection on them, and the residual that certifies a solution.

use crate::solver::exact::CERTIFIED;
use crate::solver::rows::mlcp::{natural_map, natural_map_disc};
use glam::DVec2;

/// How friction rows are bounded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Law {
    /// By `lo` and `hi` as given.
    #[default]
    Frozen,
    /// Each by the coefficient of friction times the normal multiplier.
    Box,
    /// Both together by the disc of that radius.
    Disc,
}

/// What the solver must know of the rows besides `A`.
#[derive(Debug, Default)]
pub(crate) struct ExactRows {
    /// Rows per contact: 3 or 2.
    pub(crate) per_contact: usize,
    pub(crate) law: Law,
    /// `-b`.
    pub(crate) free: Vec<f64>,
    /// `A_ii`.
    pub(crate) diagonal: Vec<f64>,
    /// Coefficient of friction of each contact.
    pub(crate) friction: Vec<f64>,
    /// What the friction of each contact may be beyond that times the normal multiplier, N s.
    pub(crate) cohesion: Vec<f64>,
    /// Bounds; for a disc, `hi` of both tangents is the radius.
    pub(crate) lo: Vec<f64>,
    pub(crate) hi: Vec<f64>,
    /// Square of the natural map that rounding of `b` alone may cause.
    pub(crate) floor: f64,
    /// `1 / A_ii`, or 0; the same for both rows of a disc, whose projection needs that.
    pub(crate) compliance: Vec<f64>,
}

/// Second derivative of a contact's penalty: the entries of `D` in `I + K^T D K`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Weight {
    pub(crate) normal: f64,
    /// `[t1 t1, t1 t2, t2 t2]`.
    pub(crate) tangents: [f64; 3],
}

impl Weight {
    /// Whether row `k` of the contact has no weight at all.
    pub(crate) fn is_zero(&self, k: usize) -> bool {
        let [tt, ts, ss] = self.tangents;
        match k {
            0 => self.normal == 0.0,
            1 => tt == 0.0 && ts == 0.0,
            _ => ss == 0.0 && ts == 0.0,
        }
    }

    /// Entry of the symmetric 3 x 3 matrix.
    pub(crate) fn entry(&self, i: usize, j: usize) -> f64 {
        match (i.min(j), i.max(j)) {
            (0, 0) => self.normal,
            (1, 1) => self.tangents[0],
            (1, 2) => self.tangents[1],
            (2, 2) => self.tangents[2],
            _ => 0.0,
        }
    }
}

impl ExactRows {
    /// Empties the rows for another problem.
    pub(crate) fn begin(&mut self, per_contact: usize, law: Law) {
        (self.per_contact, self.law) = (per_contact, law);
        self.floor = 0.0;
        let lists = [
            &mut self.free,
            &mut self.diagonal,
            &mut self.friction,
            &mut self.cohesion,
            &mut self.lo,
            &mut self.hi,
            &mut self.compliance,
        ];
        lists.into_iter().for_each(Vec::clear);
    }

    /// Adds a row: `free` is its entry of `-b`, a sum of terms that come to `magnitude`.
    pub(crate) fn push(&mut self, free: f64, magnitude: f64, diagonal: f64) {
        self.free.push(free);
        self.diagonal.push(diagonal);
        if diagonal > 0.0 {
            self.floor += square(f64::EPSILON * magnitude) / diagonal;
        }
    }

    /// Fills in what follows from the diagonal.
    pub(crate) fn finish(&mut self) {
        let inverse = |a: f64| if a > 0.0 { 1.0 / a } else { 0.0 };
        self.compliance
            .extend(self.diagonal.iter().map(|&a| inverse(a)));
        if self.law == Law::Disc {
            for row in self.compliance.chunks_exact_mut(self.per_contact) {
                let least = row[1].min(row[2]);
                row[1..].fill(least);
            }
        }
        if self.law != Law::Frozen {
            self.lo.resize(self.free.len(), 0.0);
            self.hi.resize(self.free.len(), f64::INFINITY);
        }
        self.cohesion.resize(self.friction.len(), 0.0);
    }

    /// Bound of a contact's friction with a normal multiplier.
    pub(crate) fn friction_bound(&self, contact: usize, normal: f64) -> f64 {
        self.friction[contact] * normal.max(0.0) + self.cohesion[contact]
    }

    /// Rows that are bounded by themselves.
    pub(crate) fn singles(&self) -> impl Iterator<Item = usize> + use<> {
        let step = if self.law == Law::Disc {
            self.per_contact
        } else {
            1
        };
        (0..self.free.len()).step_by(step)
    }

    /// The first row of each pair that is bounded by a disc.
    pub(crate) fn discs(&self) -> impl Iterator<Item = usize> + use<> {
        let end = if self.law == Law::Disc {
            self.free.len()
        } else {
            0
        };
        (1..end).step_by(self.per_contact)
    }

    /// Mean over the rows of the energy that correcting each alone would take, J.
    pub(crate) fn row_energy(&self) -> f64 {
        let rows = self.free.iter().zip(&self.compliance);
        let sum: f64 = rows
            .map(|(free, compliance)| free * free * compliance)
            .sum();
        sum / self.free.len() as f64
    }

    /// The bounds of friction follow the normal multipliers.
    pub(crate) fn follow(&mut self, lambda: &[f64]) {
        if self.law == Law::Frozen {
            return;
        }
        let d = self.per_contact;
        for c in 0..self.friction.len() {
            let bound = self.friction_bound(c, lambda[c * d]);
            self.lo[c * d + 1..(c + 1) * d].fill(-bound);
            self.hi[c * d + 1..(c + 1) * d].fill(bound);
        }
    }

    /// Moves `wish` to the nearest point within the bounds.
    pub(crate) fn project(&self, wish: &mut [f64]) {
        for (c, wish) in wish.chunks_exact_mut(self.per_contact).enumerate() {
            let first = c * self.per_contact;
            wish[0] = wish[0].max(self.lo[first]).min(self.hi[first]);
            if self.law == Law::Disc {
                let factor = shrink(wish[1], wish[2], self.hi[first + 1]);
                wish[1..].iter_mut().for_each(|x| *x *= factor);
                continue;
            }
            for (k, wish) in wish.iter_mut().enumerate().skip(1) {
                *wish = wish.max(self.lo[first + k]).min(self.hi[first + k]);
            }
        }
    }

    /// Generalised derivative of the projection at `wish`, times the penalty `rho / A_ii`.
    pub(crate) fn weight(&self, c: usize, wish: &[f64], rho: f64) -> Weight {
        let first = c * self.per_contact;
        let inside = |k: usize| {
            let i = first + k;
            let free = wish[k] > self.lo[i] && wish[k] < self.hi[i];
            if free { rho * self.compliance[i] } else { 0.0 }
        };
        let mut weight = Weight {
            normal: inside(0),
            tangents: [0.0; 3],
        };
        if self.law == Law::Disc {
            weight.tangents = self.disc_weight(first, wish, rho);
        } else {
            weight.tangents[0] = inside(1);
            if self.per_contact == 3 {
                weight.tangents[2] = inside(2);
            }
        }
        weight
    }

    /// `rho / A (r / |t|) (I - t t^T / |t|^2)` outside the disc of radius `r`, `rho / A I` within.
    fn disc_weight(&self, first: usize, wish: &[f64], rho: f64) -> [f64; 3] {
        let (x, y, radius) = (wish[1], wish[2], self.hi[first + 1]);
        let rho = rho * self.compliance[first + 1];
        if radius <= 0.0 {
            return [0.0; 3];
        }
        let factor = shrink(x, y, radius);
        if factor >= 1.0 {
            return [rho, 0.0, rho];
        }
        let scale = rho * factor / (x * x + y * y);
        [scale * y * y, -scale * x * y, scale * x * x]
    }

    /// Natural map relative to the energy norm of `lambda`, or to that norm at which rounding is 1e-10 of it.
    pub(crate) fn residual(&self, lambda: &[f64], w: &[f64], energy_norm: f64) -> f64 {
        let error = self.natural_map(lambda, w);
        if error == 0.0 {
            return 0.0;
        }
        error / energy_norm.max(self.floor.sqrt() / CERTIFIED)
    }

    /// Euclidean norm of the natural map in the mass norm; see [`natural_map`].
    fn natural_map(&self, lambda: &[f64], w: &[f64]) -> f64 {
        let d = self.per_contact;
        let row = |i: usize| natural_map(lambda[i], w[i], self.diagonal[i], self.lo[i], self.hi[i]);
        let pair = |i: usize, x: &[f64]| DVec2::new(x[i], x[i + 1]);
        let mut sum = 0.0;
        for first in (0..lambda.len()).step_by(d) {
            sum += square(row(first));
            if self.law == Law::Disc {
                let i = first + 1;
                let a = pair(i, &self.diagonal);
                let r = natural_map_disc(pair(i, lambda), pair(i, w), a, self.hi[i]);
                sum += square(r);
            } else {
                sum += (first + 1..first + d).map(|i| square(row(i))).sum::<f64>();
            }
        }
        sum.sqrt()
    }
}

fn square(x: f64) -> f64 {
    x * x
}

/// By what the vector `(x, y)` must be multiplied to lie in the disc of the given radius.
fn shrink(x: f64, y: f64, radius: f64) -> f64 {
    let length = (x * x + y * y).sqrt();
    if length > radius {
        radius / length
    } else {
        1.0
    }
}
