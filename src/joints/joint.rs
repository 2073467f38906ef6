//! What a joint is: two frames, and what each of six axes may do.

use crate::joints::axis::{AxisRange, DriveTarget, JointAxis, JointDrive, JointSpring};
use crate::joints::error::JointError;
use crate::math::{Pose, rotate};
use bevy_ecs::component::Component;
use glam::{Mat3, Quat, Vec3};

/// Joins two bodies, or a body and the world: a frame in each, and for each axis of A's what B may do along and about it.
///
/// The kinds ([`fixed`](Self::fixed), [`ball`](Self::ball), [`hinge`](Self::hinge) and so on) set the axes; what they leave
/// open can be set afterwards. The first axis (x) is that of a hinge and a slider and the twist of a ball; y and z are the swings.
#[derive(Clone, Copy, Debug, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Joint {
    /// `a_from_joint`: where the joint is on A, in the frame of A's shape; of the world if there is no A.
    pub frame_a: Pose,
    /// `b_from_joint`: the same on B.
    pub frame_b: Pose,
    /// What B's anchor may do along the axes of A's frame, m.
    pub linear: [JointAxis; 3],
    /// What B may do about them, rad: twist, and the two swings.
    pub angular: [JointAxis; 3],
    /// What the distance of the two anchors may do, m. Free where there is none.
    pub distance: JointAxis,
    /// Largest force that it bears, N.
    pub break_force: f32,
    /// Largest torque that it bears, N m.
    pub break_torque: f32,
    /// Whether the two bodies may touch each other.
    pub contacts: bool,
}

impl Joint {
    const RIGID: Self = Self {
        frame_a: Pose::IDENTITY,
        frame_b: Pose::IDENTITY,
        linear: [JointAxis::LOCKED; 3],
        angular: [JointAxis::LOCKED; 3],
        distance: JointAxis::FREE,
        break_force: f32::INFINITY,
        break_torque: f32::INFINITY,
        contacts: false,
    };

    /// Nothing moves.
    pub const fn fixed() -> Self {
        Self::RIGID
    }

    /// Turns freely about the anchor.
    pub const fn ball() -> Self {
        Self {
            angular: [JointAxis::FREE; 3],
            ..Self::RIGID
        }
    }

    /// Turns about x: doors, wheels, elbows.
    pub const fn hinge() -> Self {
        Self {
            angular: [JointAxis::FREE, JointAxis::LOCKED, JointAxis::LOCKED],
            ..Self::RIGID
        }
    }

    /// Slides along x.
    pub const fn slider() -> Self {
        Self {
            linear: [JointAxis::FREE, JointAxis::LOCKED, JointAxis::LOCKED],
            ..Self::RIGID
        }
    }

    /// Slides along x and turns about it.
    pub const fn cylindrical() -> Self {
        Self {
            linear: [JointAxis::FREE, JointAxis::LOCKED, JointAxis::LOCKED],
            ..Self::hinge()
        }
    }

    /// A wheel on a suspension: turns about x, and gives way along y by at most `travel` (m) to either side of where the spring holds it.
    /// [`with_anchor_and_up`](Self::with_anchor_and_up) says where both point; a wheel that steers has a spring in `angular[1]`, and that
    /// axis free.
    pub const fn wheel(travel: f32, spring: JointSpring) -> Self {
        let suspension = JointAxis {
            drive: Some(JointDrive {
                target: DriveTarget::Position {
                    position: 0.0,
                    spring,
                },
                max_force: f32::INFINITY,
            }),
            ..JointAxis::limited(-travel, travel)
        };
        Self {
            linear: [JointAxis::LOCKED, suspension, JointAxis::LOCKED],
            ..Self::hinge()
        }
    }

    /// A shoulder: x of B stays within the half-angle `swing` (rad) of x of A, and B turns about it by at most `twist` (rad) to
    /// either side.
    pub const fn cone_twist(swing: f32, twist: f32) -> Self {
        let swing = JointAxis::limited(-swing, swing);
        Self {
            angular: [JointAxis::limited(-twist, twist), swing, swing],
            ..Self::RIGID
        }
    }

    /// Anything.
    pub const fn six_axis(linear: [JointAxis; 3], angular: [JointAxis; 3]) -> Self {
        Self {
            linear,
            angular,
            ..Self::RIGID
        }
    }

    /// Keeps the anchors at a distance, m.
    pub const fn rod(length: f32) -> Self {
        Self::between_anchors(JointAxis::limited(length, length))
    }

    /// Keeps the anchors no farther apart than `length`, m.
    pub const fn rope(length: f32) -> Self {
        Self::between_anchors(JointAxis::limited(0.0, length))
    }

    /// Pulls or pushes the anchors to a distance, m.
    pub const fn spring(length: f32, spring: JointSpring) -> Self {
        Self::between_anchors(JointAxis {
            drive: Some(JointDrive {
                target: DriveTarget::Position {
                    position: length,
                    spring,
                },
                max_force: f32::INFINITY,
            }),
            ..JointAxis::FREE
        })
    }

    const fn between_anchors(distance: JointAxis) -> Self {
        Self {
            linear: [JointAxis::FREE; 3],
            angular: [JointAxis::FREE; 3],
            distance,
            contacts: true,
            ..Self::RIGID
        }
    }

    /// With anchors at these points of A and B, m.
    pub fn with_anchors(mut self, on_a: Vec3, on_b: Vec3) -> Self {
        self.frame_a.position = on_a;
        self.frame_b.position = on_b;
        self
    }

    /// With its first axis along these directions of A and B, of any length but zero.
    pub fn with_axes(mut self, on_a: Vec3, on_b: Vec3) -> Self {
        self.frame_a.rotation = rotation_to(on_a);
        self.frame_b.rotation = rotation_to(on_b);
        self
    }

    /// With the frames that both bodies have in common if A is at `world_from_a` and B at `world_from_b` and the joint at
    /// `world_from_joint`.
    pub fn with_frame(mut self, world_from_joint: Pose, bodies: [Pose; 2]) -> Self {
        [self.frame_a, self.frame_b] = bodies.map(|body| {
            let body_from_world = body.rotation.inverse();
            Pose {
                position: rotate(body_from_world, world_from_joint.position - body.position),
                rotation: (body_from_world * world_from_joint.rotation).normalize(),
            }
        });
        self
    }

    /// The same about a point and an axis of the world; how far it has turned is counted from there.
    pub fn with_anchor(self, point: Vec3, axis: Vec3, bodies: [Pose; 2]) -> Self {
        self.with_frame(Pose::new(point, rotation_to(axis)), bodies)
    }

    /// The same with the second axis, y, as near to `up` as it can be across the first: for what has a direction besides, as a wheel's
    /// suspension.
    pub fn with_anchor_and_up(self, point: Vec3, axis: Vec3, up: Vec3, bodies: [Pose; 2]) -> Self {
        self.with_frame(Pose::new(point, rotation_of_axes(axis, up)), bodies)
    }

    /// With a drive of the hinge or twist.
    pub fn with_angular_drive(mut self, drive: JointDrive) -> Self {
        self.angular[0].drive = Some(drive);
        self
    }

    /// With a drive of the slider.
    pub fn with_linear_drive(mut self, drive: JointDrive) -> Self {
        self.linear[0].drive = Some(drive);
        self
    }

    /// With friction about every axis that it turns about, N m: what a ragdoll needs to come to rest, as without it nothing but its contacts
    /// brakes it.
    pub fn with_angular_friction(mut self, torque: f32) -> Self {
        brake(&mut self.angular, torque);
        self
    }

    /// With friction along every axis that it slides along, N.
    pub fn with_linear_friction(mut self, force: f32) -> Self {
        brake(&mut self.linear, force);
        self
    }

    /// With a range of the hinge or twist, rad.
    pub fn with_angular_limits(mut self, min: f32, max: f32) -> Self {
        self.angular[0].range = AxisRange::Limited { min, max };
        self
    }

    /// With a range of the slider, m.
    pub fn with_linear_limits(mut self, min: f32, max: f32) -> Self {
        self.linear[0].range = AxisRange::Limited { min, max };
        self
    }

    /// Breaks beyond this force (N) and torque (N m).
    pub fn with_strength(mut self, force: f32, torque: f32) -> Self {
        (self.break_force, self.break_torque) = (force, torque);
        self
    }

    /// With contacts between the two bodies, or without.
    pub fn with_contacts(mut self, contacts: bool) -> Self {
        self.contacts = contacts;
        self
    }

    /// Whether frames, ranges and coefficients are usable.
    ///
    /// # Errors
    /// [`JointError`] with what is not.
    pub fn check(&self) -> Result<(), JointError> {
        for frame in [&self.frame_a, &self.frame_b] {
            if !frame.position.is_finite() {
                return Err(JointError::NotFinite("an anchor"));
            }
            let length = frame.rotation.length();
            if !frame.rotation.is_normalized() {
                return Err(JointError::Axis { length });
            }
        }
        for number in [self.break_force, self.break_torque] {
            if number.is_nan() || number < 0.0 {
                return Err(JointError::Coefficient { number });
            }
        }
        self.axes().try_for_each(|axis| axis.check())
    }

    /// The same joint, in which a distance that is to be none, and has no direction, is three lengths that are.
    pub(crate) fn with_directions(mut self) -> Self {
        if matches!(self.distance.range, AxisRange::Limited { max, .. } if max <= 0.0) {
            self.distance.range = AxisRange::Free;
            for axis in &mut self.linear {
                axis.range = AxisRange::Locked;
            }
        }
        self
    }

    /// Whether each axis is held rigidly or let go: no end of a range is hit, nothing drives or brakes it.
    pub(crate) fn is_free_or_rigid(&self) -> bool {
        self.axes().all(|axis| {
            let may_hit_an_end = match axis.range {
                AxisRange::Limited { min, max } => min < max,
                _ => false,
            };
            !may_hit_an_end && axis.drive.is_none() && axis.friction == 0.0
        })
    }

    /// Where a turn is counted from whose full turns are not known yet, rad: the middle of its range.
    pub(crate) fn expected_twist(&self) -> f32 {
        match self.angular[0].range {
            AxisRange::Limited { min, max } => 0.5 * (min + max),
            AxisRange::Locked | AxisRange::Free => 0.0,
        }
    }

    /// All axes: three linear, three angular, distance.
    pub(crate) fn axes(&self) -> impl Iterator<Item = &JointAxis> {
        let six = self.linear.iter().chain(&self.angular);
        six.chain(std::iter::once(&self.distance))
    }
}

impl Default for Joint {
    fn default() -> Self {
        Self::fixed()
    }
}

/// A rotation that takes x to a direction; no rotation at all, which [`Joint::check`] refuses, if that is zero or not finite.
fn rotation_to(direction: Vec3) -> Quat {
    match direction.try_normalize() {
        Some(unit) => Quat::from_rotation_arc(Vec3::X, unit).normalize(),
        None => Quat::from_xyzw(0.0, 0.0, 0.0, 0.0),
    }
}

/// A rotation that takes x to a direction and y as near as that allows to another one; no rotation at all if they tell none.
fn rotation_of_axes(axis: Vec3, up: Vec3) -> Quat {
    let x = axis.normalize_or_zero();
    let z = x.cross(up.normalize_or_zero());
    match z.try_normalize() {
        Some(z) => Quat::from_mat3(&Mat3::from_cols(x, z.cross(x), z)).normalize(),
        None => Quat::from_xyzw(0.0, 0.0, 0.0, 0.0),
    }
}

/// Gives friction to the axes that move.
fn brake(axes: &mut [JointAxis; 3], friction: f32) {
    let moves = |axis: &&mut JointAxis| axis.range != AxisRange::Locked;
    axes.iter_mut()
        .filter(moves)
        .for_each(|axis| axis.friction = friction);
}
