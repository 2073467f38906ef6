//! What islands ask of the sub-steps: how many, how many sweeps, and whether they must look out for blows.

use super::bodies::Bodies;
use super::soft_step::Softness;
use super::sweep::Feedback;
use super::{Method, SolverConfig};
use glam::Vec3;

/// Turn within a step (rad) from which the rows of a body's contacts follow it.
const TURN: f32 = 0.01;

/// Travel of two bodies against each other within a step, as a share of the smaller one's least extent, from which the
/// rows of their contact follow it.
const TRAVEL: f32 = 0.02;

/// What an island asks of its sub-steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Demand {
    /// Largest velocity that a contact gave its effective mass in the last step, over the smaller body's least extent, 1/s.
    /// Infinite where a bond is new: what it will bear must be found before it gives way.
    pub load: f32,
    /// Whether bodies may hit each other: some move, or rebound.
    pub can_hit: bool,
    /// Sub-steps that follow from all that.
    pub substeps: u32,
}

impl Demand {
    /// Whether islands with the two demands can be solved together.
    pub fn is_solved_like(&self, other: &Self) -> bool {
        self.substeps == other.substeps && self.can_hit == other.can_hit
    }
}

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
    pub fn for_demand(&self, demand: &Demand) -> Self {
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

    /// Number of parts that [`for_demand`](Self::for_demand) makes.
    pub fn substeps_for(&self, demand: &Demand) -> u32 {
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
    pub fn feedback(&self) -> Feedback {
        let rate = match self.config.method {
            Method::SoftStep => self.softness().rate,
            Method::Pgs | Method::Exact => self.config.baumgarte / self.h,
        };
        Feedback {
            h: self.h,
            rate,
            most: self.config.push_out_speed,
        }
    }

    /// Length of the step, s.
    pub fn step(&self) -> f32 {
        self.h * self.config.substeps as f32
    }
}

/// What a batch took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Effort {
    /// Sweeps of all sub-steps together.
    pub sweeps: u32,
    /// Whether a sub-step ended above the tolerance.
    pub hit_cap: bool,
    /// Sweeps beyond the least numbers that are left for this step, and for this sub-step: evenly, for sub-steps that are
    /// more precise than the next ones shake a stack.
    spare: u32,
    share: u32,
}

impl Effort {
    /// For a batch whose largest island has the given number of points.
    pub fn new(config: &SolverConfig, points: usize) -> Self {
        Self {
            spare: config.spare_updates / (points as u32).max(1),
            ..Self::default()
        }
    }

    /// Begins a sub-step, with `to_go` of them left.
    pub fn begin(&mut self, to_go: u32) {
        self.share = self.spare / to_go;
    }

    /// Most sweeps beyond the least number that this sub-step may still have.
    pub fn share(&self) -> u32 {
        self.share
    }

    /// Takes note of sweeps, `extra` of them beyond the least number, and whether they ended above the tolerance.
    pub fn note(&mut self, sweeps: u32, extra: u32, hit_cap: bool) {
        self.sweeps += sweeps;
        self.share -= extra;
        self.spare -= extra;
        self.hit_cap |= hit_cap;
    }
}

/// How two bodies move against each other in a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Travel {
    /// So far that the rows between them must follow.
    pub is_noticeable: bool,
    /// Farther than both are thick: they may pass through each other.
    pub is_fast: bool,
}

impl Travel {
    /// Of the bodies in two slots; `step`, s.
    pub fn of(bodies: &Bodies, slots: [usize; 2], step: f32) -> Self {
        let [a, b] = slots.map(|i| &bodies.velocity[i]);
        let extents = slots.map(|i| bodies.least_extent[i]);
        // Squares, so that no root has to be taken for each manifold of the scene.
        let square = |x: f32| x * x;
        let spin = a.angular.length_squared().max(b.angular.length_squared());
        let turn = square(step) * spin;
        let way = square(step) * (b.linear - a.linear).length_squared();
        Self {
            is_noticeable: turn > square(TURN) || way > square(TRAVEL * extents[0].min(extents[1])),
            is_fast: way > square(extents[0] + extents[1]),
        }
    }
}
