//! Blasts.

use crate::bodies::body::BodyError;
use glam::Vec3;

/// A blast that pushes dynamic bodies away, and breaks what is near.
///
/// A body whose parts bonds hold, see [`Cluster`](crate::cluster::Cluster), gets no more than another one, but each part its share of it, by the open
/// area that it turns to the blast and by its distance. What breaks of it under that flies off; a static one breaks too. To another body that is
/// [`Fracturable`](crate::slice::Fracturable), static or not, it is a blow: with more impulse than its strength it breaks it, and its pieces share the
/// impulse by their areas. No part and no piece gets more than four times the speed that all that are reached would have together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explosion {
    /// Where, world, m.
    pub center: Vec3,
    /// How far it reaches, m.
    pub radius: f32,
    /// Impulse on a body at its center, N s. It falls to nothing at the radius, linearly with the distance to the box around the
    /// body's shape, and acts at that box's nearest point. It makes no body faster than 10 km/s, as fast as the gas of an explosion is: of what is
    /// too light for it the rest is lost.
    pub impulse: f32,
}

impl Explosion {
    /// Whether its numbers mean something.
    ///
    /// # Errors
    /// [`BodyError::Drive`].
    pub fn validate(&self) -> Result<(), BodyError> {
        let is_finite = self.center.is_finite() && self.impulse.is_finite();
        let is_usable = is_finite && self.radius.is_finite() && self.radius > 0.0;
        is_usable.then_some(()).ok_or(BodyError::Drive("Explosion"))
    }

    /// What is left of it at a point.
    pub(super) fn share_at(&self, point: Vec3) -> f32 {
        1.0 - point.distance(self.center) / self.radius
    }

    /// Unit vector from it to a point, or to another one if it is there.
    pub(super) fn away(&self, point: Vec3, other: Vec3) -> Vec3 {
        let to = |point: Vec3| (point - self.center).try_normalize();
        to(point).or_else(|| to(other)).unwrap_or(Vec3::Y)
    }
}
