//! Where two shapes touch: one pair at a time, in the frame of the first.
//!
//! `sat.rs` finds the axis that separates best, over faces and, with `edge_search.rs`, over pairs of edges; `clipping.rs` makes points
//! of it; `half_space.rs` is the case of a floor. `scratch.rs` has the buffers, and what is handed in (`SatCache`: what was found the
//! last time, which changes the effort and never the answer) and out (`SatResult`).
//!
//! `cast.rs` follows a pair that moves far within the step (`course.rs`) to what it touches first.
//!
//! `round/` is for what is curved, `level*.rs` for levels of triangles, `compound.rs` for parts of one body and
//! `flush.rs` for what they touch.
//!
//! A test of another shape goes here: it gives a `LocalManifold`, or an axis and a distance. Must not know the world: no bodies, no
//! pairs, no steps. Read `examine_hulls` in `sat.rs` first.

pub(crate) mod cast;
mod clipping;
pub(crate) mod compound;
pub(crate) mod course;
mod edge_search;
pub(crate) mod flush;
pub(crate) mod half_space;
mod leaning;
pub(crate) mod level;
mod level_follow;
mod level_over;
mod level_plane;
pub(crate) mod level_scratch;
pub(crate) mod round;
pub(crate) mod sat;
pub(crate) mod scratch;
