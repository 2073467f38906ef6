//! Contacts: which bodies may touch, where they touch, and what the solver last said about it.
//!
//! Three rooms: `narrow` tests one pair of shapes, `pairs` finds pairs and keeps what is known of them, `impulses` is the contact
//! cache. The files here are what they have in common:
//!
//! | file | holds |
//! |---|---|
//! | `point.rs`, `manifolds.rs` | a contact point, and the manifolds of a step, as all that follows sees them |
//! | `local_manifold.rs` | what a test finds, in the frames of the two bodies |
//! | `body_manifold.rs` | the same bound to both bodies, to be seen anew after they have moved |
//! | `reduce.rs` | at most four points of many |
//! | `material.rs`, `surface.rs`, `layers.rs`, `body_id.rs` | friction, restitution, density; the same by slot; who may touch whom; what orders everything |
//!
//! Must not know velocities, masses or the solver. Read `point.rs` first, then `body_manifold.rs`.

pub(crate) mod body_id;
pub(crate) mod body_manifold;
pub(crate) mod impulses;
pub(crate) mod layers;
pub(crate) mod local_manifold;
pub(crate) mod manifolds;
pub(crate) mod material;
pub(crate) mod narrow;
pub(crate) mod pairs;
pub(crate) mod point;
mod reduce;
pub(crate) mod surface;

pub use body_id::BodyId;
pub use impulses::{CacheStats, ContactCache};
pub use layers::CollisionLayers;
pub use local_manifold::{LocalManifold, LocalPoint};
pub use manifolds::{Manifold, ManifoldHead, ManifoldRef, Manifolds};
pub use material::{CombineRule, Density, Friction, MaterialError, Restitution};
pub use narrow::sat::collide_hulls;
pub use narrow::scratch::NarrowScratch;
pub use point::{ContactPoint, MAX_POINTS};
pub use surface::{SurfaceMaterial, SurfaceMaterials};
