//! The plugin, by apps with a task pool. In a process of its own: the plain step takes the help of the pool's threads wherever
//! there is one, and the tests of `it` are to be the same in every run.

#[path = "../common/mod.rs"]
mod common;

mod app;

mod accounts;
mod bad_input;
mod births;
mod bonds;
mod chaos;
mod collision_heaps;
mod collisions;
mod forces;
mod hanging;
#[path = "../common/hierarchy.rs"]
mod hierarchy;
mod history;
mod idle;
mod joint_laws;
mod joint_world;
mod kinematic;
mod levels;
mod no_change;
mod parents;
mod phases;
mod pieces;
mod plain_step;
mod random_world;
mod rewind;
mod sleep;
mod twins;
mod unusual;
