//! What islands ask of the sub-steps: how many, how many sweeps, and whether they must look out for impacts.

use crate::solver::adaptivity::IslandRequirements;
use crate::solver::config::{Method, SolverConfig};
use crate::solver::rows::soft_step::Bias;
use crate::solver::rows::soft_step::Softness;
use glam::Vec3;

/// What the sub-steps are told.
#[derive(Clone, Copy, Debug, Default)]
pub struct SubstepSettings {
    /// How to solve.
    pub config: SolverConfig,
    /// Acceleration of dynamic bodies, m/s2.
    pub gravity: Vec3,
    /// Length of a sub-step, s.
    pub h: f32,
}

impl SubstepSettings {
    /// The sub-steps of a step of `step` seconds.
    pub fn new(config: SolverConfig, gravity: Vec3, step: f32) -> Self {
        Self {
            config,
            gravity,
            h: step / config.substeps as f32,
        }
    }

    /// The same step in as many parts as an island asks for.
    ///
    /// A soft contact under a load that gives its effective mass the acceleration `a` gives way by `s = a h^2 / (h omega)^2`,
    /// which is to stay below the share [`SolverConfig::sag`] of an extent.
    pub fn for_requirements(&self, demand: &IslandRequirements) -> Self {
        let config = &self.config;
        if config.method != Method::SoftStep {
            return *self;
        }
        let config = SolverConfig {
            substeps: self.substeps_for(demand),
            ..*config
        };
        Self::new(config, self.gravity, self.step())
    }

    /// Number of parts that [`for_requirements`](Self::for_requirements) makes.
    pub fn substeps_for(&self, demand: &IslandRequirements) -> u32 {
        let config = &self.config;
        if config.method != Method::SoftStep {
            return config.substeps;
        }
        let step = self.step();
        let per_radian = step / (std::f32::consts::TAU * config.contact_frequency);
        let parts = per_radian * (demand.load / (step * config.sag)).sqrt();
        // A number that is not finite becomes one end of the range.
        (parts.ceil() as u32).clamp(config.substeps, config.max_substeps.max(config.substeps))
    }

    /// Whether the number of parts depends on the load.
    pub fn depends_on_load(&self) -> bool {
        let config = &self.config;
        config.method == Method::SoftStep && config.max_substeps > config.substeps
    }

    /// Compliance of the rows.
    pub fn softness(&self) -> Softness {
        match self.config.method {
            Method::SoftStep => Softness::new(&self.config, self.h),
            Method::Pgs | Method::Exact => Softness::HARD,
        }
    }

    /// How overlap is pushed out.
    pub fn bias(&self) -> Bias {
        let bias_rate = match self.config.method {
            Method::SoftStep => self.softness().bias_rate,
            Method::Pgs | Method::Exact => self.config.baumgarte / self.h,
        };
        Bias {
            substep_dt: self.h,
            bias_rate,
            max_bias_velocity: self.config.push_out_speed,
        }
    }

    /// Length of the step, s.
    pub fn step(&self) -> f32 {
        self.h * self.config.substeps as f32
    }
}
