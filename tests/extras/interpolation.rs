//! Motion between fixed steps.

use crate::{all_with, app, with_frames_of};
use bevy_app::{App, FixedUpdate};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_transform::components::Transform;

const STEP: f64 = 1.0 / 60.0;

fn cube() -> ConvexMesh {
    ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box")
}

fn smooth_app() -> App {
    let mut app = app();
    app.add_plugins(InterpolationPlugin)
        .insert_resource(Gravity(Vec3::ZERO));
    app.finish();
    app.cleanup();
    app
}

fn place(app: &App, entity: Entity) -> Vec3 {
    app.world()
        .get::<Transform>(entity)
        .expect("a body")
        .translation
}

#[test]
fn a_body_moves_evenly_at_any_frame_rate() {
    for rate in [24.0, 59.0, 60.0, 75.0, 144.0, 240.0, 1000.0] {
        let mut app = smooth_app();
        with_frames_of(&mut app, 1.0 / rate);
        let velocity = LinearVelocity(3.0 * Vec3::X);
        let body = (RigidBody::Dynamic, cube(), velocity);
        let body = app.world_mut().spawn(body).id();
        // Until the first step is behind it.
        (0..(rate * 0.1) as usize + 2).for_each(|_| app.update());
        let mut before = place(&app, body);
        for frame in 0..200 {
            app.update();
            let now = place(&app, body);
            let speed = f64::from((now - before).x) * rate;
            assert!(
                (speed - 3.0).abs() < 0.02,
                "{speed} m/s in frame {frame} at {rate} Hz"
            );
            before = now;
        }
    }
}

#[test]
fn the_physics_is_the_same_with_it() {
    let motion = |is_smooth: bool| {
        let mut app = app();
        if is_smooth {
            app.add_plugins(InterpolationPlugin);
        }
        app.finish();
        app.cleanup();
        with_frames_of(&mut app, 1.0 / 144.0);
        let floor = HalfSpaceShape { normal: Vec3::Y };
        app.world_mut().spawn((RigidBody::Static, floor));
        let at = Transform::from_xyz(0.0, 2.0, 0.0);
        let spin = AngularVelocity(Vec3::new(1.0, 2.0, 3.0));
        app.world_mut()
            .spawn((RigidBody::Dynamic, cube(), at, spin));
        (0..400).for_each(|_| app.update());
        let bodies = app.world().resource::<Bodies>();
        let poses = bodies
            .iter()
            .map(|slot| (bodies.pose(slot), bodies.velocity(slot)));
        poses.map(|state| format!("{state:?}")).collect::<Vec<_>>()
    };
    assert_eq!(motion(true), motion(false));
}

#[test]
fn who_is_set_elsewhere_is_there_at_once() {
    let mut app = smooth_app();
    with_frames_of(&mut app, STEP / 3.0);
    let body = app.world_mut().spawn((RigidBody::Dynamic, cube())).id();
    (0..10).for_each(|_| app.update());
    let far = 100.0 * Vec3::Y;
    // Between frames.
    app.world_mut()
        .get_mut::<Transform>(body)
        .expect("a body")
        .translation = far;
    for _ in 0..7 {
        app.update();
        assert_eq!(place(&app, body), far);
    }
    // In a fixed step.
    #[derive(Resource)]
    struct Target(Option<Vec3>);
    app.insert_resource(Target(Some(Vec3::ZERO))).add_systems(
        FixedUpdate,
        move |mut target: ResMut<Target>, mut bodies: Query<&mut Transform>| {
            if let Some(at) = target.0.take() {
                bodies.get_mut(body).expect("a body").translation = at;
            }
        },
    );
    for _ in 0..7 {
        app.update();
        let at = place(&app, body);
        assert!(at == far || at == Vec3::ZERO, "a streak at {at}");
    }
    assert_eq!(place(&app, body), Vec3::ZERO);
}

#[test]
fn pieces_go_on_from_where_they_were_cut() {
    let mut app = smooth_app();
    let frame = STEP / 5.0;
    with_frames_of(&mut app, frame);
    let velocity = LinearVelocity(Vec3::new(6.0, 0.0, 0.0));
    let spin = AngularVelocity(Vec3::new(0.0, 0.0, 0.5));
    let body = (RigidBody::Dynamic, cube(), velocity, spin);
    let body = app.world_mut().spawn(body).id();
    (0..40).for_each(|_| app.update());
    // Of the whole cube, then the mean of both halves: the frame of a piece is its parent's.
    let middle = |app: &mut App| {
        let bodies = all_with::<RigidBody>(app);
        let places = bodies.iter().map(|&body| place(app, body));
        places.sum::<Vec3>() / bodies.len() as f32
    };
    let mut before = middle(&mut app);
    let plane = Plane::through(before, Vec3::Y);
    app.world_mut().commands().slice(body, plane);
    for _ in 0..20 {
        app.update();
        let now = middle(&mut app);
        let speed = (now - before).x / frame as f32;
        assert!((speed - 6.0).abs() < 0.1, "{speed} m/s");
        before = now;
    }
    assert_eq!(all_with::<RigidBody>(&mut app).len(), 2);
}

#[test]
fn who_does_not_want_it_jumps_from_step_to_step() {
    let mut app = smooth_app();
    with_frames_of(&mut app, STEP / 4.0);
    let velocity = LinearVelocity(3.0 * Vec3::X);
    let body = (RigidBody::Dynamic, cube(), velocity, NoInterpolation);
    let body = app.world_mut().spawn(body).id();
    let mut places = Vec::new();
    for _ in 0..40 {
        app.update();
        places.push(place(&app, body).x.to_bits());
    }
    places.dedup();
    assert!((9..=11).contains(&places.len()), "{} places", places.len());
}
