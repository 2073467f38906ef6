//! Heaps of round bodies and boxes: they lose energy, stay in their box, come to rest, and do the same on any number of threads.

use crate::any_shape;
use crate::common::dice::Dice;
use crate::common::scenes::awake;
use bevy_cleave::prelude::*;
use bevy_tasks::{ComputeTaskPool, TaskPoolBuilder};
use glam::{Quat, Vec3};

const H: f32 = 1.0 / 60.0;

/// A box without a lid, of half-spaces, and round bodies and boxes above it.
fn heap(bodies: usize, seed: u64) -> Simulation {
    let mut simulation = awake();
    let walls = [Vec3::Y, Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z];
    for normal in walls {
        let mut wall = BodyDesc::floor(HalfSpaceShape::new(normal).expect("a unit vector"));
        wall.pose.position = if normal == Vec3::Y {
            Vec3::ZERO
        } else {
            -1.2 * normal
        };
        simulation.bodies.insert(wall).expect("usable");
    }
    let mut dice = Dice::new(seed);
    for k in 0..bodies {
        let mesh = if k % 3 == 2 {
            ConvexMesh::cuboid(0.4, 0.3, 0.5).expect("a box")
        } else {
            any_shape(&mut dice)
        };
        // Two on each level, on one diagonal and then the other: none overlap at the start.
        let (level, side) = (k / 2, 0.55 - 1.1 * (k % 2) as f32);
        let (x, z) = if level % 2 == 0 {
            (side, side)
        } else {
            (side, -side)
        };
        let level = 1.0 + 1.4 * level as f32;
        let mut desc = BodyDesc::dynamic(mesh, Vec3::new(x, level, z));
        desc.pose.rotation = dice.rotation();
        simulation.bodies.insert(desc).expect("usable");
    }
    simulation
}

fn state(simulation: &Simulation) -> Vec<(Pose, Vec3)> {
    let bodies = &simulation.bodies;
    let of = |slot| (bodies.pose(slot), bodies.velocity(slot).0);
    bodies.iter().map(of).collect()
}

#[test]
fn heaps_lose_energy_and_come_to_rest() {
    for seed in 0..3 {
        let mut simulation = heap(40, seed);
        simulation.config.measure_error = true;
        let mut last = f64::INFINITY;
        for step in 0..900 {
            simulation.step(H);
            let error = simulation.report.error.expect("asked for");
            let energy = error.kinetic_energy + error.potential_energy;
            // Pushing overlap out lifts bodies: by up to 71 J of the 23 kJ of a heap that bodies hit from 30 m above.
            let is_lost = energy < last + 5e-3 * last.abs();
            assert!(is_lost, "step {step}: from {last} J to {energy} J");
            last = energy;
        }
        let error = simulation.report.error.expect("asked for");
        let fastest = simulation
            .bodies
            .iter()
            .map(|slot| simulation.bodies.velocity(slot).0.length());
        let fastest = fastest.fold(0.0, f32::max);
        println!(
            "{seed}: overlap {} m, fastest {fastest} m/s, asleep {}",
            error.penetration, simulation.report.asleep
        );
        assert!(
            error.penetration < 5e-3,
            "overlap of {} m",
            error.penetration
        );
        assert!(fastest < 0.5, "{fastest} m/s");
        for slot in simulation.bodies.iter().skip(5) {
            let at = simulation.bodies.pose(slot).position;
            assert!(at.y > 0.04 && at.x.abs() < 1.2 && at.z.abs() < 1.2, "{at}");
        }
    }
}

#[test]
fn threads_change_no_bit() {
    let run = || {
        let mut simulation = heap(60, 9);
        for _ in 0..240 {
            simulation.step(H);
        }
        state(&simulation)
    };
    // No other test of this program makes a pool.
    let alone = run();
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(4).build());
    assert!(run() == alone);
}

#[test]
fn the_cache_knows_a_ball_that_rolls() {
    let mut simulation = awake();
    let floor = BodyDesc::floor(HalfSpaceShape::new(Vec3::Y).expect("a unit vector"));
    simulation.bodies.insert(floor).expect("usable");
    let mesh = ConvexMesh::sphere(0.5).expect("a sphere");
    let mut ball = BodyDesc::dynamic(mesh, 0.5 * Vec3::Y);
    ball.linear_velocity = 2.0 * Vec3::X;
    ball.angular_velocity = -4.0 * Vec3::Z;
    ball.pose.rotation = Quat::IDENTITY;
    simulation.bodies.insert(ball).expect("usable");
    for step in 0..120 {
        simulation.step(H);
        let cache = &simulation.report.cache;
        if step > 1 {
            assert_eq!((cache.points, cache.exact_hits), (1, 1), "step {step}");
        }
    }
}
