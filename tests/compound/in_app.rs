//! Compounds as components of entities.

use crate::shapes::{cup, table};
use bevy_app::{App, TaskPoolPlugin};
use bevy_cleave::prelude::*;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use glam::Vec3;

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        TimePlugin,
        CleavePlugin::default(),
    ))
    .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    let floor = HalfSpaceShape { normal: Vec3::Y };
    app.world_mut().spawn((RigidBody::Static, floor));
    app
}

#[test]
fn an_entity_with_a_compound_is_a_body() {
    let mut app = app();
    let scaled = Transform::from_xyz(0.0, 0.01, 0.0).with_scale(Vec3::splat(2.0));
    let desk = (RigidBody::Dynamic, table(), scaled, Mass(30.0));
    let desk = app.world_mut().spawn(desk).id();
    (0..200).for_each(|_| app.update());
    let world = app.world();
    let mass = world.get::<MassProperties>(desk).expect("a body");
    assert!((mass.mass - 30.0).abs() < 1e-4);
    let at = world.get::<Transform>(desk).expect("a place").translation;
    assert!(at.length() < 2e-3, "{at}");
    assert!(world.get::<BodyIssues>(desk).is_none());
    // It gets another shape.
    app.world_mut().entity_mut(desk).insert(cup());
    (0..5).for_each(|_| app.update());
    let (slot, _) = app
        .world()
        .get::<BodyHandle>(desk)
        .and_then(BodyHandle::get)
        .expect("a body");
    let bodies = app.world().resource::<Bodies>();
    assert_eq!(bodies.compound(slot).map(Compound::len), Some(5));
}

#[test]
fn what_does_nothing_is_told() {
    let mut app = app();
    let lone = app.world_mut().spawn(table()).id();
    (0..3).for_each(|_| app.update());
    assert!(app.world().get::<BodyIssues>(lone).is_some());
    app.world_mut().entity_mut(lone).insert(RigidBody::Dynamic);
    (0..2).for_each(|_| app.update());
    assert!(app.world().get::<BodyIssues>(lone).is_none());
}
