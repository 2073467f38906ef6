//! What users do to entities beside spawning and despawning them: nothing of it is ignored in silence.

use crate::app::{app, app_of, step_length};
use crate::common::dice::Dice;
use bevy_app::{App, TaskPoolPlugin, Update};
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_math::{Mat4, Quat, Vec3};
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy};
use bevy_transform::TransformPlugin;
use bevy_transform::components::{GlobalTransform, Transform};

fn cube(size: f32) -> ConvexMesh {
    ConvexMesh::cuboid(size, size, size).expect("a cube has a volume")
}

fn body(app: &mut App, place: Vec3) -> Entity {
    let parts = (
        RigidBody::Dynamic,
        cube(1.0),
        Transform::from_translation(place),
    );
    app.world_mut().spawn(parts).id()
}

/// A static cube in the air, and one that a bond holds to it.
fn bonded(app: &mut App) -> [Entity; 2] {
    let parts = (
        RigidBody::Static,
        cube(1.0),
        Transform::from_xyz(0.0, 5.0, 0.0),
    );
    let fixed = app.world_mut().spawn(parts).id();
    let held = body(app, Vec3::new(1.0, 5.0, 0.0));
    let mut commands = app.world_mut().commands();
    commands.bond_neighbors([fixed, held], 1e9);
    [fixed, held]
}

/// An app without physics so far.
fn bare_app() -> App {
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin::default(), TimePlugin))
        .insert_resource(Time::<Fixed>::from_duration(step_length()))
        .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    app
}

fn floor(app: &mut App) -> Entity {
    let half_space = HalfSpaceShape { normal: Vec3::Y };
    app.world_mut().spawn((RigidBody::Static, half_space)).id()
}

fn steps(app: &mut App, count: usize) {
    (0..count).for_each(|_| app.update());
}

fn place(app: &App, entity: Entity) -> Vec3 {
    app.world()
        .get::<Transform>(entity)
        .expect("a body")
        .translation
}

fn count(app: &App) -> usize {
    app.world().resource::<Bodies>().len()
}

fn issues(app: &App, entity: Entity) -> Vec<String> {
    let issues = app.world().get::<BodyIssues>(entity);
    let issues = issues.map(|issues| issues.iter().map(ToString::to_string).collect());
    issues.unwrap_or_default()
}

#[test]
fn a_second_shape_and_a_normal_of_zero_are_named_until_they_are_mended() {
    let mut app = app();
    let entity = body(&mut app, 9.0 * Vec3::Y);
    let level = StaticMesh::from_heights(&[0.0; 4], 2, 1.0).expect("usable");
    app.world_mut().entity_mut(entity).insert(level);
    let none = HalfSpaceShape { normal: Vec3::ZERO };
    let floor = app.world_mut().spawn((RigidBody::Static, none)).id();
    steps(&mut app, 2);
    let named = [issues(&app, entity), issues(&app, floor)].map(|named| named.join(" "));
    assert!(named[0].contains("has one shape"), "{}", named[0]);
    assert!(named[1].contains("zero normal"), "{}", named[1]);
    app.world_mut().entity_mut(entity).remove::<StaticMesh>();
    let below = HalfSpaceShape { normal: Vec3::Y };
    app.world_mut().entity_mut(floor).insert(below);
    steps(&mut app, 2);
    assert_eq!(issues(&app, entity), Vec::<String>::new());
    assert_eq!(issues(&app, floor), Vec::<String>::new());
}

#[test]
fn a_body_spawned_disabled_takes_part_once_it_is_enabled() {
    for steps_before in [0, 1, 5] {
        let mut app = app();
        let entity = body(&mut app, 9.0 * Vec3::Y);
        app.world_mut().entity_mut(entity).insert(Disabled);
        steps(&mut app, steps_before);
        app.world_mut().entity_mut(entity).remove::<Disabled>();
        steps(&mut app, 30);
        assert_eq!(count(&app), 1);
        assert!(place(&app, entity).y < 8.9);
    }
}

#[test]
fn a_disabled_body_is_not_there_and_comes_back_as_it_was() {
    let mut app = app();
    let wall = app
        .world_mut()
        .spawn((
            RigidBody::Static,
            ConvexMesh::cuboid(4.0, 1.0, 4.0).expect("a wall"),
        ))
        .id();
    let ball = body(&mut app, 3.0 * Vec3::Y);
    let hanging = body(&mut app, Vec3::new(20.0, 9.0, 0.0));
    steps(&mut app, 60);
    assert!((place(&app, ball).y - 1.0).abs() < 0.01);
    let before = place(&app, hanging).y;
    for entity in [wall, hanging] {
        app.world_mut().entity_mut(entity).insert(Disabled);
    }
    steps(&mut app, 60);
    assert!(place(&app, ball).y < 0.0, "it falls through");
    assert_eq!(place(&app, hanging).y, before);
    app.world_mut().entity_mut(hanging).remove::<Disabled>();
    steps(&mut app, 1);
    assert!((place(&app, hanging).y - before).abs() < 0.2);
    app.world_mut().despawn(wall);
    steps(&mut app, 60);
    assert_eq!(count(&app), 2);
    assert!(place(&app, hanging).y < before - 4.0);
}

#[test]
fn what_changed_while_disabled_is_taken_over() {
    let mut app = app();
    floor(&mut app);
    let entity = body(&mut app, 5.0 * Vec3::Y);
    steps(&mut app, 3);
    app.world_mut().entity_mut(entity).insert(Disabled);
    steps(&mut app, 3);
    let place_now = Transform::from_xyz(3.0, 2.0, 0.0);
    app.world_mut()
        .entity_mut(entity)
        .insert((place_now, Density(10.0), cube(2.0)));
    steps(&mut app, 3);
    app.world_mut().entity_mut(entity).remove::<Disabled>();
    steps(&mut app, 120);
    assert!(place(&app, entity).distance(Vec3::new(3.0, 1.0, 0.0)) < 0.05);
    let mass = app
        .world()
        .get::<MassProperties>(entity)
        .expect("a body")
        .mass;
    assert!((mass - 80.0).abs() < 0.1);
}

#[test]
fn bonds_outlast_being_disabled() {
    let mut app = app();
    let [_, held] = bonded(&mut app);
    steps(&mut app, 30);
    app.world_mut().entity_mut(held).insert(Disabled);
    steps(&mut app, 30);
    app.world_mut().entity_mut(held).remove::<Disabled>();
    steps(&mut app, 60);
    assert_eq!(app.world().resource::<Bonds>().len(), 1);
    assert!((place(&app, held).y - 5.0).abs() < 0.05);
}

#[test]
fn a_sleeper_that_is_disabled_moves_again_when_enabled() {
    let mut app = app();
    app.insert_resource(SolverConfig {
        sleep: SleepConfig {
            enabled: true,
            ..SleepConfig::default()
        },
        ..SolverConfig::default()
    });
    let ground = floor(&mut app);
    let entity = body(&mut app, 0.5 * Vec3::Y);
    steps(&mut app, 200);
    assert!(app.world().entity(entity).contains::<Sleeping>());
    app.world_mut().entity_mut(entity).insert(Disabled);
    steps(&mut app, 2);
    assert!(!app.world().entity(entity).contains::<Sleeping>());
    app.world_mut().despawn(ground);
    steps(&mut app, 2);
    app.world_mut().entity_mut(entity).remove::<Disabled>();
    steps(&mut app, 30);
    assert!(place(&app, entity).y < 0.0);
}

#[test]
fn bodies_disabled_and_enabled_at_random_leave_nothing_behind() {
    let mut app = app();
    floor(&mut app);
    let mut dice = Dice::new(17);
    let mut entities: Vec<Entity> = Vec::new();
    for _ in 0..400 {
        if entities.len() < 30 {
            let at = Vec3::new(dice.in_range(-2.0, 2.0), 6.0, dice.in_range(-2.0, 2.0));
            let entity = body(&mut app, at);
            let glass = Fracturable::with_strength(300.0);
            app.world_mut().entity_mut(entity).insert(glass);
            entities.push(entity);
        }
        let at = dice.below(entities.len());
        let entity = entities[at];
        if app.world().get_entity(entity).is_err() {
            entities.swap_remove(at);
            continue;
        }
        let mut entity = app.world_mut().entity_mut(entity);
        match dice.below(5) {
            0 => drop(entity.insert(Disabled)),
            1 => drop(entity.remove::<Disabled>()),
            2 => drop(entity.insert([RigidBody::Static, RigidBody::Dynamic][dice.below(2)])),
            3 => {
                entities.swap_remove(at);
                entity.despawn();
            }
            _ => {}
        }
        app.update();
    }
    let mut all = app.world_mut().query::<(&BodyHandle, Has<Disabled>)>();
    let found: Vec<_> = all.iter(app.world()).collect();
    let bodies = app.world().resource::<Bodies>();
    assert_eq!(
        found
            .iter()
            .filter(|(handle, _)| handle.get().is_some())
            .count(),
        bodies.len()
    );
    for (handle, is_disabled) in found {
        if let Some((slot, id)) = handle.get() {
            assert!(bodies.is_current(slot, id));
            assert!(
                !is_disabled || !bodies.is_active(slot),
                "a disabled body collides"
            );
        }
    }
}

#[test]
fn scale_that_is_rounding_is_none_and_other_scales_scale_the_shape() {
    let mut dice = Dice::new(23);
    let mut app = app();
    let turned: Vec<Entity> = (0..100)
        .map(|i| {
            let at = Vec3::new(3.0 * i as f32, 0.0, 0.0);
            let matrix = Mat4::from_rotation_translation(dice.rotation(), at);
            let parts = (
                RigidBody::Dynamic,
                cube(1.0),
                Transform::from_matrix(matrix),
            );
            app.world_mut().spawn(parts).id()
        })
        .collect();
    steps(&mut app, 30);
    assert!(turned.iter().all(|&entity| place(&app, entity).y < -1.0));

    let mut app = self::app();
    floor(&mut app);
    let scale = Vec3::new(2.0, 3.0, 0.5);
    let big = body(&mut app, 4.0 * Vec3::Y);
    app.world_mut()
        .get_mut::<Transform>(big)
        .expect("a body")
        .scale = scale;
    steps(&mut app, 120);
    let transform = *app.world().get::<Transform>(big).expect("a body");
    assert!(
        (transform.translation.y - 1.5).abs() < 0.02,
        "{transform:?}"
    );
    assert_eq!(transform.scale, scale);
    let mass = |app: &App| app.world().get::<MassProperties>(big).expect("a body").mass;
    assert!((mass(&app) - 3000.0).abs() < 1.0);
    app.world_mut()
        .get_mut::<Transform>(big)
        .expect("a body")
        .scale = Vec3::ONE;
    steps(&mut app, 120);
    assert!((place(&app, big).y - 0.5).abs() < 0.02);
    assert!((mass(&app) - 1000.0).abs() < 1.0);
}

#[test]
fn scales_that_make_no_shape_are_issues_until_they_are_mended() {
    for bad in [Vec3::ZERO, Vec3::NAN, Vec3::new(-1.0, 1.0, 1.0)] {
        let mut app = app();
        let entity = body(&mut app, Vec3::ZERO);
        app.world_mut()
            .get_mut::<Transform>(entity)
            .expect("a body")
            .scale = bad;
        steps(&mut app, 3);
        assert_eq!(issues(&app, entity).len(), 1, "{bad}");
        assert_eq!(place(&app, entity), Vec3::ZERO);
        app.world_mut()
            .get_mut::<Transform>(entity)
            .expect("a body")
            .scale = 2.0 * Vec3::ONE;
        steps(&mut app, 30);
        assert!(issues(&app, entity).is_empty());
        assert!(place(&app, entity).y < -0.5);
    }
}

#[test]
fn children_rest_where_the_floor_is_whatever_their_parents_are() {
    let mut dice = Dice::new(31);
    for size in [1.0, 0.5, 2.0] {
        for depth in 1..4 {
            let mut app = bare_app();
            app.add_plugins((CleavePlugin::default(), TransformPlugin));
            floor(&mut app);
            let mut parent = None;
            for _ in 0..depth {
                let turn = Quat::from_rotation_y(dice.in_range(-3.0, 3.0));
                let place = Transform::from_translation(dice.vector(-3.0, 3.0)).with_rotation(turn);
                let entity = app.world_mut().spawn(place).id();
                if let Some(parent) = parent {
                    app.world_mut().entity_mut(entity).insert(ChildOf(parent));
                }
                parent = Some(entity);
            }
            let parent = parent.expect("there is one");
            app.world_mut()
                .get_mut::<Transform>(parent)
                .expect("it has one")
                .scale = Vec3::splat(size);
            let entity = body(&mut app, Vec3::new(0.0, 9.0 / size, 0.0));
            app.world_mut().entity_mut(entity).insert(ChildOf(parent));
            // A parent that moves does not carry what is dynamic.
            for _ in 0..200 {
                app.world_mut()
                    .get_mut::<Transform>(parent)
                    .expect("it has one")
                    .translation
                    .x += 0.01;
                app.update();
            }
            steps(&mut app, 2);
            let global = app.world().get::<GlobalTransform>(entity).expect("a child");
            let y = global.translation().y;
            assert!(
                (y - 0.5 * size).abs() < 0.02,
                "size {size}, depth {depth}: {y}"
            );
            assert!(issues(&app, entity).is_empty());
        }
    }
}

#[test]
fn fixed_children_go_with_their_parents_and_sheared_ones_are_named() {
    let mut app = app();
    let lift = app
        .world_mut()
        .spawn(Transform::from_xyz(0.0, 1.0, 0.0))
        .id();
    let plate = ConvexMesh::cuboid(4.0, 0.2, 4.0).expect("a plate");
    app.world_mut()
        .spawn((RigidBody::Kinematic, plate, ChildOf(lift)));
    let load = body(&mut app, Vec3::new(0.0, 1.6, 0.0));
    steps(&mut app, 20);
    for _ in 0..60 {
        app.world_mut()
            .get_mut::<Transform>(lift)
            .expect("it has one")
            .translation += Vec3::ONE / 60.0;
        app.update();
    }
    assert!(
        place(&app, load).distance(Vec3::new(1.0, 2.6, 1.0)) < 0.15,
        "{}",
        place(&app, load)
    );

    let skewed = Transform::from_scale(Vec3::new(1.0, 3.0, 1.0));
    let parent = app.world_mut().spawn(skewed).id();
    let turned = Transform::from_rotation(Quat::from_rotation_z(0.5));
    let parts = (RigidBody::Dynamic, cube(1.0), turned, ChildOf(parent));
    let entity = app.world_mut().spawn(parts).id();
    steps(&mut app, 2);
    assert_eq!(issues(&app, entity).len(), 1);
    app.world_mut()
        .entity_mut(parent)
        .insert(Transform::IDENTITY);
    steps(&mut app, 2);
    assert!(issues(&app, entity).is_empty());
}

#[test]
fn a_platform_moved_by_its_transform_carries_and_lifts() {
    for per_second in [Vec3::X, Vec3::Y, 5.0 * Vec3::Y, Vec3::new(-0.5, -0.5, 1.0)] {
        let mut app = app();
        let plate = ConvexMesh::cuboid(4.0, 0.2, 4.0).expect("a plate");
        let at = Transform::from_xyz(0.0, -0.1, 0.0);
        let lift = app
            .world_mut()
            .spawn((RigidBody::Kinematic, plate, at))
            .id();
        let parts = (
            RigidBody::Dynamic,
            cube(0.5),
            Transform::from_xyz(0.0, 0.25, 0.0),
        );
        let load = app.world_mut().spawn(parts).id();
        steps(&mut app, 5);
        for _ in 0..60 {
            app.world_mut()
                .get_mut::<Transform>(lift)
                .expect("it has one")
                .translation += per_second / 60.0;
            app.update();
        }
        let expected = per_second + 0.25 * Vec3::Y;
        assert!(
            // It slips until friction has given it the platform's speed.
            place(&app, load).distance(expected) < 0.25,
            "{} {expected}",
            place(&app, load)
        );
        assert!(place(&app, lift).distance(per_second - 0.1 * Vec3::Y) < 1e-4);
    }
}

#[test]
fn a_platform_that_turns_carries_and_one_that_jumps_pushes_nobody() {
    let mut app = app();
    let disc = ConvexMesh::regular_prism(24, 3.0, 0.2).expect("a disc");
    let disc = app
        .world_mut()
        .spawn((RigidBody::Kinematic, disc, Transform::IDENTITY))
        .id();
    let parts = (
        RigidBody::Dynamic,
        cube(0.4),
        Transform::from_xyz(1.5, 0.31, 0.0),
    );
    let load = app.world_mut().spawn(parts).id();
    steps(&mut app, 5);
    for i in 1..=120 {
        let turn = Quat::from_rotation_y(0.01 * i as f32);
        app.world_mut()
            .get_mut::<Transform>(disc)
            .expect("it has one")
            .rotation = turn;
        app.update();
    }
    let expected = Quat::from_rotation_y(1.2) * Vec3::new(1.5, 0.0, 0.0);
    let found = place(&app, load).with_y(0.0);
    assert!(found.distance(expected) < 0.1, "{found} {expected}");
    app.world_mut()
        .get_mut::<Transform>(disc)
        .expect("it has one")
        .translation
        .x = 100.0;
    steps(&mut app, 2);
    let speed = app
        .world()
        .get::<LinearVelocity>(load)
        .expect("a body")
        .0
        .length();
    assert!(speed < 3.0, "{speed}");
}

#[test]
fn another_kind_keeps_identity_bonds_and_contacts() {
    for kind in [RigidBody::Kinematic, RigidBody::Static] {
        let mut app = app();
        let [fixed, held] = bonded(&mut app);
        steps(&mut app, 60);
        let handle = |app: &App| app.world().get::<BodyHandle>(fixed).expect("a body").get();
        let before = handle(&app);
        app.world_mut().entity_mut(fixed).insert(kind);
        steps(&mut app, 60);
        assert_eq!(handle(&app), before);
        assert_eq!(app.world().resource::<Bonds>().len(), 1);
        assert!((place(&app, held).y - 5.0).abs() < 0.05);
        app.world_mut().entity_mut(fixed).insert(RigidBody::Dynamic);
        steps(&mut app, 60);
        assert!(place(&app, held).y < 2.0, "both fall");
        assert_eq!(app.world().resource::<Bonds>().len(), 1);
        app.world_mut().entity_mut(fixed).remove::<RigidBody>();
        steps(&mut app, 2);
        assert_eq!(count(&app), 1);
    }
}

#[test]
fn bodies_may_come_before_the_plugin() {
    let mut app = bare_app();
    let early = body(&mut app, 9.0 * Vec3::Y);
    let hidden = body(&mut app, Vec3::new(-5.0, 7.0, 0.0));
    app.world_mut()
        .entity_mut(hidden)
        .insert((Disabled, GravityScale(0.0)));
    let lone = app.world_mut().spawn(cube(1.0)).id();
    app.add_plugins(CleavePlugin::default());
    let late = body(&mut app, Vec3::new(5.0, 9.0, 0.0));
    steps(&mut app, 30);
    assert_eq!(count(&app), 2);
    assert_eq!(place(&app, early).y, place(&app, late).y);
    assert!(place(&app, late).y < 8.9);
    app.world_mut().entity_mut(hidden).remove::<Disabled>();
    steps(&mut app, 10);
    assert_eq!((count(&app), place(&app, hidden).y), (3, 7.0));
    assert_eq!(issues(&app, lone).len(), 1);
    app.world_mut().entity_mut(lone).insert(RigidBody::Dynamic);
    steps(&mut app, 2);
    assert!(issues(&app, lone).is_empty());
}

#[test]
fn an_app_without_time_or_pool_runs() {
    let mut app = App::new();
    app.add_plugins(CleavePlugin::new(Update));
    let entity = body(&mut app, Vec3::ZERO);
    steps(&mut app, 3);
    assert_eq!(place(&app, entity), Vec3::ZERO);
    let mut app = app_of(CleavePlugin::default());
    app.world_mut().remove_resource::<Time>();
    app.world_mut().run_schedule(PhysicsSchedule);
}

#[test]
fn what_does_nothing_is_an_issue() {
    let mut app = app();
    let shot = LinearVelocity(Vec3::X);
    let fixed = app
        .world_mut()
        .spawn((RigidBody::Static, cube(1.0), shot))
        .id();
    let glass = Fracturable::with_strength(1.0);
    let whole = Fracturable {
        max_pieces: 1,
        ..glass.clone()
    };
    let pane = Transform::from_xyz(5.0, 0.0, 0.0);
    let pane = app
        .world_mut()
        .spawn((RigidBody::Static, cube(1.0), pane, whole))
        .id();
    let ground = app
        .world_mut()
        .spawn((RigidBody::Static, HalfSpaceShape { normal: Vec3::Y }, glass))
        .id();
    let empty = app.world_mut().spawn(RigidBody::Dynamic).id();
    steps(&mut app, 3);
    for entity in [fixed, pane, ground, empty] {
        assert_eq!(issues(&app, entity).len(), 1, "{:?}", issues(&app, entity));
    }
    assert_eq!(app.world().get::<LinearVelocity>(fixed), Some(&shot));
    app.world_mut()
        .entity_mut(fixed)
        .insert(LinearVelocity::default());
    app.world_mut()
        .entity_mut(pane)
        .insert(Fracturable::default());
    app.world_mut().entity_mut(ground).remove::<Fracturable>();
    app.world_mut().entity_mut(empty).insert(cube(1.0));
    steps(&mut app, 3);
    for entity in [fixed, pane, ground, empty] {
        assert!(
            issues(&app, entity).is_empty(),
            "{:?}",
            issues(&app, entity)
        );
    }
}
