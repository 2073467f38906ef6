//! Surfaces that run along themselves: what lies on a belt goes as on a floor that moves, and the belt stays.

use crate::common::dice::Dice;
use crate::common::structures::{block, cuboid, fixed, floor};
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

fn simulation(bodies: impl IntoIterator<Item = BodyDesc>) -> Simulation {
    let mut simulation = Simulation::default();
    for desc in bodies {
        simulation.bodies.insert(desc).expect("usable");
    }
    simulation
}

/// Lets the surface of a body run, in its own axes.
fn run_surface(simulation: &mut Simulation, slot: u32, velocity: Vec3) {
    let drive = BodyDrive {
        surface_velocity: velocity,
        ..BodyDrive::default()
    };
    let driven = simulation.bodies.set_drive(slot, drive);
    driven.expect("usable");
}

fn steps(simulation: &mut Simulation, seconds: f32, step: f32) {
    (0..(seconds / step).round() as usize).for_each(|_| simulation.step(step));
}

/// Something that stands still, and half its height.
fn random_body(dice: &mut Dice) -> (ConvexMesh, f32) {
    let size = dice.vector(0.2, 0.8);
    let round = |shape: Result<ConvexMesh, HullError>| shape.expect("a volume");
    match dice.below(4) {
        0 => (round(ConvexMesh::sphere(0.5 * size.x)), 0.5 * size.x),
        1 => (
            round(ConvexMesh::cylinder(0.5 * size.x, 0.5 * size.x)),
            0.25 * size.x,
        ),
        2 => {
            let sides = 3 + dice.below(6) as u32;
            let prism = ConvexMesh::regular_prism(sides, 0.5 * size.x, 0.4 * size.x);
            (round(prism), 0.2 * size.x)
        }
        _ => (
            cuboid(Vec3::new(size.x, 0.4 * size.x, size.z.max(0.4))),
            0.2 * size.x,
        ),
    }
}

/// The ground, with the top at height 0.
fn random_ground(dice: &mut Dice, mu: f32) -> BodyDesc {
    let slab = |size: Vec3| fixed(&cuboid(size), -0.5 * size.y * Vec3::Y, mu);
    match dice.below(4) {
        0 => {
            let quad = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            let corners = quad.map(|[x, z]| 50.0 * Vec3::new(x, 0.0, z));
            let mesh = StaticMesh::new(&corners, &[[0, 2, 1], [0, 3, 2]]);
            BodyDesc {
                friction: Friction::new(mu),
                ..BodyDesc::level(mesh.expect("two triangles"))
            }
        }
        1 => {
            let half = cuboid(Vec3::new(50.0, 1.0, 100.0));
            let halves = [-25.0, 25.0].map(|x| (Pose::from_position(x * Vec3::X), half.clone()));
            BodyDesc {
                kind: RigidBody::Static,
                friction: Friction::new(mu),
                ..BodyDesc::compound(Compound::new(halves).expect("two"), -0.5 * Vec3::Y)
            }
        }
        _ => slab(Vec3::new(100.0, 1.0, 100.0)),
    }
}

/// A few bodies that stand on a belt, or on a floor that moves as fast; where they are after a second.
fn ride(seed: u64, is_belt: bool) -> (Vec<Vec3>, String) {
    let mut dice = Dice::new(seed);
    let mu = dice.in_range(0.1, 1.2);
    let mut ground = random_ground(&mut dice, mu);
    let mut velocity = dice.in_range(0.05, 3.0) * dice.direction();
    velocity.y = 0.0;
    ground.pose.rotation = Quat::from_rotation_y(dice.in_range(-3.0, 3.0));
    if !is_belt {
        (ground.kind, ground.linear_velocity) = (RigidBody::Kinematic, velocity);
    } else if dice.below(2) == 0 {
        ground.kind = RigidBody::Kinematic;
    }
    let to_ground = ground.pose.rotation.inverse();
    let mut all = simulation([ground]);
    let methods = [
        SolverConfig::default(),
        SolverConfig::fast(),
        SolverConfig::precise(),
        SolverConfig::paper(),
    ];
    let mut dice = Dice::new(seed ^ 0x5ee5);
    all.config = methods[[0, 0, 0, 1, 2, 3][dice.below(6)]];
    let step = 1.0 / [30.0, 60.0, 60.0, 120.0, 240.0][dice.below(5)];
    for i in 0..1 + dice.below(3) {
        let (shape, height) = random_body(&mut dice);
        let place = Vec3::new(2.0 * i as f32, height, dice.in_range(-1.0, 1.0));
        let mut body = block(&shape, place, mu);
        body.pose.rotation = Quat::from_rotation_y(dice.in_range(-3.0, 3.0));
        all.bodies.insert(body).expect("usable");
    }
    if is_belt {
        // What of it is along the normal is not there.
        let along = to_ground * (velocity + dice.in_range(-1.0, 1.0) * Vec3::Y);
        run_surface(&mut all, 0, along);
    }
    steps(&mut all, 1.0, step);
    let places = (1..all.bodies.len() as u32).map(|slot| all.bodies.center_of_mass(slot));
    let said = format!("{:?} {step} mu {mu} v {velocity}", all.config.method);
    (places.collect(), said)
}

#[test]
fn what_lies_on_a_belt_goes_as_on_a_floor_that_moves() {
    for seed in 0..40 {
        let ((belt, said), (moved, _)) = (ride(seed, true), ride(seed, false));
        for (a, b) in belt.iter().zip(&moved) {
            assert!(a.distance(*b) < 0.01, "seed {seed}: {a}, not {b}: {said}");
        }
    }
}

/// What lies on a belt, as a box before a wall that it touches if it is held back: how far it gets along the belt in 3 s, and whether it sleeps.
fn slow_ride(dice: &mut Dice, speed: f32, is_held_back: bool) -> (f32, bool) {
    let mut all = simulation([random_ground(dice, 0.6)]);
    let (shape, height) = loop {
        let (shape, height) = random_body(dice);
        if !shape.is_round() {
            break (shape, height);
        }
    };
    let heading = Quat::from_rotation_y(dice.in_range(-3.0, 3.0));
    let ahead = heading * Vec3::X;
    let mut body = block(&shape, height * Vec3::Y, 0.6);
    if is_held_back {
        let size = dice.vector(0.2, 0.8);
        body = block(&cuboid(size), 0.5 * size.y * Vec3::Y, 0.6);
        body.pose.rotation = heading;
        let place = 0.5 * (size.x + 1.0) * ahead + 0.5 * Vec3::Y;
        let mut wall = fixed(&cuboid(Vec3::ONE), place, 0.6);
        wall.pose.rotation = heading;
        all.bodies.insert(wall).expect("usable");
    }
    let body = all.bodies.insert(body).expect("usable");
    run_surface(&mut all, 0, speed * ahead);
    let from = all.bodies.center_of_mass(body);
    steps(&mut all, 3.0, 1.0 / 60.0);
    let way = all.bodies.center_of_mass(body) - from;
    (way.dot(ahead), all.bodies.is_asleep(body))
}

// Though what rests elsewhere would drift as far.
#[test]
fn what_lies_on_a_slow_belt_never_sleeps_but_where_it_is_held_back() {
    let mut dice = Dice::new(32);
    for member in 0..60 {
        let speed = [1e-4, 1e-3, 1e-2][dice.below(3)] * dice.in_range(1.0, 10.0);
        let (way, asleep) = slow_ride(&mut dice, speed, false);
        let off = (way - 3.0 * speed).abs();
        assert!(
            !asleep && off < 0.15 * speed,
            "{member}: {way} m at {speed} m/s"
        );
        let (way, asleep) = slow_ride(&mut dice, speed, true);
        assert!(
            asleep && way < 0.01,
            "{member}: {way} m at {speed} m/s to a wall"
        );
    }
}

/// A belt of 10 m along x that runs at 1 m/s, with its top at height 0.
fn belt() -> Simulation {
    let size = Vec3::new(10.0, 1.0, 2.0);
    let mut simulation = simulation([fixed(&cuboid(size), -0.5 * Vec3::Y, 0.6)]);
    run_surface(&mut simulation, 0, Vec3::X);
    simulation
}

#[test]
fn a_ball_rolls_on_a_belt_until_it_slips_no_more() {
    let mut all = belt();
    let ball = ConvexMesh::sphere(0.2).expect("a ball");
    let ball = block(&ball, Vec3::new(-3.0, 0.2, 0.0), 0.6);
    let ball = all.bodies.insert(ball).expect("usable");
    steps(&mut all, 1.0, 1.0 / 60.0);
    // Friction `F` gives `m v = F t` and `2/5 m r^2 omega = F r t`, until `v + r omega` is that of the belt.
    let (linear, angular) = all.bodies.velocity(ball);
    assert!((linear.x - 2.0 / 7.0).abs() < 1e-3, "{linear}");
    assert!((0.2 * angular.z - 5.0 / 7.0).abs() < 1e-3, "{angular}");
}

// A belt that were a body that moves would push what touches its ends.
#[test]
fn the_ends_of_a_belt_do_nothing() {
    for side in [-1.0, 1.0] {
        let mut all = belt();
        let ground = fixed(&cuboid(Vec3::new(20.0, 1.0, 2.0)), -1.5 * Vec3::Y, 0.6);
        all.bodies.insert(ground).expect("usable");
        let beside = Vec3::new(5.25 * side, -0.75, 0.0);
        let cube = block(&cuboid(Vec3::splat(0.5)), beside, 0.6);
        let cube = all.bodies.insert(cube).expect("usable");
        steps(&mut all, 2.0, 1.0 / 60.0);
        let off = all.bodies.center_of_mass(cube) - beside;
        assert!(off.length() < 1e-3, "{side}: {off}");
    }
}

#[test]
fn what_a_wall_holds_back_on_a_belt_sleeps_until_the_belt_turns_back() {
    let mut all = belt();
    let wall = fixed(&cuboid(Vec3::splat(1.0)), Vec3::new(1.0, 0.5, 0.0), 0.6);
    all.bodies.insert(wall).expect("usable");
    let cube = block(&cuboid(Vec3::splat(0.5)), Vec3::new(0.0, 0.25, 0.0), 0.6);
    let cube = all.bodies.insert(cube).expect("usable");
    steps(&mut all, 4.0, 1.0 / 60.0);
    assert!(all.bodies.is_asleep(cube));
    assert!((all.bodies.center_of_mass(cube).x - 0.25).abs() < 2e-3);
    run_surface(&mut all, 0, -Vec3::X);
    steps(&mut all, 1.0, 1.0 / 60.0);
    let (linear, _) = all.bodies.velocity(cube);
    assert!((linear.x + 1.0).abs() < 1e-3, "{linear}");
    run_surface(&mut all, 0, Vec3::ZERO);
    steps(&mut all, 2.0, 1.0 / 60.0);
    assert!(all.bodies.is_asleep(cube));
}

// On its own tracks a body goes backwards against them; two that lie on each other keep their momentum.
#[test]
fn tracks_drive_the_body_that_has_them() {
    let mut all = simulation([floor(0.6)]);
    let hull = block(&cuboid(Vec3::new(2.0, 0.5, 1.0)), 0.25 * Vec3::Y, 0.6);
    let tank = all.bodies.insert(hull.clone()).expect("usable");
    run_surface(&mut all, tank, -1.5 * Vec3::X);
    steps(&mut all, 2.0, 1.0 / 60.0);
    let (linear, _) = all.bodies.velocity(tank);
    assert!((linear - 1.5 * Vec3::X).length() < 1e-3, "{linear}");

    let ice = HalfSpaceShape::new(Vec3::Y).expect("a direction");
    let ice = BodyDesc {
        friction: Friction::new(0.0).with_combine(CombineRule::Min),
        ..BodyDesc::floor(ice)
    };
    let mut all = simulation([ice]);
    let lower = all.bodies.insert(hull.clone()).expect("usable");
    let upper = BodyDesc::dynamic(hull_shape(), 0.75 * Vec3::Y);
    let upper = all.bodies.insert(upper).expect("usable");
    run_surface(&mut all, lower, Vec3::X);
    steps(&mut all, 0.5, 1.0 / 60.0);
    let [low, up] = [lower, upper].map(|slot| all.bodies.velocity(slot).0);
    assert!((up - low - Vec3::X).length() < 1e-2, "{low} {up}");
    let momentum = all.bodies.mass(lower).mass * low + all.bodies.mass(upper).mass * up;
    assert!(
        momentum.length() < 1e-3 * all.bodies.mass(lower).mass,
        "{momentum}"
    );
}

fn hull_shape() -> ConvexMesh {
    cuboid(Vec3::new(1.0, 0.5, 1.0))
}

#[test]
fn all_methods_know_running_surfaces() {
    let soft = |substeps| SolverConfig {
        method: Method::SoftStep(SoftStep {
            min_substeps: substeps,
            max_substeps: substeps,
            ..SoftStep::default()
        }),
        ..SolverConfig::default()
    };
    let configs = [
        SolverConfig::default(),
        SolverConfig::fast(),
        SolverConfig::precise(),
        SolverConfig::paper(),
        SolverConfig::exact(),
        soft(1),
        soft(16),
    ];
    for config in configs {
        let mut all = belt();
        all.config = SolverConfig {
            measure_error: true,
            ..config
        };
        let cube = block(&cuboid(Vec3::splat(0.5)), Vec3::new(-3.0, 0.25, 0.0), 0.6);
        let cube = all.bodies.insert(cube).expect("usable");
        steps(&mut all, 1.0, 1.0 / 60.0);
        let (linear, angular) = all.bodies.velocity(cube);
        assert!(
            (linear - Vec3::X).length() < 1e-3,
            "{linear} {:?}",
            config.method
        );
        assert!(angular.length() < 1e-3, "{angular} {:?}", config.method);
        // The problem that was solved is the one with the belt.
        let error = all.report.error.expect("measured");
        let residual = error.residual.relative;
        assert!(residual < 1e-2, "{residual:?} {:?}", config.method);
    }
}
