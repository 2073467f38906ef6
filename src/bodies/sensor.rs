//! Bodies that only sense who is inside them.

use crate::bodies::store::Bodies;

impl Bodies {
    /// Lists the body among the sensors if it is one.
    pub(super) fn note_sensor(&mut self, slot: u32) {
        let is_sensor = self.info(slot).is_sensor;
        if is_sensor || !self.sensors.is_empty() {
            self.sensors.retain(|&sensor| sensor != slot);
        }
        if is_sensor {
            self.sensors.push(slot);
        }
    }

    /// Whether the body only senses who is inside it.
    pub fn is_sensor(&self, slot: u32) -> bool {
        !self.sensors.is_empty() && self.info(slot).is_sensor
    }

    /// Forgets what few bodies have of the body that leaves `slot`.
    pub(super) fn forget_extras(&mut self, slot: u32) {
        self.sensors.retain(|&sensor| sensor != slot);
        self.drives.remove(slot);
        self.forget_fatigue(slot);
        self.forget_cluster(slot);
        if let Some(hold) = self.holds.get_mut(slot as usize) {
            *hold = None;
        }
    }
}
