//! What the sub-steps of a step are told: the user's configuration as numbers that every method has.

use crate::simd::lanes::LaneWidth;
use crate::solver::adaptivity::{IslandRequirements, JointPresence};
use crate::solver::config::{FrictionModel, Method, Pgs, SoftStep, SolverConfig};
use crate::solver::graph::contact_order::ContactOrder;
use crate::solver::rows::soft_step::{Bias, RowSoftness, Softness};
use crate::solver::wide::bond::{BOND_DAMPING, BOND_RATE};
use glam::Vec3;

/// How many times the natural frequency and the damping ratio of contacts are larger in an island that has joints too: they are pushed
/// out as fast, and give way 16 times less. What hangs on a body by joints is not in the effective mass of its contacts, so a foot
/// would give way like a foot under a load of many times its mass, or ask for that many more sub-steps (`docs/decisions/joints.md`).
const STIFFNESS_AMONG_JOINTS: f32 = 4.0;

/// Times which [`SoftStep::sag`] contacts may give way there. What asks for more than the least sub-steps in spite of the stiffness is a light part under
/// many times its mass: a hand below a body, a plank below a truck.
const SAG_AMONG_JOINTS: f32 = 16.0;

/// Turn of a sub-step, rad, that is small enough for bodies that joints alone hold: rows are solved directly and motion is of second order, so that
/// the period of a pendulum is off by some `SWING^2 / 24` at most (`docs/decisions/joints.md`).
const SWING: f32 = 0.02;

/// The least sub-steps over those that slow ones of them take.
const SLOW_SHARE: u32 = 4;

/// A bounce that lasts as many steps or fewer is none; its speed comes to nothing in half of them. At 60 Hz and on Earth that is more than the 0.5 m/s of [`SolverConfig::restitution_threshold`].
const REBOUND_STEPS: f32 = 8.0;

/// Rebounds that lose less than this share of the speed are the less left out the less they lose.
pub(crate) const ELASTIC: f32 = 0.25;

/// What rests may approach by the speed of so many sub-steps' fall.
const REST_SUBSTEPS: f32 = 2.5;

/// Which of the [`Method`]s solves, without its settings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MethodKind {
    /// [`Method::SoftStep`].
    #[default]
    SoftStep,
    /// [`Method::Pgs`].
    Pgs,
    /// `Method::Exact`.
    #[cfg(feature = "exact")]
    Exact,
}

/// What tests and measurements hold against each other. All lane widths give the same bits; an order of one's own does not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SolverOverrides {
    /// How many lanes a register may have.
    pub lane_width: LaneWidth,
    /// In which order the contacts of an island are solved, instead of what follows from the method.
    pub order: Option<ContactOrder>,
}

/// How many times the updates of an island's sweeps beyond the least its local steps may cost.
const LOCAL_EFFORT: u32 = 2;

/// The numbers of one sub-step, and how many there are.
#[derive(Clone, Copy, Debug)]
pub struct SubstepSettings {
    /// What solves.
    pub method: MethodKind,
    /// Acceleration of dynamic bodies, m/s2.
    pub gravity: Vec3,
    /// Length of a sub-step, s.
    pub substep_dt: f32,
    /// Number of sub-steps; the least one before it is known what an island asks for.
    pub substeps: u32,
    /// See [`SoftStep::max_substeps`].
    pub max_substeps: u32,
    /// See [`SoftStep::sag`].
    pub sag: f32,
    /// See [`SoftStep::max_local_steps`].
    pub max_local_steps: u32,
    /// Sweeps before the bodies move.
    pub sweeps: u32,
    /// Sweeps after the bodies have moved.
    pub relax_sweeps: u32,
    /// See [`SoftStep::contact_frequency`].
    pub contact_frequency: f32,
    /// Damping ratio of soft contacts: the field of [`SoftStep`] or what it stands for.
    pub damping_ratio: f32,
    /// Times which frequency and damping ratio of contacts are larger than these in this island.
    pub stiffness: f32,
    /// See [`Pgs::baumgarte`].
    pub baumgarte: f32,
    /// See [`Pgs::slop`].
    pub slop: f32,
    /// See [`SolverConfig::push_out_speed`].
    pub push_out_speed: f32,
    /// See [`SolverConfig::restitution_threshold`].
    pub restitution_threshold: f32,
    /// See [`Pgs::friction`].
    pub friction: FrictionModel,
    /// See [`SoftStep::tolerance`].
    pub tolerance: Option<f32>,
    /// See [`SoftStep::max_sweeps`].
    pub max_sweeps: u32,
    /// See [`SoftStep::max_extra_updates`].
    pub max_extra_updates: u32,
    /// In which order contacts are solved.
    pub order: ContactOrder,
    /// How many lanes a register may have.
    pub lane_width: LaneWidth,
}

impl SubstepSettings {
    /// The sub-steps of a step of `step_dt` seconds.
    pub fn new(config: &SolverConfig, gravity: Vec3, step_dt: f32) -> Self {
        let settings = match config.method {
            Method::SoftStep(soft_step) => Self::of_soft_step(&soft_step),
            Method::Pgs(pgs) => Self::of_pgs(&pgs),
            #[cfg(feature = "exact")]
            Method::Exact(exact) => Self {
                method: MethodKind::Exact,
                substeps: exact.substeps,
                baumgarte: exact.baumgarte,
                friction: exact.friction,
                slop: 0.0,
                relax_sweeps: 1,
                order: ContactOrder::Automatic,
                ..Self::of_pgs(&Pgs::default())
            },
        };
        Self {
            gravity,
            push_out_speed: config.push_out_speed,
            restitution_threshold: config.restitution_threshold,
            substep_dt: step_dt / settings.substeps as f32,
            ..settings
        }
    }

    fn of_soft_step(soft_step: &SoftStep) -> Self {
        Self {
            method: MethodKind::SoftStep,
            gravity: Vec3::ZERO,
            substep_dt: 0.0,
            substeps: soft_step.min_substeps,
            max_substeps: soft_step.max_substeps,
            sag: soft_step.sag,
            max_local_steps: soft_step.max_local_steps,
            sweeps: soft_step.sweeps,
            relax_sweeps: soft_step.relax_sweeps,
            contact_frequency: soft_step.contact_frequency,
            damping_ratio: soft_step.damping_ratio(),
            stiffness: 1.0,
            baumgarte: 0.0,
            slop: 0.0,
            push_out_speed: 0.0,
            restitution_threshold: 0.0,
            friction: FrictionModel::Disc,
            tolerance: soft_step.tolerance,
            max_sweeps: soft_step.max_sweeps,
            max_extra_updates: soft_step.max_extra_updates,
            order: ContactOrder::Automatic,
            lane_width: LaneWidth::Widest,
        }
    }

    /// What only soft contacts have is not used.
    fn of_pgs(pgs: &Pgs) -> Self {
        Self {
            method: MethodKind::Pgs,
            substeps: pgs.substeps,
            max_substeps: pgs.substeps,
            max_local_steps: 1,
            sweeps: pgs.sweeps,
            relax_sweeps: 0,
            baumgarte: pgs.baumgarte,
            slop: pgs.slop,
            friction: pgs.friction,
            tolerance: pgs.tolerance,
            max_sweeps: pgs.max_sweeps,
            order: ContactOrder::Ordered,
            ..Self::of_soft_step(&SoftStep::default())
        }
    }

    /// Most local steps that an island may take in which contacts have so many points, so that these do not cost more than its sweeps may: a
    /// power of two.
    pub(crate) fn affordable_local_steps(&self, points: u32) -> u32 {
        let sweeps = self.sweeps.saturating_add(self.relax_sweeps);
        let updates = points.saturating_mul(self.substeps).saturating_mul(sweeps);
        let affordable = LOCAL_EFFORT.saturating_mul(self.max_extra_updates) / updates.max(1);
        1 << self.max_local_steps.min(affordable).max(1).ilog2()
    }

    /// The same, with what a test wants otherwise.
    pub fn overridden(self, overrides: &SolverOverrides) -> Self {
        Self {
            lane_width: overrides.lane_width,
            order: overrides.order.unwrap_or(self.order),
            ..self
        }
    }

    /// The same step in as many parts as an island asks for.
    ///
    /// A soft contact under a load that gives its effective mass the acceleration `a` gives way by `s = a h^2 / (h omega)^2`,
    /// which is to stay below the share [`SoftStep::sag`] of an extent.
    pub fn for_requirements(&self, requirements: &IslandRequirements) -> Self {
        if self.method != MethodKind::SoftStep {
            return *self;
        }
        let substeps = self.substeps_for(requirements);
        Self {
            substeps,
            substep_dt: self.step_dt() / substeps as f32,
            stiffness: self.stiffness_for(requirements),
            ..*self
        }
    }

    /// Number of parts that [`for_requirements`](Self::for_requirements) makes.
    pub fn substeps_for(&self, requirements: &IslandRequirements) -> u32 {
        if self.method != MethodKind::SoftStep {
            return self.substeps;
        }
        if let Some(swing) = requirements.joint_swing {
            let parts = (swing / SWING).ceil() as u32;
            return parts.clamp(self.substeps.div_ceil(SLOW_SHARE), self.substeps);
        }
        let step_dt = self.step_dt();
        let frequency = self.stiffness_for(requirements) * self.contact_frequency;
        let per_radian = step_dt / (std::f32::consts::TAU * frequency);
        let parts =
            per_radian * (requirements.load / (step_dt * self.sag_for(requirements))).sqrt();
        // A number that is not finite becomes one end of the range.
        (parts.ceil() as u32).clamp(self.substeps, self.max_substeps.max(self.substeps))
    }

    /// Load, as in [`IslandRequirements::load`], under which contacts give way by [`sag`](Self::sag) with these sub-steps, 1/s.
    pub(crate) fn bearable_load(&self) -> f32 {
        let frequency = std::f32::consts::TAU * self.contact_frequency / self.substep_dt;
        self.step_dt() * self.sag * frequency * frequency
    }

    /// See [`sag`](Self::sag).
    fn sag_for(&self, requirements: &IslandRequirements) -> f32 {
        match requirements.joints {
            JointPresence::AmongContacts => SAG_AMONG_JOINTS * self.sag,
            _ => self.sag,
        }
    }

    /// See [`stiffness`](Self::stiffness); 1 where the user has fixed the number of sub-steps.
    fn stiffness_for(&self, requirements: &IslandRequirements) -> f32 {
        match requirements.joints {
            JointPresence::AmongContacts if self.depends_on_load() => STIFFNESS_AMONG_JOINTS,
            _ => 1.0,
        }
    }

    /// Whether the number of parts depends on the load.
    pub fn depends_on_load(&self) -> bool {
        self.method == MethodKind::SoftStep && self.max_substeps > self.substeps
    }

    /// Compliance of the rows.
    pub fn softness(&self) -> RowSoftness {
        if self.method != MethodKind::SoftStep {
            return RowSoftness::HARD;
        }
        let of = |times: f32, ratio: f32| {
            let frequency = times * self.contact_frequency;
            Softness::new(frequency, times * ratio, self.substep_dt)
        };
        RowSoftness {
            contacts: of(self.stiffness, self.damping_ratio),
            friction: 1.0,
            bonds: of(1.0, BOND_DAMPING),
        }
    }

    /// How overlap is pushed out.
    pub fn bias(&self) -> Bias {
        let rates = match self.method {
            MethodKind::SoftStep => {
                let RowSoftness {
                    contacts, bonds, ..
                } = self.softness();
                [contacts.bias_rate, bonds.bias_rate]
            }
            _ => [self.baumgarte / self.substep_dt; 2],
        };
        Bias {
            substep_dt: self.substep_dt,
            bias_rate: rates[0],
            bond_rate: BOND_RATE * rates[1],
            max_bias_velocity: self.push_out_speed,
        }
    }

    /// Approach speed below which what accelerates no faster than `acceleration` does not rebound, m/s: a bounce that lasts
    /// [`REBOUND_STEPS`] steps or less, unless it is one that hardly loses speed and goes on for ever. What rests, and gains speed in each
    /// sub-step, must not take it for a bounce in any case.
    pub fn rebound_threshold(&self, acceleration: f32, restitution: f32) -> f32 {
        let [short, rest] = self.rebound_speeds(acceleration);
        let share = ((1.0 - restitution) / ELASTIC).min(1.0);
        let asked = self.restitution_threshold;
        (share * short.min(asked)).max(rest).min(asked)
    }

    /// What an acceleration gives within the shortest bounce, and to what rests, m/s.
    pub(crate) fn rebound_speeds(&self, acceleration: f32) -> [f32; 2] {
        [
            0.5 * REBOUND_STEPS * acceleration * self.step_dt(),
            REST_SUBSTEPS * acceleration * self.substep_dt,
        ]
    }

    /// Length of the step, s.
    pub fn step_dt(&self) -> f32 {
        self.substep_dt * self.substeps as f32
    }

    /// Whether the last sweep of a sub-step is one without position bias.
    pub fn is_relaxed(&self) -> bool {
        self.method == MethodKind::SoftStep && self.relax_sweeps > 0
    }

    /// Whether it is the exact method that solves.
    #[inline]
    pub fn is_exact(&self) -> bool {
        #[cfg(feature = "exact")]
        return self.method == MethodKind::Exact;
        #[cfg(not(feature = "exact"))]
        false
    }
}

impl Default for SubstepSettings {
    fn default() -> Self {
        Self::of_soft_step(&SoftStep::default())
    }
}
