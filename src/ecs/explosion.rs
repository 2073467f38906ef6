//! Blasts.

use crate::bodies::drive::StepForces;
use crate::bodies::store::Bodies;
use bevy_math::Vec3;

/// A blast that pushes dynamic bodies away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explosion {
    /// Where, world, m.
    pub center: Vec3,
    /// How far it reaches, m.
    pub radius: f32,
    /// Impulse on a body at its center, N s. It falls to nothing at the radius, linearly with the distance to the box around the
    /// body's shape, and acts at that box's nearest point.
    pub impulse: f32,
}

impl Explosion {
    /// What it does to the body in `slot`.
    pub(super) fn forces_on(&self, bodies: &Bodies, slot: u32) -> Option<StepForces> {
        let pose = bodies.pose(slot);
        let aabb = bodies.info(slot).shape.solid_aabb()?;
        let local = pose.inverse_transform_point(self.center);
        let nearest = pose.transform_point(local.clamp(aabb.min, aabb.max));
        let center = bodies.center_of_mass(slot);
        let share = 1.0 - nearest.distance(self.center) / self.radius;
        let is_reached = share > 0.0;
        let away = (nearest - self.center)
            .try_normalize()
            .or_else(|| (center - self.center).try_normalize());
        let impulse = share * self.impulse * away.unwrap_or(Vec3::Y);
        is_reached.then(|| StepForces {
            impulse,
            angular_impulse: (nearest - center).cross(impulse),
            ..StepForces::default()
        })
    }
}
