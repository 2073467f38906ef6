//! Bodies that are driven: how, by which forces, and until when.

use crate::bodies::body::BodyError;
use crate::bodies::drive::{BodyDrive, Drive, StepForces};
use crate::bodies::store::Bodies;
use crate::math::rotate;
use glam::Vec3;

/// What goes slower than this share of the speed that a motor or a running surface gives it has stalled: at a limit, against a wall, under too
/// great a load. What does not is no more at rest than what is fast: the hand of a clock, a load on a slow belt.
pub(crate) const STALLED: f32 = 0.1;

impl Bodies {
    /// What moves the body besides gravity and contacts.
    pub fn drive(&self, slot: u32) -> BodyDrive {
        self.drives
            .get(slot)
            .map_or_else(BodyDrive::default, |driven| driven.drive)
    }

    /// Along and about which axes of the world the body in `slot` does not move: one for each of these, else zero.
    pub(crate) fn locks(&self, slot: u32) -> [Vec3; 2] {
        let locked = self.drives.get(slot).map(|driven| driven.drive.locked);
        let free = locked.map_or([Vec3::ONE; 2], |axes| [axes.free_ways(), axes.free_turns()]);
        free.map(|free| Vec3::ONE - free)
    }

    /// Whether surfaces of bodies may run along themselves.
    pub(crate) fn has_running_surfaces(&self) -> bool {
        self.drives.has_surfaces
    }

    /// How fast the surface of the body in `slot` runs along itself, world axes, m/s.
    pub(crate) fn surface_velocity(&self, slot: u32) -> Vec3 {
        let driven = self.drives.get(slot);
        driven.map_or(Vec3::ZERO, |driven| {
            rotate(self.rotation[slot as usize], driven.drive.surface_velocity)
        })
    }

    /// Sets what moves the body besides gravity and contacts, and wakes it if that changes anything.
    ///
    /// # Errors
    /// [`BodyError::Drive`]; the body is driven as before then.
    pub fn set_drive(&mut self, slot: u32, drive: BodyDrive) -> Result<(), BodyError> {
        drive.validate()?;
        if drive == self.drive(slot) {
            return Ok(());
        }
        let id = self.id(slot);
        self.drives.of(slot, id).drive = drive;
        self.drives.has_surfaces |= drive.surface_velocity != Vec3::ZERO;
        if drive == BodyDrive::default() {
            self.drives.remove(slot);
        }
        self.refresh_world(slot);
        self.disturb(slot);
        Ok(())
    }

    /// Lets pieces be driven as what they were: its forces end with it, or each of them would get all.
    pub(crate) fn drive_pieces(&mut self, drive: BodyDrive, pieces: &[u32]) {
        for &piece in pieces {
            // What the parent had is usable.
            let _ = self.set_drive(piece, drive.of_pieces());
        }
    }

    /// Stops the body.
    pub(crate) fn halt(&mut self, slot: u32) {
        let v = &mut self.velocity[slot as usize];
        (v.linear, v.angular) = (Vec3::ZERO, Vec3::ZERO);
    }

    /// Lets forces act on the body in the next step; it wakes, unless they are zero. Does nothing to bodies that forces do not
    /// move. The mass must be known: call after the mass phase.
    ///
    /// # Errors
    /// [`BodyError::Drive`] if a force is not finite; none acts then.
    pub fn apply(&mut self, slot: u32, forces: &StepForces) -> Result<(), BodyError> {
        if !forces.is_finite() {
            return Err(BodyError::Drive("a force"));
        }
        let i = slot as usize;
        if *forces == StepForces::default() || self.velocity[i].inverse_mass == 0.0 {
            return Ok(());
        }
        self.wake(slot);
        let (inverse_mass, inertia) = (self.velocity[i].inverse_mass, self.inverse_inertia[i]);
        let body = &mut self.velocity[i];
        body.linear += inverse_mass * forces.impulse;
        body.angular += inertia * forces.angular_impulse;
        let acceleration = forces.acceleration + inverse_mass * forces.force;
        let angular_acceleration = forces.angular_acceleration + inertia * forces.torque;
        if (acceleration, angular_acceleration) != (Vec3::ZERO, Vec3::ZERO) {
            let id = self.id(slot);
            let driven = self.drives.of(slot, id);
            driven.acceleration += acceleration;
            driven.angular_acceleration += angular_acceleration;
        }
        Ok(())
    }

    /// How the body is driven in this step under `gravity` (m/s2), if it is.
    pub(crate) fn drive_of(&self, slot: u32, gravity: Vec3) -> Option<Drive> {
        let driven = self
            .drives
            .get(slot)
            .filter(|driven| driven.id == self.id(slot))?;
        let i = slot as usize;
        if self.velocity[i].inverse_mass == 0.0 {
            return None;
        }
        let drive = &driven.drive;
        let by_force = self.velocity[i].inverse_mass * drive.force;
        let by_torque = self.inverse_inertia[i] * drive.torque;
        Some(Drive {
            acceleration: driven.acceleration + by_force + (drive.gravity_scale - 1.0) * gravity,
            angular_acceleration: driven.angular_acceleration + by_torque,
            damping: [drive.linear_damping, drive.angular_damping],
            most: [drive.max_speed, drive.max_angular_speed],
            free: [drive.locked.free_ways(), drive.locked.free_turns()],
        })
    }

    /// After the bodies were moved: forces of the step act no more, and locked bodies have the inertia of where they are.
    pub(super) fn end_drives(&mut self) {
        if self.drives.is_empty() {
            return;
        }
        let slots: Vec<u32> = self.drives.end_step().collect();
        for slot in slots {
            if self.drives.has_locked_turns(slot) {
                self.refresh_world(slot);
            }
        }
    }
}
