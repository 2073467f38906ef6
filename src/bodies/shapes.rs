//! What bodies ask of their shapes.

use crate::bodies::body::Shape;
use crate::geometry::Compound;
use crate::math::Aabb;

impl Shape {
    /// Whether both are the same shape in memory.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Convex(a), Self::Convex(b)) => a.is_same(b),
            (Self::HalfSpace(a), Self::HalfSpace(b)) => a == b,
            (Self::Level(a), Self::Level(b)) => a.is_same(b),
            (Self::Compound(a), Self::Compound(b)) => a.is_same(b),
            _ => false,
        }
    }

    /// The shape of several parts, if it is one.
    pub(crate) fn compound(&self) -> Option<&Compound> {
        match self {
            Self::Compound(compound) => Some(compound),
            _ => None,
        }
    }

    /// Volume of its hulls, m3.
    pub(crate) fn hull_volume(&self) -> Option<f64> {
        match self {
            Self::Convex(mesh) => Some(mesh.hull().volume()),
            Self::Compound(compound) => {
                let parts = compound.parts().iter();
                Some(parts.map(|part| part.shape.hull().volume()).sum())
            }
            Self::HalfSpace(_) | Self::Level(_) => None,
        }
    }

    /// The box around what has a volume, own frame.
    pub(crate) fn solid_aabb(&self) -> Option<Aabb> {
        match self {
            Self::Convex(mesh) => Some(mesh.aabb()),
            Self::Compound(compound) => Some(compound.aabb()),
            Self::HalfSpace(_) | Self::Level(_) => None,
        }
    }
}
