//! Bodies that blows wear out: how, and how far they are.
//!
//! Few bodies do, so they are a list of their own, sorted by slot; the others are asked for nothing.

use crate::bodies::body::BodyError;
use crate::contact::body_id::BodyId;
use bevy_ecs::component::Component;

/// Wears a body out that is [`Fracturable`](crate::slice::fracturable::Fracturable), or made of parts that bonds hold: each blow that it bears takes a share of its strength,
/// by its energy. A load at rest takes none, however long it lasts.
///
/// What is left of the strength is `strength (1 - damage)`. The plugin writes `damage`; to save and load it is to save and load this
/// component. Pieces begin anew.
///
/// Of a [`Cluster`](crate::cluster::Cluster) the bonds wear out, each for itself: a blow takes the share of its energy from a bond that bears
/// all it can and is left whole, and of one that bears a share of that the square of this share, as of the energy that it holds; what is
/// loaded with less than `endurance` is not worn. So bonds near the blow are, and those far away are not. How far each is stands in [`PartBond::damage`](crate::geometry::PartBond::damage), is saved with the [`Compound`](crate::geometry::Compound), and is kept by
/// what comes off; a bond that is worn out is gone. `damage` here is that of a body that is `Fracturable` too.
///
/// Source: the linear rule of A. Palmgren (1924) and M. A. Miner, "Cumulative Damage in Fatigue", 1945, with energy for cycles.
#[derive(Clone, Copy, Debug, PartialEq, Component)]
#[component(summary_tick)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Fatigue {
    /// Energy of blows that wears the body, or a bond that they all strain, out altogether, J.
    pub energy: f32,
    /// Share of the strength, from 0 to 1, below which a blow does no damage: the endurance limit.
    pub endurance: f32,
    /// Damage until now, from 0 to 1.
    pub damage: f32,
}

impl Default for Fatigue {
    /// Worn out by 1000 J of blows of at least a tenth of the strength.
    fn default() -> Self {
        Self {
            energy: 1000.0,
            endurance: 0.1,
            damage: 0.0,
        }
    }
}

impl Fatigue {
    /// Worn out by blows with this energy together, J.
    pub fn new(energy: f32) -> Self {
        Self {
            energy,
            ..Self::default()
        }
    }

    /// Whether its numbers mean something.
    ///
    /// # Errors
    /// [`BodyError::Fatigue`].
    pub fn validate(&self) -> Result<(), BodyError> {
        let is_share = |x: f32| (0.0..=1.0).contains(&x);
        let is_usable = self.energy > 0.0 && is_share(self.endurance) && is_share(self.damage);
        is_usable.then_some(()).ok_or(BodyError::Fatigue)
    }
}

/// A body that wears out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wearing {
    pub(crate) slot: u32,
    pub(crate) id: BodyId,
    pub(crate) fatigue: Fatigue,
    /// Energy of the blows of the last step that did damage, J.
    pub(crate) blows: f32,
}
