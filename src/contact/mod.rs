//! Contacts: which bodies may touch, where they touch, and what the solver last said about it.

use bevy_ecs::component::Component;

pub mod broadphase;
pub mod cache;
mod clipping;
mod edge_search;
pub(crate) mod half_space;
pub(crate) mod known;
pub mod manifold;
pub mod manifolds;
pub mod material;
pub(crate) mod pair;
pub mod sat;

pub use broadphase::{Broadphase, Pair, Proxy, ProxyKind, ProxyShape};
pub use cache::{CacheEntry, CacheStats, ContactCache};
pub use manifold::{ContactPoint, ManifoldBody, Patch, PatchPoint};
pub use manifolds::{Manifold, ManifoldHead, ManifoldRef, Manifolds};
pub use material::{CombineRule, Density, Friction, MaterialError, Restitution};
pub use sat::{NarrowScratch, collide_half_space, collide_hulls};

/// Name of a body, given once and never again: later bodies have larger numbers.
///
/// Pairs and cache entries are ordered by it, so results do not depend on where a body is stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BodyId(pub u32);

/// Which bodies may touch: two bodies do if each one's `memberships` meets the other's `filters`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Component)]
#[component(summary_tick)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct CollisionLayers {
    /// Layers the body is in, as bits.
    pub memberships: u32,
    /// Layers the body collides with, as bits.
    pub filters: u32,
}

impl Default for CollisionLayers {
    /// In the first layer, colliding with all.
    fn default() -> Self {
        Self {
            memberships: 1,
            filters: u32::MAX,
        }
    }
}

impl CollisionLayers {
    /// Whether bodies of these layers may touch.
    pub fn interact(&self, other: &Self) -> bool {
        self.memberships & other.filters != 0 && other.memberships & self.filters != 0
    }
}
