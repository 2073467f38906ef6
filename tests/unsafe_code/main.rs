//! What the modules with `unsafe` code do: lanes, and threads that share short lists of tasks. `.ci/run` runs these tests
//! under valgrind too.

#[path = "../common/mod.rs"]
mod common;

mod lanes;
mod team;

use bevy_tasks::{ComputeTaskPool, TaskPoolBuilder};

/// The pool of all tests here: three threads, to which one comes that leads.
fn pool() -> &'static ComputeTaskPool {
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(3).build())
}
