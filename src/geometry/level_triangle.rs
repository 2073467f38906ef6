//! A triangle of a level, and what its edges are.

use crate::math::Plane;
use glam::Vec3;

/// What lies beyond an edge of a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EdgeKind {
    /// A triangle in the same plane.
    Flat,
    /// A triangle that falls away.
    Convex,
    /// A triangle that rises.
    Concave,
    /// Nothing.
    #[default]
    Open,
}

impl EdgeKind {
    /// The same edge seen from the other side.
    pub(crate) fn mirrored(self) -> Self {
        match self {
            Self::Convex => Self::Concave,
            Self::Concave => Self::Convex,
            other => other,
        }
    }
}

/// A triangle as collision tests and questions read it: in one line of the cache.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub(crate) struct LevelTriangle {
    pub(crate) corners: [Vec3; 3],
    pub(crate) plane: Plane,
    /// Beyond the edges from each corner to the next.
    pub(crate) edges: [EdgeKind; 3],
    /// Its number in the list that the mesh was made from.
    pub(crate) index: u32,
}
