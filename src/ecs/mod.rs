//! The ECS face: components, messages, and the thin systems that move data between entities and the flat arrays.
//!
//! | file | holds |
//! |---|---|
//! | `components.rs` | what users put on entities and read from them; messages |
//! | `gather.rs` | bodies that come and go, and what users changed, into `Bodies` |
//! | `scatter.rs` | poses and velocities back to entities |
//! | `cut.rs` | `commands.slice`; pieces as entities |
//! | `bond.rs` | `commands.bond` |
//! | `spawn.rs` | an entity from a description of a body |
//! | `state.rs` | the one resource that the plugin keeps for itself |
//!
//! The first layer that knows entities, queries and commands. Must not know the order of the phases: that is `plugin.rs`. Read
//! `components.rs` first.

pub mod bond;
pub mod components;
pub mod cut;
pub mod gather;
#[cfg(feature = "reflect")]
pub(crate) mod reflect;
pub mod scatter;
pub mod spawn;
pub(crate) mod state;
