//! The plugin does what the plain step does, and its systems have one order only.

mod app;
mod scenes;

use app::{app, bits, step_length};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use scenes::falling_and_breaking;

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
    let scene = falling_and_breaking();
    let mut simulation = Simulation::default();
    let mut app = app();
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
