//! Balls of iron, thrown from the camera: with the right button, or where the left one or a finger taps.

use crate::look::Looks;
use crate::panel::PointerOnPanel;
use crate::swipe::{LEAST_LENGTH, Swipe};
use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use bevy_cleave::prelude::*;

/// m.
const RADIUS: f32 = 0.1;
/// m/s.
const SPEED: f32 = 18.0;
/// kg/m3.
const DENSITY: f32 = 7800.0;
/// The oldest goes when there are more.
const MOST: usize = 24;

/// A ball along this ray.
#[derive(Clone, Copy, Message)]
pub(crate) struct Throw(pub(crate) Ray3d);

/// A ball that was thrown, with its number.
#[derive(Component)]
struct Ball(u32);

/// One shape for all balls.
#[derive(Resource)]
struct BallShape(ConvexMesh);

pub(crate) fn plugin(app: &mut App) {
    let shape = ConvexMesh::sphere(RADIUS).expect("a ball has a volume");
    app.insert_resource(BallShape(shape))
        .add_message::<Throw>()
        .add_systems(Update, (aim, throw).chain());
}

fn aim(
    buttons: Res<ButtonInput<MouseButton>>,
    panel: Res<PointerOnPanel>,
    window: Query<&Window, With<PrimaryWindow>>,
    camera: Query<(&Camera, &GlobalTransform)>,
    mut taps: MessageReader<Swipe>,
    mut throws: MessageWriter<Throw>,
) {
    let Ok((camera, eye)) = camera.single() else {
        return;
    };
    let is_tap = |swipe: &&Swipe| swipe.from.distance(swipe.to) <= LEAST_LENGTH;
    let mut targets: Vec<Vec2> = taps.read().filter(is_tap).map(|tap| tap.to).collect();
    if buttons.just_pressed(MouseButton::Right) && !panel.0 {
        targets.extend(
            window
                .single()
                .ok()
                .and_then(|window| window.cursor_position()),
        );
    }
    let rays = targets
        .into_iter()
        .filter_map(|at| camera.viewport_to_world(eye, at).ok());
    throws.write_batch(rays.map(Throw));
}

fn throw(
    mut commands: Commands,
    mut throws: MessageReader<Throw>,
    shape: Res<BallShape>,
    looks: Res<Looks>,
    balls: Query<(Entity, &Ball)>,
    mut count: Local<u32>,
) {
    for Throw(ray) in throws.read() {
        // A little upwards, for what the ball falls on its way.
        let velocity = SPEED * *ray.direction + 0.6 * Vec3::Y;
        commands.spawn((
            Ball(*count),
            RigidBody::Dynamic,
            shape.0.clone(),
            Density(DENSITY),
            Transform::from_translation(ray.get_point(0.8)),
            LinearVelocity(velocity),
            looks.iron.clone(),
        ));
        *count += 1;
    }
    for (entity, ball) in &balls {
        if (ball.0 as usize) + MOST < *count as usize {
            commands.entity(entity).despawn();
        }
    }
}
