//! Slicing with the pointer: a swipe cuts what it crosses, by the plane through the camera and the two ends of the swipe.

use crate::panel::PointerOnPanel;
use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use bevy_cleave::prelude::*;

/// Shorter swipes are taps, logical pixels.
pub(crate) const LEAST_LENGTH: f32 = 24.0;
/// How far away bodies are sliced, m.
const REACH: f32 = 30.0;
/// How fast the two sides of a cut part, m/s: else nobody would see it before they fall on something.
const PARTING_SPEED: f32 = 0.35;
/// How long the trace of a swipe stays, s.
const TRACE_TIME: f32 = 0.25;

/// A pointer went from one place of the viewport to another.
#[derive(Clone, Copy, Debug, Message)]
pub(crate) struct Swipe {
    pub(crate) from: Vec2,
    pub(crate) to: Vec2,
}

/// Where the pointer was pressed, and the last swipe with its age in s.
#[derive(Default, Resource)]
struct Trace {
    pressed: Option<Vec2>,
    last: Option<(Swipe, f32)>,
}

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<Trace>()
        .add_message::<Swipe>()
        .add_systems(Update, (follow_pointer, slice, part, draw_trace).chain());
}

fn follow_pointer(
    window: Query<&Window, With<PrimaryWindow>>,
    buttons: Res<ButtonInput<MouseButton>>,
    touches: Res<Touches>,
    panel: Res<PointerOnPanel>,
    mut trace: ResMut<Trace>,
    mut swipes: MessageWriter<Swipe>,
) {
    let finger = touches.iter().next();
    let at = finger.map(|finger| finger.position());
    let at = at.or_else(|| window.single().ok()?.cursor_position());
    let lifted = touches.iter_just_released().next();
    let at = lifted.map(|finger| finger.position()).or(at);
    if buttons.just_pressed(MouseButton::Left) || touches.any_just_pressed() {
        trace.pressed = at.filter(|_| !panel.0);
    }
    if buttons.just_released(MouseButton::Left) || lifted.is_some() {
        let ends = trace.pressed.take().zip(at);
        swipes.write_batch(ends.map(|(from, to)| Swipe { from, to }));
    }
}

fn slice(
    mut commands: Commands,
    mut swipes: MessageReader<Swipe>,
    camera: Query<(&Camera, &GlobalTransform)>,
    space: SpatialQuery,
    kinds: Query<&RigidBody>,
    mut trace: ResMut<Trace>,
) -> Result {
    let is_swipe = |swipe: &&Swipe| swipe.from.distance(swipe.to) > LEAST_LENGTH;
    for &swipe in swipes.read().filter(is_swipe) {
        trace.last = Some((swipe, 0.0));
        let (camera, eye) = camera.single()?;
        let from = camera.viewport_to_world(eye, swipe.from)?;
        let to = camera.viewport_to_world(eye, swipe.to)?;
        let [from, to] = [from, to].map(|ray| Ray::new(ray.origin, *ray.direction, REACH));
        let blade = Blade::between(&from?, &to?)?;
        let is_dynamic = |entity| {
            kinds
                .get(entity)
                .is_ok_and(|kind| *kind == RigidBody::Dynamic)
        };
        let dynamic = QueryFilter::all().with_predicate(&is_dynamic);
        for entity in space.overlap_shape(&blade.shape(), &Pose::IDENTITY, &dynamic)? {
            commands.slice(entity, blade.plane());
        }
    }
    Ok(())
}

/// The pieces on both sides of a cut part.
fn part(
    mut fractures: MessageReader<Fractured>,
    mut pieces: Query<(&Transform, &MassProperties, &mut LinearVelocity)>,
) {
    let cuts = fractures
        .read()
        .filter(|event| event.cause == FractureCause::Cut);
    for event in cuts {
        for (&piece, plane) in event.pieces.iter().zip(event.planes.iter().cycle()) {
            if let Ok((transform, mass, mut velocity)) = pieces.get_mut(piece) {
                let center = transform.transform_point(mass.center);
                velocity.0 += PARTING_SPEED * plane.distance(center).signum() * plane.normal;
            }
        }
    }
}

fn draw_trace(
    time: Res<Time<Real>>,
    window: Query<&Window, With<PrimaryWindow>>,
    camera: Query<(&Camera, &GlobalTransform)>,
    mut trace: ResMut<Trace>,
    mut gizmos: Gizmos,
) {
    let Ok((camera, eye)) = camera.single() else {
        return;
    };
    // Just beyond the near plane, so that it is in front of everything.
    let on_glass = |p: Vec2| Some(camera.viewport_to_world(eye, p).ok()?.get_point(0.3));
    let mut draw = |from, to, color: Color| {
        if let (Some(a), Some(b)) = (on_glass(from), on_glass(to)) {
            gizmos.line(a, b, color);
        }
    };
    let pointer = window
        .single()
        .ok()
        .and_then(|window| window.cursor_position());
    if let (Some(from), Some(to)) = (trace.pressed, pointer) {
        draw(from, to, Color::srgb(1.0, 0.45, 0.1));
    }
    if let Some((swipe, age)) = &mut trace.last {
        *age += time.delta_secs();
        let rest = 1.0 - *age / TRACE_TIME;
        draw(
            swipe.from,
            swipe.to,
            Color::srgba(1.0, 0.6, 0.2, rest.max(0.0)),
        );
        if rest <= 0.0 {
            trace.last = None;
        }
    }
}
