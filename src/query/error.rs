//! Why a question has no answer, and what finds it out.

use crate::math::Pose;
use glam::Vec3;

/// Why a question has no answer.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum QueryError {
    /// A coordinate is NaN or infinite.
    #[error("{0} is not finite")]
    NotFinite(&'static str),
    /// A direction without length.
    #[error("the direction has no length")]
    ZeroDirection,
    /// A length that is negative or NaN, or that has to be positive and is not.
    #[error("{name} cannot be {value} m")]
    Length {
        /// Which length.
        name: &'static str,
        /// Its value, m.
        value: f32,
    },
    /// The rotation is not a unit quaternion.
    #[error("the rotation is not a unit quaternion (length {length})")]
    NotUnitRotation {
        /// Length of the quaternion.
        length: f32,
    },
}

pub(crate) fn check_point(name: &'static str, point: Vec3) -> Result<(), QueryError> {
    if point.is_finite() {
        Ok(())
    } else {
        Err(QueryError::NotFinite(name))
    }
}

/// A length that may be zero, or without end.
pub(crate) fn check_length(name: &'static str, value: f32) -> Result<(), QueryError> {
    if value >= 0.0 {
        Ok(())
    } else {
        Err(QueryError::Length { name, value })
    }
}

pub(crate) fn check_pose(pose: &Pose) -> Result<(), QueryError> {
    check_point("the position", pose.position)?;
    let length = pose.rotation.length();
    if pose.rotation.is_normalized() {
        Ok(())
    } else {
        Err(QueryError::NotUnitRotation { length })
    }
}
