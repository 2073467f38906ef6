//! How much fracture a scene can afford.

use crate::fracture::debris::DebrisRules;
use bevy_ecs::resource::Resource;

/// Awake bodies up to which a scene may grow at once, whatever [`FractureBudget::growth`] says: a step of a millisecond or two.
const SMALL_SCENE: usize = 256;

/// Pieces that each step may make, whatever the growth: one body breaks.
const MIN_IN_STEP: usize = 8;

/// Limits for what blows break. Cuts that are asked for are made whatever the budget says, but count.
///
/// What a step cannot afford is broken into fewer pieces; what does not even get two waits for its turn, in the order of
/// the blows and then of the bodies' ids, and breaks at the start of a later step.
#[derive(Clone, Copy, Debug, PartialEq, Resource)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct FractureBudget {
    /// Pieces that one step may make at most.
    pub pieces_per_step: usize,
    /// Pieces that one step may make for each dynamic body that is awake, so that no step is much longer than those around it:
    /// a piece that has just come to be has several times the contacts of other bodies, all of which move. A step may make 8
    /// pieces in any case, and as many as bring a small scene to 256 awake bodies. Infinite: no limit.
    pub growth: f32,
    /// Triangles of meshes that blows may cut in one step. A body whose mesh has more than are left waits for another step. One that has
    /// more than a step may cut is cut over as many steps as it takes, and breaks when that is done: a step in between does
    /// its share and at most one cell more. What is cut by a few planes ([`FracturePattern::SinglePlane`](crate::slice::FracturePattern::SinglePlane) and its like) and parts of
    /// [`Compound`](crate::geometry::Compound)s wait too, but are cut in one go. Bodies that are drawn as their hulls have no triangles, nor have clusters,
    /// which were cut before.
    pub triangles_per_step: usize,
    /// Pieces that there may be; no blow breaks anything while there are as many.
    pub max_alive_pieces: usize,
    /// Pieces smaller than this are not made, m3; what [`Fracturable`](crate::slice::fracturable::Fracturable) says holds
    /// too.
    pub min_volume: f32,
    /// How often a body and its pieces may break one after the other. At 0 blows break nothing.
    pub generations: u8,
    /// When pieces go again.
    pub debris: DebrisRules,
}

impl Default for FractureBudget {
    /// In a step 2 % of the bodies that are awake, but at most 64 pieces, and of 10 000 triangles (not measured apart); 20 000 pieces in all,
    /// which stay for ever.
    fn default() -> Self {
        Self {
            pieces_per_step: 64,
            growth: 0.02,
            triangles_per_step: 10_000,
            max_alive_pieces: 20_000,
            min_volume: 0.0,
            generations: u8::MAX,
            debris: DebrisRules::default(),
        }
    }
}

impl FractureBudget {
    /// Pieces that blows may still make in a step that has `made` some, while there are `alive`; `awake` is how many dynamic
    /// bodies were awake when it began.
    pub(super) fn left(&self, made: usize, alive: usize, awake: usize) -> usize {
        if self.generations == 0 {
            return 0;
        }
        let in_step = self.in_step(awake).saturating_sub(made);
        in_step.min(self.max_alive_pieces.saturating_sub(alive))
    }

    /// Whether a blow may cut a mesh of so many triangles in a step in which blows have cut `cut` already.
    pub(super) fn may_cut(&self, cut: usize, triangles: usize) -> bool {
        triangles == 0 || cut.saturating_add(triangles) <= self.triangles_per_step
    }

    /// Pieces that blows may make in a step that begins with `awake` bodies.
    fn in_step(&self, awake: usize) -> usize {
        // A number that is not finite becomes one end of the range.
        let growth = (self.growth * awake as f32) as usize;
        let least = SMALL_SCENE.saturating_sub(awake).max(MIN_IN_STEP);
        growth.max(least).min(self.pieces_per_step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_of_a_small_scene_may_make_what_a_large_one_may_not() {
        let budget = FractureBudget::default();
        let in_step = [0, 192, 200, 248, 256, 1000, 3199, 3200, 100_000].map(|n| budget.in_step(n));
        assert_eq!(in_step, [64, 64, 56, 8, 8, 20, 63, 64, 64]);
        let unlimited = FractureBudget {
            growth: f32::INFINITY,
            ..budget
        };
        assert_eq!([0, 1, 300].map(|awake| unlimited.in_step(awake)), [64; 3]);
        let none = FractureBudget {
            pieces_per_step: 0,
            ..unlimited
        };
        assert_eq!(none.in_step(1000), 0);
        let meaningless = FractureBudget {
            growth: f32::NAN,
            ..budget
        };
        assert_eq!(meaningless.in_step(1000), 8);
    }

    #[test]
    fn a_step_cuts_no_more_than_it_may() {
        let budget = FractureBudget {
            triangles_per_step: 100,
            ..FractureBudget::default()
        };
        assert!(budget.may_cut(0, 100) && budget.may_cut(1000, 0));
        assert!(!budget.may_cut(0, 101));
        assert!(budget.may_cut(60, 40) && !budget.may_cut(60, 41));
    }

    #[test]
    fn what_was_made_and_what_is_alive_count() {
        let budget = FractureBudget {
            max_alive_pieces: 100,
            ..FractureBudget::default()
        };
        assert_eq!(budget.left(10, 10, 100), 54);
        assert_eq!(budget.left(10, 60, 100), 40);
        assert_eq!(budget.left(100, 200, 100), 0);
    }
}
