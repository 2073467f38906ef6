//! Bad input is named and left out; the rest of the scene does not notice, bit for bit.

use crate::app::{app, bits_of_entity};
use crate::common::scenes::falling_and_breaking;
use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::{Quat, Vec3};

const STEPS: usize = 90;
/// The step before which the disturbance happens, once everything moves and some touch.
const DISTURBED_AT: usize = 30;

/// What the scene looks like in the end, and what was warned about.
struct Outcome {
    motion: Vec<Vec<u32>>,
    warnings: Vec<BodyWarning>,
    /// The entity that is meant to be warned about.
    bad: Option<Entity>,
}

/// Runs the scene; `spawn_bad` adds an entity in its middle, `disturb` does something to it later.
///
/// Entities of pieces are compared too: all that have a body, except the bad one, in the order of their ids.
fn run(
    spawn_bad: impl FnOnce(&mut World) -> Option<Entity>,
    disturb: impl FnOnce(&mut World, Option<Entity>),
) -> Outcome {
    let mut app = app();
    let scene = falling_and_breaking();
    let (before, after) = scene.split_at(6);
    for desc in before {
        app.world_mut().spawn_body(desc.clone());
    }
    let bad = spawn_bad(app.world_mut());
    for desc in after {
        app.world_mut().spawn_body(desc.clone());
    }
    let (mut disturb, mut warnings) = (Some(disturb), Vec::new());
    for step in 0..STEPS {
        if step == DISTURBED_AT
            && let Some(disturb) = disturb.take()
        {
            disturb(app.world_mut(), bad);
        }
        app.update();
        let messages = app.world().resource::<Messages<BodyWarning>>();
        warnings.extend(messages.iter_current_update_messages().cloned());
    }
    let world = app.world_mut();
    let mut bodies = world.query::<(Entity, &BodyHandle)>();
    let mut found: Vec<_> = bodies
        .iter(world)
        .filter(|(entity, _)| Some(*entity) != bad)
        .map(|(entity, handle)| (handle.get().map(|(_, id)| id), entity))
        .collect();
    found.sort();
    let motion = found
        .iter()
        .map(|(_, entity)| bits_of_entity(world, *entity))
        .collect();
    Outcome {
        motion,
        warnings,
        bad,
    }
}

fn undisturbed() -> Outcome {
    run(|_| None, |_, _| ())
}

/// A body far from the others, so that it never touches them.
fn bystander(world: &mut World) -> Option<Entity> {
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    Some(
        world
            .spawn((
                RigidBody::Dynamic,
                cube,
                Transform::from_xyz(100.0, 5.0, 0.0),
            ))
            .id(),
    )
}

/// One warning about the entity, and nobody else noticed.
fn check_warned(outcome: &Outcome, expected: impl Fn(&BodyProblem) -> bool) {
    let [warning] = &outcome.warnings[..] else {
        panic!("exactly one warning expected, got {:?}", outcome.warnings)
    };
    assert!(expected(&warning.problem), "{warning:?}");
    assert_eq!(Some(warning.entity), outcome.bad, "{warning:?}");
    assert!(
        outcome.motion == undisturbed().motion,
        "the rest of the scene noticed"
    );
}

fn is_not_finite(problem: &BodyProblem) -> bool {
    matches!(problem, BodyProblem::Body(BodyError::NotFinite(_)))
}

fn spawn_with(bundle: impl Bundle) -> impl FnOnce(&mut World) -> Option<Entity> {
    move |world| {
        let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
        let body = (RigidBody::Dynamic, cube, Transform::from_xyz(0.3, 2.0, 0.1));
        Some(world.spawn(body).insert(bundle).id())
    }
}

#[test]
fn body_spawned_with_a_nan_pose_is_left_out() {
    let nan = Transform::from_xyz(f32::NAN, 0.0, 0.0);
    check_warned(&run(spawn_with(nan), |_, _| ()), is_not_finite);
}

#[test]
fn body_spawned_with_infinite_velocity_is_left_out() {
    let bad = LinearVelocity(Vec3::new(0.0, f32::INFINITY, 0.0));
    check_warned(&run(spawn_with(bad), |_, _| ()), is_not_finite);
}

#[test]
fn body_with_a_rotation_that_is_not_one_is_left_out() {
    let bad = Transform::from_rotation(Quat::from_xyzw(1.0, 1.0, 1.0, 1.0));
    let expected =
        |p: &BodyProblem| matches!(p, BodyProblem::Body(BodyError::NotUnitRotation { .. }));
    check_warned(&run(spawn_with(bad), |_, _| ()), expected);
}

#[test]
fn negative_density_is_refused() {
    for density in [-1.0, 0.0, f32::NAN] {
        let outcome = run(spawn_with(Density(density)), |_, _| ());
        check_warned(&outcome, |p| {
            matches!(p, BodyProblem::Body(BodyError::Mass(_)))
        });
    }
}

#[test]
fn friction_and_restitution_out_of_range_are_refused() {
    let expected = |p: &BodyProblem| matches!(p, BodyProblem::Body(BodyError::Material(_)));
    check_warned(&run(spawn_with(Friction::new(-0.1)), |_, _| ()), expected);
    check_warned(&run(spawn_with(Restitution::new(1.5)), |_, _| ()), expected);
}

#[test]
fn transform_scaled_to_nothing_is_refused() {
    let scaled = Transform::from_scale(Vec3::ZERO);
    let expected = |p: &BodyProblem| matches!(p, BodyProblem::Body(BodyError::Scaled(_)));
    check_warned(&run(spawn_with(scaled), |_, _| ()), expected);
}

#[test]
fn body_without_a_shape_and_dynamic_half_space_are_refused() {
    let shapeless = |world: &mut World| Some(world.spawn(RigidBody::Dynamic).id());
    check_warned(&run(shapeless, |_, _| ()), |p| {
        matches!(p, BodyProblem::Body(BodyError::NoShape))
    });
    let falling_floor = |world: &mut World| {
        Some(
            world
                .spawn((RigidBody::Dynamic, HalfSpaceShape { normal: Vec3::Y }))
                .id(),
        )
    };
    check_warned(&run(falling_floor, |_, _| ()), |p| {
        matches!(p, BodyProblem::Body(BodyError::DynamicHalfSpace))
    });
}

#[test]
fn half_space_without_a_direction_is_refused() {
    for normal in [Vec3::ZERO, Vec3::NAN] {
        let floor = move |world: &mut World| {
            Some(
                world
                    .spawn((RigidBody::Static, HalfSpaceShape { normal }))
                    .id(),
            )
        };
        check_warned(&run(floor, |_, _| ()), |p| {
            matches!(p, BodyProblem::Body(BodyError::HalfSpace(_)))
        });
    }
}

#[test]
fn shape_that_is_taken_away_is_missed_but_the_body_stays() {
    let outcome = run(bystander, |world, bad| {
        world
            .entity_mut(bad.expect("spawned"))
            .remove::<ConvexMesh>();
    });
    check_warned(&outcome, |p| {
        matches!(p, BodyProblem::Body(BodyError::NoShape))
    });
}

#[test]
fn bodies_without_entities_and_requests_without_bodies_harm_nobody() {
    let mut app = app();
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    let mut bodies = app.world_mut().resource_mut::<Bodies>();
    let slot = bodies
        .insert(BodyDesc::dynamic(cube, Vec3::ZERO))
        .expect("usable");
    let plane = Plane::through(Vec3::ZERO, Vec3::X);
    let request = CutRequest::in_world(&bodies, slot, plane).expect("a body");
    let lost = CutRequest {
        slot: 99,
        ..request
    };
    app.world_mut().resource_mut::<Fractures>().requests = vec![request, lost];
    app.update();
    assert_eq!(app.world().resource::<Bodies>().len(), 2, "two halves");
    let refused = &app.world().resource::<Fractures>().refused;
    assert!(matches!(refused[..], [(_, CutError::NoBody)]));
}

#[test]
fn fracturable_without_a_number_is_refused() {
    for fracturable in [
        Fracturable::with_strength(f32::NAN),
        Fracturable {
            min_volume: -1.0,
            ..Default::default()
        },
    ] {
        check_warned(&run(spawn_with(fracturable), |_, _| ()), |p| {
            matches!(p, BodyProblem::Body(BodyError::Fracturable(_)))
        });
    }
}

#[test]
fn given_mass_cannot_be_divided() {
    let mass = MassOverride(MassProperties {
        mass: 5.0,
        principal: Vec3::ONE,
        ..Default::default()
    });
    let both = (mass, Fracturable::default());
    check_warned(&run(spawn_with(both), |_, _| ()), |p| {
        matches!(p, BodyProblem::Body(BodyError::FracturableOverride))
    });
    let outcome = run(bystander, |world, bad| {
        let bad = bad.expect("spawned");
        world.entity_mut(bad).insert(mass);
        let plane = Plane::through(Vec3::new(100.0, 0.0, 0.0), Vec3::X);
        world.commands().slice(bad, plane);
        world.flush();
    });
    check_warned(&outcome, |p| {
        matches!(p, BodyProblem::Cut(CutError::MassOverride))
    });
}

#[test]
fn component_that_is_taken_away_is_missed_until_it_is_back() {
    let mut app = app();
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    let body = app.world_mut().spawn((RigidBody::Dynamic, cube)).id();
    app.world_mut().entity_mut(body).remove::<Friction>();
    let incomplete = BodyProblem::Body(BodyError::Incomplete);
    let mut warned = Vec::new();
    for _ in 0..3 {
        app.update();
        let messages = app.world().resource::<Messages<BodyWarning>>();
        let problems = messages.iter_current_update_messages();
        warned.extend(problems.map(|warning| warning.problem.clone()));
    }
    assert_eq!(warned, [incomplete], "warned about once");
    app.world_mut().entity_mut(body).insert(Friction::default());
    app.update();
    assert_eq!(app.world().resource::<Bodies>().len(), 1);
}

#[test]
fn clones_of_bodies_are_bodies_of_their_own() {
    let mut app = app();
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    let body = app.world_mut().spawn((RigidBody::Dynamic, cube)).id();
    app.update();
    let clone = app.world_mut().entity_mut(body).clone_and_spawn();
    app.update();
    assert_eq!(app.world().resource::<Bodies>().len(), 2);
    app.world_mut().despawn(clone);
    app.update();
    assert_eq!(app.world().resource::<Bodies>().len(), 1);
    app.world_mut().entity_mut(body).remove::<BodyHandle>();
    app.update();
    assert_eq!(app.world().resource::<Bodies>().len(), 0, "nothing leaks");
}

#[test]
fn bodies_that_are_taken_from_under_their_entities_harm_nobody() {
    let mut app = app();
    for desc in falling_and_breaking() {
        app.world_mut().spawn_body(desc);
    }
    app.update();
    app.world_mut().resource_mut::<Bodies>().remove(3);
    app.update();
    app.world_mut().insert_resource(Bodies::default());
    app.update();
    assert!(app.world().resource::<Bodies>().is_empty());
}

#[test]
fn kind_can_be_switched_and_a_static_body_forgets_its_velocity() {
    let mut app = app();
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    let body = app.world_mut().spawn((RigidBody::Dynamic, cube)).id();
    for _ in 0..30 {
        app.update();
    }
    let velocity = |app: &App| {
        app.world()
            .entity(body)
            .get::<LinearVelocity>()
            .expect("there")
            .0
    };
    assert!(velocity(&app).y < -4.0);
    app.world_mut().entity_mut(body).insert(RigidBody::Static);
    app.update();
    app.update();
    assert_eq!(velocity(&app), Vec3::ZERO);
    app.world_mut().entity_mut(body).insert(RigidBody::Dynamic);
    app.update();
    let after = velocity(&app).y;
    assert!(
        after < 0.0 && after > -0.5,
        "falls from rest, at {after} m/s"
    );
    assert_eq!(app.world().resource::<Bodies>().len(), 1);
}

/// Its issue says what to do, and that does it.
#[test]
fn a_velocity_that_was_set_while_a_body_was_static_acts_once_it_moves() {
    for kind in [RigidBody::Dynamic, RigidBody::Kinematic] {
        let mut app = app();
        app.insert_resource(Gravity(Vec3::ZERO));
        let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
        let body = app.world_mut().spawn((RigidBody::Static, cube)).id();
        app.update();
        let velocity = LinearVelocity(Vec3::X);
        app.world_mut().entity_mut(body).insert(velocity);
        app.update();
        assert!(app.world().get::<BodyIssues>(body).is_some());
        app.world_mut().entity_mut(body).insert(kind);
        (0..60).for_each(|_| app.update());
        assert!(app.world().get::<BodyIssues>(body).is_none());
        let at = app.world().get::<Transform>(body).expect("there");
        assert!((at.translation.x - 1.0).abs() < 1e-3, "{at:?}");
    }
}

#[test]
fn pose_that_becomes_nan_takes_the_body_out() {
    let outcome = run(bystander, |world, bad| {
        let mut entity = world.entity_mut(bad.expect("spawned"));
        entity.get_mut::<Transform>().expect("there").translation.y = f32::NAN;
    });
    check_warned(&outcome, is_not_finite);
}

/// Finite, but no rotation can tell a turn by so many radians in a step.
#[test]
fn what_turns_too_fast_is_stopped_and_named() {
    let mut app = app();
    let entity = bystander(app.world_mut()).expect("spawned");
    let too_fast = AngularVelocity(Vec3::new(1e12, 0.0, 0.0));
    app.world_mut().entity_mut(entity).insert(too_fast);
    app.update();
    let warnings = app.world().resource::<Messages<BodyWarning>>();
    let problem = BodyProblem::Body(BodyError::Overflow);
    let expected = BodyWarning { entity, problem };
    assert!(warnings.iter_current_update_messages().eq([&expected]));
    let body = app.world().entity(entity);
    let rotation = body.get::<Transform>().map(|t| t.rotation);
    assert_eq!(rotation, Some(Quat::IDENTITY));
    assert_eq!(body.get(), Some(&AngularVelocity(Vec3::ZERO)));
}

#[test]
fn body_comes_back_when_its_pose_is_mended() {
    let mut app = app();
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    let nan = Transform::from_xyz(0.0, f32::NAN, 0.0);
    let body = app.world_mut().spawn((RigidBody::Dynamic, cube, nan)).id();
    app.update();
    assert!(
        app.world()
            .entity(body)
            .get::<BodyHandle>()
            .expect("required")
            .get()
            .is_none()
    );
    app.world_mut()
        .entity_mut(body)
        .insert(Transform::from_xyz(0.0, 3.0, 0.0));
    app.update();
    let y = app
        .world()
        .entity(body)
        .get::<Transform>()
        .expect("there")
        .translation
        .y;
    assert!(
        y < 3.0 && y > 2.9,
        "it falls from where it was put, y = {y}"
    );
}

#[test]
fn density_that_becomes_negative_is_not_taken_over() {
    let outcome = run(bystander, |world, bad| {
        world
            .entity_mut(bad.expect("spawned"))
            .insert(Density(-5.0));
    });
    check_warned(&outcome, |p| {
        matches!(p, BodyProblem::Body(BodyError::Mass(_)))
    });
}

#[test]
fn cut_of_a_half_space_is_refused() {
    let floor = |world: &mut World| {
        let half_space = HalfSpaceShape { normal: Vec3::Y };
        let at = Transform::from_xyz(100.0, -50.0, 0.0);
        Some(world.spawn((RigidBody::Static, half_space, at)).id())
    };
    let outcome = run(floor, |world, bad| {
        let plane = Plane::through(Vec3::new(100.0, -60.0, 0.0), Vec3::X);
        world.commands().slice(bad.expect("spawned"), plane);
        world.flush();
    });
    check_warned(&outcome, |p| {
        matches!(p, BodyProblem::Cut(CutError::NotConvex))
    });
}

#[test]
fn cuts_that_cannot_be_made_are_refused() {
    let through = Vec3::new(100.0, 5.0, 0.0);
    let without_offset = Plane {
        normal: Vec3::X,
        offset: f32::NAN,
    };
    let no_plane = |e: &CutError| matches!(e, CutError::Slice(_));
    check_refused(Plane::through(through, Vec3::ZERO), no_plane);
    check_refused(without_offset, no_plane);
    let beside = Plane::through(Vec3::new(200.0, 0.0, 0.0), Vec3::X);
    check_refused(beside, |e| matches!(e, CutError::Missed));
}

fn check_refused(plane: Plane, expected: impl Fn(&CutError) -> bool) {
    let outcome = run(bystander, |world, bad| {
        world.commands().slice(bad.expect("spawned"), plane);
        world.flush();
    });
    check_warned(
        &outcome,
        |p| matches!(p, BodyProblem::Cut(e) if expected(e)),
    );
}

#[test]
fn cut_of_a_despawned_body_is_refused() {
    let outcome = run(bystander, |world, bad| {
        let bad = bad.expect("spawned");
        world
            .commands()
            .slice(bad, Plane::through(Vec3::ZERO, Vec3::X));
        world.flush();
        world.despawn(bad);
    });
    check_warned(&outcome, |p| {
        matches!(p, BodyProblem::Cut(CutError::NoBody))
    });
}

#[test]
fn two_cuts_of_one_body_in_one_step_are_both_made() {
    let mut app = app();
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    let body = app.world_mut().spawn((RigidBody::Dynamic, cube)).id();
    app.update();
    for normal in [Vec3::X, Vec3::Z] {
        app.world_mut()
            .commands()
            .slice(body, Plane::through(Vec3::ZERO, normal));
    }
    app.update();
    let world = app.world_mut();
    let messages = world.resource::<Messages<Fractured>>();
    let pieces: Vec<_> = messages
        .iter_current_update_messages()
        .map(|m| m.pieces.len())
        .collect();
    assert_eq!(pieces, [4], "one fracture into four quarters");
    assert!(world.resource::<Messages<BodyWarning>>().is_empty());
}

#[test]
fn bodies_despawned_while_they_touch_harm_nobody() {
    let mut app = app();
    let scene = falling_and_breaking();
    let spawned: Vec<_> = scene
        .iter()
        .map(|desc| app.world_mut().spawn_body(desc.clone()))
        .collect();
    for step in 0..120 {
        app.update();
        // One body each tenth step, with whatever it touches at that moment.
        if step % 10 == 4 {
            let _ = app.world_mut().try_despawn(spawned[1 + step / 10]);
        }
    }
    let world = app.world_mut();
    let mut bodies = world.query::<(&BodyHandle, &Transform)>();
    assert!(
        bodies
            .iter(world)
            .all(|(handle, t)| handle.get().is_some() && t.is_finite())
    );
    let alive = bodies.iter(world).count();
    assert_eq!(world.resource::<Bodies>().len(), alive);
    assert!(world.resource::<Messages<BodyWarning>>().is_empty());
}

#[test]
fn nonsense_step_lengths_do_nothing() {
    let mut simulation = Simulation::default();
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    let body = simulation
        .bodies
        .insert(BodyDesc::dynamic(cube, Vec3::Y))
        .expect("usable");
    for h in [0.0, -0.1, f32::NAN, f32::INFINITY] {
        simulation.step(h);
        assert_eq!(simulation.bodies.pose(body).position, Vec3::Y);
    }
    simulation.gravity = Gravity(Vec3::NAN);
    simulation.step(0.01);
    assert_eq!(simulation.bodies.pose(body).position, Vec3::Y);
}
