//! Clusters as components of entities.

use crate::app::stepping_app;
use crate::shapes::wall;
use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::Vec3;

fn app() -> App {
    let mut app = stepping_app();
    let floor = HalfSpaceShape { normal: Vec3::Y };
    app.world_mut().spawn((RigidBody::Static, floor));
    app
}

fn shoot(app: &mut App, speed: f32) {
    let ball = ConvexMesh::sphere(0.1).expect("a ball");
    app.world_mut().spawn((
        RigidBody::Dynamic,
        ball,
        Density(2000.0),
        LinearVelocity(-speed * Vec3::Z),
        Transform::from_xyz(0.07, 0.62, 0.3),
    ));
}

/// Events of fractures until now, as messages.
fn told(app: &App) -> Vec<Fractured> {
    let messages = app.world().resource::<Messages<Fractured>>();
    messages.iter_current_update_messages().cloned().collect()
}

fn run(app: &mut App, updates: usize) -> Vec<Fractured> {
    let mut all = Vec::new();
    for _ in 0..updates {
        app.update();
        all.extend(told(app));
    }
    all
}

fn parts(app: &App, entity: Entity) -> usize {
    app.world().get::<Compound>(entity).map_or(1, Compound::len)
}

#[test]
fn what_is_anchored_stays_the_same_entity() {
    let mut app = app();
    let scaled = Transform::from_scale(Vec3::splat(1.0));
    let entity = (RigidBody::Static, wall(8, 10, 1e5), scaled);
    let entity = app.world_mut().spawn(entity).id();
    let whole = {
        app.update();
        parts(&app, entity)
    };
    shoot(&mut app, 15.0);
    let events = run(&mut app, 60);
    assert!(!events.is_empty());
    let mut off = 0;
    for event in &events {
        if event.parent != entity {
            continue;
        }
        assert!(event.goes_on);
        assert!(matches!(
            event.cause,
            FractureCause::Impact { .. } | FractureCause::Load
        ));
        assert!(event.ledger.mass_error() < 1e-6);
        off += event.pieces.len();
    }
    assert!(off > 0);
    assert_eq!(
        app.world().get::<RigidBody>(entity),
        Some(&RigidBody::Static)
    );
    assert!(parts(&app, entity) < whole);
    let handle = app
        .world()
        .get::<BodyHandle>(entity)
        .and_then(BodyHandle::get);
    let (slot, _) = handle.expect("a body");
    let bodies = app.world().resource::<Bodies>();
    assert_eq!(
        bodies.compound(slot).map(Compound::len),
        Some(parts(&app, entity))
    );
    assert!(app.world().get::<BodyIssues>(entity).is_none());
    // All parts are somewhere.
    let mut shapes = app.world_mut().query::<(&PieceOf, Option<&Compound>)>();
    let pieces: usize = shapes
        .iter(app.world())
        .map(|(_, shape)| shape.map_or(1, Compound::len))
        .sum();
    assert_eq!(pieces + parts(&app, entity), whole);
}

#[test]
fn a_clone_breaks_for_itself_and_who_is_disabled_does_not() {
    let mut app = app();
    let entity = app
        .world_mut()
        .spawn((RigidBody::Static, wall(8, 10, 1e4)))
        .id();
    app.update();
    let clone = app.world_mut().entity_mut(entity).clone_and_spawn();
    let aside = Transform::from_xyz(20.0, 0.0, 0.0);
    app.world_mut().entity_mut(clone).insert(aside);
    app.world_mut().entity_mut(entity).insert(Disabled);
    shoot(&mut app, 30.0);
    assert!(run(&mut app, 30).is_empty());
    app.world_mut().entity_mut(entity).remove::<Disabled>();
    app.update();
    shoot(&mut app, 30.0);
    let events = run(&mut app, 30);
    assert!(!events.is_empty());
    assert!(events.iter().all(|event| event.parent != clone));
    // A despawned one takes its body with it.
    app.world_mut().entity_mut(entity).despawn();
    run(&mut app, 5);
    app.world_mut().entity_mut(clone).despawn();
    run(&mut app, 5);
}

#[test]
fn a_given_mass_is_refused() {
    let mut app = app();
    let mass = MassProperties {
        mass: 3.0,
        principal: Vec3::ONE,
        ..MassProperties::default()
    };
    let entity = (RigidBody::Dynamic, wall(4, 4, 1e4), MassOverride(mass));
    let entity = app.world_mut().spawn(entity).id();
    run(&mut app, 2);
    let issues = app.world().get::<BodyIssues>(entity);
    assert!(issues.is_some());
}

#[test]
fn what_was_saved_breaks_as_what_it_was_saved_from() {
    let shape = wall(8, 10, 1e5);
    let saved = Cluster::from(&shape);
    // As a file would hold it: poses, corners, bonds.
    let parts = saved.parts.iter().map(|part| {
        let corners = part.shape.hull().vertices().to_vec();
        let shape = ConvexMesh::from_points(&corners).expect("a hull");
        CompoundPart::new(part.pose, shape)
    });
    let loaded = Cluster {
        parts: parts.collect(),
        bonds: saved.bonds.clone(),
    };
    let loaded = loaded.compound().expect("one wall");
    assert_eq!(loaded.bonds(), shape.bonds());
    // Under the blow alone: what falls on what is chance, of rounding, which hulls with their corners in another order differ by.
    let pieces = |shape: &Compound, speed: f32| {
        let shape = shape.clone();
        let mut app = app();
        let entity = app.world_mut().spawn((RigidBody::Static, shape)).id();
        app.update();
        shoot(&mut app, speed);
        run(&mut app, 4);
        crate::in_app::parts(&app, entity)
    };
    for number in 0..10 {
        let speed = 8.0 + 2.0 * number as f32;
        assert_eq!(pieces(&shape, speed), pieces(&loaded, speed), "{speed} m/s");
    }
}
