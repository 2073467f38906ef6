//! What wakes a body at once: whoever changes it.

use crate::bodies::sleep_state::{Rest, Status, Stay};
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;

impl Bodies {
    /// Whether the body sleeps: it rests with its whole island, and no step touches it until something wakes it.
    #[inline]
    pub fn is_asleep(&self, slot: u32) -> bool {
        self.status.get(slot as usize) == Some(&Status::Asleep)
    }

    /// Number of bodies that sleep.
    pub fn asleep(&self) -> usize {
        self.sleep.asleep
    }

    /// Wakes the body and all that fell asleep in one island with it; of a fixed body, all that rests on it. A body that
    /// is awake stays so for at least [`SleepConfig::time`](crate::solver::SleepConfig::time). Changes by other methods of
    /// [`Bodies`] do this by themselves.
    pub fn wake(&mut self, slot: u32) {
        if !self.is_asleep(slot) {
            self.sleep.reset(slot);
            self.mark_changed(slot);
            return;
        }
        let mut member = slot;
        loop {
            let i = member as usize;
            self.status[i] = Status::Active;
            self.sleep.reset(member);
            self.sleep.asleep -= 1;
            self.sleep.woken.push(self.ids[i]);
            self.sleep.sleep_changes.push((member, self.ids[i]));
            member = self.sleep.next[i];
            if member == slot {
                return;
            }
        }
    }

    /// Lets the body fall asleep without waiting for [`SleepConfig::time`](crate::solver::SleepConfig::time), at the end of
    /// the next step: if it is at rest by the limits of [`SleepConfig`](crate::solver::SleepConfig) then, and so are all
    /// bodies of its island. For scenes that start at rest.
    pub fn request_sleep(&mut self, slot: u32) {
        if self.is_asleep(slot) {
            return;
        }
        let i = slot as usize;
        let needed = self.sleep.rest.len().max(i + 1);
        self.sleep.rest.resize(needed, Rest::default());
        self.sleep.rest[i] = self.rest_here(slot);
        self.sleep.rest[i].still.time = f32::INFINITY;
        self.sleep.sleep_changes.push((slot, self.ids[i]));
    }

    /// Slots and ids of bodies that fell asleep or woke since [`forget_sleep_changes`](Self::forget_sleep_changes), some perhaps both, or
    /// were expected to.
    pub(crate) fn sleep_changes(&self) -> &[(u32, BodyId)] {
        &self.sleep.sleep_changes
    }

    /// Forgets who fell asleep and woke.
    pub(crate) fn forget_sleep_changes(&mut self) {
        self.sleep.sleep_changes.clear();
    }

    /// Notes that a body was added, removed or changed: what sleeps on it wakes in the next step.
    pub(crate) fn mark_changed(&mut self, slot: u32) {
        if !self.sleep.is_on || self.sleep.is_changed(slot) {
            return;
        }
        let slots = self.slots();
        self.sleep.is_changed.resize(slots, false);
        self.sleep.is_changed[slot as usize] = true;
        self.sleep.changed.push(slot);
    }

    /// Wakes the body if it sleeps, and what sleeps on it.
    pub(crate) fn disturb(&mut self, slot: u32) {
        self.wake(slot);
        self.mark_changed(slot);
    }

    /// Rest that begins now.
    pub(crate) fn rest_here(&self, slot: u32) -> Rest {
        let here = Stay {
            time: 0.0,
            center: self.center[slot as usize],
            rotation: self.rotation[slot as usize],
        };
        Rest {
            still: here,
            rocking: here,
        }
    }
}
