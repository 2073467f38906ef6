//! Bodies that break: which ones, through which planes, and what becomes of their motion.
//!
//! Cuts that were asked for are made at the start of a step. A body that is hit with more than it bears breaks in the very
//! step: the solver gives up its island, the part of the impulses that the body withstands acts on it and on what hit it, and
//! the island is solved anew with the pieces. So what hit it goes on with the rest of its momentum, and nothing bounces off
//! a pane that is not there any more. Only what comes above the load that is borne breaks a body; a sustained load never does, nor
//! does it wear it out.
//!
//! A body is cut in its own frame; each piece becomes a body about its own center of mass and moves as that part of the parent did:
//! `v_i = v + omega x r_i`, `omega_i = omega`, which conserves momentum, angular momentum and energy exactly; the
//! [`Ledger`] shows the rounding.
//!
//! | file | holds |
//! |---|---|
//! | `breaking.rs` | when: on request, overloaded, or after waiting for the budget (`budget.rs`, `pending.rs`) |
//! | `gradual.rs` | large meshes, which are cut over several steps |
//! | `impact.rs`, `shares.rs` | impulses of a step by body: what they break, and what of them acts before |
//! | `pieces.rs`, `conservation.rs`, `ledger.rs` | pieces as bodies; what rounding takes from them; before and after |
//! | `holding.rs`, `hold_area.rs` | which pieces of what stood stay, and what falls with the others |
//! | `blast.rs`, `pressure.rs` | explosions and forces at points, which push clusters part by part; other bodies |
//! | `cluster.rs`, `cluster_loads.rs` | bodies whose parts are held by bonds: what comes off, and what sustained loads break |
//! | `contact_loads.rs`, `grip.rs`, `bearings.rs` | what contacts do to their parts, and where they lie on something |
//! | `debris.rs` | which pieces go again |
//! | `inheritance.rs`, `bond_inheritance.rs`, `joint_inheritance.rs` | which piece gets multipliers, bonds and joints of the parent |
//! | `bond.rs`, `bonded_pair.rs`, `bonds.rs`, `neighbors.rs` | what holds bodies together, and over which area |
//!
//! Must not know entities. How an impact divides a shape is decided in `slice`, whether it is too much in `bodies/breaking.rs` while
//! the island is solved. Read `breaking.rs` first.

mod bearings;
mod blast;
pub(crate) mod bond;
mod bond_inheritance;
mod bonded_pair;
pub(crate) mod bonds;
mod breaking;
mod budget;
mod cluster;
mod cluster_loads;
mod conservation;
mod contact_loads;
mod debris;
mod gradual;
mod grip;
mod hold_area;
mod holding;
mod impact;
mod inheritance;
mod joint_inheritance;
mod ledger;
mod neighbors;
mod pending;
mod pieces;
mod pressure;
mod requests;
mod shares;

pub use bond::{Bond, BondError};
pub use bonded_pair::BrokenBond;
pub use bonds::Bonds;
pub(crate) use breaking::{
    Inherited, break_overloaded, break_under_loads, end_loads, make_cuts, note_blows,
};
pub use budget::FractureBudget;
pub(crate) use cluster::find_holds;
pub(crate) use cluster_loads::StepLoads;
pub use debris::{DebrisRules, ExpiredPiece, FadingPiece, RemovedDebris};
pub use ledger::{Invariants, Ledger};

use crate::bodies::body::BodyError;
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::math::Plane;
use crate::slice::SliceError;
use bevy_ecs::resource::Resource;
use breaking::FractureState;
use glam::Vec3;
use smallvec::SmallVec;

/// Pieces that a body must make to be broken.
const MIN_PIECES: usize = 2;

/// Why a cut that was asked for was not made. The body is left as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CutError {
    /// There is no such body (any more).
    #[error("there is no such body")]
    NoBody,
    /// A half-space and a level of triangles have no inside that could be divided.
    #[error("only what has an inside can be cut, no half-space and no level of triangles")]
    NotConvex,
    /// The body is out of the simulation because its state is not finite.
    #[error("the body is left out of the simulation")]
    Frozen,
    /// The body's mass was given, not computed: nobody knows which piece would get which share.
    #[error("a body with a MassOverride cannot be cut: give it a Density instead")]
    MassOverride,
    /// The plane does not go through the body.
    #[error("the plane misses the body")]
    Missed,
    /// Fewer than two pieces are larger than the least volume.
    #[error("fewer than two pieces would be larger than the least volume")]
    TooSmall,
    /// The slicer refused.
    #[error(transparent)]
    Slice(#[from] SliceError),
    /// A piece does not make a body.
    #[error(transparent)]
    Piece(#[from] BodyError),
}

/// A cut that was asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutRequest {
    /// The body to cut.
    pub body: BodyId,
    /// Its slot.
    pub slot: u32,
    /// Where to cut, in the body's frame: it moves with the body until the cut is made.
    pub plane: Plane,
}

impl CutRequest {
    /// A cut of the body in `slot` by a plane in the world, as the body lies now.
    ///
    /// # Errors
    /// [`CutError::NoBody`] if the slot is free.
    pub fn in_world(bodies: &Bodies, slot: u32, plane: Plane) -> Result<Self, CutError> {
        if !bodies.contains(slot) {
            return Err(CutError::NoBody);
        }
        let plane = plane.in_frame_of(&bodies.pose(slot));
        Ok(Self {
            body: bodies.id(slot),
            slot,
            plane,
        })
    }
}

/// One body that became several.
#[derive(Clone, Debug, PartialEq)]
pub struct Fracture {
    /// The body that is no more, unless it goes on.
    pub parent: BodyId,
    /// The slot it had.
    pub parent_slot: u32,
    /// Slots of the pieces.
    pub pieces: SmallVec<[u32; 8]>,
    /// Their ids. A piece that broke in the same step is gone, and is the parent of a later fracture.
    pub ids: SmallVec<[BodyId; 8]>,
    /// By piece: its number among what the body came apart into, some of which may have been too small.
    pub(crate) numbers: SmallVec<[u32; 8]>,
    /// The planes, world frame; of a body that broke into cells, only those of cuts on request.
    pub planes: SmallVec<[Plane; 8]>,
    /// Before and after.
    pub ledger: Ledger,
    /// Slots of static bodies that became dynamic because nothing but the parent bore them, pieces among them; by id.
    pub fallen: Vec<u32>,
    /// What broke it; `None` if it was cut, or had to wait for its turn to break.
    pub blow: Option<BreakingImpact>,
    /// Of a body that had to wait for its turn: what it was hit with then, all of which acted on it.
    pub waited: Option<BreakingImpact>,
    /// Whether it was a sustained load, and no blow.
    pub is_load: bool,
    /// Whether the parent goes on, in its slot, with what bonds still hold to where it is anchored. That is none of the pieces.
    pub goes_on: bool,
}

/// What a body was hit with when it broke.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BreakingImpact {
    /// Sum of the normal impulses until then, N s.
    pub impulse: f32,
    /// Kinetic energy that they would have turned into something else, J.
    pub energy: f32,
    /// Share of the impulses that acted on the body, and on what hit it, before it broke. The rest was for the pieces.
    pub withstood: f32,
    /// Slot and id of the body that gave most of it; none of an explosion.
    pub by: Option<(u32, BodyId)>,
    /// Where it acted: the mean of the contact points, weighted by their impulses; world, m.
    pub point: Vec3,
    /// Unit vector along which the body was pushed, world axes.
    pub direction: Vec3,
}

/// Cuts asked for, and what broke in the last step.
#[derive(Clone, Debug, Default, Resource)]
pub struct Fractures {
    /// Cuts to make at the start of the next step, in order; several on one body cut its pieces too.
    pub requests: Vec<CutRequest>,
    /// Fractures of the last step: the cuts in order of the parents' ids, what had waited for its turn, and what the
    /// impulses of the step broke, round by round.
    pub done: Vec<Fracture>,
    /// Cuts of the last step that were not made.
    pub refused: Vec<(CutRequest, CutError)>,
    /// Pieces that were removed at the start of the last step because their time was over, by id.
    pub expired: Vec<ExpiredPiece>,
    /// Pieces that will be removed, in the order in which they came to be.
    pub fading: Vec<FadingPiece>,
    /// All that has been removed.
    pub removed: RemovedDebris,
    state: FractureState,
}

impl Fractures {
    /// How often planes were held against triangles of meshes since this was asked last, for what blows and requests have cut: what cutting
    /// costs, whatever the machine.
    pub fn take_cut_work(&mut self) -> usize {
        self.state.take_gone_through()
    }

    /// Number of bodies that were hit with more than they bear and wait for a budget to break.
    pub fn waiting(&self) -> usize {
        self.state.waiting()
    }

    /// Whether blows may break anything more in this step.
    pub(crate) fn can_afford(&self, budget: &FractureBudget) -> bool {
        self.state.left(budget) >= MIN_PIECES
    }
}
