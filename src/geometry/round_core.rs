//! What a round shape has a radius around.

use crate::geometry::ConvexHull;
use crate::geometry::frustum::Frustum;
use crate::geometry::support::Core;
use glam::Vec3;

/// The inside of a round shape.
#[derive(Clone, Debug)]
pub(crate) enum RoundCore {
    /// The origin.
    Point,
    /// Along y, this far up and down from the origin, m.
    Segment(f32),
    /// A cylinder or a cone.
    Frustum(Frustum),
    /// A hull.
    Hull(Box<ConvexHull>),
}

impl RoundCore {
    /// As distances and casts read it.
    pub(crate) fn core(&self) -> Core<'_> {
        match self {
            Self::Point => Core::of_point(Vec3::ZERO),
            Self::Segment(half) => Core::of_segment(*half * Vec3::NEG_Y, *half * Vec3::Y),
            Self::Frustum(frustum) => Core::Frustum(*frustum),
            Self::Hull(hull) => Core::of_hull(hull),
        }
    }
}
