//! Bodies that blows wear out: how strong they are still, and what a step did to them.

use crate::bodies::body::BodyError;
use crate::bodies::breaking::ImpactLoad;
use crate::bodies::fatigue::{Fatigue, Wearing};
use crate::bodies::store::Bodies;
use crate::geometry::Compound;

impl Bodies {
    /// How blows wear the body out, and how far it is.
    pub fn fatigue(&self, slot: u32) -> Option<&Fatigue> {
        let at = self.find_wearing(slot).ok()?;
        Some(&self.wearing[at].fatigue)
    }

    /// Says how blows wear the body out, and how far it is.
    ///
    /// # Errors
    /// [`BodyError::Fatigue`] if the numbers mean nothing; nothing changes then.
    pub fn set_fatigue(&mut self, slot: u32, fatigue: Option<Fatigue>) -> Result<(), BodyError> {
        fatigue.iter().try_for_each(Fatigue::validate)?;
        let id = self.id(slot);
        match (self.find_wearing(slot), fatigue) {
            (Ok(at), Some(fatigue)) => self.wearing[at].fatigue = fatigue,
            (Ok(at), None) => drop(self.wearing.remove(at)),
            (Err(at), Some(fatigue)) => self.wearing.insert(
                at,
                Wearing {
                    slot,
                    id,
                    fatigue,
                    blows: 0.0,
                },
            ),
            (Err(_), None) => {}
        }
        Ok(())
    }

    /// Lets those of the pieces that may break again be worn out as what they were, from the beginning but for bonds.
    pub(crate) fn wear_pieces(&mut self, fatigue: Fatigue, pieces: &[u32]) {
        let unworn = Fatigue {
            damage: 0.0,
            ..fatigue
        };
        for &piece in pieces {
            if self.fracturable(piece).is_some() || self.is_bonded(piece) {
                // What the parent had is usable.
                let _ = self.set_fatigue(piece, Some(unworn));
            }
        }
    }

    /// Whether bonds hold the parts of a body.
    pub(crate) fn is_bonded(&self, slot: u32) -> bool {
        self.compound(slot).is_some_and(Compound::is_bonded)
    }

    /// What blows have left of the strength of the body, N s; 0 of one that does not break.
    pub(crate) fn strength(&self, slot: u32) -> f32 {
        let whole = self.fracturable(slot).map_or(0.0, |f| f.strength);
        if self.wearing.is_empty() {
            return whole;
        }
        match self.fatigue(slot) {
            // Nothing wears out what is infinitely strong: that is how bodies are marked that only cuts divide.
            Some(fatigue) if whole.is_finite() => whole * (1.0 - fatigue.damage),
            _ => whole,
        }
    }

    /// Forgets the blows of the last step.
    pub(crate) fn begin_wearing(&mut self) {
        let blows = self.wearing.iter_mut().map(|wearing| &mut wearing.blows);
        blows.for_each(|blows| *blows = 0.0);
    }

    /// Adds a blow that a body bears in this step to what will wear it out.
    pub(crate) fn add_blow(&mut self, slot: u32, load: ImpactLoad) {
        let Ok(at) = self.find_wearing(slot) else {
            return;
        };
        // Bonds tell by themselves how worn they are.
        let Some(strength) = self.fracturable(slot).map(|f| f.strength) else {
            return;
        };
        let wearing = &mut self.wearing[at];
        if load.impulse > wearing.fatigue.endurance * strength {
            wearing.blows += load.energy;
        }
    }

    /// Adds the damage of what bodies (by slot) bore in a step.
    pub(crate) fn wear_out(&mut self, loads: impl Iterator<Item = (u32, ImpactLoad)>) {
        loads.for_each(|(slot, load)| self.add_blow(slot, load));
        for Wearing { fatigue, blows, .. } in &mut self.wearing {
            if *blows > 0.0 && fatigue.damage < 1.0 {
                fatigue.damage = (fatigue.damage + *blows / fatigue.energy).min(1.0);
            } else {
                *blows = 0.0;
            }
        }
    }

    /// Bodies to which the last step did damage.
    pub(crate) fn damaged(&self) -> impl Iterator<Item = &Wearing> {
        self.wearing.iter().filter(|wearing| wearing.blows > 0.0)
    }

    /// Forgets that a body wears out.
    pub(super) fn forget_fatigue(&mut self, slot: u32) {
        if let Ok(at) = self.find_wearing(slot) {
            self.wearing.remove(at);
        }
    }

    fn find_wearing(&self, slot: u32) -> Result<usize, usize> {
        self.wearing
            .binary_search_by_key(&slot, |wearing| wearing.slot)
    }
}
