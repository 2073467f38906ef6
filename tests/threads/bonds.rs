//! Bonds of a block that stands with half of its width on a beam.

use crate::common::scenes::awake;
use crate::{alone, on_threads};
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Length of a step, s.
const H: f32 = 1.0 / 60.0;

/// What a run came to.
#[derive(PartialEq)]
pub(crate) struct Outcome {
    /// Positions and velocities as bits.
    state: Vec<[u32; 6]>,
    /// Which bonds broke, and in which step.
    broken: Vec<(u32, [u32; 2])>,
}

/// A block of 16 x 4 x 16 bonded cubes that stands with half of its width on a fixed beam: one calm island that threads
/// solve together, while bonds of the overhang break.
pub(crate) fn run() -> Outcome {
    let mut simulation = awake();
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    let beam = ConvexMesh::cuboid(8.0, 1.0, 16.0).expect("valid size");
    let mut beam = BodyDesc::dynamic(beam, Vec3::new(3.5, -0.5, 7.5));
    beam.kind = RigidBody::Static;
    simulation.bodies.insert(beam).expect("usable");
    let slots: Vec<u32> = (0..16 * 4 * 16)
        .map(|i| {
            let at = [i % 16, i / 256, i / 16 % 16].map(|k| k as f32);
            let desc = BodyDesc::dynamic(cube.clone(), Vec3::from(at) + 0.5 * Vec3::Y);
            simulation.bodies.insert(desc).expect("usable")
        })
        .collect();
    simulation.bond_neighbors(&slots, 6e4).expect("usable");
    let mut broken = Vec::new();
    let mut largest = 0;
    for step in 0..30 {
        simulation.step(H);
        broken.extend(simulation.bonds.broken.iter().map(|b| (step, b.slots)));
        let islands = simulation.contacts.solver().islands();
        largest = largest.max(islands.map(|island| island.contacts).max().unwrap_or(0));
    }
    assert!(largest > 6000, "{largest} contacts are one island");
    assert!(!broken.is_empty(), "bonds are meant to break");
    assert!(!simulation.bonds.is_empty(), "not all of them");
    let state = |&slot: &u32| {
        let x = simulation.bodies.center_of_mass(slot);
        let (v, _) = simulation.bodies.velocity(slot);
        [x.x, x.y, x.z, v.x, v.y, v.z].map(f32::to_bits)
    };
    Outcome {
        state: slots.iter().map(state).collect(),
        broken,
    }
}

#[test]
fn bonds_hold_and_break_with_the_same_bits_on_one_thread_and_on_four() {
    assert!(alone().bonds == on_threads(run));
}
