//! Feeds the rooms of `contact` with bodies: boxes that last some steps, pairs, manifolds.
//!
//! Must not know what is done with manifolds.

pub mod narrow_phase;
pub mod proxies;
