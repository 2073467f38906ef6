//! Rigid-body physics for convex bodies with real-time slicing and fracture.

pub mod contact;
pub mod geometry;
pub mod mass;
pub mod math;
pub mod slice;
pub mod solver;
