//! Plugins that connect the physics to other parts of Bevy.

mod constructors;
mod diagnostics;
#[path = "../common/dice.rs"]
mod dice;
mod drawing;
mod gizmos;
#[path = "../common/hierarchy.rs"]
mod hierarchy;
mod interpolation;
mod meshes;
mod picking;
mod shapes;

use bevy_app::{App, TaskPoolPlugin};
use bevy_asset::AssetPlugin;
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_mesh::MeshPlugin;
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy};
use bevy_transform::TransformPlugin;
use std::time::Duration;

/// An app that makes one step with every update, of 1/60 s unless told otherwise.
fn app() -> App {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        TimePlugin,
        TransformPlugin,
        AssetPlugin::default(),
        MeshPlugin,
        CleavePlugin::default(),
    ))
    .insert_resource(Time::<Fixed>::from_hz(60.0))
    .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    app
}

/// The same with shapes from meshes and meshes of shapes, ready to run.
fn mesh_app() -> App {
    let mut app = app();
    app.add_plugins(CleaveMeshPlugin);
    app.finish();
    app.cleanup();
    app.update();
    app
}

/// Frames of another rate than steps.
fn with_frames_of(app: &mut App, seconds: f64) {
    let frame = Duration::from_secs_f64(seconds);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(frame));
}

/// All entities with a component.
fn all_with<C: Component>(app: &mut App) -> Vec<Entity> {
    let world = app.world_mut();
    let mut found: Vec<_> = world
        .query_filtered::<Entity, With<C>>()
        .iter(world)
        .collect();
    found.sort_unstable();
    found
}
