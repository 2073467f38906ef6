//! Slicers of this crate and of others, on the same meshes and planes; the bench times them.

#[path = "../../../tests/dice/mod.rs"]
mod dice;

pub mod bodies;
pub mod engines;
