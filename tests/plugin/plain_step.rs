//! The plugin does what the plain step does, and its systems have one order only.

use crate::app::{accompanied_app, app, app_of, step_length};
use crate::common::scenes::falling_and_breaking;
use crate::common::states::bits;
use bevy_app::{App, Last, Update};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;

/// Pose and velocity of every body as bits, by body id.
fn bits_of_simulation(simulation: &Simulation) -> Vec<(u32, Vec<u32>)> {
    let bodies = &simulation.bodies;
    let mut all: Vec<_> = bodies
        .iter()
        .map(|slot| {
            let (pose, (v, omega)) = (bodies.pose(slot), bodies.velocity(slot));
            (bodies.id(slot).0, bits(&pose, v, omega))
        })
        .collect();
    all.sort();
    all
}

fn bits_of_world(world: &mut World) -> Vec<(u32, Vec<u32>)> {
    let mut query = world.query::<(&BodyHandle, &Transform, &LinearVelocity, &AngularVelocity)>();
    let mut all: Vec<_> = query
        .iter(world)
        .map(|(handle, t, v, omega)| {
            let (_, id) = handle.get().expect("every body takes part");
            (
                id.0,
                bits(&Pose::new(t.translation, t.rotation), v.0, omega.0),
            )
        })
        .collect();
    all.sort();
    all
}

#[test]
fn plugin_and_plain_step_agree_bit_for_bit_over_a_scene_that_fractures() {
    for app in [app(), accompanied_app(), app_of(CleavePlugin::new(Update))] {
        agrees_with_the_plain_step(app);
    }
}

fn agrees_with_the_plain_step(mut app: App) {
    let scene = falling_and_breaking();
    let mut simulation = Simulation::default();
    for desc in &scene {
        simulation.bodies.insert(desc.clone()).expect("usable");
        app.world_mut().spawn_body(desc.clone());
    }
    let mut fractures = 0;
    for step in 0..300 {
        simulation.step(step_length().as_secs_f32());
        app.update();
        fractures += simulation.fractures.done.len();
        assert_eq!(
            bits_of_simulation(&simulation),
            bits_of_world(app.world_mut()),
            "step {step}"
        );
        assert_eq!(
            simulation.report,
            *app.world().resource::<StepReport>(),
            "step {step}"
        );
    }
    assert!(
        fractures >= 4,
        "the scene is meant to fracture, but only {fractures} bodies did"
    );
}

#[test]
fn pieces_carry_the_components_of_their_parent() {
    #[derive(Component, Clone, PartialEq, Debug)]
    struct Material(&'static str);

    let mut app = app();
    let parent = app
        .world_mut()
        .spawn((
            RigidBody::Dynamic,
            ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid"),
            Material("oak"),
            Density(700.0),
        ))
        .insert(Friction::new(0.9))
        .id();
    app.update();
    app.world_mut()
        .commands()
        .slice(parent, Plane::through(glam::Vec3::ZERO, glam::Vec3::X));
    app.update();
    let world = app.world_mut();
    assert!(world.get_entity(parent).is_err(), "the parent is gone");
    let mut pieces =
        world.query::<(&Material, &Density, &Friction, &MassProperties, &ConvexMesh)>();
    assert_eq!(pieces.iter(world).count(), 2);
    for (material, density, friction, mass, mesh) in pieces.iter(world) {
        assert_eq!(
            (material, density.0, friction.coefficient),
            (&Material("oak"), 700.0, 0.9)
        );
        assert!((f64::from(mass.mass) - 700.0 * mesh.hull().volume()).abs() < 1e-3);
    }
    let messages = world.resource::<Messages<Fractured>>();
    let message = messages
        .iter_current_update_messages()
        .next()
        .expect("one message");
    assert_eq!((message.parent, message.pieces.len()), (parent, 2));
    assert!(message.ledger.mass_error() < 1e-6 && message.ledger.momentum_error() < 1e-5);
    assert!((message.ledger.before.mass - 700.0).abs() < 1e-3);
}

#[test]
fn bodies_without_anything_else_have_all_defaults() {
    let mut app = app();
    let mesh = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid");
    let body = app.world_mut().spawn((RigidBody::Dynamic, mesh)).id();
    app.update();
    let entity = app.world().entity(body);
    assert!((entity.get::<MassProperties>().expect("computed").mass - 1000.0).abs() < 1e-3);
    assert!(
        entity.get::<LinearVelocity>().expect("required").0.y < 0.0,
        "it falls"
    );
}

fn height_in_simulation(app: &App, entity: Entity) -> f32 {
    let handle = app.world().get::<BodyHandle>(entity).expect("a body");
    let (slot, _) = handle.get().expect("takes part");
    app.world().resource::<Bodies>().pose(slot).position.y
}

#[test]
fn a_body_put_back_where_it_was_spawned_is_there() {
    let mut app = app();
    let mesh = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid");
    let start = Transform::from_xyz(0.0, 3.0, 0.0);
    let body = app
        .world_mut()
        .spawn((RigidBody::Dynamic, mesh, start))
        .id();
    for _ in 0..10 {
        app.update();
    }
    assert!(height_in_simulation(&app, body) < 2.9, "it falls");
    let mut entity = app.world_mut().entity_mut(body);
    *entity.get_mut::<Transform>().expect("a body") = start;
    entity.get_mut::<LinearVelocity>().expect("a body").0 = glam::Vec3::ZERO;
    app.update();
    let fall = 3.0 - height_in_simulation(&app, body);
    assert!((0.0..0.01).contains(&fall), "fell {fall} m in one step");
}

#[test]
fn a_change_between_gathering_and_writing_back_is_taken_over_in_the_next_step() {
    let mut app = app();
    let mesh = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid");
    let wall = app.world_mut().spawn((RigidBody::Static, mesh)).id();
    app.update();
    app.add_systems(
        PhysicsSchedule,
        (move |mut walls: Query<&mut Transform>| {
            let mut wall = walls.get_mut(wall).expect("there");
            if wall.translation.y == 0.0 {
                wall.translation.y = 4.0;
            }
        })
        .after(PhysicsSystems::Solve)
        .before(PhysicsSystems::Integrate),
    );
    app.update();
    assert_eq!(height_in_simulation(&app, wall), 0.0, "gathered before");
    app.update();
    assert_eq!(height_in_simulation(&app, wall), 4.0);
}

/// Entities whose `Transform` was marked as changed in the last update.
#[derive(Resource, Default)]
struct Moved(Vec<Entity>);

fn watch_moved(app: &mut App) {
    app.init_resource::<Moved>().add_systems(
        Last,
        |mut moved: ResMut<Moved>, changed: Query<Entity, Changed<Transform>>| {
            moved.0 = changed.iter().collect();
        },
    );
}

#[test]
fn only_bodies_that_move_are_marked_as_changed() {
    let mut app = app();
    let mesh = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid");
    let body = |kind, x| (kind, mesh.clone(), Transform::from_xyz(x, 0.0, 0.0));
    let falling = app.world_mut().spawn(body(RigidBody::Dynamic, 0.0)).id();
    app.world_mut().spawn(body(RigidBody::Static, 5.0));
    app.world_mut().spawn(body(RigidBody::Kinematic, 10.0));
    watch_moved(&mut app);
    app.update();
    app.update();
    assert_eq!(app.world().resource::<Moved>().0, [falling]);
}

/// Cubes that fly past each other, every third one fixed: more than are written by one thread.
fn swarm() -> Vec<BodyDesc> {
    let mesh = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid");
    let cube = |i: u16| {
        let at = 4.0 * glam::Vec3::new(f32::from(i % 60), f32::from(i / 60), 0.0);
        let mut cube = BodyDesc::dynamic(mesh.clone(), at);
        cube.linear_velocity = glam::Vec3::Z * f32::from(i % 7);
        cube.angular_velocity = glam::Vec3::new(0.1, 0.2, 0.3) * f32::from(i % 5);
        if i.is_multiple_of(3) {
            cube.kind = RigidBody::Static;
            cube.linear_velocity = glam::Vec3::ZERO;
            cube.angular_velocity = glam::Vec3::ZERO;
        }
        cube
    };
    (0..5000).map(cube).collect()
}

#[test]
fn what_a_team_writes_is_what_the_plain_step_finds() {
    let mut simulation = Simulation::default();
    let mut app = app();
    let mut entities = Vec::new();
    for desc in swarm() {
        simulation.bodies.insert(desc.clone()).expect("usable");
        entities.push(app.world_mut().spawn_body(desc));
    }
    for step in 0..5 {
        simulation.step(step_length().as_secs_f32());
        app.update();
        let expected = bits_of_simulation(&simulation);
        assert_eq!(expected, bits_of_world(app.world_mut()), "step {step}");
        // One change among thousands is seen.
        let chosen = entities[999 * step + 1];
        let mut velocity = app.world_mut().get_mut::<LinearVelocity>(chosen);
        velocity.as_mut().expect("a body").0 = glam::Vec3::X;
        let (slot, _) = app
            .world()
            .get::<BodyHandle>(chosen)
            .and_then(|h| h.get())
            .expect("a body");
        let (_, omega) = simulation.bodies.velocity(slot);
        simulation
            .bodies
            .set_velocity(slot, glam::Vec3::X, omega)
            .expect("usable");
    }
}

#[test]
fn what_a_team_writes_is_marked_as_changed_and_nothing_else() {
    let mut app = app();
    let mut movable = Vec::new();
    for desc in swarm() {
        let kind = desc.kind;
        let entity = app.world_mut().spawn_body(desc);
        if kind == RigidBody::Dynamic {
            movable.push(entity);
        }
    }
    watch_moved(&mut app);
    app.update();
    app.update();
    let mut moved = std::mem::take(&mut app.world_mut().resource_mut::<Moved>().0);
    moved.sort();
    movable.sort();
    assert_eq!(moved, movable);
}

#[test]
fn gravity_changed_within_a_step_acts_from_the_next_one_on() {
    let mut app = app();
    let mesh = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid");
    let body = app.world_mut().spawn((RigidBody::Dynamic, mesh)).id();
    app.world_mut().insert_resource(Gravity(glam::Vec3::ZERO));
    app.update();
    app.add_systems(
        PhysicsSchedule,
        (|mut gravity: ResMut<Gravity>| gravity.0 = -glam::Vec3::Y)
            .after(PhysicsSystems::MassProperties)
            .before(PhysicsSystems::Cut),
    );
    let fall = |app: &App| app.world().get::<LinearVelocity>(body).expect("a body").0.y;
    app.update();
    assert_eq!(fall(&app), 0.0, "read before");
    app.update();
    assert!(fall(&app) < 0.0);
}
