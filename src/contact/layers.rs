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
    /// In all layers, colliding with all.
    pub const ALL: Self = Self::new(u32::MAX, u32::MAX);

    /// In no layer: touches nothing.
    pub const NONE: Self = Self::new(0, 0);

    /// In the layers of `memberships`, colliding with those of `filters`, both as bits.
    pub const fn new(memberships: u32, filters: u32) -> Self {
        Self {
            memberships,
            filters,
        }
    }

    /// In one layer, 0 to 31, colliding with all; in none for a number beyond.
    pub const fn in_layer(layer: u32) -> Self {
        Self::new(bit(layer), u32::MAX)
    }

    /// The same, in one more layer, 0 to 31.
    pub const fn and_in_layer(self, layer: u32) -> Self {
        Self::new(self.memberships | bit(layer), self.filters)
    }

    /// The same, colliding with these layers only, 0 to 31 each.
    pub const fn colliding_with(self, layers: &[u32]) -> Self {
        Self::new(self.memberships, bits(layers))
    }

    /// The same, but not colliding with these layers, 0 to 31 each.
    pub const fn ignoring(self, layers: &[u32]) -> Self {
        Self::new(self.memberships, self.filters & !bits(layers))
    }

    /// Whether bodies of these layers may touch.
    pub fn interact(&self, other: &Self) -> bool {
        self.memberships & other.filters != 0 && other.memberships & self.filters != 0
    }
}

const fn bit(layer: u32) -> u32 {
    if layer < u32::BITS { 1 << layer } else { 0 }
}

const fn bits(layers: &[u32]) -> u32 {
    let (mut all, mut at) = (0, 0);
    while at < layers.len() {
        all |= bit(layers[at]);
        at += 1;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_are_what_their_makers_say() {
        let player = CollisionLayers::in_layer(1).colliding_with(&[0, 2]);
        let enemy = CollisionLayers::in_layer(2)
            .and_in_layer(5)
            .ignoring(&[2, 5]);
        assert_eq!(player, CollisionLayers::new(0b10, 0b101));
        assert!(player.interact(&enemy) && enemy.interact(&player));
        assert!(!enemy.interact(&enemy) && !player.interact(&player));
        assert!(player.interact(&CollisionLayers::default()));
        assert!(!CollisionLayers::NONE.interact(&CollisionLayers::ALL));
        assert_eq!(CollisionLayers::in_layer(32).memberships, 0);
    }
}
