//! Convex shapes by their supports: how far a shape reaches along a direction is all that distances and casts ask.
//!
//! A shape is a core, whose corners are known, and a radius around it: a sphere is one corner, a capsule two, a hull many.

use crate::geometry::ConvexHull;
use crate::geometry::frustum::Frustum;
use crate::geometry::hull_lanes::{LANES, Points4, lowest, point};
use crate::math::{Aabb, Pose};
use glam::{DMat3, DVec3, Mat3, Vec3};

/// The corners of a convex shape, own frame, m.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Core<'s> {
    /// The vertices of a hull.
    Hull(&'s [Points4]),
    /// Up to four corners; the first so many count.
    Few([Vec3; 4], usize),
    /// The corners of a box.
    Box(Aabb),
    /// A cylinder or a cone, which has more corners than can be listed.
    Frustum(Frustum),
}

impl<'s> Core<'s> {
    pub(crate) fn of_hull(hull: &'s ConvexHull) -> Self {
        Self::Hull(&hull.lanes.points)
    }

    pub(crate) fn of_point(at: Vec3) -> Self {
        Self::Few([at; 4], 1)
    }

    pub(crate) fn of_segment(from: Vec3, to: Vec3) -> Self {
        Self::Few([from, to, to, to], 2)
    }

    pub(crate) fn of_triangle([a, b, c]: [Vec3; 3]) -> Self {
        Self::Few([a, b, c, c], 3)
    }

    /// The corner farthest along `axis`, the first one on a tie.
    #[inline]
    pub(crate) fn support(&self, axis: Vec3) -> Vec3 {
        match self {
            Self::Hull(points) => point(points, lowest(points.iter(), -axis).0),
            Self::Few(corners, count) => {
                let mut best = corners[0];
                let mut height = axis.dot(best);
                for &corner in &corners[1..*count] {
                    let other = axis.dot(corner);
                    if other > height {
                        (best, height) = (corner, other);
                    }
                }
                best
            }
            Self::Box(b) => Vec3::select(axis.cmpge(Vec3::ZERO), b.max, b.min),
            Self::Frustum(frustum) => frustum.support(axis.as_dvec3()).as_vec3(),
        }
    }

    /// The same, as exact as it can be told.
    #[inline]
    pub(crate) fn exact_support(&self, axis: DVec3) -> DVec3 {
        match self {
            Self::Frustum(frustum) => frustum.support(axis),
            _ => self.support(axis.as_vec3()).as_dvec3(),
        }
    }

    /// A point of it.
    pub(crate) fn middle(&self) -> Vec3 {
        match self {
            Self::Hull(points) => point(points, 0),
            Self::Few(corners, count) => corners[..*count].iter().sum::<Vec3>() / *count as f32,
            Self::Box(b) => b.center(),
            Self::Frustum(f) => 0.5 * (f.levels[0] + f.levels[1]) * Vec3::Y,
        }
    }

    /// The box around the core in another frame.
    pub(crate) fn bounds(&self, turn: &Mat3, shift: Vec3) -> Aabb {
        if let Self::Box(b) = self {
            let (middle, half) = (*turn * b.center() + shift, 0.5 * b.extents());
            let half =
                Mat3::from_cols(turn.x_axis.abs(), turn.y_axis.abs(), turn.z_axis.abs()) * half;
            return Aabb {
                min: middle - half,
                max: middle + half,
            };
        }
        let rows = turn.transpose();
        let along = |axis: Vec3| axis.dot(self.support(axis));
        let [x, y, z] = [rows.x_axis, rows.y_axis, rows.z_axis];
        Aabb {
            min: shift - Vec3::new(along(-x), along(-y), along(-z)),
            max: shift + Vec3::new(along(x), along(y), along(z)),
        }
    }
}

/// The mean of points, of which those that fill up a group count too.
fn mean(points: &[Points4]) -> Vec3 {
    let sums = points.iter().map(|group| {
        let sum = |along: &[f32; LANES]| along.iter().sum::<f32>();
        Vec3::new(sum(&group.x), sum(&group.y), sum(&group.z))
    });
    sums.sum::<Vec3>() / (LANES * points.len()) as f32
}

/// What is known by how far it reaches along a direction.
pub(crate) trait Support {
    /// The corner farthest along `axis`.
    fn support(&self, axis: DVec3) -> DVec3;
}

/// A point.
impl Support for DVec3 {
    #[inline]
    fn support(&self, _: DVec3) -> DVec3 {
        *self
    }
}

impl Support for PlacedCore<'_> {
    #[inline]
    fn support(&self, axis: DVec3) -> DVec3 {
        PlacedCore::support(self, axis)
    }
}

/// A core in the frame of another one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedCore<'s> {
    pub(crate) core: Core<'s>,
    turn: Mat3,
    exact_turn: DMat3,
    shift: DVec3,
}

impl<'s> PlacedCore<'s> {
    pub(crate) fn new(core: Core<'s>, pose: &Pose) -> Self {
        let turn = Mat3::from_quat(pose.rotation);
        Self {
            core,
            turn,
            exact_turn: turn.as_dmat3(),
            shift: pose.position.as_dvec3(),
        }
    }

    /// The box around the core.
    pub(crate) fn bounds(&self) -> Aabb {
        self.core.bounds(&self.turn, self.shift.as_vec3())
    }

    /// The middle, axes and half of the edges of a core that is a box.
    pub(crate) fn as_box(&self) -> Option<(Vec3, Mat3, Vec3)> {
        match &self.core {
            Core::Box(b) => Some((self.middle().as_vec3(), self.turn, 0.5 * b.extents())),
            _ => None,
        }
    }

    /// The axes of the core's own frame.
    pub(crate) fn axes(&self) -> DMat3 {
        self.exact_turn
    }

    /// The same, moved from where it was placed.
    pub(crate) fn moved(&self, by: DVec3) -> Self {
        Self {
            shift: self.shift + by,
            ..*self
        }
    }

    /// The same core, seen from a frame that is at a pose.
    pub(crate) fn seen_from(&self, pose: &Pose) -> Self {
        let back = Mat3::from_quat(pose.rotation).transpose();
        let exact_back = back.as_dmat3();
        Self {
            core: self.core,
            turn: back * self.turn,
            exact_turn: exact_back * self.exact_turn,
            shift: exact_back * (self.shift - pose.position.as_dvec3()),
        }
    }

    /// The corner farthest along `axis`.
    pub(crate) fn support(&self, axis: DVec3) -> DVec3 {
        let own = match self.core {
            Core::Frustum(_) => self.exact_turn.transpose() * axis,
            _ => (self.turn.transpose() * axis.as_vec3()).as_dvec3(),
        };
        self.exact_turn * self.core.exact_support(own) + self.shift
    }

    pub(crate) fn middle(&self) -> DVec3 {
        self.exact_turn * self.core.middle().as_dvec3() + self.shift
    }

    /// A point inside, unlike [`middle`](Self::middle), which may be a corner, and the middle of the box around it, which may be outside.
    pub(crate) fn inside(&self) -> Vec3 {
        let inside = match self.core {
            Core::Hull(points) => mean(points).as_dvec3(),
            _ => self.core.middle().as_dvec3(),
        };
        (self.exact_turn * inside + self.shift).as_vec3()
    }
}

/// A core that is smaller about a point inside.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShrunkCore<'s> {
    core: PlacedCore<'s>,
    inside: DVec3,
    factor: f64,
}

impl<'s> ShrunkCore<'s> {
    /// `factor`: how many times as large it is.
    pub(crate) fn new(core: PlacedCore<'s>, factor: f64) -> Self {
        Self {
            core,
            inside: core.inside().as_dvec3(),
            factor,
        }
    }

    /// The point that stays where it is.
    pub(crate) fn inside(&self) -> DVec3 {
        self.inside
    }
}

impl Support for ShrunkCore<'_> {
    fn support(&self, axis: DVec3) -> DVec3 {
        self.inside + self.factor * (self.core.support(axis) - self.inside)
    }
}
