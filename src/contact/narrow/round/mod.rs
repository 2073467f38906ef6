//! Where round shapes touch: spheres, capsules, cylinders, cones, rounded hulls, and what they meet.
//!
//! The direction is that in which two cores are nearest to each other; cylinders and cones are taken a little smaller for that, so
//! that they have a distance where they overlap a little. Along it the gap is told by the farthest points of the shapes themselves.
//! Points come from the features that lie there: a face of the one cuts the face, line or point of the other; where no face is, two
//! lines side by side have two points, and all else one.
//!
//! | file | holds |
//! |---|---|
//! | `solid.rs` | a shape as these tests read it: its core, its farthest points, its features |
//! | `axis.rs` | the direction of a pair |
//! | `patch.rs` | the points of a pair along it |
//! | `pair.rs` | two shapes, and a shape over a half-space |
//! | `cast.rs` | a pair that moves far within the step |
//! | `level.rs` | a shape over the triangles of a level |
//!
//! Read `examine_round` in `pair.rs` first.

mod axis;
pub(crate) mod cast;
pub(crate) mod level;
pub(crate) mod pair;
pub(crate) mod patch;
mod solid;
