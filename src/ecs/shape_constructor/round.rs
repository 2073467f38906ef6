//! Round shapes as data.

use crate::geometry::round_core::RoundCore;
use crate::geometry::{ConvexHull, ConvexMesh, HullError};
use bevy_math::Vec3;

/// What a round shape is made from.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum RoundForm {
    /// [`ConvexMesh::sphere`].
    Sphere {
        /// m.
        radius: f32,
    },
    /// [`ConvexMesh::capsule`].
    Capsule {
        /// m.
        radius: f32,
        /// Of the segment along y, m.
        length: f32,
    },
    /// [`ConvexMesh::cylinder`].
    Cylinder {
        /// m.
        radius: f32,
        /// Along y, m.
        height: f32,
    },
    /// [`ConvexMesh::cone`].
    Cone {
        /// Of the base, m.
        radius: f32,
        /// Along y, m.
        height: f32,
    },
    /// [`ConvexMesh::rounded`].
    Hull {
        /// Points of the hull within, m.
        points: Vec<Vec3>,
        /// Of what is around it, m.
        radius: f32,
    },
}

impl Default for RoundForm {
    /// A sphere of one meter across.
    fn default() -> Self {
        Self::Sphere { radius: 0.5 }
    }
}

impl RoundForm {
    /// What a shape is made from, if it is round.
    pub(super) fn of(shape: &ConvexMesh) -> Option<Self> {
        let round = shape.round()?;
        let radius = round.radius;
        Some(match &round.core {
            RoundCore::Point => Self::Sphere { radius },
            &RoundCore::Segment(half) => Self::Capsule {
                radius,
                length: 2.0 * half,
            },
            RoundCore::Frustum(frustum) => {
                let ([radius, top], height) = (frustum.radii, frustum.height() as f32);
                if top == 0.0 {
                    Self::Cone { radius, height }
                } else {
                    Self::Cylinder { radius, height }
                }
            }
            RoundCore::Hull(hull) => Self::Hull {
                points: hull.vertices().to_vec(),
                radius,
            },
        })
    }

    pub(super) fn build(&self) -> Result<ConvexMesh, HullError> {
        match self {
            &Self::Sphere { radius } => ConvexMesh::sphere(radius),
            &Self::Capsule { radius, length } => ConvexMesh::capsule(radius, length),
            &Self::Cylinder { radius, height } => ConvexMesh::cylinder(radius, height),
            &Self::Cone { radius, height } => ConvexMesh::cone(radius, height),
            Self::Hull { points, radius } => {
                ConvexMesh::from_hull(ConvexHull::from_points(points)?).rounded(*radius)
            }
        }
    }
}
