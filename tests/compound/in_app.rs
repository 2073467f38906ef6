//! Compounds as components of entities.

use crate::app::stepping_app;
use crate::shapes::{cup, table};
use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::Vec3;

fn app() -> App {
    let mut app = stepping_app();
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

fn slot_of(app: &App, entity: Entity) -> u32 {
    let handle = app.world().get::<BodyHandle>(entity);
    handle.and_then(BodyHandle::get).expect("a body").0
}

#[test]
fn children_are_the_parts_of_their_parent() {
    let mut app = app();
    let top = bevy_cleave::cuboid!(1.0, 0.1, 1.0);
    let leg = bevy_cleave::cuboid!(0.1, 1.0, 0.1);
    let at = |x, z| Transform::from_xyz(x, -0.55, z);
    let stool = app.world_mut().spawn((
        RigidBody::Dynamic,
        CompoundOfChildren,
        Transform::from_xyz(0.0, 1.06, 0.0),
        children![
            top.clone(),
            (leg.clone(), at(0.4, 0.4)),
            (leg.clone(), at(-0.4, 0.4)),
            // One that carries another one, scaled.
            (
                at(0.0, -0.4),
                children![(
                    leg.clone(),
                    Transform::from_xyz(0.4, 0.0, 0.0).with_scale(Vec3::new(2.0, 1.0, 1.0))
                )],
            ),
            (leg.clone(), at(-0.4, -0.4)),
        ],
    ));
    let stool = stool.id();
    (0..120).for_each(|_| app.update());
    let slot = slot_of(&app, stool);
    let bodies = app.world().resource::<Bodies>();
    let compound = bodies.compound(slot).expect("a compound");
    assert_eq!(compound.len(), 5);
    assert!((bodies.mass(slot).mass - 100.0 - 5.0 * 10.0).abs() < 1e-3);
    let height = bodies.pose(slot).position.y;
    assert!((height - 1.05).abs() < 2e-3, "{height}");
    assert!(
        app.world_mut()
            .query::<&BodyIssues>()
            .iter(app.world())
            .next()
            .is_none()
    );
    // The legs of one side go, and it falls over.
    let legs = app
        .world()
        .get::<Children>(stool)
        .expect("children")
        .to_vec();
    app.world_mut().entity_mut(legs[1]).despawn();
    app.world_mut().entity_mut(legs[3]).despawn();
    (0..120).for_each(|_| app.update());
    let bodies = app.world().resource::<Bodies>();
    assert_eq!(bodies.compound(slot).map(Compound::len), Some(3));
    assert!(bodies.pose(slot).position.y < 1.0);
    // None is left.
    for &leg in [0, 2, 4].map(|leg| &legs[leg]) {
        app.world_mut().entity_mut(leg).despawn();
    }
    (0..3).for_each(|_| app.update());
    let issues = app.world().get::<BodyIssues>(stool);
    let issues = issues.map(|issues| issues.iter().map(ToString::to_string).collect::<Vec<_>>());
    assert!(issues.is_some_and(|issues| issues.iter().any(|issue| issue.contains("children"))));
}

#[test]
fn a_disabled_compound_takes_no_part() {
    use bevy_ecs::entity_disabling::Disabled;
    let mut app = app();
    let high = Transform::from_xyz(0.0, 3.0, 0.0);
    let desk = app
        .world_mut()
        .spawn((RigidBody::Dynamic, table(), high))
        .id();
    (0..3).for_each(|_| app.update());
    app.world_mut().entity_mut(desk).insert(Disabled);
    (0..60).for_each(|_| app.update());
    let slot = slot_of(&app, desk);
    assert!(app.world().resource::<Bodies>().pose(slot).position.y > 2.9);
    app.world_mut().entity_mut(desk).remove::<Disabled>();
    (0..120).for_each(|_| app.update());
    let height = app.world().resource::<Bodies>().pose(slot).position.y;
    assert!(height.abs() < 2e-3, "{height}");
}

#[test]
fn pieces_of_a_compound_are_entities_with_shapes_of_their_own() {
    let mut app = app();
    let desk = (RigidBody::Dynamic, table(), Transform::IDENTITY);
    let desk = app.world_mut().spawn(desk).id();
    (0..3).for_each(|_| app.update());
    let plane = Plane::through(0.3 * Vec3::Y, Vec3::Y);
    let world = app.world_mut();
    world.commands().slice(desk, plane);
    world.flush();
    (0..2).for_each(|_| app.update());
    let world = app.world_mut();
    assert!(world.get_entity(desk).is_err());
    let mut pieces = world.query_filtered::<(Has<ConvexMesh>, Option<&Compound>), With<PieceOf>>();
    let shapes: Vec<_> = pieces
        .iter(world)
        .map(|(is_hull, compound)| (is_hull, compound.map(Compound::len)))
        .collect();
    let stumps = shapes.iter().filter(|shape| **shape == (true, None));
    assert_eq!(stumps.count(), 4, "{shapes:?}");
    assert!(shapes.contains(&(false, Some(5))), "{shapes:?}");
}
