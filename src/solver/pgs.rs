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
use super::mlcp::{self, Residual};
use super::rows::{PointRows, Row};
use super::{FrictionModel, SolverConfig};
use glam::{DVec2, Vec2};

/// Solves the rows: impulses in `rows`, velocities in `bodies` (indexed by slot).
///
/// The impulses found in `rows` are the start; pass zeros for a cold start. `sweeps` times, friction is solved before
/// the normal of the same point, so that the last word is non-penetration.
pub fn solve(rows: &mut [PointRows], bodies: &mut [SolverBody], config: &SolverConfig) {
    for point in rows.iter() {
        let [a, b] = pair(bodies, point.bodies);
        for row in [&point.normal, &point.tangents[0], &point.tangents[1]] {
            row.apply(row.impulse, a, b);
        }
    }
    for _ in 0..config.sweeps * config.substeps * (1 + config.relax_sweeps) {
        match config.friction_model {
            FrictionModel::Disc => rows
                .iter_mut()
                .for_each(|p| relax(p, bodies, friction_in_disc)),
            FrictionModel::Box => rows
                .iter_mut()
                .for_each(|p| relax(p, bodies, friction_in_box)),
        }
    }
}

#[inline]
fn relax(
    point: &mut PointRows,
    bodies: &mut [SolverBody],
    friction: impl Fn(&mut [Row; 2], f32, &mut SolverBody, &mut SolverBody),
) {
    let [a, b] = pair(bodies, point.bodies);
    if point.friction > 0.0 {
        friction(
            &mut point.tangents,
            point.friction * point.normal.impulse,
            a,
            b,
        );
    }
    let row = &mut point.normal;
    let wish = row.impulse - (row.velocity(a, b) - row.wanted) * row.effective_mass;
    move_to(row, wish.max(0.0), a, b);
}

/// Each tangent within `-bound..=bound`, one after the other: the paper's box.
#[inline]
fn friction_in_box(rows: &mut [Row; 2], bound: f32, a: &mut SolverBody, b: &mut SolverBody) {
    for row in rows {
        let wish = row.impulse - row.velocity(a, b) * row.effective_mass;
        move_to(row, wish.max(-bound).min(bound), a, b);
    }
}

/// Both tangents together within the disc of radius `bound`.
#[inline]
fn friction_in_disc(rows: &mut [Row; 2], bound: f32, a: &mut SolverBody, b: &mut SolverBody) {
    let wish = rows
        .each_ref()
        .map(|row| row.impulse - row.velocity(a, b) * row.effective_mass);
    let target = mlcp::project_to_disc(Vec2::from_array(wish), bound);
    move_to(&mut rows[0], target.x, a, b);
    move_to(&mut rows[1], target.y, a, b);
}

#[inline]
fn move_to(row: &mut Row, impulse: f32, a: &mut SolverBody, b: &mut SolverBody) {
    let change = impulse - row.impulse;
    row.impulse = impulse;
    row.apply(change, a, b);
}

/// The two bodies of a row. A manifold never joins a body with itself.
#[inline]
fn pair(bodies: &mut [SolverBody], slots: [u32; 2]) -> [&mut SolverBody; 2] {
    bodies
        .get_disjoint_mut(slots.map(|s| s as usize))
        .expect("a manifold joins two different bodies")
}

/// How far `rows` are from solving the problem at the velocities in `bodies`; see [`mlcp`].
pub fn residual(rows: &[PointRows], bodies: &[SolverBody], config: &SolverConfig) -> Residual {
    let (mut sum, mut scale, mut approach) = (0.0, 0.0, 0.0_f64);
    for point in rows {
        let (a, b) = (
            &bodies[point.bodies[0] as usize],
            &bodies[point.bodies[1] as usize],
        );
        let velocity = |row: &Row| f64::from(row.velocity(a, b) - row.wanted);
        let normal = &point.normal;
        let w = velocity(normal);
        approach = approach.max(-w);
        let r = mlcp::natural_map(
            f64::from(normal.impulse),
            w,
            f64::from(normal.diagonal),
            0.0,
            f64::INFINITY,
        );
        sum += r * r
            + friction_residual(
                point,
                point.tangents.each_ref().map(velocity),
                config.friction_model,
            );
        for row in [normal, &point.tangents[0], &point.tangents[1]] {
            scale += f64::from(row.impulse) * f64::from(row.impulse) * f64::from(row.diagonal);
        }
    }
    Residual {
        natural_map: sum.sqrt() as f32,
        relative: if scale > 0.0 {
            (sum / scale).sqrt() as f32
        } else {
            0.0
        },
        approach_speed: approach as f32,
    }
}

/// Square of the residual of a point's two friction rows with the velocities `w`.
fn friction_residual(point: &PointRows, w: [f64; 2], model: FrictionModel) -> f64 {
    let impulse = point.tangents.each_ref().map(|row| f64::from(row.impulse));
    let diagonal = point.tangents.each_ref().map(|row| f64::from(row.diagonal));
    let bound = f64::from(point.friction * point.normal.impulse);
    match model {
        FrictionModel::Disc => {
            let r = mlcp::natural_map_disc(
                DVec2::from_array(impulse),
                DVec2::from_array(w),
                DVec2::from_array(diagonal),
                bound,
            );
            r * r
        }
        FrictionModel::Box => (0..2)
            .map(|i| mlcp::natural_map(impulse[i], w[i], diagonal[i], -bound, bound))
            .map(|r| r * r)
            .sum(),
    }
}
