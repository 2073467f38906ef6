//! Avian 0.8 on a headless Bevy app; one `app.update()` is one physics step. Knob: sub-steps per step.

use super::headless;
use crate::engine::{Engine, Entry, Settings, State};
use crate::scene::Scene;
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
    Box::new(Avian { app, bodies })
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
