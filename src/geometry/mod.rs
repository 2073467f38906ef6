//! Shapes: triangle meshes, convex hulls, primitives, and the KD code of a point in a box.
//!
//! | file | holds |
//! |---|---|
//! | `predicates.rs` | every geometric tolerance, derived from rounding; exact side tests |
//! | `mesh.rs`, `mesh_join.rs`, `mesh_error.rs`, `closed.rs`, `face_numbers.rs`, `weld.rs` | triangle meshes, whether they are closed and which faces are flat |
//! | `hull.rs`, `coplanar.rs` | the convex hull of a point cloud; triangles in one plane become a polygon |
//! | `convex.rs`, `face.rs`, `around.rs`, `hull_error.rs` | a hull with polygon faces and edges, and why something is none |
//! | `hull_lanes.rs`, `edge_tables.rs`, `triangle_corners.rs` | the same for several numbers at a time |
//! | `polygon.rs`, `triangle_distance.rs` | plane polygons: clipping by a plane, area; the nearest point of a triangle |
//! | `moments.rs` | volume integrals from faces |
//! | `convex_mesh.rs`, `primitives.rs` | the shapes that a body can have |
//! | `round.rs`, `round_core.rs`, `round_moments.rs`, `round_polyhedron.rs`, `frustum.rs` | spheres, capsules, cylinders, cones, rounded hulls |
//! | `compound.rs`, `compound_part.rs`, `compound_cover.rs`, `compound_seen.rs` | a shape of several convex parts, what of them is covered by others, and how much something sees |
//! | `part_bond.rs`, `compound_bonds.rs`, `shared_area.rs` | what holds parts together, and which of them hang together; faces that two shapes share |
//! | `constant_shapes.rs` | shapes of constant sizes, as macros |
//! | `static_mesh.rs`, `level_triangle.rs`, `level_edges.rs`, `flat_ground.rs`, `bvh.rs`, `wide_tree.rs`, `wide_tree_build.rs`, `tree_queue.rs` | a level of triangles, where it is a plane, and walks through trees |
//! | `support.rs`, `distance.rs`, `simplex.rs`, `penetration.rs` | distances and casts of convex shapes, and ways out of each other |
//! | `kd_code.rs` | cells of a box, for the contact cache |
//!
//! Must not know mass, motion, contacts or the ECS. Coordinates are meters in the body's own frame; triangles and face loops run
//! counter-clockwise seen from outside. Read `predicates.rs` first.

mod around;
pub(crate) mod bvh;
mod closed;
pub(crate) mod compound;
mod compound_bonds;
pub(crate) mod compound_cover;
pub(crate) mod compound_part;
mod compound_seen;
mod constant_shapes;
pub(crate) mod convex;
pub(crate) mod convex_mesh;
mod coplanar;
pub(crate) mod distance;
pub(crate) mod edge_tables;
pub(crate) mod face;
mod face_numbers;
pub(crate) mod flat_ground;
pub(crate) mod frustum;
pub(crate) mod hull;
pub(crate) mod hull_error;
pub(crate) mod hull_lanes;
pub(crate) mod kd_code;
mod level_edges;
pub(crate) mod level_triangle;
pub(crate) mod mesh;
mod mesh_error;
mod mesh_join;
pub(crate) mod moments;
mod part_bond;
pub(crate) mod penetration;
pub(crate) mod polygon;
pub(crate) mod predicates;
pub mod primitives;
pub(crate) mod round;
pub(crate) mod round_core;
mod round_moments;
mod round_polyhedron;
pub(crate) mod shared_area;
mod simplex;
pub(crate) mod static_mesh;
pub(crate) mod support;
mod tree_queue;
mod triangle_corners;
pub(crate) mod triangle_distance;
mod weld;
pub(crate) mod wide_tree;
mod wide_tree_build;

pub(crate) use closed::{EdgeCensus, KnownClosed};
pub use compound::{Compound, CompoundError, MAX_PARTS};
pub(crate) use compound_bonds::groups_of;
pub use compound_part::CompoundPart;
#[doc(hidden)]
pub use constant_shapes::are_sizes_usable;
pub use convex::ConvexHull;
pub use convex_mesh::{ConvexMesh, HalfSpaceShape};
pub use face::{Edge, Face};
pub(crate) use face_numbers::FaceNumbers;
pub use hull::convex_hull_triangles;
pub use hull_error::{HullDefect, HullError};
pub use kd_code::{KdBox, KdCode};
pub use level_triangle::EdgeKind;
pub use mesh::TriMesh;
pub use mesh_error::MeshError;
pub use part_bond::PartBond;
pub use predicates::{PlaneError, Side};
pub use round_polyhedron::RESOLUTIONS;
pub use static_mesh::StaticMesh;
