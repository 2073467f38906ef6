//! Islands of small bodies take local steps: nobody else notices, and what they report is of the whole step.

use crate::common::dice::Dice;
use bevy_cleave::contact::ManifoldRef;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

const H: f32 = 1.0 / 60.0;

fn cube(size: f32, at: Vec3) -> BodyDesc {
    let mesh = ConvexMesh::cuboid(size, size, size).expect("a size");
    BodyDesc::dynamic(mesh, at)
}

fn awake() -> Simulation {
    let mut simulation = Simulation::default();
    simulation.config.sleep = SleepConfig::off();
    let up = HalfSpaceShape { normal: Vec3::Y };
    let floor = BodyDesc::floor(up);
    simulation.bodies.insert(floor).expect("a floor");
    simulation
}

/// The same with no more than so many local steps.
fn with_at_most(max_local_steps: u32) -> Simulation {
    let mut simulation = awake();
    simulation.config.method = SoftStep {
        max_local_steps,
        ..SoftStep::default()
    }
    .into();
    simulation
}

fn insert(simulation: &mut Simulation, desc: BodyDesc) -> u32 {
    simulation.bodies.insert(desc).expect("usable")
}

/// Normal impulse of all contacts of a body, N s.
fn impulse_on(simulation: &Simulation, slot: u32) -> f32 {
    let of_body = |m: &ManifoldRef| m.a == slot || m.b == slot;
    let manifolds = simulation.contacts.manifolds().iter().filter(of_body);
    let points = manifolds.flat_map(|m| m.points());
    points.map(|point| point.total_impulse).sum()
}

/// Some crates that fall onto each other.
fn crates() -> Vec<BodyDesc> {
    let mut dice = Dice::new(3);
    let fall = |i: usize| {
        let mut desc = cube(0.5, Vec3::new(0.1 * i as f32, 0.4 + 0.6 * i as f32, 0.0));
        desc.pose.rotation = Quat::from_rotation_x(dice.in_range(-0.5, 0.5));
        desc
    };
    (0..8).map(fall).collect()
}

#[test]
fn bodies_elsewhere_move_by_the_same_bits() {
    let mut alone = awake();
    let mut beside = awake();
    let slots: Vec<u32> = crates()
        .into_iter()
        .map(|desc| {
            insert(&mut beside, desc.clone());
            insert(&mut alone, desc)
        })
        .collect();
    for i in 0..30 {
        let size = [0.002, 0.01, 0.04, 0.1][i % 4];
        let at = Vec3::new(20.0 + 0.05 * (i % 5) as f32, 0.1 + 0.05 * i as f32, 0.0);
        insert(&mut beside, cube(size, at));
    }
    for step in 0..200 {
        alone.step(H);
        beside.step(H);
        for &slot in &slots {
            let (here, there) = (alone.bodies.pose(slot), beside.bodies.pose(slot));
            assert_eq!(here, there, "body {slot} in step {step}");
            let velocities = [&alone, &beside].map(|s| s.bodies.velocity(slot));
            assert_eq!(velocities[0], velocities[1], "body {slot} in step {step}");
        }
    }
}

#[test]
fn contacts_report_the_impulses_of_the_whole_step() {
    for size in [0.1, 0.03, 0.01, 0.002] {
        let mut simulation = awake();
        let slot = insert(&mut simulation, cube(size, 0.5 * size * Vec3::Y));
        for _ in 0..60 {
            simulation.step(H);
        }
        let weight = simulation.bodies.mass(slot).mass * 9.81 * H;
        let borne = impulse_on(&simulation, slot);
        assert!((borne / weight - 1.0).abs() < 1e-3, "{size}: {borne}");
    }
}

#[test]
fn a_blow_in_an_early_local_step_is_told() {
    // It is on its way up again when the step ends.
    let mut simulation = awake();
    let mut desc = cube(0.01, 0.02 * Vec3::Y);
    desc.linear_velocity = -3.0 * Vec3::Y;
    desc.restitution = Restitution::new(1.0);
    let slot = insert(&mut simulation, desc);
    let watch = ContactWatch {
        touches: true,
        ..ContactWatch::default()
    };
    let Simulation {
        bodies, contacts, ..
    } = &mut simulation;
    contacts.events_mut().watch(bodies, slot, watch);
    simulation.step(H);
    let (velocity, _) = simulation.bodies.velocity(slot);
    assert!(velocity.y > 1.0, "{velocity}");
    let news = simulation.contacts.events().news();
    let starts = news.iter().filter(|n| n.change == ContactChange::Start);
    assert_eq!(starts.clone().count(), 1, "{news:?}");
    // It comes at 3 m/s and goes at half of that: the floor has no restitution of its own.
    let change = 4.5 * simulation.bodies.mass(slot).mass;
    let told: f32 = starts.map(|n| n.impulse).sum();
    assert!((told / change - 1.0).abs() < 0.1, "{told} of {change} N s");
}

#[test]
fn what_is_small_rides_on_what_moves_by_itself() {
    let mut simulation = awake();
    let mesh = ConvexMesh::cuboid(1.0, 0.1, 1.0).expect("a size");
    let mut lift = BodyDesc::dynamic(mesh, 0.5 * Vec3::Y);
    lift.kind = RigidBody::Kinematic;
    lift.linear_velocity = Vec3::new(0.3, 0.5, 0.0);
    let lift = insert(&mut simulation, lift);
    let small = insert(&mut simulation, cube(0.02, 0.56 * Vec3::Y));
    for step in 1..=120 {
        simulation.step(H);
        let at = simulation.bodies.pose(lift).position;
        let expected = 0.5 * Vec3::Y + step as f32 * H * Vec3::new(0.3, 0.5, 0.0);
        assert!(at.distance(expected) < 1e-5, "step {step}: lift at {at}");
    }
    let over = simulation.bodies.pose(small).position - simulation.bodies.pose(lift).position;
    assert!((over.y - 0.06).abs() < 1e-4, "{over}");
    let (velocity, _) = simulation.bodies.velocity(small);
    let carried = Vec3::new(0.3, 0.5, 0.0);
    assert!(velocity.distance(carried) < 1e-3, "{velocity}");
}

#[test]
fn what_is_small_breaks_within_a_local_step_with_its_ledger_exact() {
    let mut simulation = awake();
    for i in 0..12 {
        let mut desc = cube(0.05, Vec3::new(0.2 * i as f32, 0.06 + 0.01 * i as f32, 0.0));
        desc.linear_velocity = -6.0 * Vec3::Y;
        desc.pose.rotation = Quat::from_rotation_z(0.1 * i as f32);
        desc.fracturable = Some(Fracturable::with_strength(0.05));
        insert(&mut simulation, desc);
    }
    let mass = |simulation: &Simulation| -> f64 {
        let bodies = &simulation.bodies;
        let dynamic = bodies
            .iter()
            .filter(|&s| bodies.kind(s) == RigidBody::Dynamic);
        dynamic.map(|s| f64::from(bodies.mass(s).mass)).sum()
    };
    simulation.step(H);
    let before = mass(&simulation);
    let mut broken = simulation.fractures.done.len();
    for _ in 0..60 {
        simulation.step(H);
        broken += simulation.fractures.done.len();
        assert!(simulation.report.problems.is_empty());
    }
    assert!(broken >= 12, "{broken} broke");
    let after = mass(&simulation);
    assert!(
        (after / before - 1.0).abs() < 1e-6,
        "{before} kg became {after}"
    );
}

#[test]
fn a_large_island_takes_none_for_a_splinter() {
    // 400 crates in one layer, side by side on a beam, and a splinter on one: more than the sweeps of an island may cost.
    let run = |max_local_steps| {
        let mut simulation = with_at_most(max_local_steps);
        for i in 0..400 {
            let at = Vec3::new(0.5 * (i % 20) as f32, 0.25, 0.5 * (i / 20) as f32);
            insert(&mut simulation, cube(0.5, at));
        }
        insert(&mut simulation, cube(0.01, Vec3::new(2.0, 0.505, 2.0)));
        (0..30).for_each(|_| simulation.step(H));
        let slots: Vec<u32> = simulation.bodies.iter().collect();
        let poses = slots.iter().map(|&slot| simulation.bodies.pose(slot));
        poses.collect::<Vec<_>>()
    };
    assert_eq!(run(1), run(16));
}

#[test]
fn a_deck_of_cards_keeps_its_height() {
    // 52 cards of 0.3 mm: without local steps they lose the height of 21 of them.
    let thickness = 3e-4;
    let mut simulation = awake();
    let mesh = ConvexMesh::cuboid(0.063, thickness, 0.088).expect("a size");
    let mut top = 0;
    for i in 0..52 {
        let at = (i as f32 + 0.5) * thickness * Vec3::Y;
        top = insert(&mut simulation, BodyDesc::dynamic(mesh.clone(), at));
    }
    for _ in 0..600 {
        simulation.step(H);
    }
    let sunk = 51.5 * thickness - simulation.bodies.pose(top).position.y;
    assert!(sunk < 0.12 * thickness, "{} of a card", sunk / thickness);
}
