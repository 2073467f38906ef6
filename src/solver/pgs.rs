//! Projected Gauss-Seidel on velocities: the paper's method.
//!
//! Each row in turn gets the impulse that makes its own velocity right while all others rest, clipped to its bounds:
//! `lambda_i <- clip(lambda_i - w_i / A_ii, lo_i, hi_i)`, where `w_i = J_i v - u_i` is read from the velocities, which
//! carry `v* + M^-1 J^T lambda` at all times. `A` is never formed.
//!
//! # References
//! Erleben, "Stable, Robust, and Versatile Multibody Dynamics Animation", 2005; Catto, "Iterative Dynamics with Temporal
//! Coherence", 2005 (warm start, friction bounds from the current normal impulse).

use super::bodies::SolverBody;
use super::mlcp;
use super::rows::{PointRows, Row};
use super::{FrictionModel, SolverConfig};
use glam::Vec2;

/// Where a sweep moves the normal impulse of a point to, before it is clipped.
pub trait NormalRule {
    /// The impulse that the rule asks for, N s, where the normal velocity is `velocity`, m/s.
    fn wish(&self, point: &PointRows, velocity: f32) -> f32;
}

/// The paper's rule: the impulse that gives the row its wanted velocity.
#[derive(Clone, Copy, Debug)]
pub struct Hard;

impl NormalRule for Hard {
    #[inline]
    fn wish(&self, point: &PointRows, velocity: f32) -> f32 {
        let row = &point.normal;
        row.impulse - (velocity - row.wanted) * row.effective_mass
    }
}

/// Solves the rows: impulses in `rows`, velocities in `bodies`, which the numbers in the rows refer to.
///
/// The impulses found in `rows` are the start; pass zeros for a cold start. `sweeps` times, friction is solved before
/// the normal of the same point, so that the last word is non-penetration.
pub fn solve(rows: &mut [PointRows], bodies: &mut [SolverBody], config: &SolverConfig) {
    apply_impulses(rows, bodies);
    for _ in 0..config.sweeps {
        sweep(rows, bodies, &Hard, config.friction_model);
    }
}

/// Adds `M^-1 J^T lambda` of the impulses found in `rows` to the velocities: the warm start.
pub fn apply_impulses(rows: &[PointRows], bodies: &mut [SolverBody]) {
    for point in rows {
        let [a, b] = pair(bodies, point.bodies);
        for row in point.rows() {
            row.apply(row.impulse, a, b);
        }
    }
}

/// One pass over all rows; returns the largest velocity change that a row made, m/s.
pub fn sweep(
    rows: &mut [PointRows],
    bodies: &mut [SolverBody],
    rule: &impl NormalRule,
    model: FrictionModel,
) -> f32 {
    match model {
        FrictionModel::Disc => relax_all(rows, bodies, rule, friction_in_disc),
        FrictionModel::Box => relax_all(rows, bodies, rule, friction_in_box),
    }
}

/// A type of its own for each friction rule, so that its code is part of the loop.
fn relax_all(
    rows: &mut [PointRows],
    bodies: &mut [SolverBody],
    rule: &impl NormalRule,
    friction: impl Fn(&mut [Row; 2], f32, &mut SolverBody, &mut SolverBody) -> f32,
) -> f32 {
    let mut change = 0.0_f32;
    for point in rows {
        change = change.max(relax(point, bodies, rule, &friction));
    }
    change
}

#[inline]
fn relax(
    point: &mut PointRows,
    bodies: &mut [SolverBody],
    rule: &impl NormalRule,
    friction: impl Fn(&mut [Row; 2], f32, &mut SolverBody, &mut SolverBody) -> f32,
) -> f32 {
    let [a, b] = pair(bodies, point.bodies);
    let mut change = 0.0;
    if point.friction > 0.0 {
        let bound = point.friction * point.normal.impulse;
        change = friction(&mut point.tangents, bound, a, b);
    }
    let wish = rule.wish(point, point.normal.velocity(a, b));
    move_to(&mut point.normal, wish.max(0.0), a, b).max(change)
}

/// Each tangent within `-bound..=bound`, one after the other: the paper's box.
#[inline]
fn friction_in_box(rows: &mut [Row; 2], bound: f32, a: &mut SolverBody, b: &mut SolverBody) -> f32 {
    let mut change: f32 = 0.0;
    for row in rows {
        let wish = row.impulse - row.velocity(a, b) * row.effective_mass;
        change = change.max(move_to(row, wish.max(-bound).min(bound), a, b));
    }
    change
}

/// Both tangents together within the disc of radius `bound`.
#[inline]
fn friction_in_disc(
    rows: &mut [Row; 2],
    bound: f32,
    a: &mut SolverBody,
    b: &mut SolverBody,
) -> f32 {
    // One mass for both, or the projection would leave friction askew to the velocity where the two differ.
    let mass = rows[0].effective_mass.min(rows[1].effective_mass);
    let wish = rows
        .each_ref()
        .map(|row| row.impulse - row.velocity(a, b) * mass);
    let target = mlcp::project_to_disc(Vec2::from_array(wish), bound);
    let change = move_to(&mut rows[0], target.x, a, b);
    change.max(move_to(&mut rows[1], target.y, a, b))
}

/// Changes a row's impulse; returns by how much that changes the row's velocity, m/s.
#[inline]
fn move_to(row: &mut Row, impulse: f32, a: &mut SolverBody, b: &mut SolverBody) -> f32 {
    let change = impulse - row.impulse;
    row.impulse = impulse;
    row.apply(change, a, b);
    (change * row.diagonal).abs()
}

/// The two bodies of a row. A manifold never joins a body with itself.
#[inline]
fn pair(bodies: &mut [SolverBody], slots: [u32; 2]) -> [&mut SolverBody; 2] {
    bodies
        .get_disjoint_mut(slots.map(|s| s as usize))
        .expect("a manifold joins two different bodies")
}
