//! Soft contacts, and a sweep without position bias once the bodies have moved.
//!
//! An overlapping contact is a spring of natural frequency `omega` and damping ratio `zeta` on the effective mass of its
//! row, integrated implicitly over the sub-step `substep_dt`. That is the row of the problem with a compliance on the diagonal:
//!
//! ```text
//! a1 = 2 zeta + substep_dt omega,  a2 = substep_dt omega a1
//! w = J v - u + gamma lambda,  gamma = A_ii / a2,  u = (omega / a1) overlap
//! ```
//!
//! so that overlap is pushed out at a rate which every stack can bear, whatever its height. The velocity that does so
//! would stay with the bodies; sweeps after the motion, hard and with `u = 0`, take it out again and leave the impulses
//! that the bodies need to rest.
//!
//! The frequency is a share of the sub-step rate without an upper limit: a limit bounds how high a stack can be.
//!
//! # References
//! Catto, "Soft Constraints", GDC 2011; Catto, "Solver2D", 2024 (soft contacts, relax sweep); Macklin et al., "Small Steps
//! in Physics Simulation", 2019.

/// Coefficients of soft contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Softness {
    /// Share of the overlap that is pushed out per second, 1/s.
    pub bias_rate: f32,
    /// `a2 / (1 + a2)`: share of the effective mass that a sweep uses.
    pub mass_scale: f32,
    /// `1 / (1 + a2)`: share of the impulse that a sweep lets go.
    pub impulse_scale: f32,
}

impl Softness {
    /// No compliance: the rows of the paper.
    pub const HARD: Self = Self {
        bias_rate: 0.0,
        mass_scale: 1.0,
        impulse_scale: 0.0,
    };

    /// The coefficients for sub-steps of `substep_dt` seconds: `contact_frequency` as a share of the sub-step rate.
    pub fn new(contact_frequency: f32, damping_ratio: f32, substep_dt: f32) -> Self {
        let h_omega = std::f32::consts::TAU * contact_frequency;
        let a1 = 2.0 * damping_ratio + h_omega;
        let a2 = h_omega * a1;
        Self {
            bias_rate: if a1 > 0.0 {
                h_omega / (substep_dt * a1)
            } else {
                0.0
            },
            mass_scale: a2 / (1.0 + a2),
            impulse_scale: 1.0 / (1.0 + a2),
        }
    }
}

/// The softness of each kind of rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowSoftness {
    /// Of contacts.
    pub contacts: Softness,
    /// How far the friction of contacts goes in a sweep towards stopping a point: a share of the change that would.
    pub friction: f32,
    /// Of bonds.
    pub bonds: Softness,
}

impl RowSoftness {
    /// No compliance.
    pub const HARD: Self = Self {
        contacts: Softness::HARD,
        friction: 1.0,
        bonds: Softness::HARD,
    };

    /// How far friction goes in sweeps with position bias that end before rows agree. What pushes overlap out moves points along their
    /// tangents too, only while bodies move: friction that follows all of it passes it on through a deck of thin plates, the sweeps without
    /// bias do not get to take all of it back, and the plates rock and creep for ever (`docs/decisions/soft_step.md`). Where sweeps go on until
    /// rows agree, half steps end at the same impulses, but what rolls, for which one sweep is enough, would gain speed.
    pub const UNCONVERGED_FRICTION: f32 = 0.5;
}

/// The normal velocity that a point should have after the bodies have moved, m/s. A `rebound` that is not positive is added to the
/// least that it may have.
pub(crate) fn relaxed_velocity(rebound: f32, impulse: f32, target_velocity: f32) -> f32 {
    if rebound > 0.0 {
        rebound
    } else if impulse > 0.0 {
        // Pushed, so it has arrived.
        rebound
    } else {
        target_velocity.min(0.0) + rebound
    }
}

/// How position bias is computed; see `soft_step`.
#[derive(Clone, Copy, Debug)]
pub struct Bias {
    /// Length of the sub-step, s.
    pub substep_dt: f32,
    /// Share of the overlap that is pushed out per second, 1/s.
    pub bias_rate: f32,
    /// Share of its displacement by which a bonded point goes back per second, 1/s.
    pub bond_rate: f32,
    /// Fastest speed at which that happens, m/s.
    pub max_bias_velocity: f32,
}
