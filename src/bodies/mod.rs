//! The bodies of a simulation as flat arrays, one entry per slot: what they are, where they are, how they move.
//!
//! | file | holds |
//! |---|---|
//! | `store.rs`, `slots.rs` | `Bodies`, the arrays; slots and ids |
//! | `body.rs`, `shapes.rs` | what a body is made from, and why one is refused; what is asked of its shape |
//! | `solver_body.rs` | the rows of eight numbers that sweeps touch: velocity, mass, motion |
//! | `drive.rs`, `driving.rs`, `sensor.rs` | forces, damping, locked axes of the few bodies that have some; bodies that only sense |
//! | `explosion.rs`, `exploding.rs`, `blast_shares.rs` | blasts, on bodies and on the parts of clusters; who gets how much |
//! | `pushes.rs`, `pushing.rs` | forces at points, which load single parts of clusters |
//! | `kind.rs` | a body becomes dynamic, kinematic or static |
//! | `free_rotation.rs` | rotation without torque that keeps angular momentum and energy |
//! | `integrate.rs` | phase 7: bodies are put where the solver has moved them |
//! | `inertia.rs` | how heavy bodies are: inertia and energy from shape and density |
//! | `links.rs` | who is bonded to whom, and whom joints hold |
//! | `anchors.rs`, `holding.rs` | where bodies that stand hold on to the world |
//! | `cluster_state.rs`, `clusters.rs` | those whose parts are held by bonds |
//! | `breaking.rs`, `fatigue.rs`, `wearing.rs` | what a body bears, and what it was hit with; what blows leave of it |
//! | `sleep_state.rs`, `waking.rs` | who rests and who sleeps; setters wake at once |
//!
//! Must not know manifolds, rows or how anything is solved: when islands fall asleep is the solver's business, who breaks that of
//! `fracture`. Read `store.rs` first, then `solver_body.rs`.

pub(crate) mod anchors;
pub(crate) mod blast_shares;
pub(crate) mod body;
pub(crate) mod breaking;
pub(crate) mod cluster_state;
mod clusters;
pub(crate) mod drive;
pub(crate) mod driving;
mod exploding;
pub(crate) mod explosion;
pub(crate) mod fatigue;
pub(crate) mod free_rotation;
mod holding;
pub(crate) mod inertia;
pub(crate) mod integrate;
mod kind;
mod links;
mod local;
pub(crate) mod local_state;
pub(crate) mod pushes;
mod pushing;
mod sensor;
mod shapes;
pub(crate) mod sleep_state;
mod slots;
pub(crate) mod solver_body;
pub(crate) mod store;
mod waking;
mod wearing;

pub use anchors::{AnchorRegion, Anchors};
pub use body::{BodyDesc, BodyError, RigidBody, Shape};
pub use drive::{BodyDrive, LockedAxes, StepForces};
pub use explosion::Explosion;
pub use fatigue::Fatigue;
pub use store::Bodies;
