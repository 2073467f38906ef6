//! Shapes: triangle meshes, convex hulls, primitives, and the KD code of a point in a box.
//!
//! Nothing here knows of mass, motion or the ECS. Coordinates are metres in the body's own frame; triangles and face
//! loops run counter-clockwise seen from outside.

mod around;
mod closed;
pub mod convex;
pub mod convex_mesh;
pub(crate) mod edge_tables;
pub mod face;
pub mod hull;
pub(crate) mod hull_lanes;
pub mod kd_code;
pub mod mesh;
pub(crate) mod moments;
pub mod predicates;
pub mod primitives;
mod triangle_corners;
mod weld;

pub(crate) use closed::{EdgeCensus, KnownClosed};
pub use convex::{ConvexHull, HullDefect, HullError};
pub use convex_mesh::{ConvexMesh, HalfSpace};
pub use face::{Edge, Face};
pub use hull::convex_hull_triangles;
pub use kd_code::{KdBox, KdCode};
pub use mesh::{MeshError, TriMesh};
pub use predicates::{PlaneError, Side};
