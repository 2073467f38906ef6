//! Towers that fall asleep, are hit, and sleep again.

use crate::common::states::bits_by_id;
use crate::common::structures::{block, cuboid, floor, tower};
use crate::{alone, on_threads};
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Length of a step, s.
const H: f32 = 1.0 / 60.0;

/// States at the end, and the steps in which the number asleep changed.
pub(crate) type Outcome = (Vec<[u32; 13]>, Vec<(usize, usize)>);

/// State after a scene has slept, was hit, and sleeps again, and the steps in which the number asleep changed.
pub(crate) fn history(spare_slots: usize) -> Outcome {
    let mut simulation = Simulation::default();
    simulation.config.sleep = SleepConfig::default();
    let dummies: Vec<_> = (0..spare_slots)
        .map(|_| {
            simulation
                .bodies
                .insert(block(&cuboid(Vec3::ONE), Vec3::ZERO, 0.6))
        })
        .collect();
    for slot in dummies {
        simulation.bodies.remove(slot.expect("usable"));
    }
    let towers = (0..30).flat_map(|i| {
        tower(3).into_iter().skip(1).map(move |mut desc| {
            desc.pose.position += Vec3::new(2.0 * (i % 6) as f32, 0.0, 2.0 * (i / 6) as f32);
            desc
        })
    });
    for desc in std::iter::once(floor(0.6)).chain(towers) {
        simulation.bodies.insert(desc).expect("usable");
    }
    let mut changes = vec![(0, 0)];
    for step in 0..400 {
        if step == 150 {
            let mut ball = block(
                &ConvexMesh::icosphere(0.5, 1).expect("valid"),
                Vec3::new(-2.0, 1.5, 0.1),
                0.6,
            );
            ball.linear_velocity = Vec3::new(12.0, 2.0, 1.0);
            simulation.bodies.insert(ball).expect("usable");
        }
        simulation.step(H);
        if changes.last().map(|last| last.1) != Some(simulation.report.asleep) {
            changes.push((step, simulation.report.asleep));
        }
    }
    let states = bits_by_id(&simulation).into_iter().map(|(_, state)| state);
    (states.collect(), changes)
}

#[test]
fn sleep_depends_neither_on_slots_nor_on_threads() {
    let [alone, recycled] = &alone().sleep;
    assert!(alone.1.len() > 3, "{:?}", alone.1);
    assert!(alone == recycled, "with recycled slots");
    let on_threads = on_threads(|| history(0));
    assert!(*alone == on_threads, "with four threads");
}
