//! Inertia that bodies have besides their own, since what they bear at joints resists their turn.

use glam::{DMat3, DVec3};

/// `1 / (h omega)^2` of the fastest swing that is left. With 1 twice as many of 300 chains under 300 to 1500 times a link's mass come open.
const FASTEST: f64 = 0.5;

/// What makes bodies of joints hard to turn.
#[derive(Debug, Default)]
pub(super) struct Stiffening {
    /// By body, N m / rad.
    pub(super) stiffness: Vec<DMat3>,
    /// By component: fastest turn of a body in the sub-step, over that at which it has no such inertia any more.
    pub(super) turns: Vec<f64>,
    /// By component: angular momentum that bodies have got in the sub-step by inertia that is none of theirs, N m s.
    pub(super) borrowed_spin: Vec<DVec3>,
    /// Whether bodies have such inertia.
    pub(super) is_any: bool,
    /// Whether some have that turn fast.
    pub(super) is_fast: bool,
}

/// How hard a force at an anchor makes it to turn a body, N m / rad; not at all where it pushes the body, which makes that easier.
pub(super) fn stiffness_of(r: DVec3, force: DVec3) -> DMat3 {
    let pull = r.dot(force);
    if pull > 0.0 {
        let n = r.normalize();
        pull * (DMat3::IDENTITY - DMat3::from_cols(n * n.x, n * n.y, n * n.z))
    } else {
        DMat3::ZERO
    }
}

/// Inertia that a body has besides its own, kg m2, such that its fastest swing has `(h omega)^2 = 1 / FASTEST` at most. Two axes swing alike
/// as a rule, so that `omega^2` of the fastest is half of the trace of `I^-1 K`.
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
