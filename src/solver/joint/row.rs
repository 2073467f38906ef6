//! One constraint of a joint along one direction.
//!
//! With velocities `v` of the two bodies and the row's Jacobian `J`, the impulse of a row in half a sub-step is
//!
//! ```text
//! lambda = clamp(base + stiffness (target - J v), bounds)
//! ```
//!
//! - A rigid row has `base` = the impulse so far and a stiffness of `1 / (EPSILON J M^-1 J^T)`: the method of multipliers, in
//!   which what is left of the error goes into `base` and is gone the next time. Nothing is singular, so rows that say the same
//!   twice, in closed loops or between the same two bodies, do no harm.
//! - A spring of stiffness `k` (N/m) and damping `c` (N s/m) has `base = -h k x` and `stiffness = h (c + theta h k)`: the force at
//!   the place where it is, and an implicit share `theta` of what it will be. With `s = h^2 k J M^-1 J^T` of all springs of the two
//!   bodies, `theta = s / (1 + s)`: hardly any for a spring that many sub-steps see swing, which keeps its energy, and nearly all
//!   for one that no sub-step can follow, which is stable whatever its stiffness (it is from `theta >= 1/2 - 2/s` on).
//!
//! Together these are the conditions for the least of a convex function of `v`,
//! `|v - v_free|_M^2 / 2 + sum psi_i(J_i v)`, that is quadratic by pieces. Which piece is found by Newton's method.
//!
//! # References
//! Hestenes, "Multiplier and Gradient Methods", 1969; Rockafellar, "Augmented Lagrangians and Applications of the Proximal Point
//! Algorithm in Convex Programming", 1976; Baraff, "Linear-Time Dynamics using Lagrange Multipliers", SIGGRAPH 1996 (trees).

use crate::solver::joint::vector6::{Vector6, dot};

/// How much softer than the two bodies alone a rigid row is within one solve. In double precision the solution keeps some eight
/// digits with it.
pub(crate) const EPSILON: f64 = 1e-8;

/// How a row is to be understood.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum RowKind {
    /// Stays at a place.
    #[default]
    Equality,
    /// Stays on one side of a place.
    Limit,
    /// Has a velocity, as far as its bounds let it.
    Velocity(f64),
    /// Is pulled to a place: stiffness, damping.
    Spring([f64; 2]),
}

/// Whether a row acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum RowState {
    /// It has not been asked yet.
    #[default]
    Unknown,
    /// Within its bounds.
    Free,
    /// At the lower bound.
    AtLeast,
    /// At the upper bound.
    AtMost,
}

/// A row.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct JointRow {
    /// Which of the joint's rows it is.
    pub(crate) slot: u8,
    pub(crate) kind: RowKind,
    pub(crate) state: RowState,
    /// The state that it has in the factor.
    pub(crate) factored: RowState,
    /// On which side of its place it is to stay: 1 above, -1 below, 0 on either.
    pub(crate) side: f64,
    /// Whether it is about an angle.
    pub(crate) is_angular: bool,
    /// Of A and B.
    pub(crate) jacobian: [Vector6; 2],
    /// How far it is from where it should be, m or rad.
    pub(crate) position: f64,
    /// How far it should be at the end of the sub-step, but for what it is pushed.
    pub(crate) goal: f64,
    /// How fast a motion with the velocities that it had would leave its place, by the sub-step before, m/s2 or rad/s2: what turns is pulled
    /// inward.
    pub(crate) curve: f64,
    /// How far it is pushed in the sub-step, which leaves no velocity.
    pub(crate) push: f64,
    /// Share of the speed that comes back from a limit.
    pub(crate) restitution: f64,
    /// Velocity before the sub-step, m/s or rad/s; not of rows that always act.
    pub(crate) velocity_before: f64,
    /// Velocity along it of bodies that joints do not move, m/s or rad/s.
    pub(crate) fixed_velocity: f64,
    /// `J M^-1 J^T`, 1/kg.
    pub(crate) mobility: f64,
    /// Largest force either way, N.
    pub(crate) max_force: f64,
    pub(crate) base: f64,
    pub(crate) stiffness: f64,
    pub(crate) target: f64,
    /// N s.
    pub(crate) bounds: [f64; 2],
    /// N s, in this half of the sub-step.
    pub(crate) impulse: f64,
    /// N s, in the half before it.
    pub(crate) spent: f64,
}

/// Share of its speeds by which a rigid row that acts may miss its target: what rows leave that were asked for what another one forbids.
const CONTRADICTED: f64 = 1e-3;

impl JointRow {
    /// Whether its impulse adds up.
    #[inline(always)]
    pub(crate) fn is_rigid(&self) -> bool {
        !matches!(self.kind, RowKind::Spring(_))
    }

    /// Whether it acts, whatever the velocity.
    #[inline(always)]
    pub(crate) fn always_acts(&self) -> bool {
        matches!(self.kind, RowKind::Equality)
    }

    /// Whether it keeps a place exactly.
    #[inline(always)]
    pub(crate) fn is_position(&self) -> bool {
        matches!(self.kind, RowKind::Equality | RowKind::Limit)
    }

    /// `J v` of both bodies, of which those that joints do not move have none.
    #[inline(always)]
    pub(crate) fn velocity(&self, velocities: [Option<&Vector6>; 2]) -> f64 {
        let [fixed, a, b] = self.speeds(velocities);
        fixed + a + b
    }

    /// Of its velocity, what is given to it, and what each of its bodies gives, m/s or rad/s.
    #[inline(always)]
    pub(crate) fn speeds(&self, velocities: [Option<&Vector6>; 2]) -> [f64; 3] {
        let of = |side: usize| velocities[side].map_or(0.0, |v| dot(&self.jacobian[side], v));
        [self.fixed_velocity, of(0), of(1)]
    }

    /// How much its velocity is above the one that goes with its impulse, m/s or rad/s; none where no velocity does, as of a spring
    /// whose force is given.
    pub(crate) fn velocity_error(&self, velocities: [Option<&Vector6>; 2]) -> Option<f64> {
        let error = self.velocity(velocities) - self.target;
        if self.is_rigid() {
            return (self.stiffness > 0.0).then_some(error);
        }
        let given = (self.impulse - self.base) / self.stiffness;
        given.is_finite().then_some(error + given)
    }

    /// Whether it is rigid, acts, and misses its target by more than its softness leaves.
    pub(super) fn is_contradicted(&self, velocities: [Option<&Vector6>; 2]) -> bool {
        if self.state != RowState::Free || !self.is_rigid() {
            return false;
        }
        let Some(miss) = self.velocity_error(velocities) else {
            return false;
        };
        let speeds = self.speeds(velocities).map(f64::abs);
        let given = self.mobility * self.impulse.abs();
        let most = speeds.iter().sum::<f64>() + self.target.abs() + given;
        miss.abs() > CONTRADICTED * most
    }

    /// Impulse that it is to have more, at a velocity of the row and before that changes. At a bound it is all that is left, whatever the
    /// velocity.
    #[inline(always)]
    pub(crate) fn missing_impulse(&self, velocity: impl FnOnce() -> f64) -> f64 {
        match self.state {
            RowState::AtLeast => self.bounds[0] - self.impulse,
            RowState::AtMost => self.bounds[1] - self.impulse,
            _ => self.unbounded(velocity()) - self.impulse,
        }
    }

    /// Impulse without bounds.
    #[inline(always)]
    pub(crate) fn unbounded(&self, velocity: f64) -> f64 {
        let base = if self.is_rigid() {
            self.impulse
        } else {
            self.base
        };
        self.unbounded_from(base, velocity)
    }

    /// The same from another base.
    #[inline(always)]
    pub(crate) fn unbounded_from(&self, base: f64, velocity: f64) -> f64 {
        base + self.stiffness * (self.target - velocity)
    }

    /// The state that goes with a velocity; of a row that acts, with the impulse that it has got.
    #[inline(always)]
    pub(crate) fn state_at(&self, velocity: impl FnOnce() -> f64) -> RowState {
        if self.always_acts() {
            return RowState::Free;
        }
        let wanted = if self.state == RowState::Free {
            self.impulse
        } else {
            self.unbounded(velocity())
        };
        // A rigid row that leaves one bound would reach the other at once, were it not asked in between.
        match self.state {
            RowState::AtLeast if wanted > self.bounds[0] => RowState::Free,
            RowState::AtMost if wanted < self.bounds[1] => RowState::Free,
            _ => self.state_of(wanted),
        }
    }

    /// The state that goes with an impulse without bounds.
    #[inline(always)]
    pub(crate) fn state_of(&self, wanted: f64) -> RowState {
        if wanted <= self.bounds[0] {
            RowState::AtLeast
        } else if wanted >= self.bounds[1] {
            RowState::AtMost
        } else {
            RowState::Free
        }
    }
}
