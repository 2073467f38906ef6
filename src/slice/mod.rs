//! Cutting: a plane against a closed triangle mesh, and against a convex hull.
//!
//! Works in the body's frame on plain data. Both sides are made from the same classification of the same vertices, so
//! they are exactly complementary: no gap, no overlap, no crack.

pub mod attributes;
pub mod border;
pub mod cap;
pub mod clip;
pub mod convex;
pub mod pattern;
