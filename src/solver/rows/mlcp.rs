//! The problem, and how far a vector of multipliers is from solving it.
//!
//! All constraints of a step are rows of one mixed linear complementarity problem (MLCP); today they are contacts.
//! With the Jacobian `J` (one row per constraint), the inverse mass matrix `M^-1`, the velocities `v*` that the bodies
//! would have without constraints, and the target constraint velocity `u`:
//!
//! ```text
//! A = J M^-1 J^T            effective inverse mass between rows
//! b = u - J v*              u holds the stabilisation term zeta = -beta C / h, or the rebound speed
//! w = A lambda - b          constraint velocity after the impulses lambda, less the target one
//!
//! lo <= lambda <= hi        and for each row one of
//!   w_i  = 0  and  lo_i < lambda_i < hi_i      (holding)
//!   w_i >= 0  and  lambda_i = lo_i             (separating, or sliding one way)
//!   w_i <= 0  and  lambda_i = hi_i             (sliding the other way)
//! ```
//!
//! A normal row has `lo = 0, hi = inf`, one of a bond `lo = -adhesion`; an equality row `lo = -inf, hi = inf`; a friction
//! row `-mu lambda_n` and `mu lambda_n` with the normal impulse of its point (box), or the pair of friction rows is kept in
//! the disc of that radius; a bond adds its shear strength to the radius. The bounds follow the current `lambda_n`.
//!
//! # References
//! Stewart and Trinkle 1996 and Anitescu and Potra 1997 for the velocity-level problem; Erleben, "Stable, Robust, and
//! Versatile Multibody Dynamics Animation", 2005, for the matrix form; Catto, "Iterative Dynamics with Temporal
//! Coherence", 2005, for the stabilisation term.

use glam::{DVec2, Vec2};

/// Residual of one row: `lambda - clip(lambda - w / a, lo, hi)`, times `sqrt(a)`.
///
/// `a` is the row's diagonal entry of `A`. Zero exactly at a solution. The factor makes it the mass norm of a single
/// row, so that rows of all kinds and bodies of all masses add up: unit kg^(1/2) m/s.
pub(crate) fn natural_map(lambda: f64, w: f64, a: f64, lo: f64, hi: f64) -> f64 {
    if a <= 0.0 {
        return 0.0;
    }
    (lambda - (lambda - w / a).max(lo).min(hi)) * a.sqrt()
}

/// Residual of a pair of friction rows that is kept in the disc of the given `radius`; see [`natural_map`].
///
/// The projection onto the disc is exact for equal diagonal entries, so both rows are scaled with the larger one.
pub(crate) fn natural_map_disc(lambda: DVec2, w: DVec2, a: DVec2, radius: f64) -> f64 {
    let a = a.max_element();
    if a <= 0.0 {
        return 0.0;
    }
    let moved = lambda - w / a;
    let inside = if moved.length() <= radius {
        moved
    } else {
        moved * (radius / moved.length())
    };
    (lambda - inside).length() * a.sqrt()
}

/// The point of the disc of the given radius about zero that is nearest to `lambda`.
pub(crate) fn project_to_disc(lambda: Vec2, radius: f32) -> Vec2 {
    let length_squared = lambda.length_squared();
    if length_squared <= radius * radius {
        lambda
    } else {
        lambda * (radius / length_squared.sqrt())
    }
}

/// How far a set of multipliers is from solving the problem.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Residual {
    /// Euclidean norm of the natural map in the mass norm over all rows, kg^(1/2) m/s.
    pub natural_map: f32,
    /// The same relative to the mass norm of the multipliers' own effect; 0 when there are none.
    pub relative: f32,
    /// Fastest remaining approach at a contact, beyond what its gap allows, m/s.
    pub approach_speed: f32,
    /// Bound on the root mean square error of the bodies' velocities (weighted by mass), m/s, from the duality gap; needs no
    /// reference. Holds for the friction bounds that the solved normal impulses give.
    pub velocity_error: f32,
}

/// A small problem as dense matrices, in double precision: what the tests compare the solvers with.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DenseMlcp {
    /// `A`, row by row, n x n.
    pub a: Vec<f64>,
    /// `b`, n.
    pub b: Vec<f64>,
    /// Lower bounds, n.
    pub lo: Vec<f64>,
    /// Upper bounds, n.
    pub hi: Vec<f64>,
}

impl DenseMlcp {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.b.len()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.b.is_empty()
    }

    /// `w = A lambda - b`.
    pub fn w(&self, lambda: &[f64]) -> Vec<f64> {
        let n = self.len();
        (0..n)
            .map(|i| (0..n).map(|j| self.a[i * n + j] * lambda[j]).sum::<f64>() - self.b[i])
            .collect()
    }

    /// Largest entry of the natural map `lambda - clip(lambda - w / a_ii)`, times `sqrt(a_ii)`.
    pub fn residual(&self, lambda: &[f64]) -> f64 {
        let (n, w) = (self.len(), self.w(lambda));
        (0..n)
            .map(|i| natural_map(lambda[i], w[i], self.a[i * n + i], self.lo[i], self.hi[i]).abs())
            .fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn natural_map_vanishes_exactly_at_complementary_pairs() {
        assert_eq!(natural_map(2.0, 0.0, 3.0, 0.0, f64::INFINITY), 0.0);
        assert_eq!(natural_map(0.0, 5.0, 3.0, 0.0, f64::INFINITY), 0.0);
        assert!(natural_map(0.0, -1.0, 3.0, 0.0, f64::INFINITY).abs() > 0.1);
        assert_eq!(
            natural_map_disc(
                DVec2::new(0.6, 0.8),
                DVec2::new(-0.6, -0.8),
                DVec2::ONE,
                1.0
            ),
            0.0
        );
    }

    #[test]
    fn disc_projection_keeps_direction_and_bounds_length() {
        let p = project_to_disc(Vec2::new(3.0, 4.0), 1.0);
        assert!((p - Vec2::new(0.6, 0.8)).length() < 1e-6);
        assert_eq!(
            project_to_disc(Vec2::new(0.3, 0.4), 1.0),
            Vec2::new(0.3, 0.4)
        );
        assert_eq!(project_to_disc(Vec2::ZERO, 0.0), Vec2::ZERO);
    }
}
