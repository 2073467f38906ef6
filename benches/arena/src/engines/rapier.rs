//! Rapier 0.36. Knob: `num_solver_iterations`, which in this version are sub-steps.

use crate::engine::{Engine, Entry, Settings, State};
use crate::scene::{self, JointKind, Scene};
use rapier3d::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::Arc;

struct Rapier {
    world: PhysicsWorld,
    handles: Vec<RigidBodyHandle>,
}

pub(crate) fn entries() -> [Entry; 3] {
    let entry =
        |name, build| Entry::numbered(name, "solver_iterations", 4, &[1, 2, 4, 8, 16], build);
    [
        entry("rapier", |scene, settings| {
            build(scene, settings, FrictionModel::Simplified, Joints::Impulses)
        }),
        // Joints by reduced coordinates.
        entry("rapier-multibody", |scene, settings| {
            let joints = Joints::Coordinates;
            build(scene, settings, FrictionModel::Simplified, joints)
        })
        .for_joints(),
        entry("rapier-coulomb", |scene, settings| {
            build(scene, settings, FrictionModel::Coulomb, Joints::Impulses)
        }),
    ]
}

/// Rapier has two solvers for joints.
#[derive(Clone, Copy)]
enum Joints {
    Impulses,
    Coordinates,
}

thread_local! {
    /// A pool of the thread that asks for it and no other.
    static CALLING_THREAD: Arc<ThreadPool> = pool_of(ThreadPoolBuilder::new().num_threads(1).use_current_thread());
}

/// A pool of so many threads. One thread is the calling one: else it waits for the one of the pool, which spins while it has nothing to do, and
/// in small scenes that takes several times as much CPU time as the step.
fn thread_pool(threads: usize) -> Arc<ThreadPool> {
    match threads {
        1 => CALLING_THREAD.with(Arc::clone),
        _ => pool_of(ThreadPoolBuilder::new().num_threads(threads)),
    }
}

fn pool_of(builder: ThreadPoolBuilder) -> Arc<ThreadPool> {
    Arc::new(builder.build().expect("thread pool"))
}

fn build(
    scene: &Scene,
    settings: &Settings,
    friction_model: FrictionModel,
    joints: Joints,
) -> Box<dyn Engine> {
    let mut world = PhysicsWorld::new();
    world.gravity = scene.gravity;
    world.integration_parameters.dt = scene.dt;
    world.integration_parameters.num_solver_iterations = settings.value as usize;
    world.integration_parameters.friction_model = friction_model;
    world.set_thread_pool(Some(thread_pool(settings.threads)));
    let shapes: Vec<_> = scene
        .shapes
        .iter()
        .map(|s| match s.half_extents {
            Some(h) => SharedShape::cuboid(h.x, h.y, h.z),
            None => SharedShape::convex_hull(&s.points).expect("hull"),
        })
        .collect();
    let mut handles = Vec::new();
    for b in &scene.bodies {
        let body = if b.fixed {
            RigidBodyBuilder::fixed()
        } else {
            RigidBodyBuilder::dynamic()
        }
        .pose(Pose::from_parts(b.pos, b.rot))
        .linvel(b.linvel)
        .angvel(b.angvel)
        .ccd_enabled(b.bullet)
        .can_sleep(settings.sleeping);
        let handle = world.insert_body(body);
        let collider = ColliderBuilder::new(shapes[b.shape].clone())
            .density(b.density)
            .friction(scene.friction)
            .restitution(scene.restitution);
        world.insert_collider(collider, Some(handle));
        handles.push(handle);
    }
    for joint in &scene.joints {
        let [a, b] = joint.bodies.map(|body| handles[body]);
        let made = joint_of(joint);
        match joints {
            Joints::Impulses => {
                world.insert_impulse_joint(a, b, made);
            }
            Joints::Coordinates => {
                // What closes a loop, also one through what is fixed, goes on by impulses, as Rapier has it.
                let is_open = !scene.bodies[joint.bodies[1]].fixed;
                if !is_open || world.insert_multibody_joint(a, b, made).is_none() {
                    world.insert_impulse_joint(a, b, made);
                }
            }
        }
    }
    Box::new(Rapier { world, handles })
}

/// A joint of a scene. Its shoulders have a range about each of three axes instead of a cone.
fn joint_of(joint: &scene::Joint) -> GenericJoint {
    let mut builder = match joint.kind {
        JointKind::Fixed => GenericJointBuilder::new(JointAxesMask::LOCKED_FIXED_AXES),
        JointKind::Ball | JointKind::ConeTwist { .. } => {
            GenericJointBuilder::new(JointAxesMask::LOCKED_SPHERICAL_AXES)
        }
        JointKind::Hinge { .. } => GenericJointBuilder::new(JointAxesMask::LOCKED_REVOLUTE_AXES),
        JointKind::Slider { .. } => GenericJointBuilder::new(JointAxesMask::LOCKED_PRISMATIC_AXES),
    };
    match joint.kind {
        JointKind::Fixed | JointKind::Ball => {}
        JointKind::Hinge { range, motor } => {
            if let Some(range) = range {
                builder = builder.limits(JointAxis::AngX, range);
            }
            if let Some(motor) = motor {
                // As good as rigid up to the largest torque.
                builder = builder
                    .motor_velocity(JointAxis::AngX, motor.speed, 1e6)
                    .motor_max_force(JointAxis::AngX, motor.max_torque);
            }
        }
        JointKind::Slider { spring } => {
            if let Some(spring) = spring {
                let omega = std::f32::consts::TAU * spring.hertz;
                let stiffness = spring.mass * omega * omega;
                let damping = 2.0 * spring.damping_ratio * spring.mass * omega;
                builder = builder
                    .motor_model(JointAxis::LinX, MotorModel::ForceBased)
                    .motor_position(JointAxis::LinX, 0.0, stiffness, damping);
            }
        }
        JointKind::ConeTwist { swing, twist } => {
            builder = builder
                .limits(JointAxis::AngX, [-twist, twist])
                .limits(JointAxis::AngY, [-swing, swing])
                .limits(JointAxis::AngZ, [-swing, swing]);
        }
    }
    let [on_a, on_b] = joint
        .frames
        .map(|frame| Pose::from_parts(frame.pos, frame.rot));
    builder
        .local_frame1(on_a)
        .local_frame2(on_b)
        .contacts_enabled(false)
        .build()
}

impl Engine for Rapier {
    fn step(&mut self) {
        self.world.step();
    }

    fn read(&self, out: &mut Vec<State>) {
        out.extend(self.handles.iter().map(|&h| {
            let b = &self.world.bodies[h];
            State {
                pos: b.translation(),
                rot: *b.rotation(),
                linvel: b.linvel(),
                angvel: b.angvel(),
            }
        }));
    }

    fn num_awake(&self) -> Option<usize> {
        Some(
            self.handles
                .iter()
                .filter(|&&h| {
                    self.world.bodies[h].is_dynamic() && !self.world.bodies[h].is_sleeping()
                })
                .count(),
        )
    }
}
