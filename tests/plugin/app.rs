//! An app with the plugin that makes exactly one step with every update, and spawning from descriptions.
#![allow(dead_code, reason = "each test uses some of it")]

use crate::common::states::bits;
use bevy_app::{App, Plugins, TaskPoolPlugin};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{LogLevel, ScheduleBuildSettings};
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use std::time::Duration;

/// Length of a step, s.
pub(crate) fn step_length() -> Duration {
    Duration::from_secs_f64(1.0 / 60.0)
}

/// The app; systems without a defined order are errors in it.
pub(crate) fn app() -> App {
    app_of(CleavePlugin::default())
}

/// The same with other plugins.
pub(crate) fn app_of<M>(plugins: impl Plugins<M>) -> App {
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin::default(), TimePlugin))
        .add_plugins(plugins)
        .insert_resource(Time::<Fixed>::from_duration(step_length()))
        .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    app.edit_schedule(PhysicsSchedule, |schedule| {
        schedule.set_build_settings(ScheduleBuildSettings {
            ambiguity_detection: LogLevel::Error,
            ..Default::default()
        });
    });
    app.finish();
    app.cleanup();
    app.update();
    app
}

/// The same with a system of the user's among the phases.
pub(crate) fn accompanied_app() -> App {
    let mut app = app();
    let company = (|| ())
        .after(PhysicsSystems::Solve)
        .before(PhysicsSystems::Integrate);
    app.add_systems(PhysicsSchedule, company);
    app
}

/// Motion of one entity as bits.
pub(crate) fn bits_of_entity(world: &World, entity: Entity) -> Vec<u32> {
    let entity = world.entity(entity);
    let t = entity.get::<Transform>().expect("a body has a Transform");
    let v = entity
        .get::<LinearVelocity>()
        .expect("a body has a velocity");
    let omega = entity
        .get::<AngularVelocity>()
        .expect("a body has a velocity");
    bits(&Pose::new(t.translation, t.rotation), v.0, omega.0)
}
