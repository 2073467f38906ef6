//! Who is bonded to whom, and whom joints hold: what contacts ask about a pair before it is looked at.

use crate::bodies::store::Bodies;

impl Bodies {
    /// Whether the bodies in two slots, the first of which has the smaller id, are bonded.
    pub(crate) fn are_bonded(&self, a: u32, b: u32) -> bool {
        let name = || (self.id(a), self.id(b));
        !self.bonded.is_empty() && self.bonded.binary_search(&name()).is_ok()
    }

    /// Whether the bodies in two slots, the first of which has the smaller id, are joined without contacts.
    #[inline]
    pub(crate) fn are_apart(&self, a: u32, b: u32) -> bool {
        let name = || (self.id(a), self.id(b));
        !self.apart.is_empty()
            && self.apart.binary_search(&name()).is_ok()
            && !self.are_bonded(a, b)
    }

    /// Whether two bodies touch each other where they meet, and nothing holds them together.
    pub(crate) fn may_touch(&self, a: u32, b: u32) -> bool {
        let [first, second] = [a, b].map(|slot| self.info(slot));
        let [low, high] = if self.id(a) < self.id(b) {
            [a, b]
        } else {
            [b, a]
        };
        !first.is_sensor
            && !second.is_sensor
            && first.layers.interact(&second.layers)
            && !self.are_apart(low, high)
            && !self.are_bonded(low, high)
    }

    /// Whether a joint holds the body.
    pub(crate) fn is_jointed(&self, slot: u32) -> bool {
        !self.jointed.is_empty() && self.jointed.binary_search(&self.id(slot)).is_ok()
    }
}
