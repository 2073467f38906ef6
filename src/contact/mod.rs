//! Contacts: which bodies may touch, where they touch, and what the solver last said about it.
//!
//! Must not know velocities, masses or the solver.

pub mod body_id;
pub mod body_manifold;
pub mod impulses;
pub mod layers;
pub mod local_manifold;
pub mod manifolds;
pub mod material;
pub mod narrow;
pub mod pairs;
pub mod point;
mod reduce;
