//! The shapes that questions are asked with.

use crate::geometry::support::Core;
use crate::geometry::{Compound, CompoundPart, ConvexHull, ConvexMesh};
use crate::math::{Aabb, Pose, rotate};
use crate::query::ball::Ball;
use crate::query::error::QueryError;
use glam::{Mat3, Vec3};

/// A shape to cast or to overlap with: a hull, a box, a sphere, a capsule, each with a radius around it, or that of a body
/// (`QueryShape::from(&ConvexMesh)`, `QueryShape::from(&Compound)`), round or of several parts as it may be.
#[derive(Clone, Copy, Debug)]
pub struct QueryShape<'s> {
    form: Form<'s>,
    /// Rounding radius, m; of parts, on top of their own.
    radius: f32,
}

#[derive(Clone, Copy, Debug)]
enum Form<'s> {
    Convex(Core<'s>),
    Parts(&'s [CompoundPart]),
}

/// A convex part of a shape, or the whole of one that is convex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QueryPart<'s> {
    pub(crate) core: Core<'s>,
    /// Rounding radius, m.
    pub(crate) radius: f32,
    /// Where it is, as seen from where the whole is told to be.
    pub(crate) pose: Pose,
}

impl<'s> QueryPart<'s> {
    pub(crate) fn of(mesh: &'s ConvexMesh, pose: Pose) -> Self {
        let (core, radius) = match mesh.round() {
            Some(round) => (round.core(), round.radius),
            None => (Core::of_hull(mesh.hull()), 0.0),
        };
        Self { core, radius, pose }
    }

    pub(crate) fn bounds(&self) -> Aabb {
        let turn = Mat3::from_quat(self.pose.rotation);
        let bounds = self.core.bounds(&turn, self.pose.position);
        bounds.fattened(self.radius)
    }

    fn reach(&self, axis: Vec3) -> f32 {
        let own = rotate(self.pose.rotation.inverse(), axis);
        axis.dot(self.pose.position) + own.dot(self.core.support(own)) + self.radius
    }
}

impl QueryShape<'static> {
    /// A sphere around the origin of its frame, m.
    ///
    /// # Errors
    /// [`QueryError::Length`] unless the radius is positive and finite.
    pub fn sphere(radius: f32) -> Result<Self, QueryError> {
        Self::sharp(Core::of_point(Vec3::ZERO)).rounded(check_size("the radius", radius)?)
    }

    /// A capsule along y around the origin of its frame: all that is within `radius` (m) of a segment of `length` (m).
    ///
    /// # Errors
    /// [`QueryError::Length`] unless both are positive and finite.
    pub fn capsule(radius: f32, length: f32) -> Result<Self, QueryError> {
        let half = 0.5 * check_size("the length", length)? * Vec3::Y;
        Self::sharp(Core::of_segment(-half, half)).rounded(check_size("the radius", radius)?)
    }

    /// A box around the origin of its frame with edges of the lengths in `size`, m.
    ///
    /// # Errors
    /// [`QueryError::Length`] unless all are positive and finite.
    pub fn cuboid(size: Vec3) -> Result<Self, QueryError> {
        for edge in size.to_array() {
            check_size("the edge", edge)?;
        }
        Ok(Self::of_extents(size))
    }

    /// A box that may be flat.
    pub(crate) fn of_extents(size: Vec3) -> Self {
        let half = 0.5 * size;
        let (min, max) = (-half, half);
        Self::sharp(Core::Box(Aabb { min, max }))
    }
}

impl<'s> QueryShape<'s> {
    fn sharp(core: Core<'s>) -> Self {
        Self {
            form: Form::Convex(core),
            radius: 0.0,
        }
    }

    /// What it consists of, with the whole at a pose.
    pub(crate) fn parts(&self, pose: &Pose) -> impl Iterator<Item = QueryPart<'s>> {
        let (radius, pose) = (self.radius, *pose);
        let (whole, parts) = match self.form {
            Form::Convex(core) => (Some(QueryPart { core, radius, pose }), &[][..]),
            Form::Parts(parts) => (None, parts),
        };
        let parts = parts.iter().map(move |part| {
            let own = QueryPart::of(&part.shape, pose * part.pose);
            QueryPart {
                radius: own.radius + radius,
                ..own
            }
        });
        whole.into_iter().chain(parts)
    }

    /// A convex hull.
    pub fn hull(hull: &'s ConvexHull) -> Self {
        Self::sharp(Core::of_hull(hull))
    }

    /// The shape with all that is within `radius` (m) of it.
    ///
    /// # Errors
    /// [`QueryError::Length`] if the radius is negative or not finite.
    pub fn rounded(self, radius: f32) -> Result<Self, QueryError> {
        if !(radius >= 0.0 && radius.is_finite()) {
            let name = "the radius";
            return Err(QueryError::Length {
                name,
                value: radius,
            });
        }
        Ok(Self {
            radius: self.radius + radius,
            ..self
        })
    }

    /// How far the shape at a pose reaches along a unit vector, from the origin, m.
    pub(crate) fn reach(&self, pose: &Pose, axis: Vec3) -> f32 {
        let reaches = self.parts(pose).map(|part| part.reach(axis));
        reaches.fold(f32::NEG_INFINITY, f32::max)
    }

    /// A ball around the shape at a pose; `bounds`: the box around it.
    pub(crate) fn ball(&self, pose: &Pose, bounds: &Aabb) -> Ball {
        match self.form {
            Form::Convex(Core::Box(b)) => Ball {
                center: pose.transform_point(b.center()),
                radius: 0.5 * b.diagonal() + self.radius,
            },
            _ => Ball::around(bounds),
        }
    }

    /// The box around the shape at a pose.
    pub(crate) fn bounds(&self, pose: &Pose) -> Aabb {
        if let Form::Convex(core) = self.form {
            let radius = self.radius;
            return QueryPart {
                core,
                radius,
                pose: *pose,
            }
            .bounds();
        }
        let boxes = self.parts(pose).map(|part| part.bounds());
        Aabb::of_points(boxes.flat_map(|b| [b.min, b.max]))
    }
}

impl<'s> From<&'s ConvexHull> for QueryShape<'s> {
    fn from(hull: &'s ConvexHull) -> Self {
        Self::hull(hull)
    }
}

impl<'s> From<&'s ConvexMesh> for QueryShape<'s> {
    fn from(mesh: &'s ConvexMesh) -> Self {
        let QueryPart { core, radius, .. } = QueryPart::of(mesh, Pose::IDENTITY);
        let form = Form::Convex(core);
        Self { form, radius }
    }
}

impl<'s> From<&'s Compound> for QueryShape<'s> {
    fn from(mesh: &'s Compound) -> Self {
        let form = Form::Parts(mesh.parts());
        Self { form, radius: 0.0 }
    }
}

fn check_size(name: &'static str, value: f32) -> Result<f32, QueryError> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(QueryError::Length { name, value })
    }
}
