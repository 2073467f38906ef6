//! Bodies that break: whether what they were hit with so far in a step is more than they bear.
//!
//! Looked at while the step is being solved. As soon as one body of a batch is overloaded, the solve is given up: the body
//! breaks, and the step is solved anew with its pieces. If nothing may break any more in the step, it is only noted.

use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use crate::slice::fracturable::Fracturable;

/// What one body of a batch bears in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BreakingLimit {
    /// Its number within the batch.
    pub body: u32,
    /// Impulse that it bears, N s.
    pub impulse: f32,
    /// Energy that a load must have to break it, J.
    pub energy: f32,
}

impl BreakingLimit {
    /// Whether a load is more than the body bears.
    pub fn is_exceeded_by(&self, load: &ImpactLoad) -> bool {
        load.impulse > self.impulse && load.energy >= self.energy
    }
}

/// What contacts did to a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImpactLoad {
    /// Sum of the normal impulses, N s.
    pub impulse: f32,
    /// Kinetic energy that they took out of the approach, J.
    pub energy: f32,
}

impl ImpactLoad {
    /// Adds a contact point with the normal impulse `impulse` (N s) on two bodies that approached each other with `speed`
    /// (m/s) before the step.
    ///
    /// A plastic load changes the energy by `impulse (v + v') / 2` with the speeds before and after it, and leaves `v' = 0`.
    pub fn add(&mut self, impulse: f32, speed: f32) {
        self.impulse += impulse;
        self.energy += 0.5 * impulse * speed.max(0.0);
    }
}

impl Bodies {
    /// What the body bears in a step, with number 0; `None` if it does not break, or has borne more already.
    #[inline]
    pub(crate) fn limit(&self, slot: u32) -> Option<BreakingLimit> {
        let fracturable = self.fracturable(slot)?;
        let is_at_risk =
            self.kind(slot) == RigidBody::Dynamic && !self.is_overloaded[slot as usize];
        is_at_risk.then_some(BreakingLimit {
            body: 0,
            impulse: fracturable.strength,
            energy: fracturable.min_energy,
        })
    }

    /// Most pieces that a blow may make of the body.
    pub(crate) fn max_pieces(&self, slot: u32) -> usize {
        self.fracturable(slot).map_or(0, |f| f.max_pieces.into())
    }

    /// How the body breaks; `None` if it does not or the slot is free.
    #[inline]
    pub fn fracturable(&self, slot: u32) -> Option<&Fracturable> {
        self.info.get(slot as usize)?.as_ref()?.fracturable.as_ref()
    }

    /// Whether any body can break.
    pub fn any_fracturable(&self) -> bool {
        self.fracturable > 0
    }

    /// Makes a body breakable or unbreakable, and wakes it if that changes anything: its own weight may break it.
    pub fn set_fracturable(&mut self, slot: u32, fracturable: Option<Fracturable>) {
        if self.is_asleep(slot) && self.info(slot).fracturable != fracturable {
            self.wake(slot);
        }
        self.fracturable += usize::from(fracturable.is_some());
        self.fracturable -= usize::from(self.info(slot).fracturable.is_some());
        self.info[slot as usize]
            .as_mut()
            .expect("slot holds a body")
            .fracturable = fracturable;
    }
}
