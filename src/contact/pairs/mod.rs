//! Which bodies may touch, and what is kept about a pair from step to step.
//!
//! `broad_phase.rs` makes boxes into pairs, sorted by the ids of their bodies. `recycle.rs` decides whether what the last test of a pair
//! found still holds: a contact is recycled there. `store.rs` keeps that in flat lists, those that touch apart from the others
//! (`touches.rs`). `box_search.rs` asks the tree (`box_tree.rs`) for who is near.
//!
//! Must not know shapes, nor how a test is done. Read `recycle.rs` first.

pub(crate) mod box_search;
mod box_tree;
pub(crate) mod broad_phase;
pub(crate) mod recycle;
pub(crate) mod store;
pub(crate) mod touches;
