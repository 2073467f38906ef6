//! Bodies placed where they cannot be: deep overlaps, and gaps that are too small.

use super::scene::*;
use super::support::*;
use crate::common::structures::*;
use bevy_cleave::prelude::*;
use glam::Vec3;

fn weightless() -> Simulation {
    Simulation {
        gravity: Gravity(Vec3::ZERO),
        ..simulation([])
    }
}

/// Hard because bias on an overlap of half a metre asks for 6 m/s (beta d / h), which is 18 J for each kilogram: an
/// explosion. With a cap on the push-out speed they part in 0.5 m / cap + 0.1 s, and then stand.
#[test]
fn two_overlapping_cubes_part_at_the_push_out_speed_and_stand() {
    let mut simulation = weightless();
    let cap = simulation.config.push_out_speed;
    let shape = cuboid(Vec3::ONE);
    let cubes = [0.0, 0.5].map(|x| add(&mut simulation, block(&shape, x * Vec3::X, 0.5)));
    let (mut fastest, mut parted) = (0.0_f32, None);
    let mut speed = 0.0;
    for step in 1..=120_u16 {
        simulation.step(H);
        let [a, b] = cubes.map(|slot| simulation.bodies.velocity(slot).0);
        speed = a.distance(b);
        fastest = fastest.max(speed);
        let [a, b] = cubes.map(|slot| simulation.bodies.center_of_mass(slot));
        if a.distance(b) > 0.99 {
            parted.get_or_insert(f32::from(step) * H);
        }
    }
    println!(
        "24 two cubes: {fastest:.3} m/s at most, apart after {parted:?} s, then {speed:.2e} m/s"
    );
    assert!(
        fastest <= cap + 1e-3,
        "{fastest} m/s against a cap of {cap}"
    );
    let parted = parted.expect("they part");
    assert!(parted <= 0.5 / cap + 0.1, "apart after {parted} s");
    assert!(speed < 0.1, "go on at {speed} m/s");
}

/// The centers of 27 unit cubes half overlapped.
fn lattice() -> impl Iterator<Item = Vec3> {
    (0..27_u8)
        .map(|i| 0.5 * Vec3::new(f32::from(i % 3), f32::from(i / 3 % 3), f32::from(i / 9)) - 0.5)
}

/// Hard because a cube in the middle is pushed by 26 others, all ways at once, and the walls of the box push back.
#[test]
fn twenty_seven_overlapping_cubes_in_a_box_do_not_explode() {
    let mut simulation = weightless();
    for normal in [Vec3::X, Vec3::Y, Vec3::Z]
        .into_iter()
        .flat_map(|n| [n, -n])
    {
        let mut wall = BodyDesc::floor(HalfSpaceShape { normal });
        wall.pose.position = -2.0 * normal;
        add(&mut simulation, wall);
    }
    let shape = cuboid(Vec3::ONE);
    let cubes: Vec<u32> = lattice()
        .map(|place| add(&mut simulation, block(&shape, place, 0.5)))
        .collect();
    let mut fastest = 0.0_f32;
    let speed = |simulation: &Simulation| {
        let speeds = cubes
            .iter()
            .map(|&c| simulation.bodies.velocity(c).0.length());
        speeds.fold(0.0, f32::max)
    };
    for _ in 0..600 {
        simulation.step(H);
        fastest = fastest.max(speed(&simulation));
    }
    let manifolds = simulation.contacts.manifolds().iter();
    let overlaps = manifolds.flat_map(|m| m.points()).map(|p| -p.separation);
    let (overlap, last) = (overlaps.fold(0.0, f32::max), speed(&simulation));
    println!(
        "24 27 cubes in a box: {fastest:.3} m/s at most, after 10 s {last:.3} m/s and overlaps of {overlap:.4} m"
    );
    let cap = simulation.config.push_out_speed;
    assert!(fastest <= 2.0 * cap, "{fastest} m/s against a cap of {cap}");
    assert!(overlap < 0.02, "still {overlap} m of overlap");
    let within = cubes
        .iter()
        .all(|&c| simulation.bodies.center_of_mass(c).abs().max_element() < 2.0);
    assert!(within, "a cube left the box");
}

/// A row of five unit cubes on a floor between two fixed walls that are 8 mm too near.
fn squeezed_row() -> (Simulation, Vec<u32>) {
    let mut simulation = with_floor(0.5);
    for side in [-1.0, 1.0] {
        let mut wall = block(
            &cuboid(Vec3::new(1.0, 4.0, 4.0)),
            side * (3.0 - 0.004) * Vec3::X,
            0.5,
        );
        wall.kind = RigidBody::Static;
        add(&mut simulation, wall);
    }
    let shape = cuboid(Vec3::ONE);
    let cubes = (0..5_u8).map(|i| {
        let place = Vec3::new(f32::from(i) - 2.0, 0.5, 0.0);
        add(&mut simulation, block(&shape, place, 0.5))
    });
    let cubes = cubes.collect();
    (simulation, cubes)
}

/// Hard because there is no solution: 5 m of cubes in 4.992 m. Multipliers that add up what is missing step by step grow
/// without bound. Nothing may move by a centimetre in 1000 steps.
#[test]
fn row_squeezed_between_walls_stays_where_it_is() {
    let (mut simulation, cubes) = squeezed_row();
    let places = |simulation: &Simulation| -> Vec<Vec3> {
        cubes
            .iter()
            .map(|&c| simulation.bodies.center_of_mass(c))
            .collect()
    };
    weigh(&mut simulation);
    let before = places(&simulation);
    let (mut early, mut late, mut farthest) = (0.0_f32, 0.0_f32, 0.0_f32);
    for step in 0..1000 {
        simulation.step(H);
        let manifolds = simulation.contacts.manifolds().iter();
        let most = manifolds
            .flat_map(|m| m.points())
            .map(|p| p.normal_impulse)
            .fold(0.0, f32::max);
        assert!(most.is_finite(), "multiplier {most}");
        let record = if step < 100 { &mut early } else { &mut late };
        *record = record.max(most);
        for (now, before) in places(&simulation).iter().zip(&before) {
            assert!(now.is_finite(), "at {now}");
            farthest = farthest.max(now.distance(*before));
        }
    }
    println!(
        "25 squeezed row: moved {farthest:.2e} m, largest multiplier {early:.1}, later {late:.1} N s"
    );
    assert!(farthest < 0.01, "moved {farthest} m");
    assert!(
        late < 2.0 * early,
        "multipliers grow: {early}, then {late} N s"
    );
}
