//! Where two shapes touch: one pair at a time, in the frame of the first.

mod clipping;
mod edge_search;
pub mod half_space;
pub mod sat;
pub mod scratch;
