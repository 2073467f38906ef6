//! Threads of the task pool that work through many short lists together.
//!
//! Must not know what is in the lists.

pub mod parts;
pub mod team;
