//! Avian 0.8 on a headless Bevy app; one `app.update()` is one physics step. Knob: sub-steps per step.

use super::headless;
use crate::engine::{Engine, Entry, Settings, State};
use crate::scene::{self, JointKind, Scene};
use avian3d::prelude::*;
use bevy::prelude::*;

struct Avian {
    app: App,
    bodies: Vec<Entity>,
}

pub(crate) fn entry() -> Entry {
    Entry::numbered("avian", "substeps", 6, &[1, 2, 4, 6, 12, 24], build)
}

fn build(scene: &Scene, settings: &Settings) -> Box<dyn Engine> {
    // Its systems run on threads of the pool while the calling one waits, and it divides work by the size of the pool.
    let mut app = headless::app(scene.dt, settings.threads);
    app.add_plugins(PhysicsPlugins::new(PostUpdate));
    app.insert_resource(Gravity(scene.gravity));
    app.insert_resource(SubstepCount(settings.value));
    headless::start(&mut app);
    let colliders: Vec<_> = scene
        .shapes
        .iter()
        .map(|s| match s.half_extents {
            Some(h) => Collider::cuboid(2.0 * h.x, 2.0 * h.y, 2.0 * h.z),
            None => Collider::convex_hull(&s.points).expect("hull"),
        })
        .collect();
    let mut bodies = Vec::new();
    for b in &scene.bodies {
        let mut body = app.world_mut().spawn((
            if b.fixed {
                RigidBody::Static
            } else {
                RigidBody::Dynamic
            },
            colliders[b.shape].clone(),
            ColliderDensity(b.density),
            Friction::new(scene.friction),
            Restitution::new(scene.restitution),
            Transform::from_translation(b.pos).with_rotation(b.rot),
            LinearVelocity(b.linvel),
            AngularVelocity(b.angvel),
        ));
        if b.bullet {
            body.insert(SweptCcd {
                filter: CcdFilter::ALL,
                ..default()
            });
        }
        if !settings.sleeping {
            body.insert(SleepingDisabled);
        }
        bodies.push(body.id());
    }
    for joint in &scene.joints {
        let [a, b] = joint.bodies.map(|body| bodies[body]);
        add_joint(app.world_mut().spawn(JointCollisionDisabled), joint, a, b);
    }
    Box::new(Avian { app, bodies })
}

/// A joint of a scene.
fn add_joint(mut entity: EntityWorldMut<'_>, joint: &scene::Joint, a: Entity, b: Entity) {
    let [on_a, on_b] = joint
        .frames
        .map(|frame| Isometry3d::new(frame.pos, frame.rot));
    match joint.kind {
        JointKind::Fixed => {
            let fixed = FixedJoint::new(a, b).with_local_frame1(on_a);
            entity.insert(fixed.with_local_frame2(on_b));
        }
        JointKind::Ball => {
            let ball = SphericalJoint::new(a, b).with_local_frame1(on_a);
            entity.insert(ball.with_local_frame2(on_b));
        }
        JointKind::ConeTwist { swing, twist } => {
            let ball = SphericalJoint::new(a, b).with_local_frame1(on_a);
            let limited = ball
                .with_twist_axis(Vec3::X)
                .with_swing_limits(-swing, swing)
                .with_twist_limits(-twist, twist);
            entity.insert(limited.with_local_frame2(on_b));
        }
        JointKind::Hinge { range, motor } => {
            let hinge = RevoluteJoint::new(a, b).with_local_frame1(on_a);
            let mut hinge = hinge.with_local_frame2(on_b).with_hinge_axis(Vec3::X);
            if let Some([least, most]) = range {
                hinge = hinge.with_angle_limits(least, most);
            }
            if let Some(motor) = motor {
                let model = MotorModel::AccelerationBased {
                    stiffness: 0.0,
                    damping: 1e3,
                };
                let motor = AngularMotor::new(model)
                    .with_target_velocity(motor.speed)
                    .with_max_torque(motor.max_torque);
                hinge = hinge.with_motor(motor);
            }
            entity.insert(hinge);
        }
        JointKind::Slider { spring } => {
            let slider = PrismaticJoint::new(a, b).with_local_frame1(on_a);
            let mut slider = slider.with_local_frame2(on_b).with_slider_axis(Vec3::X);
            if let Some(spring) = spring {
                slider = slider.with_motor(LinearMotor::new(MotorModel::SpringDamper {
                    frequency: spring.hertz,
                    damping_ratio: spring.damping_ratio,
                }));
            }
            entity.insert(slider);
        }
    }
}

impl Engine for Avian {
    fn step(&mut self) {
        self.app.update();
    }

    fn read(&self, out: &mut Vec<State>) {
        out.extend(self.bodies.iter().map(|&e| {
            let b = self.app.world().entity(e);
            State {
                pos: b.get::<Position>().unwrap().0,
                rot: b.get::<Rotation>().unwrap().0,
                linvel: b.get::<LinearVelocity>().unwrap().0,
                angvel: b.get::<AngularVelocity>().unwrap().0,
            }
        }));
    }

    fn num_awake(&self) -> Option<usize> {
        let awake = |&&e: &&Entity| {
            let b = self.app.world().entity(e);
            b.get::<RigidBody>() == Some(&RigidBody::Dynamic) && !b.contains::<Sleeping>()
        };
        Some(self.bodies.iter().filter(awake).count())
    }
}
