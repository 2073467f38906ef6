//! The sums of every fracture, of bodies thinner than their corners can be placed too.

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use bevy_cleave::geometry::ConvexHull;
use bevy_cleave::prelude::*;
use glam::Vec3;

/// A cuboid in any direction of its own frame, so that all coordinates of its corners are rounded.
fn turned_cuboid(size: Vec3, dice: &mut Dice) -> ConvexMesh {
    let turn = dice.rotation();
    let corners = (0..8_u8).map(|corner| {
        let side = |axis: u8| f32::from(corner >> axis & 1) - 0.5;
        turn * (size * Vec3::new(side(0), side(1), side(2)))
    });
    let corners: Vec<Vec3> = corners.collect();
    ConvexMesh::from_hull(ConvexHull::from_points(&corners).expect("a body"))
}

/// Ledgers of a body that flies and turns, cut by two planes, and of so many generations of its pieces.
fn ledgers(size: Vec3, position: Vec3, generations: usize, dice: &mut Dice) -> Vec<Ledger> {
    let mut simulation = Simulation {
        gravity: Gravity(Vec3::ZERO),
        ..awake()
    };
    let mut body = BodyDesc::dynamic(turned_cuboid(size, dice), position);
    body.linear_velocity = dice.vector(-1.0, 1.0);
    body.angular_velocity = dice.vector(-3.0, 3.0);
    simulation.bodies.insert(body).expect("a usable body");
    let mut ledgers = Vec::new();
    for _ in 0..generations {
        let slots: Vec<u32> = simulation.bodies.iter().collect();
        for slot in slots {
            let mesh = simulation.bodies.convex(slot).expect("a convex body");
            let corners = mesh.hull().vertices().to_vec();
            let to_world = simulation.bodies.pose(slot).inverse();
            for _ in 0..2 {
                let plane = dice.plane_through(&corners).in_frame_of(&to_world);
                simulation.slice(slot, plane).expect("a usable plane");
            }
        }
        simulation.step(1e-6);
        ledgers.extend(simulation.fractures.done.iter().map(|f| f.ledger));
    }
    ledgers
}

/// Needles and plates of a metre and this thickness.
fn sizes(thickness: f32) -> [Vec3; 2] {
    [
        Vec3::new(1.0, thickness, thickness),
        Vec3::new(1.0, 1.0, thickness),
    ]
}

#[test]
fn mass_and_momentum_are_kept_however_thin_the_body_is() {
    let mut dice = Dice::new(7);
    for thickness in [1.0, 1e-1, 1e-2, 1e-3, 1e-4] {
        for position in [Vec3::ZERO, 1e2 * Vec3::ONE, 1e4 * Vec3::ONE] {
            for size in sizes(thickness) {
                for _ in 0..20 {
                    for ledger in ledgers(size, position, 3, &mut dice) {
                        assert!(ledger.mass_error() <= 1e-6, "{size}: {ledger:?}");
                        assert!(ledger.momentum_error() <= 1e-5, "{size}: {ledger:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn angular_momentum_and_energy_are_kept_down_to_a_hundredth() {
    let mut dice = Dice::new(8);
    for thickness in [1.0, 1e-1, 1e-2] {
        for size in sizes(thickness) {
            for _ in 0..100 {
                for ledger in ledgers(size, Vec3::ZERO, 2, &mut dice) {
                    let error = ledger.angular_momentum_error();
                    assert!(error <= 1e-5, "{size}: {ledger:?}");
                    assert!(ledger.energy_gain().abs() <= 1e-5, "{size}: {ledger:?}");
                }
            }
        }
    }
}

#[test]
fn usual_pieces_have_the_density_of_their_body_bit_for_bit() {
    let mut simulation = awake();
    let mesh = ConvexMesh::cuboid(1.0, 0.6, 0.4).expect("valid sizes");
    let mut body = BodyDesc::dynamic(mesh, Vec3::ZERO);
    body.density = 2345.6;
    let slot = simulation.bodies.insert(body).expect("a usable body");
    let mut dice = Dice::new(9);
    let corners = [Vec3::splat(-0.2), Vec3::splat(0.2)];
    for _ in 0..5 {
        let plane = dice.plane_through(&corners);
        simulation.slice(slot, plane).expect("a usable plane");
    }
    simulation.step(1e-6);
    assert!(simulation.bodies.len() > 5);
    for slot in simulation.bodies.iter() {
        assert_eq!(simulation.bodies.density(slot), 2345.6);
    }
}
