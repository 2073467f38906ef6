//! Rapier 0.36. Knob: `num_solver_iterations`, which in this version are sub-steps.

use crate::engine::{Engine, Entry, Settings, State};
use crate::scene::Scene;
use rapier3d::prelude::*;

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
        })
        .with_joints(),
        // Joints by reduced coordinates. Without joints it is the entry above.
        entry("rapier-multibody", |scene, settings| {
            let joints = Joints::Coordinates;
            build(scene, settings, FrictionModel::Simplified, joints)
        })
        .with_joints(),
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
    world
        .physics_pipeline
        .configure_thread_pool(settings.threads)
        .expect("thread pool");
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
        let [on_a, on_b] = joint.anchors;
        let made: GenericJoint = match joint.hinge {
            None => SphericalJointBuilder::new()
                .local_anchor1(on_a)
                .local_anchor2(on_b)
                .contacts_enabled(false)
                .into(),
            Some(hinge) => RevoluteJointBuilder::new(hinge.axis)
                .local_anchor1(on_a)
                .local_anchor2(on_b)
                .limits(hinge.range)
                .contacts_enabled(false)
                .into(),
        };
        match joints {
            Joints::Impulses => {
                world.insert_impulse_joint(a, b, made);
            }
            Joints::Coordinates => {
                let made = world.insert_multibody_joint(a, b, made);
                made.expect("no loops");
            }
        }
    }
    Box::new(Rapier { world, handles })
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
