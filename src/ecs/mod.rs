//! The ECS face: components, messages, and the thin systems that move data between entities and the flat arrays.
//!
//! This is the first layer that knows entities, queries and commands. [`gather`] brings entities and what users changed
//! into [`Bodies`](crate::bodies::store::Bodies), [`scatter`] writes poses and velocities back, [`cut`] turns cuts
//! into entities, and [`bond`] holds entities together.

pub mod bond;
pub mod components;
pub mod cut;
pub mod gather;
#[cfg(feature = "reflect")]
pub(crate) mod reflect;
pub mod scatter;
pub mod spawn;
pub(crate) mod state;
