//! What a walk through the bodies reads of each, copied from where they are kept: two lines of the cache that lie together instead of
//! eight that do not.

use crate::bodies::body::Shape;
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::geometry::round_core::RoundCore;
use crate::math::Aabb;
use crate::math::Pose;
use crate::query::ball::Ball;
use crate::query::cuboid::box_of;
use glam::{Quat, Vec3};

/// Slot of a body that is gone.
const NOWHERE: u32 = u32::MAX;

/// A shape that a few numbers tell, own frame: what is asked of it need not look for it elsewhere.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Plain {
    /// A ball around the origin with this radius, m.
    Ball(f32),
    Box(Aabb),
    /// None of these.
    Other,
}

impl Plain {
    fn of(shape: &Shape) -> Self {
        let Some(mesh) = shape.convex() else {
            return Self::Other;
        };
        match mesh.round() {
            Some(round) if matches!(round.core, RoundCore::Point) => Self::Ball(round.radius),
            Some(_) => Self::Other,
            None => box_of(mesh.hull()).map_or(Self::Other, Self::Box),
        }
    }
}

/// A body where it is.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Place {
    /// `world_from_body`.
    pub(crate) rotation: Quat,
    pub(crate) position: Vec3,
    pub(crate) slot: u32,
    /// Of mass, world frame, m.
    center: Vec3,
    /// Of the ball around it, m; 0 if there is none.
    radius: f32,
    pub(crate) id: BodyId,
    pub(crate) plain: Plain,
    pub(crate) shape: Shape,
}

impl Place {
    pub(crate) fn of(bodies: &Bodies, slot: u32) -> Self {
        let Pose { position, rotation } = bodies.pose(slot);
        let shape = bodies.info(slot).shape.clone();
        Self {
            rotation,
            position,
            slot,
            center: bodies.center_of_mass(slot),
            radius: bodies.radius(slot),
            id: bodies.id(slot),
            plain: Plain::of(&shape),
            shape,
        }
    }

    /// The body has moved.
    pub(crate) fn follow(&mut self, bodies: &Bodies) {
        Pose {
            position: self.position,
            rotation: self.rotation,
        } = bodies.pose(self.slot);
        self.center = bodies.center_of_mass(self.slot);
    }

    /// The body will be at a pose, with its center of mass there.
    pub(crate) fn go_to(&mut self, pose: Pose, center: Vec3) {
        (self.position, self.rotation) = (pose.position, pose.rotation);
        self.center = center;
    }

    /// The body is gone.
    pub(crate) fn clear(&mut self) {
        self.slot = NOWHERE;
    }

    /// Whether the body was gone when it was last looked at.
    pub(crate) fn is_empty(&self) -> bool {
        self.slot == NOWHERE
    }

    /// Whether the body is still there.
    pub(crate) fn is_taken(&self, bodies: &Bodies) -> bool {
        bodies.is_active(self.slot) && bodies.id(self.slot) == self.id
    }

    /// The ball around the body; of none that has no end, or is new, anything is known.
    #[inline]
    pub(crate) fn ball(&self) -> Option<Ball> {
        (self.radius > 0.0).then_some(Ball {
            center: self.center,
            radius: self.radius,
        })
    }

    pub(crate) fn pose(&self) -> Pose {
        Pose {
            position: self.position,
            rotation: self.rotation,
        }
    }
}
