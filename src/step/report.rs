//! What a step did, and how wrong it was.

use crate::bodies::body::BodyError;
use crate::contact::impulses::CacheStats;
use crate::solver::rows::mlcp::Residual;
use bevy_ecs::resource::Resource;

/// What the last step did.
#[derive(Clone, Debug, Default, PartialEq, Resource)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct StepReport {
    /// Bodies in the simulation.
    pub bodies: usize,
    /// Dynamic bodies that are awake.
    pub awake: usize,
    /// Bodies that sleep.
    pub asleep: usize,
    /// Pairs that the broad phase found.
    pub pairs: usize,
    /// Pairs that touch or nearly touch.
    pub manifolds: usize,
    /// Contact points.
    pub contacts: usize,
    /// How the contact cache did.
    pub cache: CacheStats,
    /// Errors of the solution; only with [`SolverConfig::measure_error`](crate::solver::SolverConfig::measure_error).
    pub error: Option<StepError>,
    /// One body each of the islands in which a sub-step ended above the tolerance, by slot.
    pub unconverged: Vec<u32>,
    /// The islands; only with [`SolverConfig::measure_islands`](crate::solver::SolverConfig::measure_islands).
    #[cfg_attr(feature = "reflect", reflect(ignore))]
    pub islands: Vec<IslandReport>,
    /// Bodies that were left out since the last step, with the reason, by slot.
    #[cfg_attr(feature = "reflect", reflect(ignore))]
    pub problems: Vec<(u32, BodyError)>,
}

/// How wrong the step was.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct StepError {
    /// Residual of the contact problem of the last sub-step.
    pub residual: Residual,
    /// Deepest overlap of two bodies at the start of the step, m.
    pub penetration: f32,
    /// Kinetic energy of all dynamic bodies after the step, J.
    pub kinetic_energy: f64,
    /// Potential energy of all dynamic bodies in the gravity field after the step, zero at the origin, J.
    pub potential_energy: f64,
    /// What both together gained in the step, J; friction and impacts make it negative.
    pub energy_change: f64,
}

/// How one island was solved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IslandReport {
    /// Slot of one of its dynamic bodies, to find it by.
    pub slot: u32,
    /// Bodies, with those that contacts do not move.
    pub bodies: usize,
    /// Contact points.
    pub contacts: usize,
    /// Sweeps of all sub-steps together.
    pub sweeps: u32,
    /// Whether a sub-step ended above the tolerance, because the most sweeps were done.
    pub is_unconverged: bool,
    /// Its own residual, with [`SolverConfig::measure_error`](crate::solver::SolverConfig::measure_error).
    pub residual: Option<Residual>,
}
