//! Threads of the task pool that work through many short lists together.
//!
//! `team.rs` is the team: helpers come for a phase and look for tasks, the thread that leads never waits for one that has taken none.
//! `Team::each` is the parallel loop of this crate. `parts.rs` cuts lists into parts.
//!
//! How a list is cut depends on the scene only, never on how many threads there are, and what parts find is put together in their
//! order: any number of threads gives the same bits. Must not know what is in the lists. Read `team.rs` first.

pub(crate) mod parts;
pub(crate) mod team;
