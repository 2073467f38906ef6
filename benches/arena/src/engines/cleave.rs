//! bevy_cleave without an app: [`Simulation::step`].
//!
//! There is no switch for continuous collision, which is always on.

use super::cleave_settings::{DEFAULT, config, settings, with_sleep};
use crate::engine::{Engine, Entry, Settings, State};
use crate::scene::{self, Body, JointKind, Scene, Shape};
use bevy_cleave::prelude::*;
use bevy_tasks::{ComputeTaskPool, TaskPoolBuilder};

struct Cleave {
    simulation: Simulation,
    slots: Vec<u32>,
    dt: f32,
}

pub(crate) fn entry() -> Entry {
    Entry {
        name: "cleave",
        knob: "configuration",
        settings: settings(),
        default: DEFAULT.into(),
        build,
        is_for_joints: false,
    }
}

/// Threads that the compute pool gets so that `threads` work in all: the one that calls `TaskPool::scope` takes part, as
/// the scope runs tasks of the pool while it waits.
pub(super) fn pool_threads(threads: usize) -> usize {
    threads - 1
}

fn build(scene: &Scene, settings: &Settings) -> Box<dyn Engine> {
    let threads = pool_threads(settings.threads);
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(threads).build());
    let mut simulation = Simulation {
        gravity: Gravity(scene.gravity),
        config: with_sleep(config(settings.value), settings.sleeping),
        ..Simulation::default()
    };
    let bodies = descriptions(scene).map(|body| simulation.bodies.insert(body));
    let slots: Vec<u32> = bodies.collect::<Result<_, _>>().expect("usable bodies");
    for joint in &scene.joints {
        let [a, b] = joint.bodies.map(|body| slots[body]);
        let made = simulation.join(Some(a), b, joint_of(joint));
        made.expect("a usable joint");
    }
    Box::new(Cleave {
        simulation,
        slots,
        dt: scene.dt,
    })
}

/// A joint of a scene.
pub(super) fn joint_of(joint: &scene::Joint) -> Joint {
    let kind = match joint.kind {
        JointKind::Fixed => Joint::fixed(),
        JointKind::Ball => Joint::ball(),
        JointKind::Hinge { range, motor } => {
            let mut hinge = Joint::hinge();
            if let Some([least, most]) = range {
                hinge = hinge.with_angular_limits(least, most);
            }
            hinge.angular[0].drive =
                motor.map(|motor| JointDrive::velocity(motor.speed, motor.max_torque));
            hinge
        }
        JointKind::Slider { spring } => {
            let mut slider = Joint::slider();
            slider.linear[0].drive = spring.map(|spring| {
                let scene::Spring {
                    hertz,
                    damping_ratio,
                    ..
                } = spring;
                let spring = JointSpring::Frequency {
                    hertz,
                    damping_ratio,
                };
                JointDrive::spring(0.0, spring)
            });
            slider
        }
        JointKind::ConeTwist { swing, twist } => Joint::cone_twist(swing, twist),
    };
    let [frame_a, frame_b] = joint.frames.map(|frame| Pose::new(frame.pos, frame.rot));
    Joint {
        frame_a,
        frame_b,
        ..kind
    }
}

/// The bodies of a scene, in its order.
pub(super) fn descriptions(scene: &Scene) -> impl Iterator<Item = BodyDesc> {
    let shapes: Vec<ConvexMesh> = scene.shapes.iter().map(convex_mesh).collect();
    let friction = Friction::new(scene.friction);
    let restitution = Restitution::new(scene.restitution);
    scene.bodies.iter().map(move |body: &Body| BodyDesc {
        kind: if body.fixed {
            RigidBody::Static
        } else {
            RigidBody::Dynamic
        },
        linear_velocity: body.linvel,
        angular_velocity: body.angvel,
        density: body.density,
        // The default rule takes the mean of two equal values, which is that value.
        friction,
        restitution,
        pose: Pose {
            position: body.pos,
            rotation: body.rot,
        },
        ..BodyDesc::dynamic(shapes[body.shape].clone(), body.pos)
    })
}

fn convex_mesh(shape: &Shape) -> ConvexMesh {
    match shape.half_extents {
        Some(h) => ConvexMesh::cuboid(2.0 * h.x, 2.0 * h.y, 2.0 * h.z),
        None => ConvexMesh::from_points(&shape.points),
    }
    .expect("a hull")
}

impl Engine for Cleave {
    fn step(&mut self) {
        self.simulation.step(self.dt);
    }

    fn read(&self, out: &mut Vec<State>) {
        let bodies = &self.simulation.bodies;
        out.extend(self.slots.iter().map(|&slot| {
            let Pose { position, rotation } = bodies.pose(slot);
            let (linvel, angvel) = bodies.velocity(slot);
            State {
                pos: position,
                rot: rotation,
                linvel,
                angvel,
            }
        }));
    }

    fn num_awake(&self) -> Option<usize> {
        Some(self.simulation.report.awake)
    }

    fn num_contacts(&self) -> Option<usize> {
        Some(self.simulation.report.contacts)
    }
}
