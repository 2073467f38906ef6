//! Which bodies may touch, and what is kept about a pair from step to step.

pub mod broad_phase;
pub mod recycle;
pub mod store;
pub mod touches;
