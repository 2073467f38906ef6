//! The same bits without a task pool, and with one of four threads.
//!
//! A process has one pool and keeps it. So all runs without it are made before any other, and every test holds its run on
//! threads against them.

#[path = "../common/mod.rs"]
mod common;

mod bodies;
mod bonded_wall;
mod bonds;
mod cache;
mod compounds;
mod joints;
mod sleep;

use bevy_tasks::{ComputeTaskPool, TaskPoolBuilder};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::thread;

/// What the runs come to without a pool.
struct Alone {
    bodies: [bodies::Outcome; 3],
    bonded_wall: bonded_wall::Outcome,
    bonds: bonds::Outcome,
    cache: Vec<cache::Outcome>,
    compounds: compounds::Outcome,
    joints: joints::Outcome,
    /// Without slots that were used before, and with them.
    sleep: [sleep::Outcome; 2],
}

impl Alone {
    fn run() -> Self {
        assert!(
            ComputeTaskPool::try_get().is_none(),
            "the first run has no pool"
        );
        let alone = thread::scope(|scope| {
            let bodies = scope.spawn(bodies::run_all);
            Self {
                bonded_wall: bonded_wall::run(),
                bonds: bonds::run(),
                cache: cache::play(),
                compounds: compounds::run(),
                joints: joints::run(),
                sleep: [0, 40].map(sleep::history),
                bodies: bodies.join().expect("the run went as it should"),
            }
        });
        assert!(
            ComputeTaskPool::try_get().is_none(),
            "no run has made a pool"
        );
        alone
    }
}

/// What the runs come to without a pool; there is one afterwards.
fn alone() -> &'static Alone {
    static ALONE: LazyLock<Alone> = LazyLock::new(|| {
        let alone = Alone::run();
        ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(4).build());
        alone
    });
    &ALONE
}

/// What `run` comes to with the pool. One at a time, or only one of them would have the help of its threads.
fn on_threads<T>(run: impl FnOnce() -> T) -> T {
    static TURN: Mutex<()> = Mutex::new(());
    alone();
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    run()
}
