//! How far the solved rows are from solving the problem, and what that means for the velocities.
//!
//! The natural map vanishes exactly at solutions but can be small far away from one. The duality gap of the problem with the
//! friction bounds as they stand bounds the velocity error without knowing the solution: with `f(lambda) = lambda^T A lambda / 2
//! - b^T lambda`,
//!
//! ```text
//! |v - v*|_M^2 / 2 <= f(lambda) - f(lambda*) <= gap = sum_i max(w_i, 0) (lambda_i - lo_i) + max(-w_i, 0) (hi_i - lambda_i)
//! ```
//!
//! A normal row has no upper bound; `hi` is a cap on what any solution could need there.

use crate::bodies::solver_body::SolverBody;
use crate::solver::config::FrictionModel;
use crate::solver::rows::contact_rows::{PointRows, Row};
use crate::solver::rows::mlcp;
use crate::solver::rows::mlcp::Residual;
use crate::solver::rows::soft_step;
use glam::DVec2;

/// Which problem the rows were solved for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Solved {
    /// Shape of the friction bound.
    pub friction: FrictionModel,
    /// Whether the last sweep was one without position bias.
    pub is_relaxed: bool,
}

/// Sums over rows, to be added up over islands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ResidualSum {
    /// Square of the natural map, kg m2/s2.
    natural_map: f64,
    /// `sum lambda_i^2 A_ii`, kg m2/s2.
    scale: f64,
    /// Duality gap, J.
    gap: f64,
    /// Mass of the bodies, kg.
    mass: f64,
    /// Fastest approach, m/s.
    approach: f64,
}

/// A row of another kind than those of contacts, solved.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SolvedRow {
    /// N s, or N m s.
    pub impulse: f64,
    /// How much its velocity is above what it should be with the impulse, m/s or rad/s.
    pub velocity_error: f64,
    /// Velocity that an impulse of one gives, 1/kg.
    pub diagonal: f64,
    /// Of the impulse.
    pub bounds: [f64; 2],
}

impl ResidualSum {
    /// Adds rows of the same island that are no contacts.
    pub(crate) fn add_rows(&mut self, rows: impl Iterator<Item = SolvedRow> + Clone) {
        // As for contacts: no row needs more than all carry together.
        let cap: f64 = rows.clone().map(|row| row.impulse.abs()).sum();
        for row in rows {
            let (impulse, w, [least, most]) = (row.impulse, row.velocity_error, row.bounds);
            let r = mlcp::natural_map(impulse, w, row.diagonal, least, most);
            self.natural_map += r * r;
            self.scale += impulse * impulse * row.diagonal;
            let [below, above] = [impulse - least.max(-cap), most.min(cap) - impulse];
            self.gap += w.max(0.0) * below.max(0.0) + (-w).max(0.0) * above.max(0.0);
        }
    }

    /// Sums over the rows of an island, at the velocities in `bodies`.
    pub fn of(rows: &[PointRows], bodies: &[SolverBody], problem: Solved) -> Self {
        let mut sum = Self::default();
        let movable = bodies.iter().filter(|b| b.inverse_mass > 0.0);
        sum.mass = movable.map(|b| 1.0 / f64::from(b.inverse_mass)).sum();
        // No contact of an island needs to carry more than all that its contacts carry together.
        let cap = rows.iter().map(|p| f64::from(p.normal.impulse.abs())).sum();
        for point in rows {
            sum.add_point(point, bodies, problem, cap);
        }
        sum
    }

    /// Adds another island.
    pub fn add(&mut self, other: &Self) {
        self.natural_map += other.natural_map;
        self.scale += other.scale;
        self.gap += other.gap;
        self.mass += other.mass;
        self.approach = self.approach.max(other.approach);
    }

    /// The measures that the sums stand for.
    pub fn residual(&self) -> Residual {
        let ratio = |part: f64, whole: f64| {
            if whole > 0.0 {
                (part / whole).sqrt() as f32
            } else {
                0.0
            }
        };
        Residual {
            natural_map: self.natural_map.sqrt() as f32,
            relative: ratio(self.natural_map, self.scale),
            approach_speed: self.approach as f32,
            velocity_error: ratio(2.0 * self.gap, self.mass),
        }
    }

    fn add_point(&mut self, point: &PointRows, bodies: &[SolverBody], problem: Solved, cap: f64) {
        let [a, b] = point.bodies.map(|b| &bodies[b as usize]);
        let normal = &point.normal;
        let impulse = f64::from(normal.impulse);
        let w = f64::from(normal.velocity(a, b) - target_velocity(point, problem));
        let least = f64::from(point.min_normal());
        let r = mlcp::natural_map(impulse, w, f64::from(normal.diagonal), least, f64::INFINITY);
        self.natural_map += r * r;
        self.approach = self.approach.max(-w);
        self.gap += w.max(0.0) * (impulse - least) + (-w).max(0.0) * (cap - impulse).max(0.0);
        for row in point.rows() {
            let impulse = f64::from(row.impulse);
            self.scale += impulse * impulse * f64::from(row.diagonal);
        }
        if point.has_friction() {
            let slip = |row: &Row| f64::from(row.velocity(a, b) - target_slip(point, row, problem));
            let slip = point.tangents.each_ref().map(slip);
            self.add_friction(point, slip, problem.friction);
        }
    }

    /// `w`: the velocities of the point's two friction rows, m/s.
    fn add_friction(&mut self, point: &PointRows, w: [f64; 2], model: FrictionModel) {
        let of =
            |value: fn(&Row) -> f32| point.tangents.each_ref().map(|row| f64::from(value(row)));
        let (impulse, diagonal) = (of(|row| row.impulse), of(|row| row.diagonal));
        let bound = f64::from(point.friction_bound(point.normal.impulse));
        match model {
            FrictionModel::Disc => {
                let (impulse, w) = (DVec2::from_array(impulse), DVec2::from_array(w));
                let r = mlcp::natural_map_disc(impulse, w, DVec2::from_array(diagonal), bound);
                self.natural_map += r * r;
                self.gap += (bound * w.length() + impulse.dot(w)).max(0.0);
            }
            FrictionModel::Box => {
                for i in 0..2 {
                    let r = mlcp::natural_map(impulse[i], w[i], diagonal[i], -bound, bound);
                    self.natural_map += r * r;
                    self.gap += (bound * w[i].abs() + impulse[i] * w[i]).max(0.0);
                }
            }
        }
    }
}

/// The normal velocity that the last word on a point was about, m/s.
fn target_velocity(point: &PointRows, problem: Solved) -> f32 {
    if !problem.is_relaxed {
        point.normal.target_velocity
    } else if point.is_bonded() {
        0.0
    } else {
        soft_step::relaxed_velocity(
            point.rebound,
            point.normal.impulse,
            point.normal.target_velocity,
        )
    }
}

/// The same along one of its tangents.
fn target_slip(point: &PointRows, row: &Row, problem: Solved) -> f32 {
    if point.is_bonded() && problem.is_relaxed {
        0.0
    } else {
        row.target_velocity
    }
}
