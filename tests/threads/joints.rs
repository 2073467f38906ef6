//! Joints in a heap that threads solve together, and chains beside it that they solve one each.

use crate::common::scenes::awake_on_floor;
use crate::common::states::bits_by_id;
use crate::{alone, on_threads};
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Length of a step, s.
const H: f32 = 1.0 / 60.0;

/// What a run came to: poses and velocities as bits.
pub(crate) type Outcome = Vec<(u32, [u32; 13])>;

/// A block of 14 x 5 x 14 cubes, every other one fixed to its neighbor, on which a row falls; and 80 chains of 6 links.
pub(crate) fn run() -> Outcome {
    let mut simulation = awake_on_floor();
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    let mut last = None;
    for i in 0..14 * 5 * 14 {
        let at = [i % 14, i / 196, i / 14 % 14].map(|k| k as f32);
        let at = Vec3::from(at) + 0.5 * Vec3::Y;
        let cube = BodyDesc::dynamic(cube.clone(), at);
        let slot = simulation.bodies.insert(cube).expect("usable");
        match last.take() {
            Some(before) => {
                let poses = [before, slot].map(|slot| simulation.bodies.pose(slot));
                let joint = Joint::fixed().with_anchor(at - 0.5 * Vec3::X, Vec3::X, poses);
                simulation.join(Some(before), slot, joint).expect("usable");
            }
            None => last = Some(slot),
        }
    }
    let link = ConvexMesh::cuboid(0.5, 0.1, 0.1).expect("valid size");
    for chain in 0..80 {
        let origin = Vec3::new(
            30.0 + 2.0 * (chain % 10) as f32,
            8.0,
            4.0 * (chain / 10) as f32,
        );
        let half = Vec3::new(0.25, 0.0, 0.0);
        let mut last = None;
        for i in 0..6 {
            let at = origin + (0.25 + 0.5 * i as f32) * Vec3::X;
            let link = BodyDesc::dynamic(link.clone(), at);
            let slot = simulation.bodies.insert(link).expect("usable");
            let on_a = last.map_or(origin, |_| half);
            let joint = Joint::ball().with_anchors(on_a, -half);
            simulation.join(last, slot, joint).expect("usable");
            last = Some(slot);
        }
    }
    for _ in 0..20 {
        simulation.step(H);
    }
    assert!(simulation.report.manifolds > 1000);
    bits_by_id(&simulation)
}

#[test]
fn joints_hold_with_the_same_bits_on_one_thread_and_on_four() {
    assert!(alone().joints == on_threads(run));
}
