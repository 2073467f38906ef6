//! The bodies of a simulation as flat arrays, one entry per slot.
//!
//! Must not know contacts, rows or how anything is solved. Read [`store`] first.

pub mod body;
pub mod breaking;
pub mod free_rotation;
pub mod integrate;
pub mod sleep_state;
pub mod solver_body;
pub mod store;
mod waking;
