//! Helpers stay for the next phase. In a process of its own: a team has one leader at a time, and here nobody else is one.

use bevy_cleave::testing::threads::Team;
use bevy_tasks::{ComputeTaskPool, TaskPoolBuilder};
use std::time::Duration;

/// Whether work finds helpers that have not gone yet.
fn is_helped() -> bool {
    Team::lead_present_if(true, |team| team.is_some())
}

#[test]
fn helpers_stay_for_a_while_and_then_go() {
    let pool = ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(3).build());
    assert!(!is_helped(), "nobody has called them yet");
    // A busy machine may let all of them come and go before they are looked for.
    let stay = (0..1000).any(|_| {
        Team::lead(pool, |_| ());
        is_helped()
    });
    assert!(stay);
    assert!(Team::lead_present_if(false, |team| team.is_none()));
    let go = (0..1000).any(|_| {
        std::thread::sleep(Duration::from_millis(5));
        !is_helped()
    });
    assert!(go);
}
