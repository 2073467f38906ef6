//! How much fracture a scene can afford.

use bevy_ecs::resource::Resource;

/// Limits for what blows break. Cuts that are asked for are made whatever the budget says, but count.
///
/// What a step cannot afford is broken into fewer pieces; what does not even get two waits for its turn, in the order of
/// the blows and then of the bodies' ids, and breaks at the start of a later step.
#[derive(Clone, Copy, Debug, PartialEq, Resource)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct FractureBudget {
    /// Pieces that one step may make.
    pub pieces_per_step: usize,
    /// Pieces that there may be; no blow breaks anything while there are as many.
    pub pieces_alive: usize,
    /// Pieces smaller than this are not made, m3; what [`Fracturable`](crate::slice::fracturable::Fracturable) says holds
    /// too.
    pub least_volume: f32,
    /// How often a body and its pieces may break one after the other. At 0 blows break nothing.
    pub generations: u8,
    /// Pieces that have slept for so long, s, are removed. Infinite: never.
    pub lifetime: f32,
}

impl Default for FractureBudget {
    /// 64 pieces in a step, 20 000 in all, and pieces stay for ever.
    fn default() -> Self {
        Self {
            pieces_per_step: 64,
            pieces_alive: 20_000,
            least_volume: 0.0,
            generations: u8::MAX,
            lifetime: f32::INFINITY,
        }
    }
}

impl FractureBudget {
    /// Pieces that blows may still make in a step that has `made` some, while there are `alive`.
    pub(super) fn left(&self, made: usize, alive: usize) -> usize {
        if self.generations == 0 {
            return 0;
        }
        let in_step = self.pieces_per_step.saturating_sub(made);
        in_step.min(self.pieces_alive.saturating_sub(alive))
    }
}
