//! Heaps and large islands.

use crate::common::scenes::awake;
use crate::{alone, on_threads};
use bevy_cleave::prelude::*;
use bevy_cleave::step::StepError;
use glam::Vec3;

use crate::common::scenes::pile;

/// Positions and velocities at the end of a run, and what is told of the error of its last step.
pub(crate) type Outcome = (Vec<[u32; 6]>, Option<StepError>);

/// A block of 20 x 5 x 20 cubes that touch each other, let go with a push in the middle: one island of 5800 manifolds, which
/// threads solve together. It is calm, or every fifth cube flies off, spinning, and some break. Positions and velocities after
/// 20 steps, and what is told of the error of the last one.
fn run_large(is_calm: bool) -> Outcome {
    let mut simulation = awake();
    simulation.config.measure_error = true;
    let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    simulation.bodies.insert(floor).expect("usable");
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    for i in 0..20 * 5 * 20 {
        let at = Vec3::new(
            (i % 20) as f32,
            (i / 400) as f32 + 0.5,
            (i / 20 % 20) as f32,
        );
        let mut desc = BodyDesc::dynamic(cube.clone(), at);
        if i == 210 {
            desc.linear_velocity = Vec3::new(0.3, 0.5, 0.2);
        }
        if !is_calm && i % 5 == 0 {
            let way = [-1.0, 0.5, 1.0][i % 3];
            desc.linear_velocity = Vec3::new(2.0 * way, 1.0, -way);
            desc.angular_velocity = Vec3::new(4.0, -way, 3.0 * way);
        }
        let slot = simulation.bodies.insert(desc).expect("usable");
        if !is_calm && i % 3 == 0 {
            let breakable = Fracturable::with_strength(4000.0);
            simulation.bodies.set_fracturable(slot, Some(breakable));
        }
    }
    let mut broken = 0;
    for _ in 0..20 {
        simulation.step(1.0 / 60.0);
        broken += simulation.fractures.done.len();
    }
    assert_eq!(broken == 0, is_calm);
    let islands = simulation.contacts.solver().islands();
    let largest = islands.map(|island| island.contacts).max();
    assert!(
        largest.is_some_and(|contacts| contacts > 12_000),
        "{largest:?}"
    );
    (bits(&simulation), simulation.report.error)
}

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
        simulation
            .bodies
            .set_fracturable(slot, Some(breakable.clone()));
    }
    let mut broken = 0;
    for _ in 0..60 {
        simulation.step(1.0 / 60.0);
        broken += simulation.fractures.done.len();
    }
    assert!(broken > 0 && simulation.report.pairs > 500);
    bits(&simulation)
}

fn bits(simulation: &Simulation) -> Vec<[u32; 6]> {
    let bodies = &simulation.bodies;
    let state = |slot| (bodies.center_of_mass(slot), bodies.velocity(slot).0);
    let parts = bodies
        .iter()
        .map(state)
        .map(|(x, v)| [x.x, x.y, x.z, v.x, v.y, v.z]);
    parts.map(|numbers| numbers.map(f32::to_bits)).collect()
}

pub(crate) fn run_all() -> [Outcome; 3] {
    [(run(), None), run_large(true), run_large(false)]
}

#[test]
fn one_thread_and_four_give_the_same_bits() {
    assert!(alone().bodies == on_threads(run_all));
}
