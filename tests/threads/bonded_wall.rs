//! A wall whose bricks are bonded and break.

use crate::common::scenes::awake;
use crate::{alone, on_threads};
use bevy_cleave::prelude::*;
use glam::{DVec3, Vec3};

const H: f32 = 1.0 / 60.0;
const BRICK: Vec3 = Vec3::new(0.4, 0.2, 0.2);

/// What a run came to.
#[derive(Debug, PartialEq)]
pub(crate) struct Outcome {
    /// Positions and velocities as bits, by id.
    state: Vec<(BodyId, [u32; 6])>,
    broken_bonds: usize,
    fractures: usize,
    bonds_left: usize,
}

/// A floating wall of 12 x 10 bonded bricks, far enough from rest that a ball both breaks bricks and cracks joints.
fn wall() -> Simulation {
    let mut simulation = Simulation {
        gravity: Gravity(Vec3::ZERO),
        ..awake()
    };
    let brick = ConvexMesh::cuboid(BRICK.x, BRICK.y, BRICK.z).expect("valid size");
    let bricks: Vec<u32> = (0..120_u16)
        .map(|i| {
            let (row, column) = (f32::from(i / 12), f32::from(i % 12));
            let at = BRICK * Vec3::new(column + 0.5 * (row % 2.0), row, 0.0);
            let mut desc = BodyDesc::dynamic(brick.clone(), at);
            desc.fracturable = Some(Fracturable {
                pattern: FracturePattern::Star { planes: 2 },
                min_energy: 100.0,
                seed: i.into(),
                ..Fracturable::with_strength(20.0)
            });
            simulation.bodies.insert(desc).expect("usable")
        })
        .collect();
    let made = simulation.bond_neighbors(&bricks, 2e5).expect("usable");
    assert!(made > 250, "{made} bonds");
    let ball = ConvexMesh::cuboid(0.3, 0.3, 0.3).expect("valid size");
    let mut ball = BodyDesc::dynamic(ball, BRICK * Vec3::new(6.0, 5.0, 6.0));
    ball.density = 7800.0;
    ball.linear_velocity = Vec3::new(1.0, 0.5, -20.0);
    simulation.bodies.insert(ball).expect("usable");
    simulation
}

fn momentum(simulation: &Simulation) -> DVec3 {
    let bodies = &simulation.bodies;
    let of_body = |slot| f64::from(bodies.mass(slot).mass) * bodies.velocity(slot).0.as_dvec3();
    bodies.iter().map(of_body).sum()
}

pub(crate) fn run() -> Outcome {
    let mut simulation = wall();
    simulation.step(1e-6);
    let before = momentum(&simulation);
    let (mut broken_bonds, mut fractures) = (0, 0);
    for step in 0..40 {
        simulation.step(H);
        broken_bonds += simulation.bonds.broken.len();
        fractures += simulation.fractures.done.len();
        let now = momentum(&simulation);
        assert!(
            (now - before).length() < 1e-5 * before.length(),
            "step {step}: {before} became {now} N s"
        );
        for ledger in simulation.fractures.done.iter().map(|f| &f.ledger) {
            assert!(ledger.mass_error() < 1e-6, "{ledger:?}");
            assert!(ledger.momentum_error() < 1e-5, "{ledger:?}");
            assert!(ledger.angular_momentum_error() < 1e-5, "{ledger:?}");
        }
    }
    let bodies = &simulation.bodies;
    let state = bodies.iter().map(|slot| {
        let (x, v) = (bodies.center_of_mass(slot), bodies.velocity(slot).0);
        let bits = [x.x, x.y, x.z, v.x, v.y, v.z].map(f32::to_bits);
        (bodies.id(slot), bits)
    });
    let mut state: Vec<_> = state.collect();
    state.sort_unstable();
    Outcome {
        state,
        broken_bonds,
        fractures,
        bonds_left: simulation.bonds.len(),
    }
}

#[test]
fn a_bonded_wall_breaks_and_cracks_with_its_momentum_and_the_same_bits_on_four_threads() {
    let alone = &alone().bonded_wall;
    assert!(alone.broken_bonds > 5, "{} bonds broke", alone.broken_bonds);
    assert!(alone.fractures > 2, "{} bricks broke", alone.fractures);
    assert!(alone.bonds_left > 0, "some joints hold");
    assert!(*alone == on_threads(run));
}
