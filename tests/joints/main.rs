//! Joints let move what they are to let move and nothing else, bear what mechanics says they bear, and keep their energy.
#![expect(clippy::print_stdout, reason = "docs cite the figures")]

mod chains;
mod changes;
#[path = "../common/mod.rs"]
mod common;
mod determinism;
mod distances;
mod drives;
mod entities;
mod hard;
mod kinds;
mod laws;
mod lives;
mod loaded;
mod loops;
mod members;
mod motions;
mod pendulums;
mod random_trees;
mod scene;
mod scenes;
mod statics;
mod taut;
mod touching;
mod vehicles;
