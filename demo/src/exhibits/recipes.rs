//! The recipes of `docs/materials.md`, as its examples have them.

use bevy::math::Vec3;

/// What the wall of concrete may fail with.
type Error = Box<dyn std::error::Error + Send + Sync>;

#[path = "../../../examples/materials/concrete.rs"]
mod of_concrete;
#[path = "../../../examples/materials/recipes.rs"]
#[expect(dead_code, reason = "the bonds of an app are commands")]
mod of_examples;

pub(super) use of_concrete::concrete;
pub(super) use of_examples::{MORTAR, brick, glass, lath, stone};
