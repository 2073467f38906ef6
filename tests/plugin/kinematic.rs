//! Kinematic bodies whose `Transform` is set anew in every step: what differs from where they are by rounding leaves their motion
//! alone, what is more brings them there.
#![allow(clippy::disallowed_methods, reason = "lengths and angles of scenes")]

use crate::app::app;
use crate::common::dice::Dice;
use crate::hierarchy::{local_beneath, world_of};
use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_math::{Quat, Vec3};
use bevy_time::{Fixed, Time};
use bevy_transform::components::{GlobalTransform, Transform};
use std::time::Duration;

/// One body that touches nothing, perhaps beneath a parent, 1 cm to 10 km from the origin, 30 to 240 steps a second.
struct Scene {
    app: App,
    body: Entity,
    parent: Option<Entity>,
    /// s.
    step_dt: f32,
    /// Largest coordinate of what its pose is computed from, m.
    size: f32,
    about: String,
}

impl Scene {
    fn new(dice: &mut Dice, velocity: (Vec3, Vec3)) -> Self {
        let mut app = app();
        app.insert_resource(Gravity(Vec3::ZERO));
        let rate = [30.0, 60.0, 144.0, 240.0][dice.below(4)];
        let step = Duration::from_secs_f64(1.0 / rate);
        app.insert_resource(Time::<Fixed>::from_duration(step));
        let far = far(dice);
        let place =
            Transform::from_translation(far * dice.direction()).with_rotation(dice.rotation());
        let parent = (dice.below(2) == 0).then(|| {
            let scale = [1.0, dice.in_range(0.3, 3.0)][dice.below(2)];
            let above = Transform::from_translation(far * dice.direction())
                .with_rotation(dice.rotation())
                .with_scale(Vec3::splat(scale));
            app.world_mut().spawn(above).id()
        });
        let cube = ConvexMesh::cuboid(1.0, 0.5, 2.0).expect("a box");
        let (linear, angular) = (LinearVelocity(velocity.0), AngularVelocity(velocity.1));
        let local = local_beneath(app.world(), parent, place.compute_affine());
        let parts = (RigidBody::Kinematic, cube, local, linear, angular);
        let body = app.world_mut().spawn(parts).id();
        if let Some(parent) = parent {
            app.world_mut().entity_mut(body).insert(ChildOf(parent));
        }
        app.update();
        Self {
            about: format!("{far} m, {rate} Hz, {parent:?}, {velocity:?}"),
            app,
            body,
            parent,
            step_dt: step.as_secs_f32(),
            size: far.max(1.0),
        }
    }

    fn place(&self) -> (Vec3, Quat) {
        let world = self.app.world();
        let handle = world.get::<BodyHandle>(self.body).expect("a body");
        let (slot, _) = handle.get().expect("a body");
        let pose = world.resource::<Bodies>().pose(slot);
        (pose.position, pose.rotation)
    }

    fn transform(&self) -> Transform {
        *self.app.world().get(self.body).expect("it has one")
    }

    fn set(&mut self, transform: Transform) {
        let mut own = self.app.world_mut().get_mut::<Transform>(self.body);
        **own.as_mut().expect("it has one") = transform;
    }

    /// What differs by rounding of coordinates of the scene, m.
    fn rounding(&self) -> f32 {
        f32::EPSILON * self.size
    }
}

/// 1 cm to 10 km.
fn far(dice: &mut Dice) -> f32 {
    let decade = [0.01, 0.1, 1.0, 10.0, 100.0, 1000.0][dice.below(6)];
    decade * dice.in_range(1.0, 10.0)
}

/// The same `Transform` as somebody computes it who comes by another way: one of six, of which the last, through another frame and
/// back, rounds most.
fn again(dice: &mut Dice, transform: Transform, ways: usize) -> Transform {
    let off = |dice: &mut Dice, x: f32| {
        f32::from_bits((x.to_bits() + 2).saturating_sub(dice.below(5) as u32))
    };
    let mut it = transform;
    match dice.below(ways) {
        0 => {}
        1 => it.rotation = -it.rotation,
        2 => it.rotation = it.rotation.normalize(),
        3 => it.translation = Vec3::from_array(it.translation.to_array().map(|x| off(dice, x))),
        4 => it = GlobalTransform::from(it).compute_transform(),
        _ => {
            let at = it.translation.length() * dice.direction();
            let frame = Transform::from_translation(at)
                .with_rotation(dice.rotation())
                .with_scale(Vec3::splat(dice.in_range(0.3, 3.0)));
            let frame = frame.compute_affine();
            let seen = frame.inverse() * it.compute_affine();
            it = GlobalTransform::from(frame * seen).compute_transform();
        }
    }
    it.scale = transform.scale;
    it
}

fn turn_between(a: Quat, b: Quat) -> f32 {
    (a - b).length().min((a + b).length())
}

// It stood still in that step, or turned back, as it was to be where its `Transform` said at the end of it.
#[test]
fn a_moving_body_goes_on_if_its_transform_is_set_anew_with_rounding() {
    for seed in 0..200 {
        let dice = &mut Dice::new(seed);
        let velocity = (dice.vector(-5.0, 5.0), dice.vector(-5.0, 5.0));
        let mut scene = Scene::new(dice, velocity);
        for step in 0..20 {
            let written = again(dice, scene.transform(), 6);
            let before = scene.place();
            scene.set(written);
            scene.app.update();
            let after = scene.place();
            let about = || format!("seed {seed}, step {step}: {}", scene.about);
            let way = scene.step_dt * velocity.0;
            let missed = (after.0 - before.0 - way).length();
            let allowed = 4.0 * scene.rounding() + 1e-3 * way.length();
            assert!(missed <= allowed, "{missed} m of {way}, {}", about());
            let turn = turn_between(after.1, before.1);
            let expected = 0.5 * scene.step_dt * velocity.1.length();
            assert!(
                (turn / expected - 1.0).abs() < 0.01,
                "{turn} for {expected}, {}",
                about()
            );
        }
    }
}

// At 10 km it went by the decimetre beneath a parent.
#[test]
fn a_body_that_is_set_elsewhere_is_there_after_the_step() {
    for seed in 0..200 {
        let dice = &mut Dice::new(seed);
        let moves = [0.0, 1.0][dice.below(2)];
        let velocity = (
            moves * dice.vector(-5.0, 5.0),
            moves * dice.vector(-5.0, 5.0),
        );
        let mut scene = Scene::new(dice, velocity);
        for step in 0..20 {
            let below = scene.transform();
            let above = world_of(scene.app.world(), scene.body) * below.compute_affine().inverse();
            let (scale, ..) = above.to_scale_rotation_translation();
            // From what is more than rounding to less than a diameter of the body, beyond which it is a jump.
            let least = 50.0 * scene.rounding();
            let share = dice.unit();
            let shift = least * (1.0 / least).powf(share);
            let turn = 1e-4 * 1e3f32.powf(dice.unit());
            let mut moved = below;
            moved.translation += shift / scale.x * dice.direction();
            let turns = dice.below(2) == 0;
            if turns {
                let turn = Quat::from_axis_angle(dice.direction(), turn);
                moved.rotation = (turn * moved.rotation).normalize();
            }
            // By its parent, half of the time.
            let world = above * moved.compute_affine();
            match scene.parent.filter(|_| dice.below(2) == 0) {
                Some(parent) => {
                    let above = world * below.compute_affine().inverse();
                    let above = GlobalTransform::from(above).compute_transform();
                    scene.app.world_mut().entity_mut(parent).insert(above);
                }
                None => scene.set(moved),
            }
            scene.app.update();
            let (_, rotation, position) = world.to_scale_rotation_translation();
            let (at, turned) = scene.place();
            let missed = at.distance(position);
            let about = || format!("seed {seed}, step {step}: {shift} m, {}", scene.about);
            assert!(missed <= 16.0 * scene.rounding(), "{missed} m, {}", about());
            let missed = turn_between(turned, rotation);
            assert!(missed <= 4e-6, "{missed} rad, {}", about());
        }
    }
}

// Not more than told from rounding, step by step: they add up, whoever sets it, and to what its `Transform` says.
#[test]
fn a_body_at_rest_goes_as_slowly_as_it_is_pushed_on() {
    for seed in 0..100 {
        let dice = &mut Dice::new(seed);
        let mut scene = Scene::new(dice, (Vec3::ZERO, Vec3::ZERO));
        let axis = dice.below(3);
        let from = scene.transform();
        let push = dice.in_range(1.0, 3.0) * scene.rounding();
        for _ in 0..200 {
            let mut moved = scene.transform();
            moved.translation[axis] += push;
            scene.set(moved);
            scene.app.update();
        }
        let way = scene.transform().translation[axis] - from.translation[axis];
        assert!(
            way > 90.0 * push,
            "{way} m by {push}, seed {seed}: {}",
            scene.about
        );
        let (_, _, world) = world_of(scene.app.world(), scene.body).to_scale_rotation_translation();
        let off = scene.place().0.distance(world);
        assert!(
            off <= 32.0 * scene.rounding(),
            "{off} m, seed {seed}: {}",
            scene.about
        );
    }
}

// Each time it was a motion, which wakes.
#[test]
fn what_sleeps_on_a_body_sleeps_on_while_that_is_set_anew_with_rounding() {
    for seed in 0..20 {
        let dice = &mut Dice::new(seed);
        let mut app = app();
        let at = 10.0f32.powf(dice.in_range(-1.0, 2.0)) * dice.direction();
        let turn = Quat::from_rotation_y(dice.in_range(-3.0, 3.0));
        let plate = ConvexMesh::cuboid(4.0, 0.2, 4.0).expect("a plate");
        let place = Transform::from_translation(at).with_rotation(turn);
        let world = app.world_mut();
        let lift = world.spawn((RigidBody::Kinematic, plate, place)).id();
        let cube = ConvexMesh::cuboid(0.5, 0.5, 0.5).expect("a cube");
        let above = Transform::from_translation(at + 0.35 * Vec3::Y).with_rotation(turn);
        let load = world.spawn((RigidBody::Dynamic, cube, above)).id();
        (0..120).for_each(|_| app.update());
        let sleeps = |app: &App| app.world().get::<Sleeping>(load).is_some();
        assert!(sleeps(&app), "seed {seed}: {at}");
        for _ in 0..40 {
            let own = *app.world().get::<Transform>(lift).expect("it has one");
            let again = again(dice, place, 5);
            app.world_mut().entity_mut(lift).insert(again);
            app.update();
            assert!(sleeps(&app), "seed {seed}: {at}, {own:?}");
        }
    }
}
