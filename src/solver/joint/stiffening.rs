//! Inertia that bodies have besides their own, since what they bear at joints resists their turn.

use glam::{DMat3, DVec3};

/// `1 / (h omega)^2` of the fastest swing that is left. With 1 twice as many of 300 chains under 300 to 1500 times a link's mass come open.
const FASTEST: f64 = 0.5;

/// Share of the turn at which bodies have no such inertia any more, beyond which the energy of their component is bounded.
const BOUNDED: f64 = 0.3;

/// What makes bodies of joints hard to turn.
#[derive(Debug, Default)]
pub(super) struct Stiffening {
    /// By body, N m / rad.
    pub(super) stiffness: Vec<DMat3>,
    /// By component.
    pub(super) swings: Vec<Swing>,
    /// Whether bodies have such inertia.
    pub(super) is_any: bool,
}

/// How a component moves in a sub-step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Swing {
    /// Fastest turn of a body, over that at which none has inertia besides its own any more.
    pub(super) turn: f64,
    /// Whether bodies have such inertia.
    pub(super) is_stiffened: bool,
    /// Angular momentum that they have got by it, N m s.
    pub(super) borrowed_spin: DVec3,
}

impl Swing {
    /// Whether it may gain energy by such inertia.
    pub(super) fn is_fast(&self) -> bool {
        self.is_stiffened && self.turn > BOUNDED
    }
}

/// How hard a force at an anchor makes it to turn a body, N m / rad; not at all where it pushes the body, which makes that easier.
#[inline(always)]
pub(super) fn stiffness_of(r: DVec3, force: DVec3) -> DMat3 {
    let pull = r.dot(force);
    if pull > 0.0 && pull.is_finite() {
        let n = r.normalize();
        pull * (DMat3::IDENTITY - DMat3::from_cols(n * n.x, n * n.y, n * n.z))
    } else {
        DMat3::ZERO
    }
}

/// Inertia that a body has besides its own, kg m2, such that its fastest swing has `(h omega)^2 = 1 / FASTEST` at most. Two axes swing alike
/// as a rule, so that `omega^2` of the fastest is half of the trace of `I^-1 K`.
#[inline(always)]
pub(super) fn implicit_inertia(inverse_inertia: &DMat3, stiffness: &DMat3, h: f64) -> DMat3 {
    let of_axis = |i: usize| inverse_inertia.row(i).dot(stiffness.col(i));
    let square = 0.5 * (0..3).map(of_axis).sum::<f64>();
    let share = FASTEST * h * h - square.recip();
    if square > 0.0 && share > 0.0 {
        share * *stiffness
    } else {
        DMat3::ZERO
    }
}
