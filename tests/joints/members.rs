//! Random members of what joints are used for: any size, mass, step rate, gravity, effort, frame and order of the two bodies, on what
//! does not move, on what moves steadily and on what is heavy.

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use crate::scene::{fixed_substeps, heavy};
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// How many times what is joined to it a heavy body weighs.
const HEAVY: f32 = 1e3;

/// What the other end of a joint is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Carrier {
    World,
    Static,
    /// Moves steadily, m/s.
    Moving(Vec3),
    /// A heavy body that a joint holds.
    Held,
    /// A heavy body that stands on the ground.
    Standing,
}

/// How a scene is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Member {
    /// Hz
    pub(crate) rate: f32,
    /// Of all lengths, m.
    pub(crate) size: f32,
    /// kg
    pub(crate) mass: f32,
    /// m/s2
    pub(crate) gravity: Vec3,
    pub(crate) effort: Effort,
    pub(crate) carrier: Carrier,
    /// Whether the carrier is the second body of joints.
    pub(crate) is_swapped: bool,
}

/// How much a step may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Effort {
    Default,
    Fast,
    Substeps(u32),
}

/// A power of a base with a random exponent, between two numbers.
#[expect(
    clippy::disallowed_methods,
    reason = "a test may differ in the last bit"
)]
pub(crate) fn between(dice: &mut Dice, least: f32, most: f32) -> f32 {
    least * (most / least).powf(dice.unit())
}

/// A direction across another one.
pub(crate) fn across(dice: &mut Dice, axis: Vec3) -> Vec3 {
    loop {
        let v = dice.direction();
        let v = v - v.dot(axis) * axis;
        if v.length() > 0.3 {
            return v.normalize();
        }
    }
}

impl Member {
    pub(crate) fn draw(dice: &mut Dice) -> Self {
        let size = between(dice, 0.01, 10.0);
        let strength = between(dice, 1.0, 30.0);
        let efforts = [
            Effort::Default,
            Effort::Default,
            Effort::Fast,
            Effort::Substeps(1 + dice.below(16) as u32),
        ];
        let speed = (strength * size).sqrt();
        let carriers = [
            Carrier::World,
            Carrier::Static,
            Carrier::Moving(dice.vector(-speed, speed)),
            Carrier::Held,
            Carrier::Standing,
        ];
        Self {
            rate: [30.0, 60.0, 120.0, 240.0, dice.in_range(30.0, 240.0)][dice.below(5)],
            size,
            mass: between(dice, 1e-3, 1e4),
            gravity: strength * dice.direction(),
            effort: efforts[dice.below(4)],
            carrier: carriers[dice.below(5)],
            is_swapped: dice.below(2) == 0,
        }
    }

    /// Length of a step, s.
    pub(crate) fn step(&self) -> f32 {
        self.rate.recip()
    }

    /// Length of the longest sub-step that what is jointed takes, s.
    pub(crate) fn substep(&self) -> f32 {
        let least = match self.effort {
            Effort::Default => 8,
            Effort::Fast => 4,
            Effort::Substeps(count) => count,
        };
        self.step() / least as f32
    }

    /// Of the body that joints hold, N.
    pub(crate) fn weight(&self) -> Vec3 {
        self.mass * self.gravity
    }

    pub(crate) fn up(&self) -> Vec3 {
        -self.gravity.normalize()
    }

    pub(crate) fn carrier_velocity(&self) -> Vec3 {
        match self.carrier {
            Carrier::Moving(velocity) => velocity,
            _ => Vec3::ZERO,
        }
    }
}

/// A scene with a carrier.
pub(crate) struct Rig {
    pub(crate) simulation: Simulation,
    pub(crate) member: Member,
    pub(crate) carrier: Option<u32>,
    /// Where the carrier was at first.
    start: Pose,
    /// Of all bodies, by slot.
    pub(crate) descs: Vec<BodyDesc>,
}

impl Rig {
    pub(crate) fn new(member: Member, dice: &mut Dice) -> Self {
        let mut simulation = awake();
        simulation.gravity.0 = member.gravity;
        let config = match member.effort {
            Effort::Default => SolverConfig::default(),
            Effort::Fast => SolverConfig::fast(),
            Effort::Substeps(count) => fixed_substeps(count),
        };
        simulation.config = SolverConfig {
            sleep: SleepConfig::off(),
            ..config
        };
        let mut rig = Self {
            simulation,
            member,
            carrier: None,
            start: Pose::IDENTITY,
            descs: Vec::new(),
        };
        let kind = match member.carrier {
            Carrier::World => return rig,
            Carrier::Static => RigidBody::Static,
            Carrier::Moving(_) => RigidBody::Kinematic,
            Carrier::Held | Carrier::Standing => RigidBody::Dynamic,
        };
        let is_standing = member.carrier == Carrier::Standing;
        // What stands does so on a face.
        let turn = if is_standing {
            Quat::from_rotation_arc(Vec3::Y, member.up()).normalize()
        } else {
            dice.rotation()
        };
        let mut body = heavy(
            4.0 * member.size * Vec3::ONE,
            member.size * dice.vector(-1.0, 1.0),
            HEAVY * member.mass,
        );
        body.pose.rotation = turn;
        body.kind = kind;
        body.linear_velocity = member.carrier_velocity();
        body.layers = if is_standing {
            CollisionLayers::default()
        } else {
            CollisionLayers::NONE
        };
        rig.start = body.pose;
        let carrier = rig.insert(body);
        rig.carrier = Some(carrier);
        match member.carrier {
            Carrier::Held => {
                let poses = [Pose::IDENTITY, rig.start];
                let at = Pose::new(rig.start.position, dice.rotation());
                let hold = Joint::fixed().with_frame(at, poses);
                rig.simulation.join(None, carrier, hold).expect("usable");
            }
            Carrier::Standing => {
                let normal = member.up();
                let mut floor = BodyDesc::floor(HalfSpaceShape { normal });
                floor.pose.position = rig.start.position - 2.0 * member.size * normal;
                rig.insert(floor);
            }
            _ => {}
        }
        rig
    }

    fn insert(&mut self, body: BodyDesc) -> u32 {
        self.descs.push(body.clone());
        self.simulation.bodies.insert(body).expect("usable")
    }

    /// A box that touches nothing, moves as the carrier does and has its center of mass where its pose is.
    pub(crate) fn add(&mut self, size: Vec3, pose: Pose, mass: f32) -> u32 {
        let mut body = heavy(size, pose.position, mass);
        body.pose.rotation = pose.rotation;
        body.linear_velocity = self.member.carrier_velocity();
        body.layers = CollisionLayers::NONE;
        self.insert(body)
    }

    /// Joins a body to another one, or to the carrier, with the joint's frames at these places of the world: on the other one, and on it.
    pub(crate) fn join(
        &mut self,
        a: Option<u32>,
        b: u32,
        joint: Joint,
        [on_a, on_b]: [Pose; 2],
    ) -> JointId {
        let a = a.or(self.carrier);
        let bodies = &self.simulation.bodies;
        let pose_a = a.map_or(Pose::IDENTITY, |slot| bodies.pose(slot));
        let pose_b = bodies.pose(b);
        let frames = [(on_a, pose_a), (on_b, pose_b)].map(|(at, body)| {
            let both = Joint::fixed().with_frame(at, [body, body]);
            both.frame_a
        });
        let (first, second, joint, frames) = match a {
            Some(a) if self.member.is_swapped => {
                (Some(b), a, mirrored(joint), [frames[1], frames[0]])
            }
            _ => (a, b, joint, frames),
        };
        let joint = Joint {
            frame_a: frames[0],
            frame_b: frames[1],
            ..joint
        };
        self.simulation.join(first, second, joint).expect("usable")
    }

    pub(crate) fn is_swapped(&self) -> bool {
        self.member.is_swapped && self.carrier.is_some()
    }

    /// What a joint bears, as if the carrier were its first body.
    pub(crate) fn load(&self, id: JointId) -> JointLoad {
        let load = *self.simulation.joints.load(id).expect("there");
        if self.is_swapped() {
            return JointLoad {
                force: -load.force,
                torque: -load.torque,
                translation: -load.translation,
                angle: -load.angle,
                ..load
            };
        }
        load
    }

    /// Changes a joint.
    pub(crate) fn change(&mut self, id: JointId, change: impl FnOnce(&mut Joint)) {
        let Simulation { joints, bodies, .. } = &mut self.simulation;
        let mut joint = *joints.get(id).expect("there");
        change(&mut joint);
        joints.set(bodies, id, joint).expect("usable");
    }

    pub(crate) fn step(&mut self) {
        self.simulation.step(self.member.step());
    }

    /// How fast a body is against the carrier, m/s and rad/s.
    pub(crate) fn velocity(&self, slot: u32) -> (Vec3, Vec3) {
        let (v, omega) = self.simulation.bodies.velocity(slot);
        (v - self.member.carrier_velocity(), omega)
    }

    /// Where a body's center of mass is, against where the carrier is, m.
    pub(crate) fn place(&self, slot: u32) -> Vec3 {
        let at = self.simulation.bodies.center_of_mass(slot);
        match self.carrier {
            Some(carrier) => {
                at - self.simulation.bodies.center_of_mass(carrier) + self.start.position
            }
            None => at,
        }
    }
}

/// The same joint seen from its other body: what B does against A, A does against B in the opposite direction.
pub(crate) fn mirrored(joint: Joint) -> Joint {
    let axis = |axis: JointAxis| JointAxis {
        range: match axis.range {
            AxisRange::Limited { min, max } => AxisRange::Limited {
                min: -max,
                max: -min,
            },
            other => other,
        },
        drive: axis.drive.map(|drive| JointDrive {
            target: match drive.target {
                DriveTarget::Velocity(velocity) => DriveTarget::Velocity(-velocity),
                DriveTarget::Position { position, spring } => DriveTarget::Position {
                    position: -position,
                    spring,
                },
            },
            ..drive
        }),
        ..axis
    };
    Joint {
        linear: joint.linear.map(axis),
        angular: joint.angular.map(axis),
        ..joint
    }
}

/// Moment of inertia of a box about an axis through its center, kg m2.
pub(crate) fn inertia(size: Vec3, mass: f32, rotation: Quat, axis: Vec3) -> f32 {
    let squares = size * size;
    let moments = mass / 12.0 * (Vec3::splat(squares.element_sum()) - squares);
    let axis = rotation.inverse() * axis;
    (moments * axis * axis).element_sum()
}
