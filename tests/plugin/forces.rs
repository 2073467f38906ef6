//! Forces, damping, limits and locks against what mechanics says, and against the frame rate.

use crate::app::{app, bits_of_entity};
use crate::common::dice::Dice;
use bevy_app::{App, FixedUpdate, Update};
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_math::{Quat, Vec3};
use bevy_time::TimeUpdateStrategy;
use bevy_transform::components::Transform;
use std::f32::consts::FRAC_PI_2;

fn weightless() -> App {
    let mut app = app();
    app.insert_resource(Gravity(Vec3::ZERO));
    app
}

fn brick() -> ConvexMesh {
    ConvexMesh::cuboid(1.0, 0.5, 0.25).expect("a brick has a volume")
}

fn spawn(app: &mut App, parts: impl Bundle) -> Entity {
    let body = (RigidBody::Dynamic, brick());
    app.world_mut().spawn((body, parts)).id()
}

fn steps(app: &mut App, count: usize) {
    (0..count).for_each(|_| app.update());
}

fn velocity(app: &App, entity: Entity) -> Vec3 {
    app.world().get::<LinearVelocity>(entity).expect("a body").0
}

fn spin(app: &App, entity: Entity) -> Vec3 {
    app.world()
        .get::<AngularVelocity>(entity)
        .expect("a body")
        .0
}

fn place(app: &App, entity: Entity) -> Vec3 {
    app.world()
        .get::<Transform>(entity)
        .expect("a body")
        .translation
}

fn push(app: &mut App, entity: Entity, action: impl Fn(&mut ForcesItem<'_, '_>)) {
    let mut query = app.world_mut().query::<Forces>();
    let mut forces = query.get_mut(app.world_mut(), entity).expect("a body");
    action(&mut forces);
}

#[test]
fn each_way_to_push_gives_what_mechanics_says() {
    let mut dice = Dice::new(1);
    for _ in 0..20 {
        let mut app = weightless();
        let at = 20.0 * dice.vector(-1.0, 1.0);
        let pose = Transform::from_translation(at).with_rotation(dice.rotation());
        let body = spawn(&mut app, pose);
        if dice.unit() < 0.5 {
            steps(&mut app, 1);
        }
        let vectors = [0; 6].map(|_| dice.vector(-1.0, 1.0));
        let [force, torque, impulse, twist, gain, turn] = vectors;
        let point = at + dice.vector(-0.2, 0.2);
        push(&mut app, body, |forces| {
            forces.apply_force(600.0 * force);
            forces.apply_torque(60.0 * torque);
            forces.apply_impulse_at(impulse, point);
            forces.apply_force_at(60.0 * twist, point);
            forces.apply_angular_impulse(twist);
            forces.apply_acceleration(60.0 * gain);
            forces.apply_angular_acceleration(turn);
        });
        steps(&mut app, 1);
        let mass = app.world().get::<MassProperties>(body).expect("a body");
        let lever = point - at;
        let linear = (10.0 * force + impulse + twist) / mass.mass + gain;
        let found = velocity(&app, body);
        assert!(found.distance(linear) < 1e-4, "{found}, {linear}");
        let moment = torque + lever.cross(impulse + twist) + twist;
        let r = bevy_math::Mat3::from_quat(pose.rotation);
        let inverse = r * mass.inverse_inertia() * r.transpose();
        let angular = inverse * moment + turn / 60.0;
        let found = spin(&app, body);
        assert!(
            found.distance(angular) < 1e-2 * angular.length(),
            "{found}, {angular}"
        );
        // It was for one step.
        steps(&mut app, 5);
        assert!(velocity(&app, body).distance(linear) < 1e-4);
    }
}

#[test]
fn a_force_acts_for_one_step_whatever_the_frame_rate() {
    let run = |steps_a_frame: u32| {
        let mut app = weightless();
        app.insert_resource(TimeUpdateStrategy::FixedTimesteps(steps_a_frame));
        let body = spawn(&mut app, ());
        app.add_systems(FixedUpdate, |mut bodies: Query<Forces>| {
            bodies
                .iter_mut()
                .for_each(|mut body| body.apply_force(125.0 * Vec3::X));
        });
        steps(&mut app, (120 / steps_a_frame) as usize);
        velocity(&app, body)
    };
    let expected = run(1);
    assert!((expected.x - 2.0).abs() < 1e-3, "{expected}");
    assert_eq!((run(2), run(8)), (expected, expected));
    // Frames without a step keep what was applied.
    let mut app = weightless();
    let body = spawn(&mut app, ());
    steps(&mut app, 1);
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(0));
    app.add_systems(
        Update,
        |mut bodies: Query<Forces>, mut is_done: Local<bool>| {
            if !std::mem::replace(&mut *is_done, true) {
                bodies
                    .iter_mut()
                    .for_each(|mut body| body.apply_impulse(125.0 * Vec3::X));
            }
        },
    );
    steps(&mut app, 5);
    assert_eq!(velocity(&app, body), Vec3::ZERO);
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    steps(&mut app, 5);
    assert!((velocity(&app, body).x - 1.0).abs() < 1e-5);
}

#[test]
fn scaled_gravity_is_a_parabola_and_none_is_rest() {
    for scale in [0.0, 0.5, 2.0, -1.0] {
        let mut app = app();
        let body = spawn(&mut app, GravityScale(scale));
        steps(&mut app, 60);
        let expected = -0.5 * 9.81 * scale;
        let y = place(&app, body).y;
        assert!((y - expected).abs() < 1e-3, "{scale}: {y}, {expected}");
        if scale == 0.0 {
            assert_eq!(place(&app, body), Vec3::ZERO);
        }
    }
}

#[test]
fn a_constant_force_holds_a_body_up_and_lets_it_go_when_removed() {
    let mut app = app();
    let body = spawn(&mut app, ConstantForce(Vec3::ZERO));
    steps(&mut app, 1);
    let mass = app
        .world()
        .get::<MassProperties>(body)
        .expect("a body")
        .mass;
    let lift = ConstantForce(Vec3::new(0.0, 9.81 * mass, 0.0));
    app.world_mut()
        .entity_mut(body)
        .insert((lift, LinearVelocity::default()));
    let y = place(&app, body).y;
    steps(&mut app, 60);
    assert!((place(&app, body).y - y).abs() < 1e-3);
    // Changed in place, and removed.
    app.world_mut()
        .get_mut::<ConstantForce>(body)
        .expect("it is there")
        .0 *= 2.0;
    steps(&mut app, 60);
    assert!((velocity(&app, body).y - 9.81).abs() < 1e-2);
    app.world_mut().entity_mut(body).remove::<ConstantForce>();
    steps(&mut app, 60);
    assert!(velocity(&app, body).y.abs() < 2e-2);
}

#[test]
fn what_a_force_presses_on_a_floor_rests_however_elastic_it_is() {
    let mut app = weightless();
    let bouncy = |restitution| Restitution::new(restitution);
    let floor = HalfSpaceShape { normal: Vec3::Y };
    app.world_mut()
        .spawn((RigidBody::Static, floor, bouncy(1.0)));
    let bricks = [0.3, 0.8, 1.0].map(|restitution| {
        let at = Transform::from_xyz(5.0 * restitution, 0.25, 0.0);
        let weight = ConstantForce(-9.81 * 100.0 * Vec3::Y);
        spawn(&mut app, (at, bouncy(restitution), Mass(100.0), weight))
    });
    for _ in 0..120 {
        steps(&mut app, 1);
        for brick in bricks {
            let velocity = velocity(&app, brick);
            assert!(velocity.length() < 0.01, "{velocity}");
        }
    }
}

#[test]
fn damping_and_limits_of_speed() {
    let mut app = weightless();
    let fast = (
        LinearVelocity(Vec3::new(8.0, 0.0, 0.0)),
        AngularVelocity(Vec3::new(0.0, 0.0, 8.0)),
    );
    let damped = spawn(&mut app, (fast, LinearDamping(0.5), AngularDamping(1.0)));
    let limit = MaxSpeed {
        linear: 3.0,
        angular: 2.0,
    };
    let limited = spawn(&mut app, (fast, limit, Transform::from_xyz(0.0, 9.0, 0.0)));
    steps(&mut app, 60);
    // exp(-0.5) and exp(-1).
    let expected = 8.0 * 0.606_530_7;
    assert!((velocity(&app, damped).x - expected).abs() < 0.01);
    assert!((spin(&app, damped).z - 8.0 * 0.367_879_44).abs() < 0.02);
    assert!((velocity(&app, limited).x - 3.0).abs() < 1e-5);
    assert!((spin(&app, limited).z - 2.0).abs() < 1e-5);
    assert!((place(&app, limited).x - 3.0).abs() < 1e-3);
}

#[test]
fn a_belt_carries_what_lies_on_it_until_it_loses_its_velocity_or_breaks() {
    let mut app = app();
    let belt = ConvexMesh::cuboid(20.0, 1.0, 2.0).expect("a slab");
    // Turned, it runs along z.
    let turned = Quat::from_rotation_y(-FRAC_PI_2);
    let place = Transform::from_xyz(0.0, -0.5, 0.0).with_rotation(turned);
    let run = SurfaceVelocity(2.0 * Vec3::X);
    let belt = (RigidBody::Static, belt, run, place);
    let belt = app.world_mut().spawn(belt).id();
    let brick = spawn(&mut app, Transform::from_xyz(0.0, 0.25, -3.0));
    steps(&mut app, 60);
    let along = 2.0 * Vec3::Z;
    assert!((velocity(&app, brick) - along).length() < 1e-3);
    assert_eq!(self::place(&app, belt), place.translation);

    app.world_mut().entity_mut(belt).remove::<SurfaceVelocity>();
    steps(&mut app, 120);
    assert!(velocity(&app, brick).length() < 1e-3);
    assert!(app.world().get::<Sleeping>(brick).is_some());

    app.world_mut().entity_mut(belt).insert(run);
    steps(&mut app, 60);
    assert!((velocity(&app, brick) - along).length() < 1e-3);
    let middle = Plane::through(5.0 * Vec3::Z, Vec3::Z);
    app.world_mut().commands().slice(belt, middle);
    steps(&mut app, 60);
    assert!(app.world().get_entity(belt).is_err());
    let mut running = app.world_mut().query::<&SurfaceVelocity>();
    assert_eq!(running.iter(app.world()).count(), 0);
}

#[test]
fn a_belt_whose_velocity_is_no_number_is_an_issue_and_does_not_run() {
    let mut app = app();
    let run = SurfaceVelocity(f32::NAN * Vec3::X);
    let belt = spawn(&mut app, run);
    steps(&mut app, 2);
    let issues = app.world().get::<BodyIssues>(belt).expect("an issue");
    let problem = BodyProblem::Body(BodyError::Drive("SurfaceVelocity"));
    assert_eq!(issues.iter().collect::<Vec<_>>(), [&problem]);
}

#[test]
fn locked_axes_are_kept_under_blows() {
    let mut dice = Dice::new(9);
    for _ in 0..10 {
        let mut app = app();
        let half_space = HalfSpaceShape { normal: Vec3::Y };
        app.world_mut().spawn((RigidBody::Static, half_space));
        let upright = Transform::from_xyz(0.0, 0.3, 0.0);
        let standing = spawn(&mut app, (upright, LockedAxes::ROTATION));
        let flat = Transform::from_xyz(6.0, 0.3, 0.0);
        let flat = spawn(&mut app, (flat, LockedAxes::PLANE_XY));
        for target in [0.0, 6.0] {
            let way = Vec3::new(dice.in_range(-1.0, 1.0), 0.0, 2.0);
            let shot = (
                Transform::from_translation(Vec3::new(target, 0.5, 0.2) - 1.5 * way),
                LinearVelocity(4.0 * way),
            );
            spawn(&mut app, shot);
        }
        steps(&mut app, 120);
        let turn = app
            .world()
            .get::<Transform>(standing)
            .expect("a body")
            .rotation;
        assert_eq!(turn.xyz(), Vec3::ZERO);
        assert!(place(&app, standing).z > 0.01, "it was pushed");
        let pose = app.world().get::<Transform>(flat).expect("a body");
        assert!(pose.translation.z.abs() < 1e-4, "{pose:?}");
        assert!(
            pose.rotation.x.abs() + pose.rotation.y.abs() < 1e-4,
            "{pose:?}"
        );
    }
}

#[test]
fn a_mass_is_what_was_asked_for_and_pieces_share_it() {
    let mut app = weightless();
    let body = spawn(&mut app, Mass(7.0));
    steps(&mut app, 1);
    let mass = |app: &App, body| {
        app.world()
            .get::<MassProperties>(body)
            .expect("a body")
            .mass
    };
    assert!((mass(&app, body) - 7.0).abs() < 1e-5);
    app.world_mut()
        .get_mut::<Mass>(body)
        .expect("it is there")
        .0 = 14.0;
    steps(&mut app, 1);
    assert!((mass(&app, body) - 14.0).abs() < 1e-5);
    app.world_mut()
        .commands()
        .slice(body, Plane::through(Vec3::new(0.2, 0.0, 0.0), Vec3::X));
    steps(&mut app, 1);
    let mut pieces = app.world_mut().query::<(&MassProperties, Has<Mass>)>();
    let masses: Vec<f32> = pieces
        .iter(app.world())
        .map(|(mass, _)| mass.mass)
        .collect();
    assert_eq!(masses.len(), 2);
    assert!((masses.iter().sum::<f32>() - 14.0).abs() < 1e-4);
    assert!(pieces.iter(app.world()).all(|(_, has_mass)| !has_mass));
}

#[test]
fn bad_numbers_are_named_and_do_nothing() {
    #[derive(Resource, Default)]
    struct Named(Vec<Entity>);
    let mut app = weightless();
    app.init_resource::<Named>().add_systems(
        Update,
        |mut warnings: MessageReader<BodyWarning>, mut named: ResMut<Named>| {
            named
                .0
                .extend(warnings.read().map(|warning| warning.entity));
        },
    );
    let apart = |i: usize| Transform::from_xyz(3.0 * i as f32, 0.0, 0.0);
    let bodies = [
        spawn(&mut app, (apart(0), GravityScale(f32::NAN))),
        spawn(&mut app, (apart(1), LinearDamping(-1.0))),
        spawn(
            &mut app,
            (
                apart(2),
                MaxSpeed {
                    linear: f32::NAN,
                    ..MaxSpeed::default()
                },
            ),
        ),
        spawn(&mut app, (apart(3), ConstantForce(Vec3::INFINITY))),
        spawn(&mut app, (apart(4), Mass(0.0))),
        spawn(
            &mut app,
            (
                apart(5),
                ContactForceEvents {
                    threshold: f32::NAN,
                },
            ),
        ),
        spawn(&mut app, apart(6)),
    ];
    push(&mut app, bodies[6], |forces| forces.apply_force(Vec3::NAN));
    for number in [f32::NAN, f32::INFINITY, 0.0, -1.0] {
        app.world_mut().commands().explode(Explosion {
            center: Vec3::ZERO,
            radius: number,
            impulse: 1.0,
        });
    }
    steps(&mut app, 3);
    let mut named = app.world().resource::<Named>().0.clone();
    named.sort_by_key(|entity| bodies.iter().position(|body| body == entity));
    assert_eq!(named, bodies);
    for (i, body) in bodies.into_iter().enumerate() {
        assert_eq!(place(&app, body), apart(i).translation);
    }
}

#[test]
fn explosions_push_away_and_wake() {
    let mut app = app();
    app.insert_resource(SolverConfig {
        sleep: SleepConfig {
            enabled: true,
            ..SleepConfig::default()
        },
        ..SolverConfig::default()
    });
    let half_space = HalfSpaceShape { normal: Vec3::Y };
    app.world_mut().spawn((RigidBody::Static, half_space));
    let at = |x: f32| Transform::from_xyz(x, 0.25, 0.0);
    let bodies = [-2.0, 2.0, 30.0].map(|x| spawn(&mut app, at(x)));
    steps(&mut app, 200);
    assert_eq!(app.world().resource::<StepReport>().asleep, 3);
    app.world_mut().commands().explode(Explosion {
        center: Vec3::new(0.0, 0.2, 0.0),
        radius: 5.0,
        impulse: 1000.0,
    });
    steps(&mut app, 2);
    let [left, right, far] = bodies.map(|body| velocity(&app, body));
    assert!(left.x < -1.0 && right.x > 1.0, "{left} {right}");
    assert_eq!(far, Vec3::ZERO);
    assert!(app.world().entity(bodies[2]).contains::<Sleeping>());
}

#[test]
fn the_plugin_drives_as_the_plain_step_does() {
    let drive = BodyDrive {
        gravity_scale: 0.25,
        linear_damping: 0.3,
        angular_damping: 0.1,
        max_speed: 2.0,
        force: Vec3::new(30.0, 0.0, 4.0),
        ..BodyDrive::default()
    };
    let mut simulation = Simulation::default();
    let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    simulation.bodies.insert(floor.clone()).expect("a floor");
    let desc = BodyDesc::dynamic(brick(), Vec3::new(0.0, 0.6, 0.0));
    let slot = simulation.bodies.insert(desc.clone()).expect("a brick");
    simulation
        .bodies
        .set_drive(slot, drive)
        .expect("it is usable");
    let mut app = app();
    app.world_mut().spawn_body(floor);
    let body = app.world_mut().spawn_body(desc);
    let speed = MaxSpeed {
        linear: drive.max_speed,
        ..MaxSpeed::default()
    };
    app.world_mut().entity_mut(body).insert((
        GravityScale(drive.gravity_scale),
        LinearDamping(drive.linear_damping),
        AngularDamping(drive.angular_damping),
        ConstantForce(drive.force),
        speed,
    ));
    for _ in 0..200 {
        simulation.step(1.0 / 60.0);
        app.update();
    }
    let pose = simulation.bodies.pose(slot);
    let (linear, angular) = simulation.bodies.velocity(slot);
    assert_eq!(
        crate::common::states::bits(&pose, linear, angular),
        bits_of_entity(app.world(), body)
    );
    assert!(pose.position.x > 0.03, "{pose:?}");
}

type Change = fn(&mut EntityWorldMut);

/// Ways of taking no part in steps, and of taking part after all.
fn ways() -> [(Change, Change); 3] {
    [
        (
            |entity| {
                entity.insert(ShapeAwaited).remove::<ConvexMesh>();
            },
            |entity| {
                entity.insert(brick()).remove::<ShapeAwaited>();
            },
        ),
        (
            |entity| {
                entity.remove::<ConvexMesh>();
            },
            |entity| {
                entity.insert(brick());
            },
        ),
        (
            |entity| {
                entity.insert(Disabled);
            },
            |entity| {
                entity.remove::<Disabled>();
            },
        ),
    ]
}

// An impulse on a body whose shape was still to come was forgotten until the next push, and then what had been pushed in all the steps
// before acted in one.
#[test]
fn impulses_wait_for_a_body_and_forces_do_not() {
    for seed in 0..30 {
        let (hide, show) = ways()[seed % 3];
        let mut dice = Dice::new(seed as u64);
        let mut app = weightless();
        let body = spawn(&mut app, ());
        let mass = 1000.0 * brick().hull().volume() as f32;
        let (mut momentum, mut is_there) = (Vec3::ZERO, false);
        for step in 0..20 {
            let what = dice.below(4);
            let (impulse, force) = (dice.vector(-50.0, 50.0), dice.vector(-50.0, 50.0));
            let is_shown = dice.below(6) == 0;
            if !is_there && is_shown {
                is_there = true;
                show(&mut app.world_mut().entity_mut(body));
            }
            // Queries do not find what is disabled.
            if app.world().entity(body).contains::<Disabled>() {
                app.update();
                continue;
            }
            push(&mut app, body, |forces| match what {
                0 => forces.apply_impulse(impulse),
                1 => forces.apply_impulse_at(impulse, Vec3::ZERO),
                2 => forces.apply_force(force),
                _ => {}
            });
            momentum += match what {
                0 | 1 => impulse,
                2 if is_there => force / 60.0,
                _ => Vec3::ZERO,
            };
            if step == 0 && !is_there {
                hide(&mut app.world_mut().entity_mut(body));
                momentum = if what < 2 { impulse } else { Vec3::ZERO };
            }
            app.update();
            if is_there {
                let found = mass * velocity(&app, body);
                let off = found.distance(momentum);
                assert!(
                    off < 1e-2,
                    "seed {seed}, step {step}: {found} for {momentum} N s"
                );
            }
        }
    }
}
