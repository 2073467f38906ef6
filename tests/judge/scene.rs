//! A scene as plain numbers: who is in it, for how long, and which laws it has to keep.

use super::laws::Law;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// In which of a scene's two versions a body is. Some laws compare the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// In both.
    Both,
    /// Only in the scene itself: a floor in many pieces, something that is passed by.
    Here,
    /// Only in what the scene is compared with: the same floor in one piece.
    There,
}

impl Role {
    /// Name in files.
    pub(crate) const NAMES: [(Self, &str); 3] = [
        (Self::Both, "both"),
        (Self::Here, "here"),
        (Self::There, "there"),
    ];
}

/// A shape as numbers, m, in the body's frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Form {
    /// A box by its edge lengths.
    Box(Vec3),
    /// The hull of points.
    Hull(Vec<Vec3>),
    /// What is below the plane through the origin with this normal.
    HalfSpace(Vec3),
}

impl Form {
    /// Largest distance of a corner from the frame's origin, m; zero for a half-space.
    pub(crate) fn radius(&self) -> f32 {
        match self {
            Self::Box(size) => 0.5 * size.length(),
            Self::Hull(points) => points.iter().fold(0.0, |r, p| r.max(p.length())),
            Self::HalfSpace(_) => 0.0,
        }
    }

    /// The shape of a simulation; `None` if the numbers make none.
    pub(crate) fn shape(&self) -> Option<Shape> {
        let mesh = match self {
            Self::Box(s) => ConvexMesh::cuboid(s.x, s.y, s.z).ok()?,
            Self::Hull(points) => ConvexMesh::from_points(points).ok()?,
            Self::HalfSpace(normal) => {
                return Some(Shape::HalfSpace(HalfSpaceShape::new(*normal).ok()?));
            }
        };
        Some(Shape::Convex(mesh))
    }

    /// The same shape in another size.
    pub(crate) fn scaled(&mut self, factor: f32) {
        match self {
            Self::Box(size) => *size *= factor,
            Self::Hull(points) => points.iter_mut().for_each(|p| *p *= factor),
            Self::HalfSpace(_) => {}
        }
    }
}

/// A body of a scene.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Actor {
    pub(crate) kind: RigidBody,
    pub(crate) role: Role,
    pub(crate) form: Form,
    pub(crate) pose: Pose,
    /// Velocity of the center of mass, m/s.
    pub(crate) linear: Vec3,
    /// rad/s, world axes.
    pub(crate) angular: Vec3,
    /// kg/m3.
    pub(crate) density: f32,
    pub(crate) friction: f32,
    pub(crate) restitution: f32,
}

impl Actor {
    /// A dynamic body at rest, of the density of water.
    pub(crate) fn new(form: Form, position: Vec3) -> Self {
        Self {
            kind: RigidBody::Dynamic,
            role: Role::Both,
            form,
            pose: Pose::new(position, Quat::IDENTITY),
            linear: Vec3::ZERO,
            angular: Vec3::ZERO,
            density: 1000.0,
            friction: 0.5,
            restitution: 0.0,
        }
    }

    /// A static body.
    pub(crate) fn fixed(form: Form, position: Vec3) -> Self {
        Self {
            kind: RigidBody::Static,
            ..Self::new(form, position)
        }
    }

    pub(crate) fn is_dynamic(&self) -> bool {
        self.kind == RigidBody::Dynamic
    }

    /// What a simulation makes the body from; `None` if its numbers make no shape.
    pub(crate) fn desc(&self) -> Option<BodyDesc> {
        let mut desc = BodyDesc::new(self.kind, self.form.shape()?);
        desc.pose = self.pose;
        (desc.linear_velocity, desc.angular_velocity) = (self.linear, self.angular);
        desc.density = self.density;
        desc.friction = Friction::new(self.friction);
        desc.restitution = Restitution::new(self.restitution);
        Some(desc)
    }
}

/// A scene and the laws that it has to keep.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scene {
    pub(crate) family: String,
    pub(crate) seed: u64,
    pub(crate) laws: Vec<Law>,
    /// m/s2.
    pub(crate) gravity: Vec3,
    /// Steps per second.
    pub(crate) rate: f32,
    /// With how many sub-steps, no more and no less, each of one sweep before and one after the motion; 0: default settings.
    pub(crate) soft: u32,
    /// How many steps the laws are given.
    pub(crate) steps: u32,
    pub(crate) actors: Vec<Actor>,
}

impl Scene {
    pub(crate) fn has(&self, law: Law) -> bool {
        self.laws.contains(&law)
    }

    /// Length of a step, s.
    pub(crate) fn step_length(&self) -> f32 {
        self.rate.recip()
    }

    /// The version of the scene that holds the bodies of both and those of `role`.
    pub(crate) fn version(&self, role: Role) -> Self {
        let mut version = self.clone();
        version
            .actors
            .retain(|actor| actor.role == Role::Both || actor.role == role);
        version
    }
}
