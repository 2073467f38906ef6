//! Slicers of this crate and of others, on the same meshes and planes; the bench times them.

#[path = "../../../tests/common/dice.rs"]
mod dice;

pub mod bodies;
pub mod engines;
