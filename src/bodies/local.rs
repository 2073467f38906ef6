//! Bodies that take local steps while all others wait.

use crate::bodies::local_state::Carrier;
use crate::bodies::sleep_state::Status;
use crate::bodies::solver_body::Motion;
use crate::bodies::store::Bodies;
use glam::Vec3;

impl Bodies {
    /// Whether a pair of slots matters to the local steps that are being taken: they may touch, and none of the two waits.
    pub(crate) fn needs_local_look(&self, [a, b]: [u32; 2]) -> bool {
        let waits = |slot: u32| {
            let i = slot as usize;
            self.status[i] != Status::Local && self.velocity[i].inverse_mass > 0.0
        };
        !waits(a) && !waits(b) && !self.are_apart(a, b)
    }

    /// Whether the body takes the local steps that are being taken.
    pub(crate) fn is_local(&self, slot: u32) -> bool {
        self.status[slot as usize] == Status::Local
    }

    /// Lets all bodies that contacts move wait, but for `members`. `carriers`: slots of what moves by itself.
    pub(crate) fn begin_local(&mut self, members: &[u32], carriers: &[u32]) {
        let mut local = std::mem::take(&mut self.local);
        local.is_on = true;
        local.revision += 1;
        local.slots.clear();
        local.slots.extend_from_slice(members);
        local.slots.extend_from_slice(carriers);
        local.carriers.clear();
        local.carriers.extend(carriers.iter().map(|&slot| {
            let i = slot as usize;
            Carrier {
                slot,
                id: self.ids[i],
                center: self.center[i],
                rotation: self.rotation[i],
                velocity: self.velocity[i],
                motion: self.motion[i],
            }
        }));
        self.local = local;
        for &slot in members {
            self.status[slot as usize] = Status::Local;
        }
    }

    /// Lets a body that has just come to be take part in local steps, if some are being taken.
    pub(super) fn join_local(&mut self, slot: u32) {
        if self.local.is_on {
            self.status[slot as usize] = Status::Local;
            self.local.revision += 1;
            self.note_local(slot);
        }
    }

    /// Sees to it that local steps, if some are being taken, look at a slot from which a body has gone, or into which one has come.
    pub(super) fn note_local(&mut self, slot: u32) {
        if self.local.is_on && !self.local.slots.contains(&slot) {
            self.local.slots.push(slot);
        }
    }

    /// Lets all bodies go on. Those that took local steps are where they are to be; what carried them is where it was, and moves
    /// with the others.
    pub(crate) fn end_local(&mut self) {
        self.local.is_on = false;
        for carrier in &self.local.carriers {
            let i = carrier.slot as usize;
            if self.ids[i] != carrier.id {
                continue;
            }
            self.center[i] = carrier.center;
            self.rotation[i] = carrier.rotation;
            self.velocity[i] = carrier.velocity;
            self.motion[i] = carrier.motion;
        }
        for &slot in &self.local.slots {
            let i = slot as usize;
            if self.status[i] == Status::Local {
                self.status[i] = Status::Active;
                self.motion[i] = Motion {
                    shift: Vec3::ZERO,
                    rotation: self.rotation[i],
                };
            }
        }
    }
}
