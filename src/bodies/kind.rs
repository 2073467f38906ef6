//! Changes of how a body moves while it stays the same body.

use crate::bodies::body::{BodyError, RigidBody};
use crate::bodies::store::Bodies;
use crate::math::Pose;
use glam::{Mat3, Vec3};

impl Bodies {
    /// Makes a body dynamic, kinematic or static. It keeps its id, and with that its bonds and what is known of its contacts; it
    /// wakes, and its mass is known after the next mass phase.
    ///
    /// # Errors
    /// [`BodyError`] if a shape like that cannot move so; the body stays what it was then.
    pub fn set_kind(&mut self, slot: u32, kind: RigidBody) -> Result<(), BodyError> {
        let before = self.kind(slot);
        if before == kind {
            return Ok(());
        }
        let mut info = self.info(slot).clone();
        info.kind = kind;
        info.check_mass()?;
        self.disturb(slot);
        self.dynamic -= usize::from(before == RigidBody::Dynamic);
        self.dynamic += usize::from(kind == RigidBody::Dynamic);
        self.info[slot as usize] = Some(info);
        self.velocities_set += 1;
        if kind != RigidBody::Dynamic {
            // What no contact moves, none turns.
            self.inverse_inertia[slot as usize] = Mat3::ZERO;
        }
        self.mark_shape_changed(slot);
        self.disturb(slot);
        Ok(())
    }

    /// Ends a motion that was to lead to `pose`: the body is there, and has this velocity. Wakes nobody.
    pub(crate) fn arrive(&mut self, slot: u32, pose: Pose, (linear, angular): (Vec3, Vec3)) {
        self.place(slot, pose);
        self.refresh_world(slot);
        let body = &mut self.velocity[slot as usize];
        (body.linear, body.angular) = (linear, angular);
        self.velocities_set += 1;
    }
}
