//! Joints as entities.

use crate::scene::{cuboid, fixed};
use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_time::Time;
use bevy_transform::components::Transform;
use glam::Vec3;
use std::time::Duration;

pub(crate) fn app() -> App {
    let mut app = App::new();
    app.init_resource::<Time>();
    app.add_plugins(CleavePlugin::new(bevy_app::Update));
    app
}

pub(crate) fn step(app: &mut App) {
    app.world_mut()
        .resource_mut::<Time>()
        .advance_by(Duration::from_secs_f64(1.0 / 60.0));
    app.update();
}

pub(crate) fn steps(app: &mut App, count: usize) {
    for _ in 0..count {
        step(app);
    }
}

pub(crate) fn bob(app: &mut App, at: Vec3) -> Entity {
    let body = BodyDesc::dynamic(cuboid(0.5, 0.5, 0.5), at);
    app.world_mut().spawn_body(body)
}

pub(crate) fn join(app: &mut App, a: Option<Entity>, b: Entity, joint: Joint) -> Entity {
    let id = app.world_mut().commands().join(a, b, joint);
    app.world_mut().flush();
    id
}

pub(crate) fn place(app: &App, entity: Entity) -> Vec3 {
    app.world()
        .get::<Transform>(entity)
        .expect("placed")
        .translation
}

/// A bob that hangs 1 m below the origin.
pub(crate) fn hanging(app: &mut App) -> (Entity, Entity) {
    let bob = bob(app, Vec3::NEG_Y);
    let joint = Joint::ball().with_anchors(Vec3::ZERO, Vec3::Y);
    (bob, join(app, None, bob, joint))
}

#[test]
fn a_joint_holds_and_tells_what_it_bears() {
    let mut app = app();
    let (bob, joint) = hanging(&mut app);
    steps(&mut app, 30);
    assert!(place(&app, bob).distance(Vec3::NEG_Y) < 1e-5);
    let load = app.world().get::<JointLoad>(joint).expect("required");
    let weight = 125.0 * 9.81;
    assert!((load.force.y - weight).abs() < 1e-3 * weight, "{load:?}");
}

#[test]
fn a_joint_goes_with_its_entity_and_with_its_bodies() {
    let mut app = app();
    let (bob, joint) = hanging(&mut app);
    step(&mut app);
    app.world_mut().despawn(joint);
    steps(&mut app, 30);
    assert!(place(&app, bob).y < -1.5);
    assert!(app.world().resource::<Joints>().is_empty());
    let (bob, joint) = hanging(&mut app);
    step(&mut app);
    app.world_mut().despawn(bob);
    step(&mut app);
    assert!(app.world().get_entity(joint).is_err());
    assert!(app.world().resource::<Joints>().is_empty());
}

#[test]
fn a_disabled_joint_or_body_lets_go_and_holds_again() {
    let mut app = app();
    let (bob, joint) = hanging(&mut app);
    steps(&mut app, 2);
    app.world_mut().entity_mut(joint).insert(Disabled);
    steps(&mut app, 10);
    assert!(place(&app, bob).y < -1.05);
    app.world_mut().entity_mut(joint).remove::<Disabled>();
    steps(&mut app, 120);
    assert!((place(&app, bob).length() - 1.0).abs() < 1e-4);
}

#[test]
fn another_kind_of_body_and_another_joint_are_followed() {
    let mut app = app();
    let (bob, joint) = hanging(&mut app);
    step(&mut app);
    app.world_mut().entity_mut(bob).insert(RigidBody::Static);
    step(&mut app);
    let problem = app.world().get::<JointProblem>(joint).copied();
    assert_eq!(problem, Some(JointProblem(JointError::NothingMoves)));
    app.world_mut().entity_mut(bob).insert(RigidBody::Dynamic);
    steps(&mut app, 30);
    assert_eq!(app.world().get::<JointProblem>(joint), None);
    assert!(place(&app, bob).distance(Vec3::NEG_Y) < 1e-5);
    app.world_mut()
        .get_mut::<Joint>(joint)
        .expect("there")
        .linear = [JointAxis::FREE; 3];
    steps(&mut app, 30);
    assert!(place(&app, bob).y < -1.5);
}

#[test]
fn what_is_unusable_is_named_on_the_entity() {
    let mut app = app();
    let bob = bob(&mut app, Vec3::NEG_Y);
    let nobody = app.world_mut().spawn_empty().id();
    let ground = app.world_mut().spawn_body(fixed(Vec3::ZERO));
    let other = app.world_mut().spawn_body(fixed(Vec3::X));
    let nan = Joint::ball().with_anchors(Vec3::NAN, Vec3::ZERO);
    let zero = Joint::hinge().with_axes(Vec3::ZERO, Vec3::X);
    for (a, b, joint, expected) in [
        (Some(nobody), bob, Joint::fixed(), JointError::NoBody),
        (
            Some(ground),
            other,
            Joint::fixed(),
            JointError::NothingMoves,
        ),
        (Some(bob), bob, Joint::fixed(), JointError::SameBody),
        (None, bob, nan, JointError::NotFinite("an anchor")),
        (None, bob, zero, JointError::Axis { length: 0.0 }),
    ] {
        let entity = join(&mut app, a, b, joint);
        steps(&mut app, 2);
        let problem = app.world().get::<JointProblem>(entity).copied();
        assert_eq!(problem, Some(JointProblem(expected)));
        app.world_mut().despawn(entity);
    }
}

#[derive(Resource, Default)]
struct Heard(Vec<Entity>);

#[test]
fn a_joint_that_breaks_says_so_once_and_can_be_mended() {
    let mut app = app();
    app.init_resource::<Heard>();
    app.add_observer(|broken: On<JointBroken>, mut heard: ResMut<Heard>| {
        heard.0.push(broken.entity);
    });
    let bob = bob(&mut app, Vec3::NEG_Y);
    let weak = Joint::ball()
        .with_anchors(Vec3::ZERO, Vec3::Y)
        .with_strength(100.0, 1.0);
    let entity = join(&mut app, None, bob, weak);
    steps(&mut app, 3);
    assert_eq!(app.world().resource::<Heard>().0, [entity]);
    let messages = app.world().resource::<Messages<JointBroken>>();
    let sent: Vec<_> = messages.iter_current_update_messages().collect();
    assert!(sent.len() <= 1);
    assert!(app.world().get::<Joint>(entity).is_none());
    let fell = place(&app, bob).y;
    app.world_mut()
        .entity_mut(entity)
        .insert(Joint::ball().with_anchors(Vec3::ZERO, Vec3::Y));
    steps(&mut app, 60);
    assert!(place(&app, bob).length() < 1.0 + (fell.abs() - 1.0) + 1e-3);
}

#[test]
fn a_cut_body_leaves_its_joints_to_the_pieces_that_own_the_anchors() {
    let mut app = app();
    let beam = BodyDesc::dynamic(cuboid(2.0, 0.2, 0.2), Vec3::ZERO);
    let beam = app.world_mut().spawn_body(beam);
    let at = Vec3::new(0.9, 0.0, 0.0);
    let left = join(&mut app, None, beam, Joint::ball().with_anchors(-at, -at));
    let right = join(&mut app, None, beam, Joint::ball().with_anchors(at, at));
    steps(&mut app, 5);
    assert!(place(&app, beam).length() < 1e-5);
    let plane = Plane::through(Vec3::ZERO, Vec3::X);
    app.world_mut().commands().slice(beam, plane);
    step(&mut app);
    let owners = [left, right].map(|joint| app.world().get::<JointB>(joint).expect("kept").0);
    assert_ne!(owners[0], owners[1]);
    assert!(app.world().get_entity(beam).is_err());
    for (owner, x) in owners.into_iter().zip([-0.5, 0.5]) {
        assert!((place(&app, owner).x - x).abs() < 0.05);
    }
    steps(&mut app, 30);
    let joints = app.world().resource::<Joints>();
    assert_eq!(joints.len(), 2);
    for joint in [left, right] {
        let load = app.world().get::<JointLoad>(joint).expect("required");
        assert!(load.error[0] < 1e-5, "{load:?}");
    }
}

#[test]
fn what_hangs_at_rest_sleeps_and_wakes_with_what_it_hangs_on() {
    let mut app = app();
    app.world_mut().resource_mut::<SolverConfig>().sleep = SleepConfig::default();
    let hook = BodyDesc {
        kind: RigidBody::Kinematic,
        ..fixed(Vec3::ZERO)
    };
    let hook = app.world_mut().spawn_body(hook);
    let bob = bob(&mut app, Vec3::NEG_Y);
    let joint = Joint::ball().with_anchors(Vec3::ZERO, Vec3::Y);
    join(&mut app, Some(hook), bob, joint);
    steps(&mut app, 90);
    assert!(app.world().get::<Sleeping>(bob).is_some());
    let asleep = place(&app, bob);
    app.world_mut()
        .get_mut::<LinearVelocity>(hook)
        .expect("a body")
        .0 = Vec3::X;
    steps(&mut app, 10);
    assert!(app.world().get::<Sleeping>(bob).is_none());
    assert!(place(&app, bob).x > asleep.x + 1e-3);
}
