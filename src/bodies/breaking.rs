//! Bodies that break: whether what they were hit with so far in a step is more than they bear.
//!
//! Looked at while the step is being solved. As soon as one body of a batch is overloaded, the solve is given up: the body
//! breaks, and the step is solved anew with its pieces. If nothing may break any more in the step, it is only noted.

use crate::bodies::store::Bodies;
use crate::slice::fracturable::Fracturable;
use crate::slice::roughen::CutLooks;
use glam::Vec3;
use smallvec::SmallVec;

/// Approach of two bodies up to which they rest on each other, m/s: a fall of 5 um. What the contact of two that rest bore in the
/// last step is a load, and no part of a blow; and where nothing comes faster, there is no blow, but only loads that shift.
pub(crate) const RESTING_SPEED: f32 = 0.01;

/// What one body of a batch bears in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BreakingLimit {
    /// Its number within the batch.
    pub body: u32,
    /// Impulse that it bears, N s.
    pub impulse: f32,
    /// Energy that a load must have to break it, J.
    pub energy: f32,
    /// Energy that a load must have to break a bond within it, J; infinite if there are none.
    pub bond_energy: f32,
}

impl BreakingLimit {
    /// Whether a load is more than the body bears.
    pub fn is_exceeded_by(&self, load: &ImpactLoad) -> bool {
        self.is_body_at_risk(load) || self.is_bond_at_risk(load.energy)
    }

    /// Whether it is more than the body bears besides its bonds.
    pub(crate) fn is_body_at_risk(&self, load: &ImpactLoad) -> bool {
        load.impulse > self.impulse && load.energy >= self.energy
    }

    /// Whether a load may break a bond within the body.
    pub(crate) fn is_bond_at_risk(&self, energy: f32) -> bool {
        energy >= self.bond_energy
    }
}

/// What contacts did to a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImpactLoad {
    /// Sum of the normal impulses, as far as they are more than what the contacts bore before, N s.
    pub impulse: f32,
    /// Kinetic energy that they took out of the approach, J.
    pub energy: f32,
}

impl ImpactLoad {
    /// Adds what one contact gave.
    pub(crate) fn add(&mut self, other: Self) {
        self.impulse += other.impulse;
        self.energy += other.energy;
    }

    /// Adds the energy of a contact point with the normal impulse `impulse` (N s) on two bodies that approached each other with
    /// `speed` (m/s) before the step.
    ///
    /// A plastic load changes the energy by `impulse (v + v') / 2` with the speeds before and after it, and leaves `v' = 0`.
    pub(crate) fn add_energy(&mut self, impulse: f32, speed: f32) {
        self.energy += 0.5 * impulse * speed.max(0.0);
    }
}

/// How two bodies rest on each other at a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Rest {
    /// What the contact bore in the last step, N s.
    pub(crate) impulse: f32,
    /// Approach above which they hit each other, m/s.
    pub(crate) speed: f32,
}

/// A blow to one body, from all contacts of its island. A body that contacts do not move has one for each island at it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Blow {
    /// Who was hit.
    pub(crate) slot: u32,
    /// Impulse and energy, all contacts together.
    pub(crate) load: ImpactLoad,
    /// Sum of the impulses times where they act, from the center of mass, world axes, N s m.
    ///
    /// Divided by the impulse, the center of the blow. A single point would do for corners only: a box that lands flat
    /// touches with four, and a plane through one of them is the plane of a face.
    pub(crate) moment: Vec3,
    /// Sum of the impulses with their directions on the body, world axes, N s.
    pub(crate) direction: Vec3,
    /// Slot of the body that gave most of it, and how much that was, N s.
    pub(crate) strongest: Option<(u32, f32)>,
    /// The manifolds that gave it, and which share of their impulses is part of it.
    pub(crate) contacts: SmallVec<[(u32, f32); 4]>,
    /// Bonds within the body that it breaks, by index, and the work that they take, J. With none it divides the body itself.
    pub(crate) bonds: Vec<u32>,
    pub(crate) bond_work: f32,
    /// Bonds of a body that blows wear out which it strains and leaves whole, see [`Bodies::wear_bonds`].
    pub(crate) strained: Vec<(u32, f32)>,
}

impl Bodies {
    /// What the body bears in a step, with number 0; `None` if it does not break, or must not now.
    #[inline]
    pub(crate) fn limit(&self, slot: u32) -> Option<BreakingLimit> {
        let fracturable = self.fracturable(slot);
        let bond_energy = self.bond_energy(slot);
        if fracturable.is_none() && bond_energy == f32::INFINITY {
            return None;
        }
        let borne = self.borne_impulse[slot as usize];
        let is_at_risk = borne < f32::INFINITY && self.info(slot).shape.solid_aabb().is_some();
        let impulse = fracturable.map_or(f32::INFINITY, |_| self.strength(slot).max(borne));
        is_at_risk.then_some(BreakingLimit {
            body: 0,
            impulse,
            energy: fracturable.map_or(f32::INFINITY, |it| it.min_energy),
            bond_energy,
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

    /// What the faces of its cuts look like.
    pub(crate) fn cut_looks(&self, slot: u32) -> CutLooks {
        let info = self.info(slot);
        let kept = info.cut_looks.as_deref().copied();
        match &info.fracturable {
            Some(fracturable) => fracturable.cut_looks(),
            None => kept.unwrap_or_default(),
        }
    }

    /// Says how cuts of a piece look that may not be [`Fracturable`] any more.
    pub(crate) fn keep_cut_looks(&mut self, slot: u32, looks: CutLooks) {
        if let Some(info) = &mut self.info[slot as usize] {
            info.cut_looks = (looks != CutLooks::default()).then(|| Box::new(looks));
        }
    }

    /// Whether any body can break.
    pub fn any_fracturable(&self) -> bool {
        self.fracturable > 0 || self.any_cluster()
    }

    /// Makes a body breakable or unbreakable, and wakes it if that changes anything.
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
