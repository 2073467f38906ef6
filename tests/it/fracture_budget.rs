//! What a scene can afford to break: pieces of a step and in all, the queue for the rest, and when pieces go.

use crate::common::scenes::awake;
use bevy_cleave::prelude::*;
use bevy_cleave::solver::SleepConfig;
use glam::Vec3;
use std::collections::BTreeSet;

const H: f32 = 1.0 / 60.0;

fn cube() -> ConvexMesh {
    ConvexMesh::cuboid(0.5, 0.5, 0.5).expect("valid size")
}

/// Cubes in a row that fall flat on a floor from 2 m, all in the same step, each breaking into eight.
fn row(count: u8, budget: FractureBudget) -> Simulation {
    row_of(count, FracturePattern::Star { planes: 4 }, budget)
}

/// The same with another pattern.
fn row_of(count: u8, pattern: FracturePattern, budget: FractureBudget) -> Simulation {
    let mut simulation = Simulation { budget, ..awake() };
    let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    simulation.bodies.insert(floor).expect("usable");
    for i in 0..count {
        let mut desc = BodyDesc::dynamic(cube(), Vec3::new(2.0 * f32::from(i), 2.25, 0.0));
        desc.fracturable = Some(Fracturable {
            pattern: pattern.clone(),
            generations: 0,
            ..Fracturable::with_strength(100.0)
        });
        simulation.bodies.insert(desc).expect("usable");
    }
    simulation
}

/// Number of pieces that each step made.
fn pieces_of_steps(simulation: &mut Simulation, steps: usize) -> Vec<usize> {
    let made = (0..steps).map(|_| {
        simulation.step(H);
        let done = simulation.fractures.done.iter();
        done.map(|fracture| fracture.pieces.len()).sum()
    });
    made.collect()
}

#[test]
fn all_break_at_once_if_there_is_budget_enough() {
    let made = pieces_of_steps(&mut row(6, FractureBudget::default()), 60);
    let steps: Vec<_> = made.into_iter().filter(|&pieces| pieces > 0).collect();
    assert_eq!(steps, [48]);
}

/// 20 pieces a step: eight of two cubes and four of a third, and the rest in order of their ids, none forgotten.
#[test]
fn what_a_step_cannot_afford_is_coarser_or_waits_for_its_turn() {
    let budget = FractureBudget {
        pieces_per_step: 20,
        ..Default::default()
    };
    let mut simulation = row(6, budget);
    let (mut parents, mut most, mut waited) = (Vec::new(), 0, 0);
    for _ in 0..60 {
        simulation.step(H);
        let done = &simulation.fractures.done;
        most = most.max(done.iter().map(|f| f.pieces.len()).sum());
        parents.extend(done.iter().map(|f| f.parent));
        waited = waited.max(simulation.fractures.waiting());
    }
    assert!((1..=20).contains(&most), "{most} pieces in one step");
    assert!(waited > 0, "none had to wait");
    assert_eq!(simulation.fractures.waiting(), 0, "all had their turn");
    assert_eq!(parents.len(), 6, "{parents:?}");
    assert!(parents.is_sorted(), "{parents:?}");
}

/// Two of these do not fit into a step: some break into fewer pieces at once, some after they have waited. Nothing of them is
/// lost.
#[test]
fn what_breaks_into_fewer_pieces_is_filled_by_them() {
    let budget = FractureBudget {
        pieces_per_step: 20,
        ..Default::default()
    };
    let patterns = [
        FracturePattern::Radial { rays: 5, rings: 2 },
        FracturePattern::Slabs { count: 15 },
        FracturePattern::Brick {
            size: Vec3::new(0.2, 0.25, 0.3),
        },
        FracturePattern::Voronoi {
            cells: 15,
            focus: 0.3,
        },
    ];
    for pattern in patterns {
        let mut simulation = row_of(6, pattern.clone(), budget);
        let (mut numbers, mut waited) = (Vec::new(), 0);
        for _ in 0..60 {
            simulation.step(H);
            waited = waited.max(simulation.fractures.waiting());
            for fracture in &simulation.fractures.done {
                numbers.push(fracture.pieces.len());
                assert!(fracture.ledger.mass_error() < 1e-6, "{fracture:?}");
            }
        }
        assert!(waited > 0, "{pattern:?}: none had to wait");
        assert_eq!(numbers.len(), 6, "{pattern:?}: {numbers:?}");
        let fewest = numbers.iter().min();
        assert!(fewest < numbers.iter().max(), "{pattern:?}: {numbers:?}");
    }
}

#[test]
fn pieces_that_are_gone_make_room_for_others() {
    let budget = FractureBudget {
        max_alive_pieces: 8,
        ..Default::default()
    };
    let mut simulation = row(2, budget);
    let made: usize = pieces_of_steps(&mut simulation, 60).iter().sum();
    assert_eq!((made, simulation.fractures.waiting()), (8, 1));
    let old: BTreeSet<u32> = (0..simulation.bodies.slots() as u32)
        .filter(|&slot| simulation.bodies.contains(slot))
        .filter(|&slot| simulation.bodies.fracturable(slot).is_none())
        .filter(|&slot| simulation.bodies.kind(slot) == RigidBody::Dynamic)
        .collect();
    assert_eq!(old.len(), 8);
    old.iter().for_each(|&slot| simulation.bodies.remove(slot));
    let made: usize = pieces_of_steps(&mut simulation, 2).iter().sum();
    assert_eq!((made, simulation.fractures.waiting()), (8, 0));
}

#[test]
fn blows_break_nothing_without_generations_but_cuts_are_made() {
    let budget = FractureBudget {
        generations: 0,
        ..Default::default()
    };
    let mut simulation = row(2, budget);
    let made: usize = pieces_of_steps(&mut simulation, 120).iter().sum();
    assert_eq!(made, 0);
    let plane = Plane::through(simulation.bodies.center_of_mass(1), Vec3::X);
    simulation.slice(1, plane).expect("a body");
    assert_eq!(pieces_of_steps(&mut simulation, 1), [2]);
}

/// The sectors of the star have an eighth of the cube on the mean, some more and some less.
#[test]
fn pieces_below_the_least_volume_of_the_budget_are_dropped_and_told_of() {
    let least = 0.125 * 0.125;
    let budget = FractureBudget {
        min_volume: least,
        ..Default::default()
    };
    let mut simulation = row(1, budget);
    let mut dropped = 0;
    for _ in 0..60 {
        simulation.step(H);
        for fracture in &simulation.fractures.done {
            dropped += fracture.ledger.dropped_pieces;
            assert!(fracture.ledger.mass_error() < 1e-6);
        }
    }
    assert!((1..=6).contains(&dropped), "{dropped} pieces");
    let bodies = &simulation.bodies;
    let dynamic = bodies
        .iter()
        .filter(|&slot| bodies.kind(slot) == RigidBody::Dynamic);
    for slot in dynamic {
        let volume = bodies.convex(slot).expect("convex").hull().volume();
        assert!(volume > least.into(), "{volume} m3");
    }
}

#[test]
fn pieces_go_when_they_have_slept_for_long_enough() {
    let budget = FractureBudget {
        debris: DebrisRules {
            max_sleep: 1.0,
            ..Default::default()
        },
        ..Default::default()
    };
    let mut simulation = row(1, budget);
    simulation.config.sleep = SleepConfig::default();
    let (mut expired, mut asleep_for) = (0, 0);
    for _ in 0..1200 {
        simulation.step(H);
        expired += simulation.fractures.expired.len();
        if expired == 0 {
            asleep_for = if simulation.report.asleep > 0 {
                asleep_for + 1
            } else {
                0
            };
        }
    }
    assert_eq!(expired, 8, "all pieces");
    assert_eq!(simulation.bodies.len(), 1, "the floor");
    assert!(
        asleep_for >= 60,
        "the first went after {asleep_for} steps of sleep"
    );
}

/// Bodies may make up to 256 pieces and make eight: 20 pieces a step are two cubes and a third in four pieces, from the
/// queue as under the blow.
#[test]
fn what_waits_counts_with_the_pieces_that_it_makes() {
    let budget = FractureBudget {
        pieces_per_step: 20,
        ..Default::default()
    };
    let made = pieces_of_steps(&mut row(6, budget), 60);
    let steps: Vec<_> = made.into_iter().filter(|&pieces| pieces > 0).collect();
    assert_eq!(steps, [20, 20]);
}

/// Balls with visual meshes of 320 triangles, all of which break in the same step: two of them for 700 triangles a step, one if there are
/// fewer than a ball has.
#[test]
fn large_meshes_are_cut_one_step_after_the_other() {
    for (triangles, at_once) in [(100_000, 6), (700, 2), (10, 1)] {
        let budget = FractureBudget {
            triangles_per_step: triangles,
            ..Default::default()
        };
        let mut simulation = Simulation { budget, ..awake() };
        let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
        simulation.bodies.insert(floor).expect("usable");
        for i in 0..6_u8 {
            let mesh = (ConvexMesh::icosphere(0.25, 2).expect("a ball"))
                .hull()
                .to_mesh();
            assert_eq!(mesh.triangles().len(), 320);
            let ball = ConvexMesh::from_mesh(mesh).expect("closed");
            let at = Vec3::new(2.0 * f32::from(i), 2.25, 0.0);
            let fracturable = Fracturable {
                pattern: FracturePattern::SinglePlane,
                generations: 0,
                ..Fracturable::with_strength(50.0)
            };
            let desc = BodyDesc {
                fracturable: Some(fracturable),
                ..BodyDesc::dynamic(ball, at)
            };
            simulation.bodies.insert(desc).expect("usable");
        }
        let (mut most, mut parents) = (0, 0);
        for _ in 0..60 {
            simulation.step(H);
            let done = &simulation.fractures.done;
            most = most.max(done.len());
            parents += done.len();
            assert!(done.iter().all(|f| f.ledger.mass_error() < 1e-6));
        }
        assert_eq!((most, parents), (at_once, 6), "{triangles} triangles");
        assert_eq!(simulation.fractures.waiting(), 0);
    }
}
