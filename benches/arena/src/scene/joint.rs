//! What a scene says of joints.

use super::Scene;
use glam::{Quat, Vec3};

/// A joint of two bodies. Bodies that one joins do not collide with each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Joint {
    /// Indices into [`Scene::bodies`].
    pub(crate) bodies: [usize; 2],
    /// The joint in each of them; at first they are the same.
    pub(crate) frames: [Frame; 2],
    pub(crate) kind: JointKind,
}

/// Where a joint is on a body, in the body's frame. Its x axis is what a hinge turns about, a slider slides along and a cone-twist
/// joint twists about.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(crate) pos: Vec3,
    pub(crate) rot: Quat,
}

/// What the second body may do against the first.
#[derive(Clone, Copy, Debug)]
pub(crate) enum JointKind {
    Fixed,
    Ball,
    Hinge {
        /// Least and largest angle, rad.
        range: Option<[f32; 2]>,
        motor: Option<Motor>,
    },
    Slider {
        spring: Option<Spring>,
    },
    /// The axis stays within a half-angle, and turns by at most `twist` to either side, rad.
    ConeTwist {
        swing: f32,
        twist: f32,
    },
}

impl JointKind {
    pub(crate) const HINGE: Self = Self::Hinge {
        range: None,
        motor: None,
    };
}

/// Keeps up an angular velocity with a bounded torque.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motor {
    /// rad/s.
    pub(crate) speed: f32,
    /// N m.
    pub(crate) max_torque: f32,
}

/// Pulls to where the frames meet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spring {
    /// Without damping, Hz.
    pub(crate) hertz: f32,
    pub(crate) damping_ratio: f32,
    /// That it swings, kg, for engines that want a stiffness.
    #[cfg_attr(
        not(feature = "rapier"),
        allow(dead_code, reason = "the others ask for a frequency")
    )]
    pub(crate) mass: f32,
}

impl Scene {
    /// Joins two bodies at a point of the world, with the axis in that direction.
    pub(super) fn join(&mut self, bodies: [usize; 2], at: Vec3, axis: Vec3, kind: JointKind) {
        let world = Quat::from_rotation_arc(Vec3::X, axis);
        let frames = bodies.map(|body| {
            let body = &self.bodies[body];
            let body_from_world = body.rot.inverse();
            Frame {
                pos: body_from_world * (at - body.pos),
                rot: (body_from_world * world).normalize(),
            }
        });
        self.joints.push(Joint {
            bodies,
            frames,
            kind,
        });
    }
}
