//! What is asked: a ray, a shape that is moved.

use crate::math::Pose;
use crate::query::error::{QueryError, check_length, check_point, check_pose};
use crate::query::shape::QueryShape;
use glam::Vec3;

fn unit(direction: Vec3) -> Result<Vec3, QueryError> {
    check_point("the direction", direction)?;
    // In f64, so that the length of no f32 vector overflows or vanishes.
    let unit = direction.as_dvec3().try_normalize();
    unit.map(|unit| unit.as_vec3())
        .ok_or(QueryError::ZeroDirection)
}

/// A ray that ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    pub(crate) origin: Vec3,
    pub(crate) direction: Vec3,
    pub(crate) max_distance: f32,
    pub(crate) is_solid: bool,
}

impl Ray {
    /// From `origin` (m, world frame) along `direction`, which is scaled to unit length, for `max_distance` (m), which may be
    /// infinite, or 0: then only what the origin is in or on is hit.
    ///
    /// A body that holds the origin is hit there, at distance 0, with a normal against the direction; see
    /// [`hollow`](Self::hollow).
    ///
    /// # Errors
    /// [`QueryError`] if a number is NaN or infinite, the direction zero, or the distance negative.
    pub fn new(origin: Vec3, direction: Vec3, max_distance: f32) -> Result<Self, QueryError> {
        check_point("the origin", origin)?;
        check_length("the distance", max_distance)?;
        Ok(Self {
            origin,
            direction: unit(direction)?,
            max_distance,
            is_solid: true,
        })
    }

    /// From one point to another, m.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`QueryError::ZeroDirection`] if it is the same point.
    pub fn between(from: Vec3, to: Vec3) -> Result<Self, QueryError> {
        check_point("the end", to)?;
        let way = (to.as_dvec3() - from.as_dvec3()).length() as f32;
        Self::new(from, to - from, way)
    }

    /// The same ray for bodies without an inside: one that holds the origin is hit where the ray leaves it.
    pub fn hollow(self) -> Self {
        Self {
            is_solid: false,
            ..self
        }
    }

    /// Where it starts, m.
    pub fn origin(&self) -> Vec3 {
        self.origin
    }

    /// Its unit direction.
    pub fn direction(&self) -> Vec3 {
        self.direction
    }

    /// How long it is, m.
    pub fn max_distance(&self) -> f32 {
        self.max_distance
    }

    /// The point at a distance along it, m.
    pub fn at(&self, distance: f32) -> Vec3 {
        self.origin + distance * self.direction
    }
}

/// A shape that is moved without turning until it touches something.
#[derive(Clone, Copy, Debug)]
pub struct ShapeCast<'s> {
    pub(crate) shape: QueryShape<'s>,
    pub(crate) pose: Pose,
    pub(crate) direction: Vec3,
    pub(crate) max_distance: f32,
}

impl<'s> ShapeCast<'s> {
    /// Moves `shape` from `pose` (world frame) along `direction`, which is scaled to unit length, for `max_distance` (m), which may
    /// be infinite.
    ///
    /// What overlaps the shape at the start is hit there, at distance 0. What only touches it there is hit if the shape moves
    /// towards it.
    ///
    /// # Errors
    /// [`QueryError`] if a number is NaN or infinite, the direction zero, the distance negative or the rotation none.
    pub fn new(
        shape: QueryShape<'s>,
        pose: Pose,
        direction: Vec3,
        max_distance: f32,
    ) -> Result<Self, QueryError> {
        check_pose(&pose)?;
        check_length("the distance", max_distance)?;
        Ok(Self {
            shape,
            pose,
            direction: unit(direction)?,
            max_distance,
        })
    }
}
