//! What touches nothing but the ground is solved beside others like it, and moves to the bit as if it were the only one: a floor, which it
//! touches at one place, and hills of triangles, where it has contacts in several directions.

use crate::common::dice::Dice;
use crate::structures::floor;
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Steps of a run.
const STEPS: usize = 150;

/// Hollows and ridges of triangles of `spacing` m, up to two meters high, below the bodies.
fn hills(dice: &mut Dice, spacing: f32) -> BodyDesc {
    let [columns, rows] = [500.0, 60.0].map(|length: f32| (length / spacing) as usize);
    let half = dice.in_range(2.5, 8.0);
    let mut height = |i: usize| {
        let [x, z] = [i % columns, i / columns].map(|k| {
            let along = (spacing * k as f32 / half).rem_euclid(2.0) - 1.0;
            along * along
        });
        x + z + 0.02 * dice.in_range(-1.0, 1.0)
    };
    let heights: Vec<f32> = (0..columns * rows).map(&mut height).collect();
    let level = StaticMesh::from_heights(&heights, columns, spacing).expect("a grid");
    let mut desc = BodyDesc::level(level);
    desc.pose.position = Vec3::new(-10.0, -1.0, -30.0);
    desc.friction = Friction::new(0.6);
    desc
}

/// A body of any kind that is thrown to the ground, `at` m from the first one.
fn thrown(dice: &mut Dice, at: f32) -> BodyDesc {
    let size = dice.in_range(0.3, 0.8);
    let shape = match dice.below(4) {
        0 => ConvexMesh::sphere(0.5 * size),
        1 => ConvexMesh::cuboid(size, dice.in_range(0.3, 0.8), dice.in_range(0.3, 0.8)),
        2 => ConvexMesh::cylinder(0.5 * size, dice.in_range(0.3, 0.8)),
        _ => ConvexMesh::from_points(&[(); 14].map(|()| size * dice.direction())),
    };
    let place = Vec3::new(at, dice.in_range(0.8, 4.0), 0.0);
    let mut desc = BodyDesc::dynamic(shape.expect("a solid"), place);
    desc.pose.rotation = dice.rotation();
    desc.linear_velocity = Vec3::new(0.0, 0.0, dice.in_range(-6.0, 6.0));
    desc.angular_velocity = dice.vector(-6.0, 6.0);
    desc.restitution = Restitution::new([0.0, 0.4, 1.0][dice.below(3)]);
    desc
}

/// What a step does to some bodies, in their order: pose of the center and velocities as bits, and whether it still moves so fast that
/// its rows follow.
fn run(ground: &BodyDesc, bodies: &[BodyDesc]) -> Vec<Vec<([u32; 9], bool)>> {
    let mut simulation = Simulation::default();
    simulation.bodies.insert(ground.clone()).expect("a floor");
    let insert = |desc: &BodyDesc| simulation.bodies.insert(desc.clone()).expect("a body");
    let slots: Vec<u32> = bodies.iter().map(insert).collect();
    let mut step = |_| {
        simulation.step(1.0 / 60.0);
        let state = |&slot: &u32| {
            let (linear, angular) = simulation.bodies.velocity(slot);
            let center = simulation.bodies.center_of_mass(slot);
            let bits = [center, linear, angular].map(|v| v.to_array().map(f32::to_bits));
            let mut all = [0; 9];
            all.copy_from_slice(bits.as_flattened());
            (all, linear.length() > 1.5 || angular.length() > 0.8)
        };
        slots.iter().map(state).collect()
    };
    (0..STEPS).map(&mut step).collect()
}

/// Holds bodies together against each of them alone.
fn check(ground: &BodyDesc, dice: &mut Dice) {
    let bodies: Vec<BodyDesc> = (0_u8..48)
        .map(|i| thrown(dice, 10.0 * f32::from(i)))
        .collect();
    let together = run(ground, &bodies);
    let mut compared = 0;
    for (i, body) in bodies.iter().enumerate() {
        let alone = run(ground, std::slice::from_ref(body));
        // Neighbors at rest share their sweeps.
        let moving = alone.iter().position(|step| !step[0].1).unwrap_or(STEPS);
        for step in 0..moving {
            assert_eq!(together[step][i], alone[step][0], "body {i}, step {step}");
        }
        compared += moving;
    }
    assert!(
        compared > 24 * STEPS,
        "{compared} steps of bodies that move"
    );
}

#[test]
fn what_touches_only_the_floor_moves_as_if_it_were_alone() {
    check(&floor(0.6), &mut Dice::new(11));
}

#[test]
fn what_touches_only_hills_moves_as_if_it_were_alone() {
    let mut dice = Dice::new(17);
    for spacing in [0.5, 1.2] {
        check(&hills(&mut dice, spacing), &mut dice);
    }
}
