//! Velocity space of a problem that is given as a matrix: `A = K K^T` by Cholesky with pivots.

use crate::solver::exact::rows::Weight;
use crate::solver::exact::velocity::VelocitySpace;

/// Share of the scaled diagonal below which what is left of `A` counts as rounding.
const RANK_TOLERANCE: f64 = 1e-14;

/// `A`, its factor `K` (as many columns as its rank) and the factor of `I + K^T D K`.
#[derive(Debug)]
pub(crate) struct DenseSpace<'a> {
    a: &'a [f64],
    rows_per_contact: usize,
    rank: usize,
    /// `K`, row by row.
    k: Vec<f64>,
    /// Lower triangle of `I + K^T D K`, column by column; then of its factor.
    h: Vec<f64>,
}

impl<'a> DenseSpace<'a> {
    pub(crate) fn new(a: &'a [f64], rows: usize, rows_per_contact: usize) -> Self {
        let columns = pivoted_cholesky(a, rows);
        let rank = columns.len();
        let mut k = vec![0.0; rows * rank];
        for (j, column) in columns.iter().enumerate() {
            (0..rows).for_each(|i| k[i * rank + j] = column[i]);
        }
        Self {
            a,
            rows_per_contact,
            rank,
            k,
            h: vec![0.0; rank * rank],
        }
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.k[i * self.rank..][..self.rank]
    }
}

/// Columns of `K` with `K K^T = A` up to rounding, by the largest diagonal entry of the scaled matrix that is left.
fn pivoted_cholesky(a: &[f64], n: usize) -> Vec<Vec<f64>> {
    let scale: Vec<f64> = (0..n).map(|i| a[i * n + i].max(0.0).sqrt()).collect();
    let mut left: Vec<f64> = scale.iter().map(|s| f64::from(*s > 0.0)).collect();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for _ in 0..n {
        let pivot = (0..n).fold(0, |best, i| if left[i] > left[best] { i } else { best });
        if left[pivot] <= RANK_TOLERANCE {
            break;
        }
        let root = left[pivot].sqrt() * scale[pivot];
        let mut column: Vec<f64> = (0..n).map(|i| a[pivot * n + i]).collect();
        for earlier in &columns {
            let factor = earlier[pivot];
            (0..n).for_each(|i| column[i] -= earlier[i] * factor);
        }
        for i in 0..n {
            column[i] /= root;
            if left[i] > 0.0 {
                let share = column[i] / scale[i];
                left[i] -= share * share;
            }
        }
        left[pivot] = 0.0;
        columns.push(column);
    }
    columns
}

impl VelocitySpace for DenseSpace<'_> {
    fn dimension(&self) -> usize {
        self.rank
    }

    fn velocities(&self, y: &[f64], out: &mut [f64]) {
        for (i, value) in out.iter_mut().enumerate() {
            *value = self.row(i).iter().zip(y).map(|(k, y)| k * y).sum();
        }
    }

    fn impulses(&self, lambda: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for (i, multiplier) in lambda.iter().enumerate() {
            add_scaled(out, self.row(i), *multiplier);
        }
    }

    fn effect(&self, lambda: &[f64], y: &mut [f64], out: &mut [f64]) {
        self.impulses(lambda, y);
        for (row, value) in self.a.chunks_exact(lambda.len()).zip(out) {
            *value = row.iter().zip(lambda).map(|(a, l)| a * l).sum();
        }
    }

    fn factor(&mut self, weights: &[Weight]) {
        let (rank, dim) = (self.rank, self.rows_per_contact);
        self.h.fill(0.0);
        (0..rank).for_each(|i| self.h[i * rank + i] = 1.0);
        let mut combined = vec![0.0; rank];
        for (c, weight) in weights.iter().enumerate() {
            for k in (0..dim).filter(|&k| !weight.is_zero(k)) {
                combined.fill(0.0);
                for other in 0..dim {
                    let row = &self.k[(c * dim + other) * rank..][..rank];
                    add_scaled(&mut combined, row, weight.entry(k, other));
                }
                let row = &self.k[(c * dim + k) * rank..][..rank];
                for j in 0..rank {
                    add_scaled(
                        &mut self.h[j * rank + j..(j + 1) * rank],
                        &row[j..],
                        combined[j],
                    );
                }
            }
        }
        factor_in_place(&mut self.h, rank);
    }

    fn solve(&self, x: &mut [f64]) {
        let n = self.rank;
        for j in 0..n {
            let column = &self.h[j * n..(j + 1) * n];
            x[j] /= column[j];
            let value = x[j];
            add_scaled(&mut x[j + 1..], &column[j + 1..], -value);
        }
        for j in (0..n).rev() {
            let column = &self.h[j * n..(j + 1) * n];
            let below: f64 = column[j + 1..]
                .iter()
                .zip(&x[j + 1..])
                .map(|(l, x)| l * x)
                .sum();
            x[j] = (x[j] - below) / column[j];
        }
    }
}

/// Cholesky factor of the lower triangle, column by column; pivots are at least 1 but for rounding.
fn factor_in_place(h: &mut [f64], n: usize) {
    for j in 0..n {
        let (done, rest) = h.split_at_mut(j * n);
        let column = &mut rest[j..n];
        for earlier in done.chunks_exact(n) {
            add_scaled(column, &earlier[j..], -earlier[j]);
        }
        let root = column[0].max(1.0).sqrt();
        column[0] = root;
        column[1..].iter_mut().for_each(|x| *x /= root);
    }
}

fn add_scaled(out: &mut [f64], x: &[f64], factor: f64) {
    if factor != 0.0 {
        out.iter_mut().zip(x).for_each(|(o, x)| *o += x * factor);
    }
}
