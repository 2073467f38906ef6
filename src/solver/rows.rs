//! Contacts as rows of the problem: Jacobian, wanted velocity, diagonal of `A`.
//!
//! A row constrains the velocity of B against A at a point along a unit direction `d`:
//!
//! ```text
//! J v = d . (v_B + omega_B x r_B) - d . (v_A + omega_A x r_A)
//!     = d . (v_B - v_A) + (r_B x d) . omega_B - (r_A x d) . omega_A
//!
//! A_ii = 1/m_A + 1/m_B + (r_A x d) . I_A^-1 (r_A x d) + (r_B x d) . I_B^-1 (r_B x d)
//! ```
//!
//! - `d`: the contact normal from A to B, or one of two tangents; world axes
//! - `r_A`, `r_B`: from each centre of mass to the contact point; world axes, m
//! - `I_A`, `I_B`: inertia about the centre of mass; world axes, kg m2
//!
//! An impulse `lambda` (N s) along the row changes `v_B` by `+lambda d / m_B`, `omega_B` by `+lambda I_B^-1 (r_B x d)`,
//! and A by the opposite: `M^-1 J^T lambda`.
//!
//! # References
//! Catto, "Iterative Dynamics with Temporal Coherence", 2005, sections 3 to 5.

use super::SolverConfig;
use super::bodies::{Bodies, SolverBody};
use crate::contact::manifold::{ContactPoint, Manifold};
use crate::math::tangents;
use glam::{Mat3, Vec3};

/// One row of the problem.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Row {
    /// `d`: direction of the row, world axes.
    pub direction: Vec3,
    /// `r_A x d`.
    pub angular_a: Vec3,
    /// `r_B x d`.
    pub angular_b: Vec3,
    /// `I_A^-1 (r_A x d)`: change of A's angular velocity per unit of impulse, with its sign reversed.
    pub turn_a: Vec3,
    /// `I_B^-1 (r_B x d)`.
    pub turn_b: Vec3,
    /// `A_ii`, 1/kg.
    pub diagonal: f32,
    /// `1 / A_ii`, or 0 if nothing can move; kg. The effective mass.
    pub effective_mass: f32,
    /// `u`: the velocity the row should have, m/s.
    pub wanted: f32,
    /// `lambda`: impulse along the row, N s.
    pub impulse: f32,
}

impl Row {
    fn new(direction: Vec3, point: &ContactPoint, a: Side, b: Side) -> Self {
        let (angular_a, angular_b) = (
            point.anchor_a.cross(direction),
            point.anchor_b.cross(direction),
        );
        let (turn_a, turn_b) = (a.inverse_inertia * angular_a, b.inverse_inertia * angular_b);
        let diagonal =
            a.inverse_mass + b.inverse_mass + angular_a.dot(turn_a) + angular_b.dot(turn_b);
        let effective_mass = if diagonal > 0.0 { 1.0 / diagonal } else { 0.0 };
        Self {
            direction,
            angular_a,
            angular_b,
            turn_a,
            turn_b,
            diagonal,
            effective_mass,
            wanted: 0.0,
            impulse: 0.0,
        }
    }

    /// `J v`: velocity of B against A along the row, m/s.
    #[inline]
    pub fn velocity(&self, a: &SolverBody, b: &SolverBody) -> f32 {
        self.direction.dot(b.linear - a.linear) + self.angular_b.dot(b.angular)
            - self.angular_a.dot(a.angular)
    }

    /// Adds `M^-1 J^T impulse` to the velocities.
    #[inline]
    pub fn apply(&self, impulse: f32, a: &mut SolverBody, b: &mut SolverBody) {
        a.linear -= self.direction * (impulse * a.inverse_mass);
        a.angular -= self.turn_a * impulse;
        b.linear += self.direction * (impulse * b.inverse_mass);
        b.angular += self.turn_b * impulse;
    }
}

#[derive(Clone, Copy)]
struct Side {
    inverse_mass: f32,
    inverse_inertia: Mat3,
}

/// The three rows of one contact point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointRows {
    /// Slots of the two bodies.
    pub bodies: [u32; 2],
    /// Along the normal; its impulse is not negative.
    pub normal: Row,
    /// Along the two tangents.
    pub tangents: [Row; 2],
    /// Coefficient of friction.
    pub friction: f32,
}

/// Fills `rows` with three rows for every contact point, in the order of `manifolds`.
///
/// `h`: step length, s. Reuses the buffer.
pub fn build_rows(
    rows: &mut Vec<PointRows>,
    manifolds: &[Manifold],
    bodies: &Bodies,
    config: &SolverConfig,
    h: f32,
) {
    rows.clear();
    for manifold in manifolds {
        let (i, j) = (manifold.a as usize, manifold.b as usize);
        let side = |k: usize| Side {
            inverse_mass: bodies.velocity[k].inverse_mass,
            inverse_inertia: bodies.inverse_inertia[k],
        };
        let (a, b) = (side(i), side(j));
        let [t1, t2] = tangents(manifold.normal);
        let slop = config.slop * bodies.least_extent[i].min(bodies.least_extent[j]);
        for point in manifold.points() {
            let mut normal = Row::new(manifold.normal, point, a, b);
            let approach = -normal.velocity(&bodies.velocity[i], &bodies.velocity[j]);
            normal.wanted = wanted_normal_velocity(
                point.separation,
                approach,
                manifold.restitution,
                slop,
                config,
                h,
            );
            normal.impulse = point.normal_impulse;
            let mut friction = [Row::new(t1, point, a, b), Row::new(t2, point, a, b)];
            // Without friction the rows are not solved, so nothing must be left in them from when there was some.
            if manifold.friction > 0.0 {
                friction[0].impulse = point.friction_impulse.dot(t1);
                friction[1].impulse = point.friction_impulse.dot(t2);
            }
            rows.push(PointRows {
                bodies: [manifold.a, manifold.b],
                normal,
                tangents: friction,
                friction: manifold.friction,
            });
        }
    }
}

/// The normal velocity that a contact point should have after the step, m/s.
///
/// - Rebound: `e` times the approach speed, if the surfaces meet within the step and fast enough.
/// - A gap `s > 0` may close, but not more: `-s / h` (speculative contact).
/// - An overlap `s < 0` beyond the slop is pushed out at `zeta = -beta C / h`, no faster than the cap.
fn wanted_normal_velocity(
    separation: f32,
    approach: f32,
    restitution: f32,
    slop: f32,
    config: &SolverConfig,
    h: f32,
) -> f32 {
    let rebounds =
        restitution > 0.0 && approach > config.restitution_threshold && approach * h > separation;
    let rebound = if rebounds {
        restitution * approach
    } else {
        f32::NEG_INFINITY
    };
    let stabilised = if separation > 0.0 {
        -separation / h
    } else {
        (config.baumgarte * (-separation - slop).max(0.0) / h).min(config.push_out_speed)
    };
    rebound.max(stabilised)
}

/// Writes the impulses of the rows back into the contact points they came from.
pub fn store_impulses(rows: &[PointRows], manifolds: &mut [Manifold]) {
    let mut rows = rows.iter();
    for manifold in manifolds {
        for point in manifold.points_mut() {
            let solved = rows.next().expect("three rows for every point");
            let [t1, t2] = &solved.tangents;
            point.normal_impulse = solved.normal.impulse;
            point.friction_impulse = t1.direction * t1.impulse + t2.direction * t2.impulse;
        }
    }
}
