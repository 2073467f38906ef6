//! What the solver needs of the bodies: the map between multipliers and velocities, and one family of linear systems.

use crate::solver::exact::rows::Weight;

/// The velocities that rows act on, in coordinates `y` in which the mass matrix is the identity: `A = K K^T`.
pub(crate) trait VelocitySpace {
    /// Number of velocity coordinates.
    fn dimension(&self) -> usize;
    /// `out = K y`.
    fn velocities(&self, y: &[f64], out: &mut [f64]);
    /// `out = K^T lambda`.
    fn impulses(&self, lambda: &[f64], out: &mut [f64]);
    /// `y = K^T lambda` and `out = A lambda`.
    fn effect(&self, lambda: &[f64], y: &mut [f64], out: &mut [f64]) {
        self.impulses(lambda, y);
        self.velocities(y, out);
    }
    /// Factors `I + K^T D K`.
    fn factor(&mut self, weights: &[Weight]);
    /// `x <- (I + K^T D K)^-1 x`.
    fn solve(&self, x: &mut [f64]);
}

pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(a, b)| a * b).sum()
}

/// `x += factor y`.
pub(crate) fn add(x: &mut [f64], factor: f64, y: &[f64]) {
    x.iter_mut().zip(y).for_each(|(x, y)| *x += factor * y);
}

/// Makes `list` hold `n` zeros.
pub(crate) fn zeros(list: &mut Vec<f64>, n: usize) {
    list.clear();
    list.resize(n, 0.0);
}
