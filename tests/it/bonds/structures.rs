//! Walls of bonded bricks.

use super::scene::{
    H, bits, centers, chain, farthest, first_break, joints_of_lintel, lintel, simulation,
};
use allocation_counter::measure;
use bevy_cleave::prelude::*;
use bevy_cleave::testing::simd::LaneWidth;
use glam::Vec3;

/// Strength of common mortar, Pa.
const MORTAR: f32 = 2e5;

fn bonded_lintel(rows: usize, columns: usize, strength: f32) -> (Simulation, Vec<u32>) {
    let (mut simulation, slots) = lintel(rows, columns);
    let made = simulation.bond_neighbors(&slots, strength);
    assert_eq!(made, Ok(joints_of_lintel(rows, columns)));
    (simulation, slots)
}

#[test]
fn a_bonded_wall_spans_a_gap_for_ten_seconds_without_sag_or_creep() {
    let (mut simulation, slots) = bonded_lintel(10, 10, MORTAR);
    let start = centers(&simulation, &slots);
    assert_eq!(first_break(&mut simulation, 300), None);
    let half_way = centers(&simulation, &slots);
    assert_eq!(first_break(&mut simulation, 300), None);
    let sag = farthest(&simulation, &slots, &start);
    assert!(sag < 1e-3, "{sag} m");
    let creep = farthest(&simulation, &slots, &half_way);
    assert!(creep < 1e-6, "{creep} m in five seconds");
}

#[test]
fn without_bonds_the_same_wall_falls_into_the_gap() {
    let (mut simulation, slots) = lintel(10, 10);
    let start = centers(&simulation, &slots);
    (0..120).for_each(|_| simulation.step(H));
    assert!(farthest(&simulation, &slots, &start) > 1.0);
}

#[test]
fn a_bonded_wall_is_solved_as_precisely_as_contacts_are() {
    let (mut simulation, _) = bonded_lintel(6, 6, MORTAR);
    simulation.config.measure_error = true;
    (0..300).for_each(|_| simulation.step(H));
    let error = simulation.report.error.expect("asked for").residual;
    assert!(error.relative < 1e-4, "{error:?}");
    let energy = simulation.report.error.map(|e| e.kinetic_energy);
    assert!(energy.is_some_and(|e| e < 1e-6), "at rest: {energy:?} J");
}

/// A wall on the ground, its feet bonded to nothing, and a ball of 200 kg that flies at it with the given speed, m/s.
fn wall_and_ball(speed: f32) -> (Simulation, Vec<u32>) {
    let (mut simulation, slots) = lintel(8, 8);
    let ground = HalfSpaceShape { normal: Vec3::Y };
    let mut floor = BodyDesc::floor(ground);
    floor.pose.position.y = -0.1;
    simulation.bodies.insert(floor).expect("usable");
    let ball = ConvexMesh::icosphere(0.3, 2).expect("valid size");
    let mut ball = BodyDesc::dynamic(ball, Vec3::new(0.1, 0.8, 1.0));
    ball.density = 200.0 / (4.0 / 3.0 * std::f32::consts::PI * 0.027);
    ball.linear_velocity = Vec3::new(0.0, 0.0, -speed);
    simulation.bodies.insert(ball).expect("usable");
    let made = simulation.bond_neighbors(&slots, MORTAR);
    assert_eq!(made, Ok(joints_of_lintel(8, 8)));
    (simulation, slots)
}

#[test]
fn a_ball_cracks_a_wall_along_its_bonds_and_the_pieces_come_apart() {
    let (mut simulation, slots) = wall_and_ball(20.0);
    let start = centers(&simulation, &slots);
    let bonds = simulation.bonds.len();
    (0..120).for_each(|_| simulation.step(H));
    let broken = bonds - simulation.bonds.len();
    assert!(broken > 10, "{broken} of {bonds} bonds broke");
    assert!(!simulation.bonds.is_empty(), "part of the wall holds");
    assert!(simulation.fractures.done.is_empty(), "nothing was cut");
    let ways = centers(&simulation, &slots).into_iter().zip(&start);
    let gone = ways
        .filter(|(now, then)| now.distance(**then) > 0.5)
        .count();
    assert!(gone > 4, "{gone} bricks flew off");
    // What still holds together has kept its shape.
    for ([a, b], _) in simulation.bonds.iter() {
        let first = |slot: u32| slots.iter().position(|&s| s == slot).map(|i| start[i]);
        let (Some(p), Some(q)) = (first(a), first(b)) else {
            panic!("bonds join bricks");
        };
        let [now_a, now_b] = [a, b].map(|slot| simulation.bodies.center_of_mass(slot));
        let stretch = (now_a.distance(now_b) - p.distance(q)).abs();
        assert!(stretch < 0.01, "a bond is stretched by {stretch} m");
    }
}

#[test]
fn a_ball_that_barely_touches_the_wall_breaks_nothing() {
    let (mut simulation, _) = wall_and_ball(0.1);
    assert_eq!(first_break(&mut simulation, 120), None);
}

#[test]
fn all_methods_hold_below_the_strength_and_break_above() {
    let paper = SolverConfig::paper();
    for config in [SolverConfig::default(), paper, SolverConfig::exact()] {
        for (share, holds) in [(1.1, true), (0.9, false)] {
            let bond = Bond::new(share * 2.0 * super::scene::WEIGHT, 1.0);
            let (mut simulation, _) = chain(2, -Vec3::Y, bond);
            simulation.config = config;
            let first = first_break(&mut simulation, 120);
            assert_eq!(first.is_none(), holds, "{:?}, {share}", config.method);
        }
    }
}

#[test]
fn the_exact_method_finds_the_static_load_of_a_cantilever() {
    let bond = Bond::new(1e6, 1.0);
    let (mut simulation, _) = chain(3, Vec3::X, bond);
    simulation.config = SolverConfig {
        measure_error: true,
        sleep: SleepConfig::off(),
        ..SolverConfig::exact()
    };
    (0..120).for_each(|_| simulation.step(H));
    let error = simulation.report.error.expect("asked for").residual;
    assert!(error.relative < 1e-4, "{error:?}");
    assert!(simulation.report.unconverged.is_empty());
    let root = simulation.contacts.manifolds().get(0).expect("they touch");
    let moment: f32 = root
        .points()
        .iter()
        .map(|p| (p.anchor_a.y + 0.5) * -p.normal_impulse)
        .sum();
    // About the lower edge of the face: three cubes with their center 1.5 m from it.
    let expected = 3.0 * super::scene::WEIGHT * 1.5 * H;
    assert!(
        (moment / expected - 1.0).abs() < 0.01,
        "{moment} of {expected} N m s"
    );
}

#[test]
fn every_lane_width_gives_the_same_bits() {
    let run = |width| {
        let (mut simulation, _) = wall_and_ball(20.0);
        simulation.overrides.lane_width = width;
        (0..60).for_each(|_| simulation.step(H));
        bits(&simulation)
    };
    let widest = run(LaneWidth::Widest);
    assert!(widest == run(LaneWidth::Four));
    assert!(widest == run(LaneWidth::One));
}

#[test]
fn a_bonded_wall_sleeps_and_wakes_when_a_bond_is_taken_away() {
    let (mut simulation, slots) = bonded_lintel(4, 4, MORTAR);
    simulation.config.sleep = SleepConfig::default();
    (0..180).for_each(|_| simulation.step(H));
    assert_eq!(simulation.report.awake, 0, "sleeps");
    assert_eq!(simulation.bonds.len(), joints_of_lintel(4, 4));
    let Simulation { bonds, bodies, .. } = &mut simulation;
    assert!(bonds.unbond(bodies, slots[0], slots[1]));
    simulation.step(H);
    assert_eq!(simulation.report.asleep, 0, "awake");
    assert_eq!(simulation.bonds.len(), joints_of_lintel(4, 4) - 1);
}

#[test]
fn a_steady_step_with_bonds_allocates_nothing() {
    let (mut simulation, _) = bonded_lintel(6, 6, MORTAR);
    (0..120).for_each(|_| simulation.step(H));
    let allocated = measure(|| (0..60).for_each(|_| simulation.step(H)));
    assert_eq!(allocated.count_total, 0, "{allocated:?}");
}

/// A bonded stick that tumbles in free flight.
fn simulation_in_flight() -> (Simulation, Vec<u32>) {
    let bodies = (0..4).map(|i| {
        let at = Vec3::X * i as f32;
        let mut body = BodyDesc::dynamic(super::scene::cube(), at);
        body.angular_velocity = Vec3::new(0.3, 1.0, 2.0);
        body.linear_velocity = body.angular_velocity.cross(at - 1.5 * Vec3::X);
        body
    });
    let (mut simulation, slots) = simulation(bodies);
    simulation.gravity = Gravity(Vec3::ZERO);
    simulation.bond_neighbors(&slots, 1e6).expect("usable");
    (simulation, slots)
}

#[test]
fn a_bonded_stick_tumbles_as_one_body() {
    let (mut simulation, slots) = simulation_in_flight();
    let energy = |simulation: &Simulation| -> f64 {
        let mass = |slot| f64::from(simulation.bodies.mass(slot).mass);
        let speed = |slot| f64::from(simulation.bodies.velocity(slot).0.length_squared());
        let of = |slot| 0.5 * mass(slot) * speed(slot) + simulation.bodies.kinetic_energy(slot);
        slots.iter().map(|&slot| of(slot)).sum()
    };
    simulation.step(H);
    let before = energy(&simulation);
    (0..300).for_each(|_| simulation.step(H));
    let change = energy(&simulation) / before - 1.0;
    assert!(change < 1e-3, "gains {change} of its energy");
    assert!(change > -0.2, "loses {change} of its energy in 5 s");
    let at = centers(&simulation, &slots);
    let length = at[0].distance(at[3]);
    // None of the three bonds is stretched by what would break one.
    let most = 3.0 * bevy_cleave::testing::fracture::BREAKING_SHARE;
    assert!((length - 3.0).abs() < most, "{length} m long");
    let middle = 0.5 * (at[0] + at[3]);
    assert!(at[1].distance(middle) < 0.502, "straight");
}
