//! Which bodies may touch at all.

use bevy_ecs::component::Component;

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
