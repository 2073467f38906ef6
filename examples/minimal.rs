//! The whole of it: an app with the plugin, a floor, a crate that breaks when it lands, and what it broke into.

use bevy_app::{App, TaskPoolPlugin, Update};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;

fn main() {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        TimePlugin,
        CleavePlugin::default(),
    ))
    .insert_resource(TimeUpdateStrategy::FixedTimesteps(1))
    .add_systems(Update, tell);
    let world = app.world_mut();
    world.spawn((RigidBody::Static, HalfSpace { normal: Vec3::Y }));
    world.spawn((
        RigidBody::Dynamic,
        ConvexMesh::cuboid(1.0, 0.6, 0.6).expect("a crate has a volume"),
        Fracturable {
            strength: 500.0,
            ..Default::default()
        },
        Transform::from_xyz(0.0, 3.0, 0.0),
    ));
    app.finish();
    app.cleanup();
    for _ in 0..200 {
        app.update();
    }
    let mut bodies = app.world_mut().query::<(&MassProperties, &Transform)>();
    for (mass, transform) in bodies.iter(app.world()).filter(|(mass, _)| mass.mass > 0.0) {
        println!("{:7.2} kg at {:.3}", mass.mass, transform.translation);
    }
}

fn tell(mut fractures: MessageReader<Fractured>) {
    for fracture in fractures.read() {
        println!(
            "{} broke into {} pieces",
            fracture.parent,
            fracture.pieces.len()
        );
    }
}
