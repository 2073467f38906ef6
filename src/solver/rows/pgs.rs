//! Projected Gauss-Seidel on velocities: the paper's method.
//!
//! Each row in turn gets the impulse that makes its own velocity right while all others rest, clipped to its bounds:
//! `lambda_i <- clip(lambda_i - w_i / A_ii, lo_i, hi_i)`, where `w_i = J_i v - u_i` is read from the velocities, which
//! carry `v* + M^-1 J^T lambda` at all times. `A` is never formed.
//!
//! # References
//! Erleben, "Stable, Robust, and Versatile Multibody Dynamics Animation", 2005; Catto, "Iterative Dynamics with Temporal
//! Coherence", 2005 (warm start, friction bounds from the current normal impulse).

use crate::bodies::solver_body::SolverBody;
use crate::solver::config::FrictionModel;
use crate::solver::rows::contact_rows::{PointRows, Row};
use crate::solver::rows::mlcp;
use glam::Vec2;

/// Solves the rows: impulses in `rows`, velocities in `bodies`, which the numbers in the rows refer to.
///
/// The impulses found in `rows` are the start; pass zeros for a cold start. `sweeps` times, friction is solved before
/// the normal of the same point, so that the last word is non-penetration.
pub fn solve(
    rows: &mut [PointRows],
    bodies: &mut [SolverBody],
    sweeps: u32,
    friction: FrictionModel,
) {
    apply_impulses(rows, bodies);
    for _ in 0..sweeps {
        sweep(rows, bodies, friction);
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

/// One pass over all rows; returns the largest velocity change that a row made, in units of its
/// [speed scale](PointRows::speed_scale).
pub fn sweep(rows: &mut [PointRows], bodies: &mut [SolverBody], model: FrictionModel) -> f32 {
    match model {
        FrictionModel::Disc => relax_all(rows, bodies, |contact| friction_in_disc(contact)),
        FrictionModel::Box => relax_all(rows, bodies, |contact| friction_in_box(contact)),
    }
}

/// A type of its own for each friction rule, so that its code is part of the loop.
fn relax_all(
    rows: &mut [PointRows],
    bodies: &mut [SolverBody],
    friction: impl Fn(&mut PointOnBodies) -> f32,
) -> f32 {
    let mut change = 0.0_f32;
    for point in rows {
        let [a, b] = pair(bodies, point.bodies);
        let mut contact = PointOnBodies { point, a, b };
        let of_point = relax(&mut contact, &friction);
        change = change.max(of_point * contact.point.speed_scale);
    }
    change
}

/// The rows of one contact and whatever they act on: row 0 is the normal, the others are tangents.
///
/// The same sweep runs in single precision on the bodies of a step and in double precision on problems from files.
pub trait ContactRows {
    /// The numbers it calculates with.
    type Real: Real;
    /// Number of tangents.
    const TANGENTS: usize;
    /// Whether the tangents take part.
    fn has_friction(&self) -> bool;
    /// Impulse of a row, N s.
    fn impulse(&self, row: usize) -> Self::Real;
    /// Velocity along a row at present, m/s; of a tangent, less the target one.
    fn velocity(&self, row: usize) -> Self::Real;
    /// `1 / A_ii`, kg.
    fn effective_mass(&self, row: usize) -> Self::Real;
    /// Where the normal impulse should be if it had no bound, N s.
    fn unbounded_normal(&self) -> Self::Real;
    /// Lower bound of the normal impulse, N s: zero unless it may pull.
    fn min_normal(&self) -> Self::Real {
        Self::Real::ZERO
    }
    /// Bounds of a tangent's impulse, N s.
    fn bounds(&self, row: usize) -> [Self::Real; 2];
    /// Changes a row's impulse; returns by how much that changes the row's velocity, m/s.
    fn move_to(&mut self, row: usize, impulse: Self::Real) -> Self::Real;
}

/// A type of floating-point numbers.
pub trait Real: Copy + std::ops::Sub<Output = Self> + std::ops::Mul<Output = Self> {
    /// Zero.
    const ZERO: Self;
    /// The larger one.
    fn max(self, other: Self) -> Self;
    /// The smaller one.
    fn min(self, other: Self) -> Self;
}

impl Real for f32 {
    const ZERO: Self = 0.0;
    #[inline]
    fn max(self, other: Self) -> Self {
        self.max(other)
    }
    #[inline]
    fn min(self, other: Self) -> Self {
        self.min(other)
    }
}

impl Real for f64 {
    const ZERO: Self = 0.0;
    #[inline]
    fn max(self, other: Self) -> Self {
        self.max(other)
    }
    #[inline]
    fn min(self, other: Self) -> Self {
        self.min(other)
    }
}

/// Solves the rows of one contact one after the other; returns the largest velocity change of a row, m/s.
#[inline]
pub fn relax<C: ContactRows>(contact: &mut C, friction: impl Fn(&mut C) -> C::Real) -> C::Real {
    let mut change = C::Real::ZERO;
    if contact.has_friction() {
        change = friction(contact);
    }
    let unbounded = contact.unbounded_normal();
    let least = contact.min_normal();
    contact.move_to(0, unbounded.max(least)).max(change)
}

/// The impulse with which the velocity along a row is zero, all others being as they are.
#[inline]
fn unbounded<C: ContactRows>(contact: &C, row: usize) -> C::Real {
    contact.impulse(row) - contact.velocity(row) * contact.effective_mass(row)
}

/// Each tangent within its bounds, one after the other: the paper's box.
#[inline]
pub fn friction_in_box<C: ContactRows>(contact: &mut C) -> C::Real {
    let mut change = C::Real::ZERO;
    for row in 1..=C::TANGENTS {
        let [lo, hi] = contact.bounds(row);
        let target = unbounded(contact, row).max(lo).min(hi);
        change = change.max(contact.move_to(row, target));
    }
    change
}

/// Both tangents together within the disc of the radius that is the bound of either.
#[inline]
fn friction_in_disc<C: ContactRows<Real = f32>>(contact: &mut C) -> f32 {
    let [_, radius] = contact.bounds(1);
    // One mass for both, or the projection would leave friction askew to the velocity where the two differ.
    let mass = contact.effective_mass(1).min(contact.effective_mass(2));
    let unbounded = |row| contact.impulse(row) - contact.velocity(row) * mass;
    let both = Vec2::new(unbounded(1), unbounded(2));
    let target = mlcp::project_to_disc(both, radius);
    let change = contact.move_to(1, target.x);
    change.max(contact.move_to(2, target.y))
}

/// A contact point of a step with its two bodies.
struct PointOnBodies<'a> {
    point: &'a mut PointRows,
    a: &'a mut SolverBody,
    b: &'a mut SolverBody,
}

impl PointOnBodies<'_> {
    #[inline]
    fn row(&self, row: usize) -> &Row {
        match row {
            0 => &self.point.normal,
            row => &self.point.tangents[row - 1],
        }
    }
}

impl ContactRows for PointOnBodies<'_> {
    type Real = f32;
    const TANGENTS: usize = 2;

    #[inline]
    fn has_friction(&self) -> bool {
        self.point.has_friction()
    }

    #[inline]
    fn impulse(&self, row: usize) -> f32 {
        self.row(row).impulse
    }

    #[inline]
    fn velocity(&self, row: usize) -> f32 {
        let velocity = self.row(row).velocity(self.a, self.b);
        match row {
            0 => velocity,
            row => velocity - self.point.tangents[row - 1].target_velocity,
        }
    }

    #[inline]
    fn effective_mass(&self, row: usize) -> f32 {
        self.row(row).effective_mass
    }

    #[inline]
    fn unbounded_normal(&self) -> f32 {
        let row = &self.point.normal;
        row.impulse - (self.velocity(0) - row.target_velocity) * row.effective_mass
    }

    #[inline]
    fn min_normal(&self) -> f32 {
        self.point.min_normal()
    }

    #[inline]
    fn bounds(&self, _: usize) -> [f32; 2] {
        let bound = self.point.friction_bound(self.point.normal.impulse);
        [-bound, bound]
    }

    #[inline]
    fn move_to(&mut self, row: usize, impulse: f32) -> f32 {
        let row = match row {
            0 => &mut self.point.normal,
            row => &mut self.point.tangents[row - 1],
        };
        let change = impulse - row.impulse;
        row.impulse = impulse;
        row.apply(change, self.a, self.b);
        (change * row.diagonal).abs()
    }
}

/// The two bodies of a row. A manifold never joins a body with itself.
#[inline]
pub(crate) fn pair(bodies: &mut [SolverBody], slots: [u32; 2]) -> [&mut SolverBody; 2] {
    bodies
        .get_disjoint_mut(slots.map(|s| s as usize))
        .expect("a manifold joins two different bodies")
}
