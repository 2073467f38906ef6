//! Pieces are born whole, while the body that they were still lives.

use crate::app::app;
use crate::common::dice::Dice;
use bevy_app::{App, Update};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_math::{Quat, Vec3};
use bevy_transform::components::Transform;

#[derive(Component, Clone, Debug, PartialEq)]
struct Glass(u32);

#[derive(Component, Clone)]
struct Secret;

#[derive(Component)]
struct Unique;

/// What observers saw.
#[derive(Resource, Default)]
struct Seen {
    born: Vec<(Entity, bool)>,
    poked: Vec<Entity>,
    fractures: Vec<(Fractured, bool)>,
    messages: Vec<Fractured>,
    unclonable: Vec<String>,
}

fn cube() -> ConvexMesh {
    ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a cube has a volume")
}

#[derive(EntityEvent)]
struct Poke(Entity);

fn watching() -> App {
    let mut app = app();
    app.init_resource::<Seen>()
        .add_observer(
            |add: On<Add<Glass>>,
             bodies: Query<(
                &RigidBody,
                &ConvexMesh,
                &Transform,
                &LinearVelocity,
                &BodyHandle,
            )>,
             store: Res<Bodies>,
             mut seen: ResMut<Seen>| {
                let is_whole = bodies
                    .get(add.entity)
                    .is_ok_and(|(_, mesh, place, v, handle)| {
                        handle.get().is_some_and(|(slot, id)| {
                            store.is_current(slot, id)
                                && store.convex(slot).is_some_and(|own| own.is_same(mesh))
                                && store.pose(slot).position == place.translation
                                && store.velocity(slot).0 == v.0
                        })
                    });
                seen.born.push((add.entity, is_whole));
            },
        )
        .add_observer(
            |broke: On<Fractured>, lives: Query<&Glass>, mut seen: ResMut<Seen>| {
                let is_there = lives.contains(broke.parent);
                seen.fractures.push((broke.event().clone(), is_there));
            },
        )
        .add_systems(
            Update,
            |mut fractures: MessageReader<Fractured>,
             mut warnings: MessageReader<BodyWarning>,
             mut seen: ResMut<Seen>| {
                seen.messages.extend(fractures.read().cloned());
                for warning in warnings.read() {
                    if let BodyProblem::NotCloned(name) = &warning.problem {
                        seen.unclonable.push(name.clone());
                    }
                }
            },
        );
    app
}

fn seen(app: &App) -> &Seen {
    app.world().resource::<Seen>()
}

fn weightless(app: &mut App) {
    app.insert_resource(Gravity(Vec3::ZERO));
}

fn glass(app: &mut App, place: Transform) -> Entity {
    let parts = (RigidBody::Dynamic, cube(), place, Glass(7));
    app.world_mut().spawn(parts).id()
}

fn steps(app: &mut App, count: usize) {
    (0..count).for_each(|_| app.update());
}

fn slice(app: &mut App, entity: Entity, plane: Plane) {
    app.world_mut().commands().slice(entity, plane);
    app.update();
}

#[test]
fn who_sees_a_piece_added_sees_all_of_it() {
    let mut app = watching();
    let mut dice = Dice::new(41);
    for i in 0..20 {
        let place = Transform::from_translation(Vec3::new(9.0 * i as f32, 0.0, 0.0))
            .with_rotation(dice.rotation());
        let entity = glass(&mut app, place);
        let spin = AngularVelocity(dice.vector(-3.0, 3.0));
        app.world_mut().entity_mut(entity).insert(spin);
        app.update();
        let center = app
            .world()
            .get::<Transform>(entity)
            .expect("a body")
            .translation;
        slice(&mut app, entity, Plane::through(center, dice.direction()));
    }
    let born = &seen(&app).born;
    // The parents had no body yet when they were added.
    assert_eq!(born.iter().filter(|(_, is_whole)| *is_whole).count(), 40);
    assert_eq!(born.len(), 60);
    assert_eq!(seen(&app).fractures.len(), 20);
    assert!(seen(&app).fractures.iter().all(|(_, is_there)| *is_there));
    steps(&mut app, 1);
    let events = seen(&app).fractures.iter().map(|(event, _)| event);
    assert!(events.eq(&seen(&app).messages));
    assert!(
        app.world()
            .get_entity(seen(&app).messages[0].parent)
            .is_err()
    );
}

#[test]
fn observers_of_the_entity_come_along() {
    let mut app = watching();
    weightless(&mut app);
    let entity = glass(&mut app, Transform::IDENTITY);
    app.world_mut()
        .entity_mut(entity)
        .observe(|poke: On<Poke>, mut seen: ResMut<Seen>| {
            seen.poked.push(poke.event_target());
        });
    app.update();
    slice(&mut app, entity, Plane::through(Vec3::ZERO, Vec3::X));
    let pieces = seen(&app).fractures[0].0.pieces.clone();
    for &piece in &pieces {
        app.world_mut().trigger(Poke(piece));
    }
    assert_eq!(seen(&app).poked, pieces);
}

#[test]
fn the_cause_names_who_hit_where_and_how_hard() {
    let mut app = watching();
    weightless(&mut app);
    let pane = ConvexMesh::cuboid(4.0, 4.0, 0.1).expect("a pane");
    let pane = app
        .world_mut()
        .spawn((
            RigidBody::Dynamic,
            pane,
            Glass(1),
            Fracturable::with_strength(50.0),
        ))
        .id();
    let shot = (
        Transform::from_xyz(0.5, 0.25, -3.0),
        LinearVelocity(Vec3::new(0.0, 0.0, 20.0)),
    );
    let shot = app
        .world_mut()
        .spawn((RigidBody::Dynamic, cube(), shot))
        .id();
    steps(&mut app, 20);
    let (event, is_there) = &seen(&app).fractures[0];
    assert!(is_there);
    assert_eq!(event.parent, pane);
    let FractureCause::Impact {
        by,
        point,
        direction,
        impulse,
        energy,
    } = event.cause
    else {
        panic!("{event:?}");
    };
    assert_eq!(by, Some(shot));
    assert!(point.distance(Vec3::new(0.5, 0.25, 0.0)) < 0.6, "{point}");
    assert!(direction.z > 0.99);
    assert!(impulse > 50.0 && energy > 0.0, "{impulse} {energy}");
    let other = glass(&mut app, Transform::from_xyz(0.0, 50.0, 0.0));
    app.update();
    slice(&mut app, other, Plane::through(50.0 * Vec3::Y, Vec3::X));
    let (event, _) = seen(&app).fractures.last().expect("it was cut");
    assert_eq!((event.parent, event.cause), (other, FractureCause::Cut));
}

#[test]
fn children_go_to_the_piece_that_holds_them_and_stay_in_place() {
    let mut app = watching();
    weightless(&mut app);
    let turn = Quat::from_rotation_y(0.8);
    let place = Transform::from_xyz(3.0, 1.0, 2.0).with_rotation(turn);
    let entity = glass(&mut app, place);
    let mut dice = Dice::new(4);
    let children: Vec<(Entity, Vec3)> = (0..20)
        .map(|_| {
            let local = dice.vector(-0.7, 0.7);
            let child = Transform::from_translation(local);
            (app.world_mut().spawn((child, ChildOf(entity))).id(), local)
        })
        .collect();
    let bare = app.world_mut().spawn(ChildOf(entity)).id();
    app.update();
    let normal = turn * Vec3::X;
    slice(&mut app, entity, Plane::through(place.translation, normal));
    let pieces = seen(&app).fractures[0].0.pieces.clone();
    for (child, local) in children {
        let parent = app
            .world()
            .get::<ChildOf>(child)
            .expect("it has one")
            .parent();
        let piece = *app.world().get::<Transform>(parent).expect("a piece");
        let side = (piece.translation - place.translation).dot(normal);
        assert!(side * local.x > 0.0, "{local}");
        let own = *app.world().get::<Transform>(child).expect("it has one");
        let now = piece.transform_point(own.translation);
        assert!(now.distance(place.transform_point(local)) < 1e-5);
    }
    assert_eq!(
        app.world().get::<ChildOf>(bare).map(ChildOf::parent),
        Some(pieces[0])
    );

    let entity = glass(&mut app, Transform::from_xyz(20.0, 0.0, 0.0));
    let child = app
        .world_mut()
        .spawn((Transform::IDENTITY, ChildOf(entity)))
        .id();
    app.world_mut()
        .entity_mut(entity)
        .insert(ChildrenOfPieces::Despawn);
    app.update();
    slice(&mut app, entity, Plane::through(20.0 * Vec3::X, Vec3::X));
    assert!(app.world().get_entity(child).is_err());
}

#[test]
fn pieces_of_a_child_stay_where_the_parent_was() {
    for size in [1.0, 2.0] {
        let mut app = watching();
        weightless(&mut app);
        let parent = Transform::from_xyz(5.0, 1.0, 0.0)
            .with_rotation(Quat::from_rotation_z(0.5))
            .with_scale(Vec3::splat(size));
        let parent_entity = app.world_mut().spawn(parent).id();
        let entity = glass(&mut app, Transform::from_xyz(0.0, 2.0, 0.0));
        app.world_mut()
            .entity_mut(entity)
            .insert(ChildOf(parent_entity));
        app.update();
        let center = parent.transform_point(2.0 * Vec3::Y);
        slice(&mut app, entity, Plane::through(center, Vec3::X));
        steps(&mut app, 3);
        let pieces = seen(&app).fractures[0].0.pieces.clone();
        let mut volume = 0.0;
        for piece in pieces {
            let local = app.world().get::<Transform>(piece).expect("a piece");
            let world = parent.mul_transform(*local);
            let (slot, _) = app
                .world()
                .get::<BodyHandle>(piece)
                .and_then(BodyHandle::get)
                .expect("a body");
            let pose = app.world().resource::<Bodies>().pose(slot);
            assert!(world.translation.distance(pose.position) < 1e-4);
            assert!(
                world.scale.distance(Vec3::ONE) < 1e-4,
                "the shape has its size"
            );
            volume += app
                .world()
                .get::<ConvexMesh>(piece)
                .expect("a piece")
                .hull()
                .volume();
        }
        assert!((volume - f64::from(size * size * size)).abs() < 1e-3);
    }
}

#[test]
fn pieces_are_related_to_what_they_were() {
    let mut app = watching();
    weightless(&mut app);
    let entity = glass(&mut app, Transform::IDENTITY);
    app.update();
    slice(&mut app, entity, Plane::through(Vec3::ZERO, Vec3::X));
    let first = seen(&app).fractures[0].0.pieces.clone();
    slice(&mut app, first[0], Plane::through(Vec3::ZERO, Vec3::Y));
    let mut remains = app.world_mut().query::<(Entity, &Remains, &Pieces)>();
    let [(of, remains, pieces)] = remains.iter(app.world()).collect::<Vec<_>>()[..] else {
        panic!("pieces of pieces belong to the same");
    };
    assert_eq!(remains.of, entity);
    assert_eq!(pieces.iter().count(), 3);
    // Debris goes in one go, and with the last piece the remains.
    app.world_mut().despawn(of);
    steps(&mut app, 2);
    assert_eq!(app.world().resource::<Bodies>().len(), 0);
    let entity = glass(&mut app, Transform::IDENTITY);
    app.update();
    slice(&mut app, entity, Plane::through(Vec3::ZERO, Vec3::X));
    let pieces = seen(&app)
        .fractures
        .last()
        .expect("it was cut")
        .0
        .pieces
        .clone();
    for piece in pieces {
        app.world_mut().despawn(piece);
    }
    let mut remains = app.world_mut().query::<&Remains>();
    assert_eq!(remains.iter(app.world()).count(), 0);
}

#[test]
fn what_pieces_do_not_get_is_a_rule_or_is_named() {
    let mut app = watching();
    weightless(&mut app);
    app.world_mut()
        .resource_mut::<PieceRules>()
        .drop_component::<Secret>();
    for i in 0..2 {
        let at = 9.0 * i as f32 * Vec3::X;
        let entity = glass(&mut app, Transform::from_translation(at));
        let parts = (Secret, Unique, GravityScale(0.5));
        app.world_mut().entity_mut(entity).insert(parts);
        app.update();
        slice(&mut app, entity, Plane::through(at, Vec3::X));
    }
    steps(&mut app, 2);
    let mut pieces = app
        .world_mut()
        .query_filtered::<(&Glass, &GravityScale, Has<Secret>, Has<Unique>), With<PieceOf>>();
    assert_eq!(pieces.iter(app.world()).count(), 4);
    assert!(
        pieces
            .iter(app.world())
            .all(|(glass, scale, secret, unique)| {
                *glass == Glass(7) && scale.0 == 0.5 && !secret && !unique
            })
    );
    let named = &seen(&app).unclonable;
    assert_eq!(named.len(), 1, "once each: {named:?}");
}

#[test]
fn observers_may_despawn_what_they_see() {
    let mut app = watching();
    weightless(&mut app);
    app.add_observer(
        |add: On<Add<PieceOf>>, mut commands: Commands, mut count: Local<u32>| {
            *count += 1;
            if (*count).is_multiple_of(3) {
                commands.entity(add.entity).despawn();
            }
        },
    );
    app.add_observer(|broke: On<Fractured>, mut commands: Commands| {
        commands.entity(broke.parent).despawn();
    });
    for i in 0..6 {
        let at = 9.0 * i as f32 * Vec3::X;
        let entity = glass(&mut app, Transform::from_translation(at));
        app.update();
        slice(&mut app, entity, Plane::through(at, Vec3::X));
    }
    steps(&mut app, 3);
    let mut handles = app.world_mut().query::<&BodyHandle>();
    let alive = handles
        .iter(app.world())
        .filter(|handle| handle.get().is_some())
        .count();
    assert_eq!(alive, 8);
    assert_eq!(app.world().resource::<Bodies>().len(), 8);
}
