//! The same bits on any number of threads.

use crate::shapes::{ball, standing, wall};
use bevy_cleave::prelude::*;
use bevy_tasks::{ComputeTaskPool, TaskPoolBuilder};
use glam::Vec3;
use std::process::Command;

/// Tells a child how many threads it has.
const THREADS: &str = "CLUSTER_THREADS";

/// A hash of where all bodies are, 40 steps after four walls were shot at.
fn hash() -> u64 {
    let mut simulation = Simulation::default();
    let floor = HalfSpaceShape { normal: Vec3::Y };
    simulation
        .bodies
        .insert(BodyDesc::floor(floor))
        .expect("usable");
    for row in 0..4 {
        let shape = wall(10, 12, 3e5);
        let z = -1.5 * row as f32;
        let desc = BodyDesc {
            pose: Pose::from_position(z * Vec3::Z),
            ..standing(shape)
        };
        simulation.bodies.insert(desc).expect("usable");
        for shot in 0..3 {
            let at = Vec3::new(shot as f32 - 0.9, 0.5 + 0.2 * shot as f32, z + 0.4);
            let missile = ball(0.08, 7800.0, at, -20.0 * Vec3::Z);
            simulation.bodies.insert(missile).expect("usable");
        }
    }
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    for _ in 0..40 {
        simulation.step(1.0 / 60.0);
        for slot in simulation.bodies.iter() {
            let at = simulation.bodies.center_of_mass(slot).to_array();
            for bits in at.map(f32::to_bits) {
                hash = (hash ^ u64::from(bits)).wrapping_mul(0x0100_0000_01b3);
            }
        }
    }
    assert!(simulation.bodies.len() > 60, "{}", simulation.bodies.len());
    hash
}

#[test]
fn child() {
    let Ok(threads) = std::env::var(THREADS) else {
        return;
    };
    let threads = threads.parse().expect("a number");
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(threads).build());
    std::fs::write(
        std::env::var("CLUSTER_HASH").expect("a file"),
        hash().to_string(),
    )
    .expect("written");
}

#[test]
fn threads_change_no_bit() {
    let of = |threads: usize| {
        let file = std::env::temp_dir().join(format!("cluster_{}_{threads}", std::process::id()));
        let program = std::env::current_exe().expect("this program");
        let status = Command::new(program)
            .args(["threads::child", "--exact"])
            .env(THREADS, threads.to_string())
            .env("CLUSTER_HASH", &file)
            .status()
            .expect("it runs");
        assert!(status.success());
        let hash = std::fs::read_to_string(&file).expect("a hash");
        std::fs::remove_file(&file).expect("it is there");
        hash
    };
    let one = of(1);
    assert_eq!(one, of(2));
    assert_eq!(one, of(5));
}
