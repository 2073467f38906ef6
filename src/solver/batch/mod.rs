//! Islands that are solved together: their bodies, blocks of contacts and buffers, in one piece of memory each.
//!
//! A batch shares nothing that is written with any other, so batches are loaded and solved side by side. Large islands and
//! those in which bodies may hit each other have a batch of their own; calm small ones share one, which fills its lanes, and so do
//! small ones whose contacts share a body, [each as if it were alone](lone).
//!
//! This room alone knows both who is where (`graph`) and what eight contacts do (`wide`), and it knows time. Read
//! [`substep`] first: one sub-step, line by line; [`load`] is what comes before, [`results`] what comes after.

mod bonds;
pub(crate) mod cluster_blow;
mod contacts;
mod drives;
mod energy_guard;
#[cfg(feature = "exact")]
mod exact_substep;
mod extra_lanes;
mod impacts;
mod joint_halves;
mod joint_results;
mod joints;
pub(crate) mod layout;
mod load;
pub(crate) mod lone;
mod mass_scaling;
mod motion;
mod open_joints;
mod overload;
mod parallel_pass;
mod pass;
mod reanchoring;
mod rebound;
mod results;
mod subdomain_slices;
pub(crate) mod substep;
mod sweeps;
mod swings;
mod targets;
mod warm_start;

pub(crate) use contacts::{BatchContacts, MovingManifold};
pub(crate) use joints::BatchJoints;
pub use load::Step;

use crate::bodies::breaking::{Blow, BreakingLimit, ImpactLoad, Rest};
use crate::bodies::drive::Drive;
use crate::bodies::free_rotation::FreeRotation;
use crate::bodies::solver_body::{BodyMass, SolverBody};
use crate::simd::lanes::F8;
use crate::solver::adaptivity::SweepBudget;
use crate::solver::batch::cluster_blow::{Crack, Strain};
use crate::solver::rows::acceleration::AccelerationWeight;
use crate::solver::settings::SubstepSettings;
use crate::solver::wide::block::PointImpact;
use crate::solver::wide::bond::BondConstraint;
use glam::{Mat3, Quat, Vec3};
use layout::Layout;
use lone::LoneIslands;
use mass_scaling::Squeeze;

/// Islands with all that their sub-steps read and write; buffers are reused from step to step.
#[derive(Debug, Default)]
pub struct Batch {
    /// Who is where.
    pub layout: Layout,
    /// The contacts, in lanes.
    pub contacts: BatchContacts,
    /// The bodies, by their numbers within the batch.
    pub bodies: BatchBodies,
    /// What bodies that hit each other leave behind.
    pub impacts: Impacts,
    /// What holds bodies together.
    pub bonds: BatchBonds,
    /// What holds bodies together at a distance.
    pub joints: BatchJoints,
    /// How it is solved.
    pub settings: SubstepSettings,
    /// What it took.
    pub budget: SweepBudget,
    /// What each island has for itself, where they are solved so.
    pub(crate) lone: LoneIslands,
    pub(crate) scratch: BatchScratch,
}

/// The bodies of a batch, one that nothing happens to, for the lanes that are not used, and copies of fixed ones.
#[derive(Debug, Default)]
pub struct BatchBodies {
    /// Velocities.
    pub velocities: Vec<SolverBody>,
    /// Displacements since the start of the step: center (m) and rotation vector (rad).
    pub displacements: Vec<SolverBody>,
    /// Masses and inertias.
    pub masses: Vec<BodyMass>,
    /// Those that are driven, and their numbers within the batch.
    pub(crate) driven: Vec<(u32, Drive)>,
    /// Largest acceleration that drives give, besides gravity, m/s2.
    pub(crate) most_driven: f32,
    /// Those that turn.
    pub turning: Vec<TurningBody>,
    /// By island: the largest extent that a contact is measured by, the lesser of the least extents of two bodies, m.
    pub extents: Vec<f32>,
    /// By island, if its energy is guarded: largest moment of inertia of a body over its mass, m2.
    pub(crate) inertias: Vec<f32>,
    /// By island, if a tolerance depends on it: square of the largest speed before contacts act in the sub-step, m2/s2.
    pub(crate) fastest: Vec<f32>,
    /// By body: its velocities at the start of the sub-step, then what contacts have added to them; empty if that is not known.
    pub(crate) contact_velocity_changes: Vec<SolverBody>,
}

/// A body that turns, and its number within the batch.
#[derive(Clone, Copy, Debug)]
pub struct TurningBody {
    /// Number within the batch.
    pub body: u32,
    /// `world_from_body` at the start of the step.
    pub start: Quat,
    /// Its rotation.
    pub spin: FreeRotation,
    /// Inverse inertia tensor, body's axes, 1/(kg m2).
    pub inverse_inertia: Mat3,
    /// Whether it turns with its joints.
    pub is_jointed: bool,
    /// The angular displacement that the rotation has followed, rad.
    pub followed: Vec3,
    /// Whether it is round: then rounding must not be taken for energy, which it would lose of rolling for ever.
    pub is_round: bool,
}

impl TurningBody {
    /// Its rotation since the start of the step.
    pub fn turn(&self) -> Quat {
        self.spin.rotation * self.start.inverse()
    }
}

/// Impacts within a batch: empty where nothing can hit, rebound or break.
#[derive(Debug, Default)]
pub struct Impacts {
    /// By point, if bodies may hit each other.
    pub points: Vec<PointImpact>,
    /// Whether any point rebounds.
    pub has_restitution: bool,
    /// By island, where bodies rebound: energy that they have been given by not falling as far as they were to, J.
    pub(crate) lifts: Vec<f64>,
    /// By body: whether it was hit in this sub-step.
    pub(crate) is_hit: Vec<bool>,
    /// Bodies that break under too large an impulse.
    pub limits: Vec<BreakingLimit>,
    /// What bodies were hit with that are overloaded, by their numbers.
    pub(crate) overloaded: Vec<Blow>,
    /// Bonds within bodies that broke without anything coming off.
    pub(crate) cracks: Vec<Crack>,
    /// Bonds within bodies that blows wear.
    pub(crate) strains: Vec<Strain>,
    /// What may still be followed in the step of blows to clusters, see [`FOLLOWED_PER_STEP`](crate::cluster::blow::FOLLOWED_PER_STEP).
    pub(crate) follow_left: usize,
    /// Whether the solve is to be given up when a body is overloaded.
    pub may_break: bool,
    /// Whether the solve was given up because a body breaks; velocities and motions mean nothing then.
    pub is_broken: bool,
    /// Velocities at the start of the step, if a body may break.
    pub(crate) start: Vec<SolverBody>,
    /// By manifold, if a body may break: how its bodies rest on each other.
    pub(crate) rests: Vec<Rest>,
    /// By body: what it was hit with.
    pub(crate) loads: Vec<ImpactLoad>,
}

/// Bonds within a batch: empty where nothing is bonded.
#[derive(Debug, Default)]
pub struct BatchBonds {
    /// By point.
    pub constraints: Vec<BondConstraint>,
}

/// Buffers of the sub-steps.
#[derive(Debug, Default)]
pub(crate) struct BatchScratch {
    pub(crate) acceleration: AccelerationWeight<f32>,
    /// Impulses and velocities of the sweep before.
    pub(crate) last_impulses: Vec<[F8; 3]>,
    pub(crate) last_velocities: Vec<SolverBody>,
    /// By body: whether a contact pushes it.
    pub(crate) is_pushed: Vec<bool>,
    /// By body, where some may be squeezed: what squeezed it in the last step.
    pub(crate) squeezes: Vec<Squeeze>,
    #[cfg(feature = "exact")]
    pub(crate) exact: exact_substep::ExactBuffers,
}

impl Impacts {
    /// Whether bodies may hit each other.
    pub(crate) fn can_hit(&self) -> bool {
        !self.points.is_empty()
    }
}

impl BatchBonds {
    /// Whether any body is bonded.
    pub(crate) fn any(&self) -> bool {
        !self.constraints.is_empty()
    }
}
