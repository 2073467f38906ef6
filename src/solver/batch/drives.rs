//! Bodies of a batch that something drives besides gravity and contacts.

use crate::bodies::drive::Drive;
use crate::bodies::store::Bodies;
use crate::solver::batch::Batch;
use glam::Vec3;

impl Batch {
    /// Share of a sub-step's gravity that acts before the motion.
    pub(super) fn gravity_share(&self) -> f32 {
        self.joints.shares()[0]
    }

    /// Lists them.
    pub(super) fn load_driven(&mut self, bodies: &Bodies) {
        self.bodies.driven.clear();
        self.bodies.most_driven = 0.0;
        if bodies.drives.is_empty() {
            return;
        }
        let gravity = self.settings.gravity;
        let driven = (0..).zip(&self.layout.slots);
        let driven = driven.filter_map(|(number, &slot)| {
            let drive = bodies.drive_of(slot, gravity)?;
            Some((number, drive))
        });
        self.bodies.driven.extend(driven);
        let driven = self.bodies.driven.iter();
        let accelerations = driven.map(|(_, drive)| drive.acceleration.length());
        self.bodies.most_driven = accelerations.fold(0.0, f32::max);
    }

    /// Drives a body by the same forces, its weight among them, when it has so many times its inverse mass.
    pub(super) fn scale_drive(&mut self, body: u32, scale: f32) {
        let driven = &mut self.bodies.driven;
        let at = driven.partition_point(|(number, _)| *number < body);
        if driven.get(at).is_none_or(|(number, _)| *number != body) {
            driven.insert(at, (body, Drive::NONE));
        }
        driven[at]
            .1
            .scale_inverse_mass(scale, self.settings.gravity);
    }

    /// Bound of the acceleration of bodies by gravity and drives together, m/s2.
    pub(super) fn fastest_acceleration(&self) -> f32 {
        self.settings.gravity.length() + self.bodies.most_driven
    }

    /// The velocities that drives give within a sub-step before the motion: as gravity, half of them where joints are alone, or what friction and
    /// motors bear in a half would be asked for twice that.
    pub(super) fn apply_drives(&mut self) {
        self.drive_for(self.gravity_share() * self.settings.substep_dt);
    }

    /// The velocities that drives give in `h` seconds.
    pub(super) fn drive_for(&mut self, h: f32) {
        for (number, drive) in &self.bodies.driven {
            let body = &mut self.bodies.velocities[*number as usize];
            drive.advance(&mut body.linear, &mut body.angular, h);
        }
    }

    /// Takes out what contacts gave along locked axes and beyond limits.
    pub(super) fn restrain_driven(&mut self) {
        for (number, drive) in &self.bodies.driven {
            let body = &mut self.bodies.velocities[*number as usize];
            drive.restrain(&mut body.linear, &mut body.angular);
        }
    }

    /// What [`correct_flight`](Self::correct_flight) took for a fall and was none.
    pub(super) fn correct_driven_flight(&mut self, is_pushed: &[bool]) {
        let h = self.settings.substep_dt;
        for (number, drive) in &self.bodies.driven {
            let i = *number as usize;
            if !is_pushed[i] {
                let more: Vec3 = 0.5 * h * h * drive.acceleration;
                self.bodies.displacements[i].linear -= more;
            }
        }
    }
}
