//! Which bodies touch face to face, and over how much.

use super::scene::{BRICK, fixed, joints_of_lintel, lintel, simulation};
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// Areas of all bonds, m2.
fn areas(simulation: &Simulation) -> Vec<f32> {
    simulation.bonds.iter().map(|(_, bond)| bond.area).collect()
}

#[test]
fn bricks_in_running_bond_share_half_a_bed_each_and_their_heads() {
    let (mut simulation, slots) = lintel(5, 6);
    let made = simulation.bond_neighbors(&slots, 1e5);
    assert_eq!(made, Ok(joints_of_lintel(5, 6)));
    let (head, half_bed) = (BRICK.y * BRICK.z, 0.5 * BRICK.x * BRICK.z);
    let row = |slot: u32| slots.iter().position(|&s| s == slot).map(|i| i / 6);
    for ([a, b], bond) in simulation.bonds.iter() {
        let expected = if row(a) == row(b) { head } else { half_bed };
        assert!((bond.area - expected).abs() < 1e-6, "{} m2", bond.area);
        assert_eq!(bond.strength, 1e5);
    }
}

#[test]
fn areas_do_not_depend_on_where_and_how_the_bodies_lie() {
    let turn = Quat::from_xyzw(0.3, -0.2, 0.5, 0.7).normalize();
    for origin in [Vec3::ZERO, Vec3::new(-300.0, 20.0, 500.0)] {
        let shape = || ConvexMesh::cuboid(1.0, 0.5, 0.8).expect("valid size");
        let bodies = [Vec3::ZERO, Vec3::new(0.25, 0.5, -0.3)].map(|at| {
            let mut body = BodyDesc::dynamic(shape(), origin + turn * at);
            body.pose.rotation = turn;
            body
        });
        let (mut simulation, slots) = simulation(bodies);
        assert_eq!(simulation.bond_neighbors(&slots, 1.0), Ok(1));
        let area = areas(&simulation)[0];
        assert!((area - 0.75 * 0.5).abs() < 1e-3, "{area} m2 at {origin}");
    }
}

#[test]
fn a_face_on_another_turned_about_the_normal_shares_an_octagon() {
    // A square of 1 m on one turned by 45 degrees: area 2 (sqrt 2 - 1).
    let slab = || ConvexMesh::cuboid(1.0, 0.4, 1.0).expect("valid size");
    let mut upper = BodyDesc::dynamic(slab(), 0.4 * Vec3::Y);
    // The tangent of half the angle is sqrt 2 - 1.
    upper.pose.rotation = Quat::from_xyzw(0.0, 2.0_f32.sqrt() - 1.0, 0.0, 1.0).normalize();
    let (mut simulation, slots) = simulation([BodyDesc::dynamic(slab(), Vec3::ZERO), upper]);
    assert_eq!(simulation.bond_neighbors(&slots, 1.0), Ok(1));
    let expected = 2.0 * (2.0_f32.sqrt() - 1.0);
    let area = areas(&simulation)[0];
    assert!((area - expected).abs() < 1e-5, "{area} of {expected} m2");
}

#[test]
fn edges_corners_gaps_and_tilted_faces_are_not_bonded() {
    let cube = super::scene::cube;
    let tilted = Quat::from_xyzw(0.0, 0.0, 0.05, 1.0).normalize();
    for (at, turn) in [
        (Vec3::new(1.0, 1.0, 0.0), Quat::IDENTITY),
        (Vec3::ONE, Quat::IDENTITY),
        (Vec3::new(1.02, 0.0, 0.0), Quat::IDENTITY),
        (Vec3::new(1.0, 0.0, 0.0), tilted),
    ] {
        let mut other = BodyDesc::dynamic(cube(), at);
        other.pose.rotation = turn;
        let (mut simulation, slots) = simulation([BodyDesc::dynamic(cube(), Vec3::ZERO), other]);
        assert_eq!(simulation.bond_neighbors(&slots, 1.0), Ok(0), "{at}");
    }
}

#[test]
fn what_stands_on_the_ground_is_bonded_to_it_by_its_lower_face() {
    let (mut simulation, slots) = simulation([
        BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y }),
        BodyDesc::dynamic(super::scene::cube(), 0.5 * Vec3::Y),
        fixed(super::scene::cube(), Vec3::new(5.0, 0.5, 0.0)),
    ]);
    assert_eq!(simulation.bond_neighbors(&slots, 1.0), Ok(1));
    let found: Vec<_> = simulation.bonds.iter().map(|(slots, _)| slots).collect();
    assert_eq!(found, [[slots[0], slots[1]]], "fixed ones need no bond");
    assert!((areas(&simulation)[0] - 1.0).abs() < 1e-6);
}
