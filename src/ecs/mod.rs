//! The ECS face: components, messages, and the thin systems that move data between entities and the flat arrays.
//!
//! | file | holds |
//! |---|---|
//! | `components.rs` | what users put on entities and read from them; messages |
//! | `gather.rs` | bodies that come and go, and what users changed, into `Bodies` |
//! | `scatter.rs` | poses and velocities back to entities |
//! | `cut.rs` | `commands.slice` |
//! | `pieces.rs`, `families.rs`, `piece_children.rs`, `uncloned.rs` | pieces as entities, whose children those of the parent become, what they cannot get |
//! | `bond.rs` | `commands.bond` |
//! | `bond_constructor.rs`, `description.rs` | bonds as data, and the description of all that is there, for scene files |
//! | `query.rs` | `SpatialQuery`: rays, casts, overlaps by entity |
//! | `walker.rs` | characters that walk |
//! | `joint.rs` | joints as entities |
//! | `collisions.rs`, `collision_news.rs` | events of contacts, sensors, `Collisions` |
//! | `forces.rs` | `Forces`, constant forces, damping, explosions |
//! | `options.rs` | reads what only some bodies have: events and drives |
//! | `issues.rs`, `issue_sync.rs` | what is wrong with an entity, as a component |
//! | `kinematic.rs`, `parents.rs` | bodies that are moved by their `Transform`, and that are children |
//! | `rewind.rs`, `rewind/`, `set_aside.rs` | moments that are kept, and restored; who waits for that |
//! | `setup.rs` | components that bodies require, whenever the plugin is added |
//! | `shape_constructor.rs`, `shape_constructor/` | shapes as data that a scene file can hold |
//! | `parts.rs` | bodies whose parts are their children |
//! | `spawn.rs` | an entity from a description of a body |
//! | `scaled_shapes.rs` | shapes as the scales of their entities make them |
//! | `state.rs` | the one resource that the plugin keeps for itself |
//!
//! The first layer that knows entities, queries and commands. Must not know the order of the phases: that is `plugin.rs`. Read
//! `components.rs` first.

pub(crate) mod bond;
pub(crate) mod bond_constructor;
pub(crate) mod collision_news;
pub(crate) mod collisions;
pub(crate) mod components;
pub(crate) mod cut;
mod description;
mod families;
pub(crate) mod forces;
pub(crate) mod gather;
pub(crate) mod issue_sync;
pub(crate) mod issues;
pub(crate) mod joint;
pub(crate) mod kinematic;
pub(crate) mod options;
pub(crate) mod parents;
pub(crate) mod parts;
pub(crate) mod piece_children;
pub(crate) mod pieces;
pub(crate) mod query;
#[cfg(feature = "reflect")]
pub(crate) mod reflect;
pub(crate) mod rewind;
mod scaled_shapes;
pub(crate) mod scatter;
pub(crate) mod set_aside;
pub(crate) mod setup;
pub(crate) mod shape_constructor;
pub(crate) mod spawn;
pub(crate) mod state;
mod uncloned;
pub(crate) mod walker;

pub use crate::bodies::Explosion;
pub use bond::BondCommands;
pub use bond_constructor::{BondConstructor, BondDescription};
pub use collisions::{
    Collision, CollisionEnd, CollisionEvents, CollisionStart, Collisions, ContactForce,
    ContactForceEvents, Sensor,
};
pub use components::{
    AngularVelocity, BodyHandle, BodyProblem, BodyWarning, BondBroken, DebrisRemoved, Fading,
    FractureCause, Fractured, LinearVelocity, MassOverride, ShapeAwaited, Sleeping, WalkerError,
};
pub use cut::SliceCommands;
pub use description::describe_bodies;
pub use forces::{
    AngularDamping, AppliedForces, ConstantForce, ConstantTorque, ForceCommands, Forces,
    ForcesItem, GravityScale, LinearDamping, Mass, MaxSpeed, SurfaceVelocity,
};
pub use issues::BodyIssues;
pub use joint::{
    JointA, JointB, JointBroken, JointCommands, JointHandle, JointProblem, JointsOfA, JointsOfB,
};
pub use parts::CompoundOfChildren;
pub use piece_children::ChildrenOfPieces;
pub use pieces::{PieceOf, PieceRules, Pieces, Remains};
pub use query::SpatialQuery;
pub use rewind::{PhysicsHistory, RewindApp, RewindCommands, Rewound};
pub use shape_constructor::{
    CompoundConstructor, LevelConstructor, MeshDescription, PartDescription, RoundForm,
    ShapeConstructor,
};
pub use spawn::SpawnBody;
pub use walker::{Walker, Walking};
