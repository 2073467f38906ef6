//! Soft contacts, and a sweep without position feedback once the bodies have moved.
//!
//! An overlapping contact is a spring of natural frequency `omega` and damping ratio `zeta` on the effective mass of its
//! row, integrated implicitly over the sub-step `h`. That is the row of the problem with a compliance on the diagonal:
//!
//! ```text
//! a1 = 2 zeta + h omega,  a2 = h omega a1
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

use super::SolverConfig;
use super::bodies::SolverBody;
use super::pgs::{self, NormalRule};
use super::rows::PointRows;

/// Coefficients of soft contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Softness {
    /// Share of the overlap that is pushed out per second, 1/s.
    pub rate: f32,
    /// `a2 / (1 + a2)`: share of the effective mass that a sweep uses.
    mass_scale: f32,
    /// `1 / (1 + a2)`: share of the impulse that a sweep lets go.
    release: f32,
}

impl Softness {
    /// The coefficients for sub-steps of `h` seconds.
    pub fn new(config: &SolverConfig, h: f32) -> Self {
        let h_omega = std::f32::consts::TAU * config.contact_frequency;
        let a1 = 2.0 * config.damping_ratio + h_omega;
        let a2 = h_omega * a1;
        Self {
            rate: if a1 > 0.0 { h_omega / (h * a1) } else { 0.0 },
            mass_scale: a2 / (1.0 + a2),
            release: 1.0 / (1.0 + a2),
        }
    }
}

impl NormalRule for Softness {
    #[inline]
    fn wish(&self, point: &PointRows, velocity: f32) -> f32 {
        let row = &point.normal;
        let correction = (velocity - row.wanted) * row.effective_mass;
        if point.is_soft {
            (1.0 - self.release) * row.impulse - self.mass_scale * correction
        } else {
            row.impulse - correction
        }
    }
}

/// Hard rows without position feedback: points that touch stop, others may close their gap, impacts rebound.
#[derive(Clone, Copy, Debug)]
struct Relaxed;

impl NormalRule for Relaxed {
    // The normal impulse falls by what pushed overlap out; friction must not keep the bound that came with it.
    const NORMAL_FIRST: bool = true;

    #[inline]
    fn wish(&self, point: &PointRows, velocity: f32) -> f32 {
        let row = &point.normal;
        row.impulse - (velocity - relaxed_velocity(point)) * row.effective_mass
    }
}

/// The normal velocity that a point should have after the bodies have moved, m/s.
pub fn relaxed_velocity(point: &PointRows) -> f32 {
    if point.rebound > 0.0 {
        point.rebound
    } else if point.normal.impulse > 0.0 {
        // Pushed, so it has arrived.
        0.0
    } else {
        point.normal.wanted.min(0.0)
    }
}

/// One sweep with soft contacts; returns the largest velocity change, as [`pgs::sweep`].
pub fn sweep(
    rows: &mut [PointRows],
    bodies: &mut [SolverBody],
    softness: &Softness,
    config: &SolverConfig,
) -> f32 {
    pgs::sweep(rows, bodies, softness, config.friction_model)
}

/// One sweep after the bodies have moved; returns the largest velocity change, as [`pgs::sweep`].
pub fn relax(rows: &mut [PointRows], bodies: &mut [SolverBody], config: &SolverConfig) -> f32 {
    pgs::sweep(rows, bodies, &Relaxed, config.friction_model)
}
