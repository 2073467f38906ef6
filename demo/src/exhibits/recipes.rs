//! The recipes of `docs/materials.md`, as its examples have them.

#[path = "../../../examples/materials/recipes.rs"]
#[expect(dead_code, reason = "the bonds of an app are commands")]
mod of_examples;

pub(super) use of_examples::{MORTAR, brick, glass, lath, stone};
