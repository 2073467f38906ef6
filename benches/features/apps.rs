//! Whole updates of an app with a heap that lies.

use crate::app::step_length;
use crate::common::scenes;
use crate::pair::{Pair, Row, Step, is_bench};
use bevy_app::{App, TaskPoolPlugin};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use glam::Vec3;

/// Bodies of the heap.
const BODIES: usize = 200;

/// An app with a heap that lies. It gets plugins before it begins, and what else is changed before anything moves.
fn heap(plugins: impl FnOnce(&mut App), change: impl FnOnce(&mut World, &[Entity])) -> Step {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        TimePlugin,
        CleavePlugin::default(),
    ))
    .insert_resource(Time::<Fixed>::from_duration(step_length()))
    .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    plugins(&mut app);
    app.finish();
    app.cleanup();
    app.update();
    app.world_mut().resource_mut::<SolverConfig>().sleep = SleepConfig::off();
    let bodies: Vec<Entity> = scenes::heap(BODIES)
        .into_iter()
        .map(|desc| app.world_mut().spawn_body(desc))
        .collect();
    change(app.world_mut(), &bodies);
    (0..if is_bench() { 600 } else { 2 }).for_each(|_| app.update());
    Box::new(move || app.update())
}

/// The app, and the same with something more.
fn changed(plugins: impl FnOnce(&mut App), change: impl FnOnce(&mut World, &[Entity])) -> Pair {
    Pair::new(heap(|_| {}, |_, _| {}), heap(plugins, change))
}

/// Gives all bodies of the heap a component.
fn all_with(component: impl Component + Clone) -> Pair {
    let give = |world: &mut World, bodies: &[Entity]| {
        for &body in bodies {
            world.entity_mut(body).insert(component.clone());
        }
    };
    changed(|_| {}, give)
}

/// Lets the ground run.
fn run_ground(world: &mut World, _: &[Entity]) {
    let mut kinds = world.query::<(Entity, &RigidBody)>();
    let ground = kinds
        .iter(world)
        .find(|(_, kind)| **kind == RigidBody::Static);
    if let Some((ground, _)) = ground {
        world
            .entity_mut(ground)
            .insert(SurfaceVelocity(0.1 * Vec3::X));
    }
}

/// Somebody who stands beside the heap.
fn spawn_walker(world: &mut World, _: &[Entity]) {
    let capsule = ConvexMesh::capsule(0.3, 0.5).expect("valid size");
    let desc = BodyDesc {
        kind: RigidBody::Kinematic,
        ..BodyDesc::dynamic(capsule, Vec3::new(-5.0, 0.6, 2.0))
    };
    let walker = world.spawn_body(desc);
    world.entity_mut(walker).insert(Walker::default());
}

/// A body that is nowhere.
fn spawn_ill(world: &mut World, _: &[Entity]) {
    let nowhere = Transform::from_translation(Vec3::NAN);
    let shape = bevy_cleave::cuboid!(1.0, 1.0, 1.0);
    world.spawn((RigidBody::Dynamic, shape, nowhere));
}

pub(crate) fn rows() -> Vec<Row> {
    let mut rows = vec![
        Row::new(
            "Events, sensors, forces",
            "app: `CollisionEvents` on all",
            || all_with(CollisionEvents),
        ),
        Row::new(
            "Events, sensors, forces",
            "app: `LinearDamping` on all",
            || all_with(LinearDamping(0.01)),
        ),
        Row::new(
            "Events, sensors, forces",
            "app: `SurfaceVelocity` of the ground",
            || changed(|_| {}, run_ground),
        ),
        Row::new("Characters", "app: `WalkerPlugin` and one `Walker`", || {
            let plugin = |app: &mut App| {
                app.add_plugins(WalkerPlugin);
            };
            changed(plugin, spawn_walker)
        }),
        Row::new("Bad input", "app: one body that has to be left out", || {
            changed(|_| {}, spawn_ill)
        }),
        Row::new("Smooth motion", "app: `InterpolationPlugin`", || {
            let plugin = |app: &mut App| {
                app.add_plugins(InterpolationPlugin);
            };
            changed(plugin, |_, _| {})
        }),
        // What they stay described by costs nothing: in each step it is looked for.
        Row::new("Saving", "app: all are described", || {
            changed(|_| {}, |world, _| describe_bodies(world))
        }),
        Row::new("Rewind", "app: `RewindPlugin`, 60 moments", || {
            let plugin = |app: &mut App| {
                app.add_plugins(RewindPlugin {
                    moments: 60,
                    interval: 1,
                });
            };
            changed(plugin, |_, _| {})
        }),
    ];
    rows.extend(featured());
    rows
}

/// Rows of what needs features of the crate.
#[cfg(not(all(feature = "diagnostics", feature = "mesh")))]
fn featured() -> [Row; 0] {
    []
}

#[cfg(all(feature = "diagnostics", feature = "mesh"))]
fn featured() -> [Row; 2] {
    use bevy_app::Plugin;
    use bevy_asset::AssetPlugin;
    use bevy_mesh::MeshPlugin;

    fn with_meshes(app: &mut App) {
        app.add_plugins((AssetPlugin::default(), MeshPlugin, CleaveMeshPlugin));
    }

    [
        Row::new("Smooth motion", "app: `DrawShape` on all", || {
            let draw = |world: &mut World, bodies: &[Entity]| {
                for &body in bodies {
                    world.entity_mut(body).insert(DrawShape::new());
                }
            };
            Pair::new(heap(with_meshes, |_, _| {}), heap(with_meshes, draw))
        }),
        Row::new("Smooth motion", "app: `CleaveDiagnosticsPlugin`", || {
            let plugin = |app: &mut App| {
                bevy_diagnostic::DiagnosticsPlugin.build(app);
                app.add_plugins(CleaveDiagnosticsPlugin);
            };
            changed(plugin, |_, _| {})
        }),
    ]
}
