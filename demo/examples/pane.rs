//! A pane that shatters in a window: the program of `docs/window.md`.

use bevy::prelude::*;
use bevy_cleave::prelude::*;

fn main() {
    App::new()
        .add_plugins((bevy::DefaultPlugins, CleavePlugin::default()))
        .add_plugins((CleaveMeshPlugin, InterpolationPlugin))
        .init_resource::<Paint>()
        .add_systems(Startup, set_up)
        .add_systems(Update, throw)
        .run();
}

/// What everything is drawn with.
#[derive(Clone, Resource)]
struct Paint(MeshMaterial3d<StandardMaterial>, DrawShape);

impl FromWorld for Paint {
    fn from_world(world: &mut World) -> Self {
        let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
        let color = materials.add(Color::srgb(0.7, 0.8, 0.8));
        Self(MeshMaterial3d(color), DrawShape::new())
    }
}

fn set_up(mut commands: Commands, paint: Res<Paint>) {
    let Paint(color, draw) = paint.clone();
    let eye = Transform::from_xyz(1.5, 1.4, 3.0).looking_at(Vec3::new(0.0, 0.6, 0.0), Vec3::Y);
    commands.spawn((Camera3d::default(), eye));
    let sun = Transform::from_xyz(2.0, 4.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y);
    commands.spawn((DirectionalLight::default(), sun));
    let at = Transform::from_xyz(0.0, -0.1, 0.0);
    let floor = (RigidBody::Static, cuboid!(6.0, 0.2, 6.0), at);
    commands.spawn((floor, color.clone(), draw.clone()));

    let mut held = Vec::new();
    for x in [-0.65, 0.65] {
        let at = Transform::from_xyz(x, 0.6, 0.0);
        let post = (RigidBody::Static, cuboid!(0.1, 1.2, 0.1), at);
        held.push(commands.spawn((post, color.clone(), draw.clone())).id());
    }
    let glass = Fracturable {
        pattern: FracturePattern::Radial { rays: 16, rings: 8 },
        toughness: 8.0, // J of impact for each square metre of crack
        generations: 0, // shards do not break again
        ..Fracturable::with_strength(20.0)  // N s
    };
    let pane = (
        RigidBody::Dynamic,
        cuboid!(1.2, 1.0, 0.012),
        Density(2500.0),
        glass,
    );
    let at = Transform::from_xyz(0.0, 0.65, 0.0);
    held.push(commands.spawn((pane, at, color, draw)).id());
    commands.bond_neighbors(held, 4.0e6); // Pa
}

/// Any key throws a ball.
fn throw(keys: Res<ButtonInput<KeyCode>>, paint: Res<Paint>, mut commands: Commands) {
    if keys.get_just_pressed().next().is_some() {
        let at = Transform::from_xyz(0.1, 0.7, 2.5);
        let velocity = LinearVelocity(Vec3::new(0.0, 1.0, -12.0));
        let ball = (RigidBody::Dynamic, icosphere!(0.06), Density(7800.0));
        let Paint(color, draw) = paint.clone();
        commands.spawn((ball, at, velocity, color, draw));
    }
}
