//! The ECS face: components, messages, and the thin systems that move data between entities and the flat arrays.
//!
//! | file | holds |
//! |---|---|
//! | `components.rs` | what users put on entities and read from them; messages |
//! | `gather.rs` | bodies that come and go, and what users changed, into `Bodies` |
//! | `scatter.rs` | poses and velocities back to entities |
//! | `cut.rs` | `commands.slice`; pieces as entities |
//! | `bond.rs` | `commands.bond` |
//! | `query.rs` | `SpatialQuery`: rays, casts, overlaps by entity |
//! | `joint.rs` | joints as entities |
//! | `spawn.rs` | an entity from a description of a body |
//! | `state.rs` | the one resource that the plugin keeps for itself |
//!
//! The first layer that knows entities, queries and commands. Must not know the order of the phases: that is `plugin.rs`. Read
//! `components.rs` first.

pub(crate) mod bond;
pub(crate) mod components;
pub(crate) mod cut;
pub(crate) mod gather;
pub(crate) mod joint;
pub(crate) mod query;
#[cfg(feature = "reflect")]
pub(crate) mod reflect;
pub(crate) mod scatter;
pub(crate) mod spawn;
pub(crate) mod state;

pub use bond::BondCommands;
pub use components::{
    AngularVelocity, BodyHandle, BodyProblem, BodyWarning, BondBroken, Fractured, LinearVelocity,
    MassOverride, Sleeping,
};
pub use cut::SliceCommands;
pub use joint::{
    JointA, JointB, JointBroken, JointCommands, JointHandle, JointProblem, JointsOfA, JointsOfB,
};
pub use query::SpatialQuery;
pub use spawn::SpawnBody;
