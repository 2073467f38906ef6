//! Threads that share short lists of tasks: each task is done once, whatever the number of helpers.

use crate::pool;
use bevy_cleave::testing::threads::{Shared, Team};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

#[test]
fn each_task_of_many_short_lists_is_done_once_and_in_its_list() {
    let done: Vec<AtomicU32> = (0..32).map(|_| AtomicU32::new(0)).collect();
    let lists = Team::lead(pool(), |team| {
        assert_eq!(team.threads(), 4);
        for list in 0..20_000_u32 {
            let count = (list % 33) as usize;
            team.run(count, &|task| {
                // What the list before left: so none of its tasks is still running, and none was left out.
                let before = done[task].fetch_add(1, Ordering::Relaxed);
                let full_rounds = list / 33 * (32 - task as u32);
                let in_this_round = (list % 33).saturating_sub(task as u32 + 1);
                assert_eq!(before, full_rounds + in_this_round);
            });
        }
        20_000
    });
    assert_eq!(lists, 20_000);
}

#[test]
#[allow(unsafe_code, reason = "each task writes to a part of its own")]
fn tasks_write_to_parts_of_one_list() {
    let mut list = vec![0_u64; 1000];
    let shared = Shared::new(&mut list);
    Team::lead(pool(), |team| {
        for round in 0..100 {
            team.run(10, &|task| {
                // SAFETY: no two tasks have the same part.
                let part = unsafe { shared.part(100 * task..100 * (task + 1)) };
                part.iter_mut().for_each(|x| *x += round * task as u64);
            });
        }
    });
    let sum = (0..100).sum::<u64>();
    assert!((0..1000).all(|i| list[i] == sum * (i as u64 / 100)));
}

#[test]
fn a_panic_in_a_task_reaches_the_leader_after_the_others_are_done() {
    let done = AtomicU32::new(0);
    let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        Team::lead(pool(), |team| {
            team.run(32, &|task| {
                assert_ne!(task, 20, "asked for");
                done.fetch_add(1, Ordering::Relaxed);
            });
        });
    }));
    assert!(outcome.is_err());
    assert!(done.load(Ordering::Relaxed) <= 31);
}

#[test]
fn each_part_is_worked_on_once_with_and_without_a_team() {
    for count in 0..=32 {
        let mut parts: Vec<u32> = vec![0; count];
        Team::lead(pool(), |team| {
            assert!(Team::parts(Some(team), 100, 10) == 4 && Team::parts(Some(team), 25, 10) == 2);
            assert_eq!(Team::parts(Some(team), 5, 10), 1);
            Team::each(Some(team), parts.iter_mut(), |part| *part += 1);
        });
        Team::each(None, parts.iter_mut(), |part| *part += 1);
        assert!(parts.iter().all(|&part| part == 2));
    }
}

#[test]
fn two_leaders_at_a_time_both_get_their_work_done() {
    let lead = || {
        for _ in 0..200 {
            let sum = AtomicU32::new(0);
            Team::lead(pool(), |team| {
                assert_eq!(team.threads(), 4);
                team.run(32, &|task| {
                    sum.fetch_add(task as u32, Ordering::Relaxed);
                });
            });
            assert_eq!(sum.into_inner(), 31 * 32 / 2);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(lead);
        }
    });
}

#[test]
fn a_panic_on_another_thread_reaches_the_leader() {
    let leader = std::thread::current().id();
    let outcome = std::panic::catch_unwind(|| {
        // Helpers may come late, and another test may lead them for a while, but not for ever.
        for _ in 0..10_000 {
            Team::lead(pool(), |team| {
                team.run(4, &|_| {
                    assert_eq!(std::thread::current().id(), leader, "asked for");
                    // Time for the others to take one.
                    std::thread::sleep(Duration::from_millis(1));
                });
            });
        }
    });
    assert!(outcome.is_err());
    Team::lead(pool(), |team| team.run(4, &|_| ()));
}
