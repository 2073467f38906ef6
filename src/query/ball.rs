//! Balls around bodies and shapes: most pairs are told apart by their balls.

use crate::math::Aabb;
use glam::Vec3;

/// What rounding may do to a distance of two centers, as a share of it and of the balls' radii.
const ROUNDING: f32 = 1e-5;

/// The way of what does not move.
pub(crate) const NOWHERE: (Vec3, f32) = (Vec3::ZERO, 0.0);

/// A ball around something: what is farther apart than two of them reach need not be looked at closer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    /// World frame, m.
    pub(crate) center: Vec3,
    /// m.
    pub(crate) radius: f32,
}

impl Ball {
    /// Around a box.
    pub(crate) fn around(b: &Aabb) -> Self {
        Self {
            center: b.center(),
            radius: 0.5 * b.diagonal(),
        }
    }

    /// Whether another ball may touch this one, which goes along a direction for a length (m).
    #[inline]
    pub(crate) fn may_reach(&self, other: &Self, (direction, length): (Vec3, f32)) -> bool {
        let apart = other.center - self.center;
        let along = apart.dot(direction).min(length).max(0.0);
        let rest = apart - along * direction;
        let reach = self.radius + other.radius;
        let slack = ROUNDING * (reach + apart.abs().max_element());
        let is_far = rest.length_squared() > (reach + slack) * (reach + slack);
        !is_far
    }
}
