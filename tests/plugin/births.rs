//! What is told of a body while its entity is renewed counts: by whoever sees a piece born or the parent break, in whatever way.
//!
//! Each way in sets each kind of component on each piece, and the pieces do as they are told.

use crate::app::app;
use bevy_app::{App, FixedPostUpdate, FixedUpdate, Update};
use bevy_cleave::prelude::*;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use bevy_math::{Quat, Vec3};
use bevy_transform::components::Transform;

/// s.
const H: f32 = 1.0 / 60.0;

#[derive(Component, Clone)]
struct Glass;

/// What is done to each piece.
#[derive(Clone, Copy, Debug)]
enum Deed {
    Velocity,
    Spin,
    Pose,
    Damping,
    Gravity,
    Layers,
    Force,
}

const DEEDS: [Deed; 7] = [
    Deed::Velocity,
    Deed::Spin,
    Deed::Pose,
    Deed::Damping,
    Deed::Gravity,
    Deed::Layers,
    Deed::Force,
];

/// m/s and rad/s.
const V: Vec3 = Vec3::new(0.3, 0.4, -0.2);
/// m.
const SHIFT: Vec3 = Vec3::new(0.0, 30.0, 5.0);

#[derive(Resource, Clone, Copy)]
struct Task(Deed);

/// The pieces, and where they were when something was done to them.
#[derive(Default, Resource)]
struct Done(Vec<(Entity, Vec3)>);

/// Does it, by commands, which act at once where an observer gives them.
fn act(world: &mut World, piece: Entity) {
    let Task(deed) = *world.resource::<Task>();
    let at = *world.get::<Transform>(piece).expect("a body");
    let mut entity = world.entity_mut(piece);
    match deed {
        Deed::Velocity => {
            *entity.get_mut::<LinearVelocity>().expect("a body") = LinearVelocity(V);
        }
        Deed::Spin => {
            entity.insert(AngularVelocity(V));
        }
        Deed::Pose => {
            entity.insert(at.with_translation(at.translation + SHIFT));
        }
        Deed::Damping => {
            entity.insert((LinearVelocity(V), LinearDamping(2.0)));
        }
        Deed::Gravity => {
            entity.insert((LinearVelocity(Vec3::ZERO), GravityScale(0.0)));
        }
        Deed::Layers => {
            entity.insert(CollisionLayers {
                memberships: 0,
                filters: 0,
            });
        }
        Deed::Force => {
            let mut forces = world.query::<Forces>();
            let mut forces = forces.get_mut(world, piece).expect("a body");
            let mass = forces.mass();
            forces.apply_impulse(mass * V);
        }
    }
    world.resource_mut::<Done>().0.push((piece, at.translation));
}

fn told_by_message(mut broke: MessageReader<Fractured>, mut commands: Commands) {
    for fractured in broke.read() {
        for &piece in &fractured.pieces {
            commands.queue(move |world: &mut World| act(world, piece));
        }
    }
}

/// A way to learn of a piece, and its name.
type Way = (&'static str, fn(&mut App));

/// Ways to learn of a piece. Those of a component see the parent added too, which is no piece.
fn ways() -> [Way; 7] {
    fn is_piece(world: &DeferredWorld, entity: Entity) -> bool {
        world
            .get::<BodyHandle>(entity)
            .is_some_and(|h| h.get().is_some())
    }
    [
        ("observer of the event", |app| {
            app.add_observer(|broke: On<Fractured>, mut commands: Commands| {
                for &piece in &broke.pieces {
                    commands.queue(move |world: &mut World| act(world, piece));
                }
            });
        }),
        ("observer of PieceOf", |app| {
            app.add_observer(|add: On<Add<PieceOf>>, mut commands: Commands| {
                let piece = add.entity;
                commands.queue(move |world: &mut World| act(world, piece));
            });
        }),
        ("observer of a component", |app| {
            app.add_observer(
                |add: On<Add<Glass>>, bodies: Query<&BodyHandle>, mut commands: Commands| {
                    let piece = add.entity;
                    if bodies.get(piece).is_ok_and(|handle| handle.get().is_some()) {
                        commands.queue(move |world: &mut World| act(world, piece));
                    }
                },
            );
        }),
        ("hook of a component", |app| {
            let hooks = app.world_mut().register_component_hooks::<Glass>();
            hooks.on_add(|mut world: DeferredWorld, at: HookContext| {
                let piece = at.entity;
                if is_piece(&world, piece) {
                    let mut commands = world.commands();
                    commands.queue(move |world: &mut World| act(world, piece));
                }
            });
        }),
        ("message after the step", |app| {
            app.add_systems(FixedPostUpdate, told_by_message);
        }),
        ("message in the frame", |app| {
            app.add_systems(Update, told_by_message);
        }),
        ("message before the next step", |app| {
            app.add_systems(FixedUpdate, told_by_message);
        }),
    ]
}

/// A cube that spins, high up, and a plate below it; cut in its second step, and one more.
fn broken(way: fn(&mut App), deed: Deed) -> App {
    let mut app = app();
    app.init_resource::<Done>().insert_resource(Task(deed));
    let gravity = match deed {
        Deed::Gravity | Deed::Layers => Vec3::new(0.0, -10.0, 0.0),
        _ => Vec3::ZERO,
    };
    app.insert_resource(Gravity(gravity));
    way(&mut app);
    let cuboid = |x, y, z| ConvexMesh::cuboid(x, y, z).expect("a box");
    let world = app.world_mut();
    let plate = Transform::from_xyz(0.0, -1.6, 0.0);
    world.spawn((RigidBody::Static, cuboid(9.0, 1.0, 9.0), plate));
    let body = (RigidBody::Dynamic, cuboid(1.0, 1.0, 1.0), Glass);
    let spin = AngularVelocity(0.1 * Vec3::Y);
    let parent = world.spawn((body, spin, Transform::default())).id();
    app.update();
    let plane = Plane::through(Vec3::ZERO, Vec3::new(1.0, 0.2, 0.0));
    app.world_mut().commands().slice(parent, plane);
    app.update();
    // A message is read a step later at most.
    (0..2).for_each(|_| app.update());
    app
}

fn check(app: &mut App, (way, deed): (&str, Deed)) {
    let done = std::mem::take(&mut app.world_mut().resource_mut::<Done>().0);
    assert_eq!(done.len(), 2, "{way}, {deed:?}");
    let steps = 30;
    let state = |app: &App, piece: Entity| {
        let (slot, _) = app
            .world()
            .get::<BodyHandle>(piece)
            .and_then(BodyHandle::get)
            .expect("a body");
        let bodies = app.world().resource::<Bodies>();
        (bodies.pose(slot).position, bodies.velocity(slot))
    };
    let before = done.iter().map(|&(piece, _)| state(app, piece));
    let before: Vec<_> = before.collect();
    (0..steps).for_each(|_| app.update());
    for (&(piece, at), (was_at, was)) in done.iter().zip(before) {
        let (now_at, now) = state(app, piece);
        let what = format!("{way}, {deed:?}: {was_at} {was:?} -> {now_at} {now:?}");
        let close = |a: Vec3, b: Vec3, by: f32| a.distance(b) <= by;
        let is_done = match deed {
            // The two touch each other, and turn.
            Deed::Velocity => close(was.0, V, 0.01) && close(now.0, V, 0.01),
            Deed::Spin => close(was.1, V, 0.02),
            Deed::Pose => close(was_at, at + SHIFT, 0.01),
            Deed::Damping => {
                let decay = (0..steps).fold(1.0, |speed, _| speed / (1.0 + 2.0 * H));
                close(now.0, decay * was.0, 0.02 * V.length()) && close(was.0, V, 0.2)
            }
            Deed::Gravity => close(was.0, Vec3::ZERO, 0.01) && close(now.0, Vec3::ZERO, 0.01),
            // Through the plate.
            Deed::Layers => now_at.y < was_at.y - 1.0,
            // Besides what the pieces had of the parent's spin.
            Deed::Force => close(was.0, V, 0.06) && close(now.0, V, 0.06),
        };
        assert!(is_done, "{what}");
        // What the entity shows is where the body is.
        let shown = app.world().get::<Transform>(piece).expect("a body");
        assert!(
            close(shown.translation, now_at, 1e-5),
            "{what}: shown at {}",
            shown.translation
        );
    }
}

#[test]
fn what_is_set_at_birth_counts_whoever_sets_it() {
    for (name, way) in ways() {
        for deed in DEEDS {
            check(&mut broken(way, deed), (name, deed));
        }
    }
}

#[test]
fn who_sees_a_body_wake_or_a_neighbor_break_moves_another() {
    // An observer of what breaks sets the velocity of a body that is not part of it.
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box");
    let world = app.world_mut();
    let at = |x| Transform::from_xyz(x, 0.0, 0.0).with_rotation(Quat::from_rotation_y(0.1));
    let [a, b] = [0.0, 5.0].map(|x| world.spawn((RigidBody::Dynamic, cube.clone(), at(x))).id());
    app.add_observer(
        move |_: On<Fractured>, mut motion: Query<(&mut LinearVelocity, &mut Transform)>| {
            if let Ok((mut velocity, mut place)) = motion.get_mut(b) {
                velocity.0 = V;
                place.translation += SHIFT;
            }
        },
    );
    app.update();
    let cut = Plane::through(Vec3::ZERO, Vec3::X);
    app.world_mut().commands().slice(a, cut);
    (0..3).for_each(|_| app.update());
    let place = app.world().get::<Transform>(b).expect("a body").translation;
    let expected = Vec3::new(5.0, 0.0, 0.0) + SHIFT + 2.0 * H * V;
    assert!(place.distance(expected) < 1e-4, "{place} for {expected}");
}

#[test]
fn what_a_system_between_the_phases_sets_is_not_lost() {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box");
    let body = app.world_mut().spawn((RigidBody::Dynamic, cube)).id();
    app.update();
    let set = move |mut bodies: Query<&mut LinearVelocity>, mut done: Local<bool>| {
        if !std::mem::replace(&mut *done, true)
            && let Ok(mut velocity) = bodies.get_mut(body)
        {
            velocity.0 = V;
        }
    };
    let between = set
        .after(PhysicsSystems::Solve)
        .before(PhysicsSystems::Fracture);
    app.add_systems(PhysicsSchedule, between);
    (0..61).for_each(|_| app.update());
    let place = app
        .world()
        .get::<Transform>(body)
        .expect("a body")
        .translation;
    assert!(place.distance(V) < 1e-3, "{place}");
}
