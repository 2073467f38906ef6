//! What several test programs, benches and examples share; each takes it in as a module with `#[path]`.
#![allow(dead_code, reason = "each program uses a part of it")]

pub(crate) mod dice;
pub(crate) mod mesh_parts;
pub(crate) mod properties;
pub(crate) mod ragdoll;
pub(crate) mod scenes;
pub(crate) mod states;
pub(crate) mod structures;
