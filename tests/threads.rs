//! The same bits on one thread and on several. A file of its own, because the task pool is one for the whole process.

mod scenes;

use bevy_cleave::prelude::*;
use bevy_tasks::{ComputeTaskPool, TaskPoolBuilder};
use scenes::pile;

/// Positions and velocities after 60 steps of a pile with far more pairs than one task takes, some breaking.
fn run() -> Vec<[u32; 6]> {
    let mut simulation = pile(300);
    let breakable = Fracturable::with_strength(100.0);
    for slot in simulation
        .bodies
        .iter()
        .skip(1)
        .step_by(5)
        .collect::<Vec<_>>()
    {
        simulation.bodies.set_fracturable(slot, Some(breakable));
    }
    let mut broken = 0;
    for _ in 0..60 {
        simulation.step(1.0 / 60.0);
        broken += simulation.fractures.done.len();
    }
    assert!(broken > 0 && simulation.report.pairs > 500);
    let bodies = &simulation.bodies;
    let state = |slot| (bodies.centre_of_mass(slot), bodies.velocity(slot).0);
    let parts = bodies
        .iter()
        .map(state)
        .map(|(x, v)| [x.x, x.y, x.z, v.x, v.y, v.z]);
    parts.map(|numbers| numbers.map(f32::to_bits)).collect()
}

#[test]
fn one_thread_and_four_give_the_same_bits() {
    assert!(
        ComputeTaskPool::try_get().is_none(),
        "the first run has no pool"
    );
    let alone = run();
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(4).build());
    assert!(alone == run());
}
