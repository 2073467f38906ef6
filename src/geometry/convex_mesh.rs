//! The shapes a body can have: `ConvexMesh`, shared and immutable, and the static `HalfSpace`.

use super::{ConvexHull, TriMesh};
use bevy_ecs::component::Component;
use glam::Vec3;
use std::sync::Arc;

/// The shape of a body: a convex hull, and optionally a closed mesh that rides inside it and is what is drawn.
///
/// Shared and immutable, so cloning costs one reference count. Coordinates are metres in the entity's frame.
#[derive(Clone, Debug, Component)]
pub struct ConvexMesh(Arc<Parts>);

#[derive(Debug)]
struct Parts {
    hull: ConvexHull,
    visual: Option<TriMesh>,
}

impl ConvexMesh {
    /// A shape from a hull and the mesh that rides in it.
    pub fn from_parts(hull: ConvexHull, visual: Option<TriMesh>) -> Self {
        Self(Arc::new(Parts { hull, visual }))
    }

    /// The hull that collides and carries the mass.
    pub fn hull(&self) -> &ConvexHull {
        &self.0.hull
    }

    /// The mesh that rides inside the hull, if one was given.
    pub fn visual(&self) -> Option<&TriMesh> {
        self.0.visual.as_ref()
    }

    /// Whether two handles are the same shape in memory.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// A static half-space: everything on the far side of the plane is solid. For a floor or a wall without end.
#[derive(Clone, Copy, Debug, PartialEq, Component)]
pub struct HalfSpace {
    /// Outward unit normal in the entity's frame; the plane goes through the entity's origin.
    pub normal: Vec3,
}
