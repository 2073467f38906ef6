//! bevy_cleave as its users have it: `CleavePlugin` in a headless app, one `app.update()` a step, transforms written back.

use super::cleave::{descriptions, joint_of, pool_threads};
use super::cleave_settings::{DEFAULT, config, settings, with_sleep};
use super::headless;
use crate::engine::{Engine, Entry, Settings, State};
use crate::scene::Scene;
use bevy_app::{App, PostUpdate};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;

struct CleaveApp {
    app: App,
    bodies: Vec<Entity>,
}

pub(crate) fn entry() -> Entry {
    Entry {
        name: "cleave-plugin",
        knob: "configuration",
        settings: settings(),
        default: DEFAULT.into(),
        build,
        is_for_joints: false,
    }
}

fn build(scene: &Scene, settings: &Settings) -> Box<dyn Engine> {
    let mut app = headless::app(scene.dt, pool_threads(settings.threads));
    app.add_plugins(CleavePlugin::new(PostUpdate));
    app.insert_resource(Gravity(scene.gravity));
    app.insert_resource(with_sleep(config(settings.value), settings.sleeping));
    headless::start(&mut app);
    let spawn = |body| app.world_mut().spawn_body(body);
    let bodies: Vec<Entity> = descriptions(scene).map(spawn).collect();
    for joint in &scene.joints {
        let [a, b] = joint.bodies.map(|body| bodies[body]);
        app.world_mut()
            .spawn((joint_of(joint), JointA(a), JointB(b)));
    }
    Box::new(CleaveApp { app, bodies })
}

impl Engine for CleaveApp {
    fn step(&mut self) {
        self.app.update();
    }

    fn read(&self, out: &mut Vec<State>) {
        out.extend(self.bodies.iter().map(|&entity| {
            let body = self.app.world().entity(entity);
            let transform = body.get::<Transform>().expect("required by RigidBody");
            let linear = body.get::<LinearVelocity>().expect("required by RigidBody");
            let angular = body
                .get::<AngularVelocity>()
                .expect("required by RigidBody");
            State {
                pos: transform.translation,
                rot: transform.rotation,
                linvel: linear.0,
                angvel: angular.0,
            }
        }));
    }

    fn num_contacts(&self) -> Option<usize> {
        Some(self.app.world().resource::<StepReport>().contacts)
    }
}
