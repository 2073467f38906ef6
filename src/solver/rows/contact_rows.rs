//! Contacts as rows of the problem: Jacobian, target velocity, diagonal of `A`.
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
//! - `r_A`, `r_B`: from each center of mass to the contact point; world axes, m
//! - `I_A`, `I_B`: inertia about the center of mass; world axes, kg m2
//!
//! An impulse `lambda` (N s) along the row changes `v_B` by `+lambda d / m_B`, `omega_B` by `+lambda I_B^-1 (r_B x d)`,
//! and A by the opposite: `M^-1 J^T lambda`.
//!
//! # References
//! Catto, "Iterative Dynamics with Temporal Coherence", 2005, sections 3 to 5.

use crate::bodies::solver_body::SolverBody;
use crate::bodies::store::Bodies;
use crate::contact::manifolds::ManifoldHead;
use crate::contact::point::ContactPoint;
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
    pub target_velocity: f32,
    /// `lambda`: impulse along the row, N s.
    pub impulse: f32,
}

impl Row {
    /// The row along `direction` at the ends of two anchors (from each center of mass, world axes, m).
    pub fn new(direction: Vec3, anchors: [Vec3; 2], sides: [RowBody; 2]) -> Self {
        let [a, b] = sides;
        let [angular_a, angular_b] = anchors.map(|anchor| anchor.cross(direction));
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
            target_velocity: 0.0,
            impulse: 0.0,
        }
    }

    /// `J v`: velocity of B against A along the row, m/s. Of displacements, how far B moved against A, m.
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

/// What a row needs to know of a body.
#[derive(Clone, Copy, Debug)]
pub struct RowBody {
    /// 1 / mass, 1/kg.
    pub inverse_mass: f32,
    /// About the center of mass, world axes, 1/(kg m2).
    pub inverse_inertia: Mat3,
}

impl RowBody {
    /// The body in a slot.
    pub(crate) fn of(bodies: &Bodies, slot: usize) -> Self {
        Self {
            inverse_mass: bodies.velocity[slot].inverse_mass,
            inverse_inertia: bodies.inverse_inertia[slot],
        }
    }

    /// What an impulse of 1 N s gives the point where it acts, along itself, m/s; `lever`: from the center of mass, cross the unit vector of the impulse, m.
    pub(crate) fn inverse_mass_at(&self, lever: Vec3) -> f32 {
        self.inverse_mass + lever.dot(self.inverse_inertia * lever)
    }
}

/// The three rows of one contact point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointRows {
    /// Numbers of the two bodies within the island.
    pub bodies: [u32; 2],
    /// Along the normal; its impulse is not below `-adhesion`.
    pub normal: Row,
    /// Along the two tangents.
    pub tangents: [Row; 2],
    /// Coefficient of friction.
    pub friction: f32,
    /// Largest tensile impulse that a bond bears here, 0 where there is none; N s.
    pub adhesion: f32,
    /// What friction may be beyond the coefficient times the normal impulse, on account of a bond; N s.
    pub shear: f32,
    /// Coefficient of restitution.
    pub restitution: f32,
    /// Gap along the normal less what displacements of the bodies add to it, m.
    pub separation: f32,
    /// Overlap that is left alone, m.
    pub slop: f32,
    /// What a velocity is multiplied with to compare it with those of other sizes, `(extent / 1 m)^(-1/2)`: under gravity all
    /// speeds grow with the square root of the size.
    pub speed_scale: f32,
    /// Normal velocity that the point should have after the bodies have moved, m/s; not positive if it does not rebound, see
    /// `PointImpact::rebound`.
    pub rebound: f32,
    /// Sum of the normal impulses of the sub-steps that are over, N s.
    pub total_normal_impulse: f32,
}

impl PointRows {
    /// The rows of a point, with the impulses of a whole step from where the last one left off.
    ///
    /// - `bodies`: numbers within the island
    /// - `extent`: the smaller body's least extent, m
    /// - `slop`: share of the extent by which bodies may overlap
    pub fn new(
        manifold: &ManifoldHead,
        point: &ContactPoint,
        bodies: [u32; 2],
        sides: [RowBody; 2],
        extent: f32,
        slop: f32,
    ) -> Self {
        let mut rows = Self {
            bodies,
            normal: Row::default(),
            tangents: [Row::default(); 2],
            friction: manifold.friction,
            adhesion: 0.0,
            shear: 0.0,
            restitution: manifold.restitution,
            separation: point.separation,
            slop: slop * extent,
            speed_scale: 1.0 / extent.sqrt(),
            rebound: 0.0,
            total_normal_impulse: 0.0,
        };
        rows.set_geometry(manifold.normal, [point.anchor_a, point.anchor_b], sides);
        rows.normal.impulse = point.normal_impulse;
        // Without friction the rows are not solved, so nothing must be left in them from when there was some.
        if manifold.friction > 0.0 {
            for row in &mut rows.tangents {
                row.impulse = point.friction_impulse.dot(row.direction);
            }
        }
        rows
    }

    /// Points the rows along the normal and its tangents at the ends of the anchors; target velocity and impulses stay.
    /// Without friction and bond the tangents are left empty.
    pub fn set_geometry(&mut self, normal: Vec3, anchors: [Vec3; 2], sides: [RowBody; 2]) {
        let geometry = |row: &mut Row, direction| {
            *row = Row {
                target_velocity: row.target_velocity,
                impulse: row.impulse,
                ..Row::new(direction, anchors, sides)
            };
        };
        geometry(&mut self.normal, normal);
        if self.has_friction() {
            let directions = tangents(normal);
            for (row, direction) in self.tangents.iter_mut().zip(directions) {
                geometry(row, direction);
            }
        }
    }

    /// Whether the tangents take part.
    pub fn has_friction(&self) -> bool {
        self.friction > 0.0 || self.shear > 0.0
    }

    /// Whether a bond holds the point.
    pub fn is_bonded(&self) -> bool {
        self.adhesion > 0.0
    }

    /// Lower bound of the normal impulse, N s.
    #[inline]
    pub fn min_normal(&self) -> f32 {
        // Not `-adhesion`, which would be the other zero where there is no bond.
        0.0 - self.adhesion
    }

    /// Bound of the friction impulse with a normal impulse, N s.
    #[inline]
    pub fn friction_bound(&self, normal: f32) -> f32 {
        self.friction * normal.max(0.0) + self.shear
    }

    /// All three rows.
    pub fn rows(&self) -> [&Row; 3] {
        [&self.normal, &self.tangents[0], &self.tangents[1]]
    }

    /// Impulses of the three rows, N s.
    pub fn impulses(&self) -> [f32; 3] {
        self.rows().map(|row| row.impulse)
    }

    /// Sets the impulses of the three rows, N s.
    pub fn set_impulses(&mut self, [normal, t1, t2]: [f32; 3]) {
        self.normal.impulse = normal;
        (self.tangents[0].impulse, self.tangents[1].impulse) = (t1, t2);
    }
}
