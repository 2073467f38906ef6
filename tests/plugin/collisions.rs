//! Events of contacts: each begins once and ends once, whatever happens to the bodies in between.

use crate::app::{app, bits_of_entity};
use crate::common::dice::Dice;
use bevy_app::{App, FixedUpdate, Update};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_math::{Quat, Vec3};
use bevy_time::TimeUpdateStrategy;
use bevy_transform::components::Transform;

/// What was told, by message and by entity event.
#[derive(Resource, Default, Debug)]
struct Heard {
    starts: Vec<CollisionStart>,
    ends: Vec<CollisionEnd>,
    forces: Vec<ContactForce>,
    entity_starts: Vec<CollisionStart>,
    entity_ends: Vec<CollisionEnd>,
    entity_forces: usize,
}

fn listen(
    mut heard: ResMut<Heard>,
    mut starts: MessageReader<CollisionStart>,
    mut ends: MessageReader<CollisionEnd>,
    mut forces: MessageReader<ContactForce>,
) {
    heard.starts.extend(starts.read());
    heard.ends.extend(ends.read());
    heard.forces.extend(forces.read());
}

/// An app that listens in a schedule of every frame.
fn listening() -> App {
    let mut app = app();
    app.init_resource::<Heard>()
        .add_systems(Update, listen)
        .add_observer(|start: On<CollisionStart>, mut heard: ResMut<Heard>| {
            heard.entity_starts.push(*start);
        })
        .add_observer(|end: On<CollisionEnd>, mut heard: ResMut<Heard>| {
            heard.entity_ends.push(*end);
        })
        .add_observer(|_: On<ContactForce>, mut heard: ResMut<Heard>| {
            heard.entity_forces += 1;
        });
    app.world_mut().resource_mut::<SolverConfig>().sleep = SleepConfig::off();
    app
}

/// The same, with bodies that fall asleep.
fn listening_with_sleep() -> App {
    let mut app = listening();
    app.insert_resource(SolverConfig::default());
    app
}

fn floor(app: &mut App) -> Entity {
    let half_space = HalfSpaceShape { normal: Vec3::Y };
    app.world_mut().spawn((RigidBody::Static, half_space)).id()
}

fn cube(size: f32) -> ConvexMesh {
    ConvexMesh::cuboid(size, size, size).expect("a cube has a volume")
}

fn steps(app: &mut App, count: usize) {
    (0..count).for_each(|_| app.update());
}

fn heard(app: &App) -> &Heard {
    app.world().resource::<Heard>()
}

#[test]
fn cubes_that_fall_begin_to_touch_once_with_the_speed_of_their_fall() {
    let mut app = listening();
    let floor = floor(&mut app);
    let mut dice = Dice::new(5);
    let mut cubes = Vec::new();
    for i in 0..30 {
        let height = dice.in_range(0.2, 6.0);
        let place = Transform::from_xyz(3.0 * i as f32, 0.5 + height, 0.0);
        let parts = (RigidBody::Dynamic, cube(1.0), place, CollisionEvents);
        cubes.push((app.world_mut().spawn(parts).id(), height));
    }
    steps(&mut app, 400);
    for (entity, height) in cubes {
        let of = |start: &&CollisionStart| start.entity == entity;
        let starts: Vec<_> = heard(&app).starts.iter().filter(of).collect();
        let [start] = starts[..] else {
            panic!("{height} m: {starts:?}");
        };
        assert_eq!(start.other, floor);
        let speed = (2.0 * 9.81 * height).sqrt();
        assert!(
            (start.approach_speed - speed).abs() < 0.25,
            "{start:?}, {speed} m/s"
        );
        assert!(
            start.impulse > 900.0 * (speed - 0.25),
            "{start:?}, {speed} m/s"
        );
        assert!(start.normal.distance(Vec3::NEG_Y) < 1e-5);
        assert!(start.point.y.abs() < 0.02, "{start:?}");
    }
    let heard = heard(&app);
    assert_eq!(heard.ends, [], "who lies goes on touching");
    assert_eq!(heard.starts, heard.entity_starts);
}

#[test]
fn both_who_ask_get_an_event_and_the_pair_one_message() {
    let mut app = listening();
    floor(&mut app);
    let at = |y: f32| Transform::from_xyz(0.0, y, 0.0);
    let parts = |y| (RigidBody::Dynamic, cube(1.0), at(y), CollisionEvents);
    let lower = app.world_mut().spawn(parts(0.5)).id();
    let upper = app.world_mut().spawn(parts(2.0)).id();
    steps(&mut app, 120);
    let pair = |start: &&CollisionStart| [start.entity, start.other].contains(&upper);
    let messages: Vec<_> = heard(&app).starts.iter().filter(pair).collect();
    let events: Vec<_> = heard(&app).entity_starts.iter().filter(pair).collect();
    assert_eq!(messages.len(), 1);
    assert_eq!(events.len(), 2);
    assert_eq!([events[0].entity, events[1].entity], [lower, upper]);
    assert_eq!(events[0].normal, -events[1].normal);
    app.world_mut().despawn(lower);
    steps(&mut app, 2);
    let ends = &heard(&app).ends;
    assert_eq!(ends.len(), 2, "with the floor and with the upper one");
    assert!(
        heard(&app)
            .entity_ends
            .iter()
            .all(|end| end.entity == upper)
    );
}

#[test]
fn sleep_ends_no_contact_and_waking_begins_none() {
    let mut app = listening_with_sleep();
    let floor = floor(&mut app);
    let mut tower = Vec::new();
    for level in 0..4 {
        let place = Transform::from_xyz(0.0, 0.5 + level as f32, 0.0);
        let parts = (RigidBody::Dynamic, cube(1.0), place, CollisionEvents);
        tower.push(app.world_mut().spawn(parts).id());
    }
    steps(&mut app, 240);
    assert_eq!(app.world().resource::<StepReport>().asleep, 4);
    assert_eq!(heard(&app).starts.len(), 4);
    app.world_mut().entity_mut(tower[2]).remove::<Sleeping>();
    steps(&mut app, 240);
    assert_eq!(app.world().resource::<StepReport>().asleep, 4);
    assert_eq!((heard(&app).starts.len(), heard(&app).ends.len()), (4, 0));
    app.world_mut().despawn(floor);
    steps(&mut app, 3);
    let ends = &heard(&app).ends;
    assert_eq!(
        ends[..],
        [CollisionEnd {
            entity: tower[0],
            other: floor
        }]
    );
}

#[test]
fn who_asks_late_hears_of_what_touches_and_who_stops_asking_of_nothing() {
    let mut app = listening();
    floor(&mut app);
    let place = Transform::from_xyz(0.0, 0.5, 0.0);
    let parts = (RigidBody::Dynamic, cube(1.0), place);
    let body = app.world_mut().spawn(parts).id();
    steps(&mut app, 60);
    assert!(heard(&app).starts.is_empty());
    app.world_mut().entity_mut(body).insert(CollisionEvents);
    steps(&mut app, 2);
    assert_eq!(heard(&app).starts.len(), 1);
    app.world_mut().entity_mut(body).remove::<CollisionEvents>();
    steps(&mut app, 2);
    app.world_mut().despawn(body);
    steps(&mut app, 3);
    assert_eq!(heard(&app).ends, []);
    let contacts = app.world().resource::<Contacts>();
    assert_eq!(contacts.events().news(), []);
}

#[test]
fn a_cut_ends_the_contacts_of_the_parent_and_begins_those_of_its_pieces() {
    let mut app = listening();
    let floor = floor(&mut app);
    let place = Transform::from_xyz(0.0, 0.5, 0.0);
    let parts = (RigidBody::Dynamic, cube(1.0), place, CollisionEvents);
    let body = app.world_mut().spawn(parts).id();
    steps(&mut app, 60);
    let plane = Plane::through(place.translation, Vec3::X);
    app.world_mut().commands().slice(body, plane);
    steps(&mut app, 30);
    let heard = heard(&app);
    assert_eq!(
        heard.ends[0],
        CollisionEnd {
            entity: body,
            other: floor
        }
    );
    let with_floor = |start: &&CollisionStart| start.other == floor || start.entity == floor;
    let starts = heard.starts.iter().filter(with_floor);
    assert_eq!(starts.count(), 3, "the parent and two pieces: {heard:?}");
    assert_eq!(heard.ends.len(), 1);
}

#[test]
fn a_load_crosses_its_threshold_once_and_bears_the_weight() {
    let mut app = listening();
    floor(&mut app);
    let place = Transform::from_xyz(0.0, 0.6, 0.0);
    let limit = ContactForceEvents { threshold: 9000.0 };
    app.world_mut()
        .spawn((RigidBody::Dynamic, cube(1.0), place, limit));
    let above = Transform::from_xyz(3.0, 0.6, 0.0);
    let limit = ContactForceEvents { threshold: 1e6 };
    app.world_mut()
        .spawn((RigidBody::Dynamic, cube(1.0), above, limit));
    steps(&mut app, 200);
    let forces = &heard(&app).forces;
    assert_eq!(forces.len(), heard(&app).entity_forces);
    assert!(forces.len() > 100);
    let crossings = forces.iter().filter(|force| force.is_crossing).count();
    assert!((1..4).contains(&crossings), "{crossings}");
    assert!(forces[0].is_crossing && forces[0].approach_speed > 1.0);
    let last = forces.last().expect("there are some");
    assert!(
        !last.is_crossing && (last.force - 9810.0).abs() < 100.0,
        "{last:?}"
    );
    assert!((last.impulse * 60.0 - last.force).abs() < 1.0);
}

#[test]
fn sensors_tell_who_is_inside_and_change_no_bit() {
    let fall = |with_sensor: bool| {
        let mut app = listening();
        floor(&mut app);
        if with_sensor {
            let zone = Transform::from_xyz(0.0, 4.0, 0.0);
            app.world_mut()
                .spawn((RigidBody::Static, cube(2.0), zone, Sensor));
        }
        let mut dice = Dice::new(3);
        let bodies = [0, 1, 2].map(|i| {
            let turn = Quat::from_rotation_x(dice.in_range(0.0, 3.0));
            let place = Transform::from_xyz(0.0, 8.0 + 2.0 * i as f32, 0.0).with_rotation(turn);
            app.world_mut()
                .spawn((RigidBody::Dynamic, cube(1.0), place))
                .id()
        });
        steps(&mut app, 300);
        let bits = bodies.map(|body| bits_of_entity(app.world(), body));
        (bits, heard(&app).starts.len(), heard(&app).ends.len())
    };
    let (with, starts, ends) = fall(true);
    let (without, none, _) = fall(false);
    assert_eq!(with, without);
    assert_eq!((starts, ends, none), (3, 3, 0));
}

#[test]
fn sensors_see_all_that_moves_and_what_flies_through() {
    let mut app = listening();
    app.insert_resource(Gravity(Vec3::ZERO));
    let wall = ConvexMesh::cuboid(0.02, 4.0, 4.0).expect("a wall has a volume");
    let gate = app
        .world_mut()
        .spawn((RigidBody::Static, wall, Sensor))
        .id();
    let fast = LinearVelocity(Vec3::new(300.0, 0.0, 0.0));
    let place = Transform::from_xyz(-12.0, 0.0, 0.0);
    let bullet = app
        .world_mut()
        .spawn((RigidBody::Dynamic, cube(0.1), place, fast))
        .id();
    let slow = LinearVelocity(Vec3::new(2.0, 0.0, 0.0));
    let place = Transform::from_xyz(-1.0, 1.0, 0.0);
    let lift = app
        .world_mut()
        .spawn((RigidBody::Kinematic, cube(0.5), place, slow))
        .id();
    // What is static is no news, nor what another layer keeps out.
    let aside = Transform::from_xyz(0.0, 0.0, 1.5);
    app.world_mut().spawn((RigidBody::Static, cube(0.5), aside));
    let layers = CollisionLayers {
        memberships: 2,
        filters: 2,
    };
    let place = Transform::from_xyz(-1.0, -1.0, 0.0);
    app.world_mut()
        .spawn((RigidBody::Dynamic, cube(0.5), place, slow, layers));
    steps(&mut app, 120);
    for other in [bullet, lift] {
        let starts = heard(&app).starts.iter();
        let starts = starts
            .filter(|s| [s.entity, s.other] == [gate, other])
            .count();
        let ends = heard(&app).ends.iter();
        let ends = ends
            .filter(|e| [e.entity, e.other] == [gate, other])
            .count();
        assert_eq!((starts, ends), (1, 1));
    }
    assert_eq!(heard(&app).starts.len(), 2);
}

#[test]
fn a_sleeper_stays_inside_a_sensor_and_a_water_level_sees_who_is_below() {
    let mut app = listening_with_sleep();
    floor(&mut app);
    let water = Transform::from_xyz(0.0, 1.5, 0.0);
    let surface = HalfSpaceShape { normal: Vec3::Y };
    app.world_mut()
        .spawn((RigidBody::Static, surface, water, Sensor));
    let place = Transform::from_xyz(0.0, 4.0, 0.0);
    let body = app
        .world_mut()
        .spawn((RigidBody::Dynamic, cube(1.0), place))
        .id();
    steps(&mut app, 300);
    assert!(app.world().entity(body).contains::<Sleeping>());
    assert_eq!((heard(&app).starts.len(), heard(&app).ends.len()), (1, 0));
    app.world_mut().despawn(body);
    steps(&mut app, 2);
    assert_eq!(heard(&app).ends.len(), 1);
}

#[test]
fn a_body_becomes_a_sensor_and_a_body_again() {
    let mut app = listening();
    let plate = Transform::from_xyz(0.0, -0.5, 0.0);
    let plate = app
        .world_mut()
        .spawn((RigidBody::Static, cube(1.0), plate))
        .id();
    let place = Transform::from_xyz(0.0, 0.5, 0.0);
    let body = app
        .world_mut()
        .spawn((RigidBody::Dynamic, cube(1.0), place))
        .id();
    let height = |app: &App| {
        app.world()
            .get::<Transform>(body)
            .expect("it is there")
            .translation
            .y
    };
    steps(&mut app, 60);
    assert!((height(&app) - 0.5).abs() < 0.01);
    app.world_mut().entity_mut(plate).insert(Sensor);
    steps(&mut app, 20);
    let inside = height(&app);
    assert!(inside < 0.3, "{inside}");
    assert_eq!(heard(&app).starts.len(), 1);
    app.world_mut().entity_mut(plate).remove::<Sensor>();
    steps(&mut app, 60);
    assert!(height(&app) > inside, "it is pushed out again");
}

#[test]
fn as_many_events_at_any_number_of_steps_a_frame() {
    let count = |steps_a_frame: u32, in_fixed: bool| {
        let mut app = listening();
        if in_fixed {
            app.add_systems(FixedUpdate, listen);
        }
        app.insert_resource(TimeUpdateStrategy::FixedTimesteps(steps_a_frame));
        floor(&mut app);
        let mut dice = Dice::new(11);
        for i in 0..20 {
            let place = Transform::from_xyz(2.0 * i as f32, dice.in_range(0.6, 3.0), 0.0);
            let bounce = Restitution::new(0.9).with_combine(CombineRule::Max);
            let parts = (
                RigidBody::Dynamic,
                cube(1.0),
                place,
                bounce,
                CollisionEvents,
            );
            app.world_mut().spawn(parts);
        }
        steps(&mut app, (240 / steps_a_frame) as usize);
        steps(&mut app, 1);
        (heard(&app).entity_starts.len(), heard(&app).starts.len())
    };
    let (events, messages) = count(1, false);
    assert_eq!(events, messages);
    assert!(events > 20, "they bounce: {events}");
    for steps_a_frame in [2, 4, 8] {
        let (events, messages) = count(steps_a_frame, false);
        assert_eq!(events, messages, "{steps_a_frame} steps a frame");
    }
}

#[test]
fn collisions_are_those_that_touch_asleep_or_not() {
    #[derive(Resource, Default)]
    struct Seen(Vec<(Entity, Entity, bool)>);
    fn look(collisions: Collisions, mut seen: ResMut<Seen>) {
        let pairs = collisions.iter();
        seen.0 = pairs
            .map(|pair| (pair.a, pair.b, pair.is_sensor()))
            .collect();
    }
    let mut app = listening();
    app.init_resource::<Seen>().add_systems(Update, look);
    app.insert_resource(SolverConfig {
        sleep: SleepConfig {
            enabled: true,
            ..SleepConfig::default()
        },
        ..SolverConfig::default()
    });
    let mut below = floor(&mut app);
    let mut expected = Vec::new();
    for level in 0..3 {
        let place = Transform::from_xyz(0.0, 0.5 + level as f32, 0.0);
        let body = app
            .world_mut()
            .spawn((RigidBody::Dynamic, cube(1.0), place))
            .id();
        expected.push((below, body, false));
        below = body;
    }
    // Beside them, nearer than contacts are looked for, is not at them.
    let beside = Transform::from_xyz(1.004, 0.5, 0.0);
    let beside = (RigidBody::Dynamic, cube(1.0), beside);
    let beside = app.world_mut().spawn(beside).id();
    expected.insert(1, (expected[0].0, beside, false));
    steps(&mut app, 10);
    assert_eq!(app.world().resource::<Seen>().0, expected);
    steps(&mut app, 230);
    assert_eq!(app.world().resource::<StepReport>().asleep, 4);
    assert_eq!(app.world().resource::<Seen>().0, expected);
}

// It began to touch and then ended to, in one step, so that who counted thought that nobody touched any more.
#[test]
fn another_body_of_the_same_entity_is_no_news() {
    for seed in 0..6 {
        let mut app = listening();
        let mut dice = Dice::new(seed);
        let floor = floor(&mut app);
        if seed % 2 == 0 {
            app.world_mut().entity_mut(floor).insert(CollisionEvents);
        }
        let cubes = [0, 1].map(|level| {
            let place = Transform::from_xyz(0.0, 0.5 + level as f32, 0.0);
            let parts = (RigidBody::Dynamic, cube(1.0), place, CollisionEvents);
            app.world_mut().spawn(parts).id()
        });
        steps(&mut app, 20);
        let begun = heard(&app).entity_starts.len();
        for _ in 0..20 {
            let cube = cubes[dice.below(2)];
            let mut entity = app.world_mut().entity_mut(cube);
            entity.remove::<RigidBody>().insert(RigidBody::Dynamic);
            steps(&mut app, 1 + dice.below(4));
        }
        let heard = heard(&app);
        assert_eq!(heard.entity_starts.len(), begun, "seed {seed}");
        assert_eq!(heard.starts.len(), 2, "seed {seed}");
        assert_eq!(
            (heard.ends.len(), heard.entity_ends.len()),
            (0, 0),
            "seed {seed}"
        );
    }
}
