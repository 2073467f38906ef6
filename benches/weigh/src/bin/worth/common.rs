//! What the library's tests share, as far as it is needed here.
#![allow(dead_code, reason = "a part of it is used")]

#[path = "../../../../../tests/common/dice.rs"]
pub(crate) mod dice;
#[path = "../../../../../tests/common/scenes.rs"]
pub(crate) mod scenes;
#[path = "../../../../../tests/common/states.rs"]
pub(crate) mod states;
#[path = "../../../../../tests/common/structures.rs"]
pub(crate) mod structures;
