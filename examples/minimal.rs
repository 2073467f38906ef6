//! The scene of `shatter` as an app: a model falls among boxes, breaks, and its pieces tell.
#[path = "support/mod.rs"]
mod support;
use bevy_app::{App, TaskPoolPlugin, Update};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;

fn main() -> Result<(), support::Error> {
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin::default(), TimePlugin));
    app.add_plugins(CleavePlugin::default());
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    app.add_systems(Update, tell);
    let model = support::model::load(support::DEFAULT_MODEL)?.fitted(2.6);
    let shape = ConvexMesh::from_mesh(model.into_mesh()?)?;
    let brittle = Fracturable::with_strength(1500.0);
    let cube = ConvexMesh::cuboid(0.6, 0.6, 0.6)?;
    let world = app.world_mut();
    world.spawn((RigidBody::Static, HalfSpace::new(glam::Vec3::Y)?));
    let above = Transform::from_xyz(0.0, 4.0, 0.0);
    world.spawn((RigidBody::Dynamic, shape, brittle, above));
    for i in 0..8_u8 {
        let beside = Transform::from_xyz(1.5, 0.4 + 1.2 * f32::from(i), 0.0);
        world.spawn((RigidBody::Dynamic, cube.clone(), beside));
    }
    (0..300).for_each(|_| app.update());
    Ok(())
}

#[expect(clippy::print_stdout, reason = "an example prints what it shows")]
fn tell(mut fractures: MessageReader<Fractured>) {
    for Fractured { parent, pieces, .. } in fractures.read() {
        println!("{parent} broke into {pieces:?}");
    }
}
