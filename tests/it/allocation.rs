//! A step in which nothing arrives, leaves or breaks takes no memory from the allocator: all buffers are kept.

use crate::common::scenes::pile;
use allocation_counter::measure;
use bevy_cleave::prelude::*;
use bevy_tasks::ComputeTaskPool;
use std::hint::black_box;

/// Length of a step, s.
const H: f32 = 1.0 / 60.0;

/// Steps in which the pile falls and comes to rest, 15 s.
const WARM_UP: usize = 900;

#[test]
fn steady_step_allocates_nothing() {
    let seen = measure(|| drop(black_box(Vec::<u8>::with_capacity(1))));
    assert_eq!(seen.count_total, 1, "allocations are counted");

    let mut simulation = pile(60);
    simulation.config.measure_error = true;
    for slot in 1..=60 {
        let unbroken = Fracturable {
            strength: f32::MAX,
            ..Default::default()
        };
        simulation.bodies.set_fracturable(slot, Some(unbroken));
    }
    for _ in 0..WARM_UP {
        simulation.step(H);
    }
    assert!(simulation.report.contacts > 100, "the pile touches");
    let allocated = measure(|| (0..60).for_each(|_| simulation.step(H)));
    assert_eq!(allocated.count_total, 0, "{allocated:?}");
    // With a pool it would not hold; nor would the other tests here be the same in every run.
    assert!(ComputeTaskPool::try_get().is_none(), "a test made a pool");
}
