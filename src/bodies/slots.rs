//! Slots that bodies leave, and get.

use crate::bodies::body::RigidBody;
use crate::bodies::sleep_state::Status;
use crate::bodies::solver_body::{Motion, SolverBody};
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::mass::MassProperties;
use glam::{Mat3, Quat, Vec3};

impl Bodies {
    /// Removes the body in `slot`; does nothing if the slot is free.
    pub fn remove(&mut self, slot: u32) {
        let i = slot as usize;
        if i >= self.slots() || self.status[i] == Status::Free {
            return;
        }
        self.departures += 1;
        self.disturb(slot);
        self.fracturable -= usize::from(self.info(slot).fracturable.is_some());
        self.dynamic -= usize::from(self.kind(slot) == RigidBody::Dynamic);
        self.status[i] = Status::Free;
        self.note_local(slot);
        self.info[i] = None;
        self.forget_extras(slot);
        self.velocity[i] = SolverBody::default();
        self.kd_box[i] = None;
        self.free.push(slot);
        self.alive -= 1;
    }

    /// The same, but nobody gets the slot before the next step: what stands may be named by contacts that are solved already.
    pub(crate) fn retire(&mut self, slot: u32) {
        self.remove(slot);
        let freed = self.free.pop();
        self.retired.extend(freed);
    }

    /// Frees the slots of bodies that retired in the last step.
    pub(crate) fn free_retired(&mut self) {
        self.free.append(&mut self.retired);
    }

    /// A slot that was never used.
    pub(super) fn grow(&mut self) -> u32 {
        let slot = self.ids.len() as u32;
        self.ids.push(BodyId::default());
        self.status.push(Status::Free);
        self.info.push(None);
        self.center.push(Vec3::ZERO);
        self.rotation.push(Quat::IDENTITY);
        self.velocity.push(SolverBody::default());
        self.motion.push(Motion::default());
        self.mass.push(MassProperties::default());
        self.inverse_inertia.push(Mat3::ZERO);
        self.kd_box.push(None);
        self.min_extent.push(0.0);
        self.radius.push(0.0);
        self.version.push(0);
        self.borne_impulse.push(0.0);
        slot
    }
}
