//! Sleep through the plugin: the `Sleeping` mark, and all that wakes an entity.

use crate::app::{app, bits_of_entity, step_length};
use crate::common::states::bits;
use crate::common::structures::{block, cuboid, floor, tower};
use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::Vec3;

/// An app with sleep on and a scene in it; its entities in order.
fn sleepy(scene: Vec<BodyDesc>) -> (App, Vec<Entity>) {
    let mut app = app();
    let entities = put_to_rest(&mut app, scene);
    (app, entities)
}

/// Turns sleep on and spawns a scene; its entities in order.
fn put_to_rest(app: &mut App, scene: Vec<BodyDesc>) -> Vec<Entity> {
    app.world_mut().resource_mut::<SolverConfig>().sleep = SleepConfig::default();
    let spawn = |desc| app.world_mut().spawn_body(desc);
    scene.into_iter().map(spawn).collect()
}

/// A floor and a tower of three, asleep.
fn asleep() -> (App, Vec<Entity>) {
    let (mut app, entities) = sleepy(tower(3));
    update(&mut app, 90);
    assert_eq!(sleeping(&mut app), 3);
    (app, entities)
}

fn update(app: &mut App, steps: usize) {
    (0..steps).for_each(|_| app.update());
}

fn sleeping(app: &mut App) -> usize {
    let mut query = app.world_mut().query_filtered::<(), With<Sleeping>>();
    query.iter(app.world()).count()
}

/// All that slept are awake after the next step, also by their mark.
fn assert_all_awake(app: &mut App) {
    app.update();
    assert_eq!(sleeping(app), 0);
    assert_eq!(app.world().resource::<StepReport>().asleep, 0);
}

fn height(app: &App, entity: Entity) -> f32 {
    let transform = app.world().get::<Transform>(entity);
    transform.expect("a body has one").translation.y
}

#[derive(Resource, Default)]
struct ChangesSeen(usize);

type Written = Or<(Changed<Transform>, Changed<LinearVelocity>)>;

fn count_changes(changed: Query<(), Written>, mut seen: ResMut<ChangesSeen>) {
    seen.0 += changed.iter().count();
}

#[test]
fn the_mark_tells_who_sleeps_and_nothing_of_them_is_written() {
    let (mut app, entities) = asleep();
    let report = app.world().resource::<StepReport>().clone();
    assert_eq!((report.awake, report.asleep), (0, 3));
    assert!(
        app.world().get::<Sleeping>(entities[0]).is_none(),
        "the floor does not sleep"
    );
    let state = |app: &App| -> Vec<_> {
        let entities = entities.iter();
        entities.map(|&e| bits_of_entity(app.world(), e)).collect()
    };
    let before = state(&app);
    let velocity = app.world().get::<LinearVelocity>(entities[2]);
    assert_eq!(velocity, Some(&LinearVelocity(Vec3::ZERO)));
    app.init_resource::<ChangesSeen>()
        .add_systems(bevy_app::Last, count_changes);
    app.update();
    app.world_mut().resource_mut::<ChangesSeen>().0 = 0;
    update(&mut app, 100);
    assert_eq!(state(&app), before);
    assert_eq!(app.world().resource::<ChangesSeen>().0, 0);
}

#[test]
fn plugin_and_plain_step_sleep_and_wake_alike() {
    let mut app = app();
    let entities = put_to_rest(&mut app, tower(5));
    let mut simulation = Simulation::default();
    simulation.config.sleep = SleepConfig::default();
    for desc in tower(5) {
        simulation.bodies.insert(desc).expect("usable");
    }
    for step in 0..300 {
        if step == 100 {
            let push = LinearVelocity(Vec3::new(0.3, 0.0, 0.2));
            app.world_mut().entity_mut(entities[4]).insert(push);
            simulation
                .bodies
                .set_velocity(4, push.0, Vec3::ZERO)
                .expect("usable");
        }
        app.update();
        simulation.step(step_length().as_secs_f32());
        let report = app.world().resource::<StepReport>();
        assert_eq!(report, &simulation.report, "step {step}");
        for (slot, &entity) in (0..).zip(&entities) {
            let (v, w) = simulation.bodies.velocity(slot);
            let plain = bits(&simulation.bodies.pose(slot), v, w);
            assert_eq!(bits_of_entity(app.world(), entity), plain, "step {step}");
        }
    }
    assert_eq!(simulation.report.asleep, 5);
}

#[test]
fn taking_the_mark_off_wakes_the_island() {
    let (mut app, entities) = asleep();
    app.world_mut().entity_mut(entities[2]).remove::<Sleeping>();
    assert_all_awake(&mut app);
}

#[test]
fn a_mark_spares_the_wait_but_does_not_hold_what_falls() {
    let falling = block(&cuboid(Vec3::ONE), Vec3::new(9.0, 5.0, 0.0), 0.6);
    let (mut app, entities) = sleepy(tower(2).into_iter().chain([falling]).collect());
    for &entity in &entities {
        app.world_mut().entity_mut(entity).insert(Sleeping);
    }
    update(&mut app, 2);
    let is_marked = |entity: &Entity| app.world().get::<Sleeping>(*entity).is_some();
    let marks: Vec<bool> = entities.iter().map(is_marked).collect();
    assert_eq!(marks, [false, true, true, false]);
    update(&mut app, 20);
    assert!(height(&app, entities[3]) < 4.6);
}

#[test]
fn a_mark_that_comes_after_the_body_spares_the_wait_too() {
    let (mut app, entities) = sleepy(tower(2));
    update(&mut app, 15);
    assert_eq!(sleeping(&mut app), 0);
    for &entity in &entities[1..] {
        app.world_mut().entity_mut(entity).insert(Sleeping);
    }
    app.update();
    assert_eq!(sleeping(&mut app), 2);
    assert_eq!(app.world().resource::<StepReport>().asleep, 2);
}

#[test]
fn with_sleep_off_no_mark_stays() {
    let (mut app, entities) = sleepy(tower(2));
    app.world_mut().resource_mut::<SolverConfig>().sleep.enabled = false;
    app.world_mut().entity_mut(entities[1]).insert(Sleeping);
    assert_all_awake(&mut app);
}

#[test]
fn a_velocity_or_a_pose_from_outside_wakes() {
    let (mut app, entities) = asleep();
    let mut entity = app.world_mut().entity_mut(entities[3]);
    entity.get_mut::<LinearVelocity>().expect("a body").0 = 2.0 * Vec3::X;
    assert_all_awake(&mut app);
    let moved = app.world().get::<Transform>(entities[3]).expect("a body");
    assert!(moved.translation.x > 0.01, "the first step is written");

    let (mut app, entities) = asleep();
    let mut entity = app.world_mut().entity_mut(entities[3]);
    entity.get_mut::<Transform>().expect("a body").translation.y = 5.0;
    assert_all_awake(&mut app);
}

#[test]
fn touching_a_component_without_changing_it_does_not_wake() {
    let (mut app, entities) = asleep();
    for &entity in &entities {
        let mut entity = app.world_mut().entity_mut(entity);
        entity.get_mut::<Transform>().expect("a body").set_changed();
        entity
            .get_mut::<LinearVelocity>()
            .expect("a body")
            .set_changed();
        entity.get_mut::<Friction>().expect("a body").set_changed();
    }
    app.update();
    assert_eq!(sleeping(&mut app), 3);
}

#[test]
fn materials_shapes_and_layers_wake() {
    let other_layer = CollisionLayers {
        memberships: 2,
        ..Default::default()
    };
    let lower = cuboid(Vec3::new(1.0, 0.9, 1.0));
    let breakable = Fracturable {
        strength: 1e3,
        ..Default::default()
    };
    let changes: [&dyn Fn(&mut EntityWorldMut); 7] = [
        &|entity| _ = entity.insert(Friction::new(0.2)),
        &|entity| _ = entity.insert(Restitution::new(0.3)),
        &|entity| _ = entity.insert(breakable.clone()),
        &|entity| {
            let mut mass = *entity.get::<MassProperties>().expect("a body");
            mass.mass *= 1.5;
            entity.insert(MassOverride(mass));
        },
        &|entity| _ = entity.insert(Density(300.0)),
        &|entity| _ = entity.insert(lower.clone()),
        &|entity| _ = entity.insert(other_layer),
    ];
    for change in changes {
        let (mut app, entities) = asleep();
        change(&mut app.world_mut().entity_mut(entities[2]));
        assert_all_awake(&mut app);
    }
}

#[test]
fn despawning_a_body_or_the_floor_wakes() {
    for gone in [0, 1] {
        let (mut app, entities) = asleep();
        app.world_mut().despawn(entities[gone]);
        assert_all_awake(&mut app);
        update(&mut app, 20);
        assert!(height(&app, entities[3]) < 2.3, "it falls");
    }
}

#[test]
fn another_kind_wakes() {
    let (mut app, entities) = asleep();
    app.world_mut()
        .entity_mut(entities[1])
        .insert(RigidBody::Kinematic);
    assert_all_awake(&mut app);
    update(&mut app, 90);
    assert_eq!(sleeping(&mut app), 2, "the others rest on it");
    app.world_mut()
        .entity_mut(entities[1])
        .insert(RigidBody::Static);
    assert_all_awake(&mut app);
}

#[test]
fn a_cut_wakes_and_pieces_are_not_marked() {
    let (mut app, entities) = asleep();
    let plane = Plane::through(1.5 * Vec3::Y, Vec3::Y);
    app.world_mut().commands().slice(entities[2], plane);
    app.update();
    assert_all_awake(&mut app);
    update(&mut app, 90);
    assert_eq!(sleeping(&mut app), 4);
}

#[test]
fn entities_that_take_the_place_of_sleeping_ones_are_awake() {
    let (mut app, entities) = asleep();
    for &entity in &entities[1..] {
        app.world_mut().despawn(entity);
    }
    for desc in tower(3).into_iter().skip(1) {
        app.world_mut().spawn_body(desc);
    }
    app.update();
    assert_eq!(sleeping(&mut app), 0);
    update(&mut app, 90);
    assert_eq!(sleeping(&mut app), 3);
}

#[test]
fn a_clone_of_a_sleeping_entity_is_a_body_of_its_own() {
    let (mut app, entities) = asleep();
    let mut top = app.world_mut().entity_mut(entities[3]);
    let clone = top.clone_and_spawn();
    let mut clone = app.world_mut().entity_mut(clone);
    clone.get_mut::<Transform>().expect("cloned").translation = Vec3::new(7.0, 4.0, 0.0);
    let clone = clone.id();
    update(&mut app, 30);
    assert_eq!(sleeping(&mut app), 3, "those far off sleep on");
    assert!(height(&app, clone) < 3.0, "it falls");
}

#[test]
fn without_sleep_nothing_is_marked() {
    let mut app = app();
    app.world_mut().resource_mut::<SolverConfig>().sleep = SleepConfig::off();
    for desc in [floor(0.6), block(&cuboid(Vec3::ONE), 0.5 * Vec3::Y, 0.6)] {
        app.world_mut().spawn_body(desc);
    }
    update(&mut app, 120);
    assert_eq!(sleeping(&mut app), 0);
}
