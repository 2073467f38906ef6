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
    let penguin = support::model::load(support::DEFAULT_MODEL)?.fitted(2.6);
    let shape = ConvexMesh::from_mesh(penguin.into_mesh()?)?;
    let breakable = Fracturable::with_strength(1500.0);
    let world = app.world_mut();
    world.spawn((RigidBody::Static, HalfSpace::new(glam::Vec3::Y)?));
    world.spawn((
        RigidBody::Dynamic,
        shape,
        breakable,
        Transform::from_xyz(0.0, 4.0, 0.0),
    ));
    for i in 0..8_u8 {
        let place = Transform::from_xyz(1.5, 0.4 + 1.2 * f32::from(i), 0.0);
        world.spawn((
            RigidBody::Dynamic,
            ConvexMesh::cuboid(0.6, 0.6, 0.6)?,
            place,
        ));
    }
    (0..300).for_each(|_| app.update());
    Ok(())
}

#[expect(clippy::print_stdout, reason = "an example prints what it shows")]
fn tell(mut fractures: MessageReader<Fractured>, masses: Query<&MassProperties>) {
    for fracture in fractures.read() {
        let pieces = fracture
            .pieces
            .iter()
            .filter_map(|&piece| masses.get(piece).ok());
        let masses: Vec<_> = pieces.map(|properties| properties.mass).collect();
        println!("{} broke into pieces of {masses:.0?} kg", fracture.parent);
    }
}
