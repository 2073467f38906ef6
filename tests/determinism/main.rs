//! The same bits whatever the number of threads, the lanes, the slots, the entities and the tables they lie in.
//!
//! Task pools are one for the whole process, so every run is a process of its own: the test program starts itself with
//! [`a_run_gives_the_same_bits_here_and_in_a_child`] as the only test, and reads the hashes that it prints.
//!
//! # Golden hashes
//! `GOLDEN=print cargo test --release --test determinism -- --nocapture` prints the constants of `golden.rs` anew. They may
//! change only together with a deliberate change of the method, which the commit names: a change that is meant to make
//! the same thing faster, or a different machine, must leave them as they are.
#![allow(clippy::print_stdout, reason = "figures are told with --nocapture")]

#[path = "../common/mod.rs"]
mod common;

mod alone;
mod builds;
mod course;
mod golden;
mod run;
mod scene;
mod sleepers;

use bevy_cleave::testing::simd::LaneWidth;
use common::{scenes as heaps, structures};
use course::Hashes;
use golden::GOLDEN;
use run::{Driver, Run};
use scene::Scene;
use std::sync::LazyLock;

/// The run that all others are held against.
const PLAIN: Run = Run {
    scene: Scene::BreakingPile,
    driver: Driver::Plain,
    threads: 0,
    lanes: LaneWidth::Widest,
};

/// Hashes of [`PLAIN`], run once.
static EXPECTED: LazyLock<Hashes> = LazyLock::new(|| PLAIN.hashes_of_child());

/// Runs the scene in other ways and compares the hashes.
fn assert_same(runs: &[Run]) {
    for run in runs {
        assert_eq!(
            run.hashes_of_child(),
            *EXPECTED,
            "{run:?} against {PLAIN:?}"
        );
    }
}

/// A child makes the run that it is told, and prints the hashes that its parent asks for.
#[test]
fn a_run_gives_the_same_bits_here_and_in_a_child() {
    if let Some(run) = Run::asked_for() {
        return run.print_hashes();
    }
    let run = Run {
        scene: Scene::Pyramid,
        ..PLAIN
    };
    assert_eq!(run.hashes(), run.hashes_of_child());
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    assert_same(&[1, 2, 4, 8].map(|threads| Run { threads, ..PLAIN }));
}

#[test]
fn any_number_of_lanes_gives_the_same_bits() {
    let (four, one) = (LaneWidth::Four, LaneWidth::One);
    assert_same(
        &[(four, 0), (four, 4), (one, 2)].map(|(lanes, threads)| Run {
            lanes,
            threads,
            ..PLAIN
        }),
    );
}

/// Runs the scene by another driver.
fn assert_driver(driver: Driver, threads: usize) {
    assert_same(&[Run {
        driver,
        threads,
        ..PLAIN
    }]);
}

#[test]
fn recycled_slots_give_the_same_bits() {
    assert_driver(Driver::RecycledSlots, 4);
}

/// What breaks, sleeps, bounces, is bonded or carried, by all methods.
#[test]
fn what_is_taken_back_goes_on_to_the_same_bits() {
    use Scene::*;
    for scene in [
        Mixed,
        LargeBreaking,
        Sleep,
        BondedWall,
        BrickWall,
        Paper,
        Exact,
        ColdStart,
        Blows,
        Carried,
    ] {
        let driver = Driver::TakenBack;
        let run = Run {
            scene,
            driver,
            ..PLAIN
        };
        assert_eq!(run.hashes_of_child(), golden(scene), "{run:?}");
    }
}

#[test]
fn plugin_gives_the_same_bits() {
    assert_driver(Driver::Plugin, 1);
}

#[test]
fn recycled_entities_give_the_same_bits() {
    assert_driver(Driver::RecycledEntities, 2);
}

#[test]
fn entities_in_other_tables_give_the_same_bits() {
    assert_driver(Driver::ManyTables, 2);
}

#[test]
fn entities_made_in_the_opposite_order_give_the_same_bits() {
    assert_driver(Driver::EntitiesBackwards, 4);
}

/// The golden hashes of a scene.
fn golden(scene: Scene) -> Hashes {
    let found = GOLDEN.iter().find(|golden| golden.0 == scene);
    let &(_, state, course) = found.expect("every scene has golden hashes");
    Hashes { state, course }
}

#[test]
fn golden_hashes_have_not_changed() {
    let found = Scene::ALL.map(|scene| match scene {
        Scene::BreakingPile => (scene, *EXPECTED),
        _ => (scene, Run { scene, ..PLAIN }.hashes_of_child()),
    });
    if std::env::var("GOLDEN").is_ok_and(|value| value == "print") {
        return golden::print(&found);
    }
    for (scene, hashes) in found {
        let golden = golden(scene);
        assert_eq!(
            hashes, golden,
            "{scene:?} has other bits: {hashes:x?}, golden {golden:x?}. Only a deliberate change of the method may do \
             that; then renew `golden.rs` as the head of this test says, and name the change in the commit"
        );
    }
}

/// Runs every scene that only the plain step runs on some threads and lanes.
fn assert_golden_with(threads: usize, lanes: LaneWidth) {
    for scene in Scene::plain() {
        let run = Run {
            scene,
            threads,
            lanes,
            ..PLAIN
        };
        assert_eq!(run.hashes_of_child(), golden(scene), "{run:?}");
    }
}

#[test]
fn all_scenes_have_the_golden_hashes_on_one_thread_and_four_lanes() {
    assert_golden_with(1, LaneWidth::Four);
}

#[test]
fn all_scenes_have_the_golden_hashes_on_two_threads_and_one_lane() {
    assert_golden_with(2, LaneWidth::One);
}

#[test]
fn all_scenes_have_the_golden_hashes_on_four_threads() {
    assert_golden_with(4, LaneWidth::Widest);
}

/// A tower is solved by colors unless another order is asked for, and the order shows.
#[test]
fn contacts_of_a_narrow_structure_are_colored() {
    let [kept, colored, automatic] =
        [Scene::TowerKept, Scene::TowerColored, Scene::TowerAutomatic].map(golden);
    assert_eq!(automatic, colored);
    assert_ne!(automatic, kept);
    assert_ne!(golden(Scene::HeapColored), golden(Scene::HeapKept));
}

#[test]
fn golden_hashes_cover_all_scenes() {
    assert_eq!(GOLDEN.map(|golden| golden.0), Scene::ALL);
}
