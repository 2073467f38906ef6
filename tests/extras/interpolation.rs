//! Motion between fixed steps.

use crate::dice::Dice;
use crate::hierarchy::{local_beneath, world_of};
use crate::{all_with, app, with_frames_of};
use bevy_app::{App, FixedUpdate};
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
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

/// Gives an entity another parent, or none, and leaves it where it is, as Bevy's `set_parent_in_place` does.
fn put_beneath(world: &mut World, entity: Entity, parent: Option<Entity>) {
    let local = local_beneath(world, parent, world_of(world, entity));
    let mut entity = world.entity_mut(entity);
    entity.remove::<ChildOf>();
    if let Some(parent) = parent {
        entity.insert(ChildOf(parent));
    }
    entity.insert(local);
}

// Who was handed to another parent in a step was drawn between two places of different frames: its own, or that of a piece.
#[test]
fn a_body_moves_evenly_whoever_its_parents_are() {
    #[derive(Resource, Default)]
    struct Due(Vec<(Entity, Option<Entity>)>);
    fn hand_over(world: &mut World) {
        for (entity, parent) in std::mem::take(&mut world.resource_mut::<Due>().0) {
            // Who sets the place of what is kinematic says where it is to be after the step.
            if world.get::<ChildOf>(entity).map(ChildOf::parent) != parent {
                put_beneath(world, entity, parent);
            }
        }
    }
    for seed in 0..8 {
        let mut dice = Dice::new(seed);
        let mut app = smooth_app();
        app.init_resource::<Due>()
            .add_systems(FixedUpdate, hand_over);
        let velocity = dice.vector(-4.0, 4.0);
        let apart = CollisionLayers {
            memberships: 1,
            filters: 0,
        };
        let kind = [RigidBody::Dynamic, RigidBody::Kinematic][dice.below(2)];
        let body = (kind, cube(), LinearVelocity(velocity), apart);
        let body = app.world_mut().spawn(body).id();
        let parents = [(); 3].map(|()| {
            let place = Transform::from_translation(dice.vector(-9.0, 9.0));
            let place = place.with_rotation(dice.rotation());
            app.world_mut().spawn(place).id()
        });
        // One that breaks at some time, and goes as fast.
        let block = (RigidBody::Dynamic, cube(), LinearVelocity(velocity), apart);
        let start = Transform::from_translation(dice.vector(-9.0, 9.0));
        let block = app.world_mut().spawn((block, start)).id();
        (0..4).for_each(|_| app.update());
        let mut before = world_of(app.world(), body).translation;
        for frame in 0..120 {
            let seconds = f64::from(dice.in_range(0.002, 0.05));
            let choice = [None, Some(parents[0]), Some(parents[1]), Some(block)];
            // Beneath what moves, only what is dynamic goes its own way.
            let count = 3 + usize::from(kind == RigidBody::Dynamic);
            let parent = choice[dice.below(count)].filter(|it| app.world().get_entity(*it).is_ok());
            match dice.below(12) {
                0 | 1 => app.world_mut().resource_mut::<Due>().0.push((body, parent)),
                2 if frame > 60 && app.world().get_entity(block).is_ok() => {
                    let middle = world_of(app.world(), block).translation;
                    let plane = Plane::through(middle.into(), dice.direction());
                    app.world_mut().commands().slice(block, plane);
                }
                _ => {}
            }
            with_frames_of(&mut app, seconds);
            app.update();
            let now = world_of(app.world(), body).translation;
            let way = Vec3::from(now - before);
            let off = way.distance(seconds as f32 * velocity);
            assert!(
                off < 2e-3,
                "seed {seed} {kind:?} {:?}, frame {frame}: {way} m in {seconds} s at {velocity} m/s",
                app.world().get::<ChildOf>(body)
            );
            before = now;
        }
    }
}

// It stayed where it was drawn between two steps, and went on from there.
#[test]
fn who_is_disabled_between_steps_is_where_the_last_step_left_it() {
    let mut app = smooth_app();
    with_frames_of(&mut app, STEP * 0.7);
    let velocity = LinearVelocity(6.0 * Vec3::X);
    let body = (RigidBody::Dynamic, cube(), velocity);
    let body = app.world_mut().spawn(body).id();
    (0..20).for_each(|_| app.update());
    let pose = |app: &App| {
        let handle = app
            .world()
            .get::<BodyHandle>(body)
            .and_then(BodyHandle::get);
        let (slot, _) = handle.expect("a body");
        app.world().resource::<Bodies>().pose(slot).position
    };
    let left = pose(&app);
    assert_ne!(place(&app, body), left);
    app.world_mut().entity_mut(body).insert(Disabled);
    (0..3).for_each(|_| app.update());
    assert_eq!(place(&app, body), left);
}

// A push at a point was taken from where the body was drawn, which is up to a step behind.
#[test]
fn who_is_pushed_where_a_ray_hits_turns_as_without_it() {
    /// Shoots at the body from the side, on its way.
    fn shoot(space: SpatialQuery, mut bodies: Query<Forces>, mut shots: Local<usize>) {
        *shots += 1;
        let ahead = Vec3::new(0.05 * *shots as f32 + 0.2, 0.3, 5.0);
        let ray = Ray::new(ahead, Vec3::NEG_Z, 50.0).expect("a ray");
        let Some(hit) = space.cast_ray(&ray, &QueryFilter::all()) else {
            return;
        };
        if let Ok(mut forces) = bodies.get_mut(hit.body) {
            forces.apply_impulse_at(-8.0 * hit.normal, hit.point);
            forces.apply_force_at(-90.0 * hit.normal, hit.point);
        }
    }
    let motion = |is_smooth: bool, rate: f64, is_child: bool| {
        let mut app = app();
        if is_smooth {
            app.add_plugins(InterpolationPlugin);
        }
        app.insert_resource(Gravity(Vec3::ZERO))
            .add_systems(bevy_app::Update, shoot);
        app.finish();
        app.cleanup();
        with_frames_of(&mut app, 1.0 / rate);
        let velocity = LinearVelocity(0.05 * rate as f32 * Vec3::X);
        let spin = AngularVelocity(Vec3::new(0.0, 0.4, 0.1));
        let body = (RigidBody::Dynamic, cube(), velocity, spin);
        let body = app.world_mut().spawn(body).id();
        if is_child {
            let parent = app.world_mut().spawn(Transform::from_xyz(0.5, 0.0, 0.0));
            let parent = parent.id();
            put_beneath(app.world_mut(), body, Some(parent));
        }
        (0..(0.4 * rate) as usize).for_each(|_| app.update());
        let bodies = app.world().resource::<Bodies>();
        let slots = bodies.iter();
        let poses = slots.map(|slot| (bodies.pose(slot), bodies.velocity(slot)));
        let poses: Vec<_> = poses.collect();
        assert!(poses[0].1.1.length() > 0.6, "it was hit: {poses:?}");
        format!("{poses:?}")
    };
    for rate in [45.0, 75.0, 144.0] {
        for is_child in [false, true] {
            let (smooth, plain) = (motion(true, rate, is_child), motion(false, rate, is_child));
            assert_eq!(smooth, plain, "{rate} Hz {is_child}");
        }
    }
}

#[test]
fn a_body_goes_on_evenly_from_where_it_is_taken_back_to() {
    // In frames of a step what is drawn is the pose before the last one.
    for rate in [60.0, 100.0, 144.0] {
        let mut app = app();
        app.add_plugins((InterpolationPlugin, RewindPlugin::default()))
            .insert_resource(Gravity(Vec3::ZERO));
        app.finish();
        app.cleanup();
        with_frames_of(&mut app, 1.0 / rate);
        let body = (RigidBody::Dynamic, cube(), LinearVelocity(3.0 * Vec3::X));
        let body = app.world_mut().spawn(body).id();
        (0..30).for_each(|_| app.update());
        for steps in [1, 4, 0] {
            let before = place(&app, body);
            app.world_mut().commands().rewind(steps);
            app.world_mut().flush();
            app.update();
            let way = f64::from((place(&app, body) - before).x) / 3.0;
            let expected = 1.0 / rate - steps as f64 * STEP;
            // What is drawn lies up to a step behind.
            assert!((way - expected).abs() < 1.01 * STEP, "{way} s at {rate} Hz");
            let mut before = place(&app, body);
            for _ in 0..10 {
                app.update();
                let now = place(&app, body);
                let speed = f64::from((now - before).x) * rate;
                assert!((speed - 3.0).abs() < 0.02, "{speed} m/s at {rate} Hz");
                before = now;
            }
        }
    }
}
