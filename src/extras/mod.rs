//! Optional plugins that connect the physics to other parts of Bevy. Each is added to the app by itself; none is needed for a step.
//!
//! | file | holds | cargo feature |
//! |---|---|---|
//! | `interpolation.rs` | motion between fixed steps | |
//! | `mesh/` | `TriMesh` from and to Bevy's `Mesh`, shapes that wait for assets, `Mesh3d` in step with shapes | `mesh` |
//! | `gizmos.rs`, `island_colors.rs` | hulls, islands, contacts, impulses, bonds and joints as lines | `gizmos` |
//! | `diagnostics.rs` | time of each phase and counts as `DiagnosticPath`s | `diagnostics` |
//! | `picking.rs` | bodies under the pointer, for Bevy's picking events | `picking` |
//!
//! The last floor: knows all that is public, and nothing knows it. Must not be needed by a scene without it.

#[cfg(feature = "diagnostics")]
pub(crate) mod diagnostics;
#[cfg(feature = "gizmos")]
pub(crate) mod gizmos;
pub(crate) mod interpolation;
#[cfg(feature = "gizmos")]
mod island_colors;
#[cfg(feature = "mesh")]
pub(crate) mod mesh;
#[cfg(feature = "picking")]
pub(crate) mod picking;

#[cfg(feature = "diagnostics")]
pub use diagnostics::CleaveDiagnosticsPlugin;
#[cfg(feature = "gizmos")]
pub use gizmos::{CleaveGizmos, CleaveGizmosPlugin};
pub use interpolation::{InterpolationPlugin, NoInterpolation};
#[cfg(feature = "mesh")]
pub use mesh::{
    CleaveMeshPlugin, DrawShape, MeshConversionError, ShapeFromMesh, ShapeFromMeshError,
    ShapeRefused, ShapesOfScene, SlotMesh, unread_attributes,
};
#[cfg(feature = "picking")]
pub use picking::CleavePickingPlugin;
