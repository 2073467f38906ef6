//! What all phases of one step are told.

use crate::fracture::FractureBudget;
use crate::solver::config::{Gravity, SolverConfig};
use crate::solver::settings::SolverOverrides;

/// What all phases of one step are told.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepSettings {
    /// Gravity.
    pub gravity: Gravity,
    /// How contacts are solved.
    pub config: SolverConfig,
    /// What fracture may cost.
    pub budget: FractureBudget,
    /// Length of the step, s.
    pub step_dt: f32,
    /// What a test wants otherwise.
    #[doc(hidden)]
    pub overrides: SolverOverrides,
}

impl StepSettings {
    /// Whether a step can be made: its length must be finite and positive, gravity and configuration usable.
    pub fn is_usable(&self) -> bool {
        self.has_length() && self.are_numbers_usable()
    }

    /// Whether the step is positive and finite; it is not while time is paused.
    pub fn has_length(&self) -> bool {
        self.step_dt.is_finite() && self.step_dt > 0.0
    }

    /// Whether gravity is finite and the configuration usable.
    pub fn are_numbers_usable(&self) -> bool {
        self.gravity.0.is_finite() && self.config.is_usable()
    }
}
