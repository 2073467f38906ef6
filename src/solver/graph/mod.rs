//! Who is solved with whom, and in which order. Integers only: nothing here computes an impulse.

pub mod bisection;
pub mod coloring;
pub mod contact_order;
pub mod indices;
pub mod islands;
pub mod lane_assignment;
pub mod ordered_packing;
pub mod partition;
pub mod relative_motion;
