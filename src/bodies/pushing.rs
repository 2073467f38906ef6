//! Forces and impulses at points of bodies. On a body whose parts bonds hold they act on one part, and may break it off.

use crate::bodies::body::BodyError;
use crate::bodies::drive::StepForces;
use crate::bodies::pushes::PointPush;
use crate::bodies::store::Bodies;
use crate::math::rotate;
use glam::Vec3;

impl Bodies {
    /// Lets a force (N) and an impulse (N s), world axes, act in the next step at a point of the world (m); otherwise as [`apply`](Self::apply).
    ///
    /// Of a body whose parts bonds hold they load the part that is there, also if the body stands: the impulse is judged as a blow, and the
    /// force, as long as it lasts, as a load.
    ///
    /// # Errors
    /// [`BodyError::Drive`] if a number is not finite; nothing acts then.
    pub fn apply_at(
        &mut self,
        slot: u32,
        point: Vec3,
        [force, impulse]: [Vec3; 2],
    ) -> Result<(), BodyError> {
        let lever = point - self.center_of_mass(slot);
        let mut forces = StepForces {
            force,
            torque: lever.cross(force),
            impulse,
            angular_impulse: lever.cross(impulse),
            ..StepForces::default()
        };
        if !(forces.is_finite() && point.is_finite()) {
            return Err(BodyError::Drive("a force"));
        }
        if self.cluster(slot).is_some() {
            let pose = self.pose(slot);
            let push = |amount: Vec3| PointPush {
                slot,
                id: self.id(slot),
                place: pose.inverse_transform_point(point),
                amount: rotate(pose.rotation.inverse(), amount),
            };
            let pushes = [push(force), push(impulse)];
            if force != Vec3::ZERO {
                self.pushes.forces.push(pushes[0]);
            }
            if impulse != Vec3::ZERO {
                // Acts once it is known what it breaks.
                self.pushes.impulses.push(pushes[1]);
            }
            (forces.impulse, forces.angular_impulse) = (Vec3::ZERO, Vec3::ZERO);
        }
        self.apply(slot, &forces)
    }
}
