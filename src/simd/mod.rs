//! Eight numbers at a time, with whatever the processor has, and asking for memory before it is read.
//!
//! Must not know what the numbers mean.

pub mod doubles;
pub mod lanes;
pub mod prefetch;
pub mod vec3;
