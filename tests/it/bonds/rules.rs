//! What bonds may join, and when they go.

use super::scene::{H, WEIGHT, chain, cube, first_break, fixed, simulation};
use bevy_cleave::prelude::*;
use glam::Vec3;

fn two_cubes() -> (Simulation, Vec<u32>) {
    simulation([
        fixed(cube(), Vec3::ZERO),
        BodyDesc::dynamic(cube(), -Vec3::Y),
    ])
}

#[test]
fn strengths_and_areas_that_are_no_positive_numbers_are_refused() {
    let (mut simulation, slots) = two_cubes();
    for bad in [f32::NAN, -1.0, 0.0, f32::INFINITY] {
        let mut good = Bond::new(1.0, 1.0);
        let refused = |simulation: &mut Simulation, bond| simulation.bond(slots[0], slots[1], bond);
        good.strength = bad;
        let error = refused(&mut simulation, good);
        assert!(
            matches!(error, Err(BondError::Strength { .. })),
            "{error:?}"
        );
        let error = refused(
            &mut simulation,
            Bond {
                strength: 1.0,
                shear_strength: bad,
                area: 1.0,
            },
        );
        assert!(
            matches!(error, Err(BondError::Strength { .. })),
            "{error:?}"
        );
        let error = refused(&mut simulation, Bond::new(1.0, bad));
        assert!(matches!(error, Err(BondError::Area { .. })), "{error:?}");
        let error = simulation.bond_neighbors(&slots, bad);
        assert!(
            matches!(error, Err(BondError::Strength { .. })),
            "{error:?}"
        );
    }
    assert!(simulation.bonds.is_empty());
}

#[test]
fn bodies_that_are_missing_the_same_or_both_fixed_are_not_bonded() {
    let (mut simulation, slots) = two_cubes();
    let other = fixed(cube(), Vec3::X);
    let other = simulation.bodies.insert(other).expect("usable");
    let bond = Bond::new(1.0, 1.0);
    let [a, b] = [slots[0], slots[1]];
    assert_eq!(simulation.bond(a, 77, bond), Err(BondError::NoBody));
    assert_eq!(simulation.bond(b, b, bond), Err(BondError::SameBody));
    assert_eq!(
        simulation.bond(a, other, bond),
        Err(BondError::NothingMoves)
    );
    assert_eq!(
        simulation.bond_neighbors(&[a, 77], 1.0),
        Err(BondError::NoBody)
    );
    simulation.bodies.remove(b);
    assert_eq!(simulation.bond(a, b, bond), Err(BondError::NoBody));
    assert!(simulation.bonds.is_empty());
}

#[test]
fn a_bond_in_place_of_another_has_the_strength_of_the_new_one() {
    let (mut simulation, slots) = chain(1, -Vec3::Y, Bond::new(1.0, 1.0));
    let strong = Bond::new(2.0 * WEIGHT, 1.0);
    // The order in which the bodies are named does not matter.
    simulation.bond(slots[1], slots[0], strong).expect("usable");
    assert_eq!(simulation.bonds.len(), 1);
    assert_eq!(first_break(&mut simulation, 60), None);
    assert_eq!(simulation.bond_neighbors(&slots, 0.5 * WEIGHT), Ok(1));
    assert_eq!(simulation.bonds.len(), 1);
    assert_eq!(first_break(&mut simulation, 60), Some(vec![[0, 1]]));
}

#[test]
fn a_bond_goes_with_its_body_and_not_to_the_next_one_in_the_slot() {
    let (mut simulation, slots) = chain(1, -Vec3::Y, Bond::new(10.0 * WEIGHT, 1.0));
    (0..30).for_each(|_| simulation.step(H));
    simulation.bodies.remove(slots[1]);
    let next = simulation
        .bodies
        .insert(BodyDesc::dynamic(cube(), -Vec3::Y));
    assert_eq!(next, Ok(slots[1]), "the slot is used again");
    simulation.step(H);
    assert!(simulation.bonds.is_empty());
    assert!(simulation.bonds.broken.is_empty(), "it did not break");
    let (v, _) = simulation.bodies.velocity(slots[1]);
    assert!(v.y < -0.9 * 9.81 * H, "the new body falls: {v}");
}

#[test]
fn a_bond_that_is_taken_away_stops_pulling_at_once() {
    let (mut simulation, slots) = chain(1, -Vec3::Y, Bond::new(10.0 * WEIGHT, 1.0));
    (0..60).for_each(|_| simulation.step(H));
    let (before, _) = simulation.bodies.velocity(slots[1]);
    let Simulation { bonds, bodies, .. } = &mut simulation;
    assert!(bonds.unbond(bodies, slots[1], slots[0]));
    assert!(!bonds.unbond(bodies, slots[1], slots[0]), "only once");
    simulation.step(H);
    let (v, w) = simulation.bodies.velocity(slots[1]);
    assert!(
        (v - before - Vec3::new(0.0, -9.81 * H, 0.0)).length() < 1e-3,
        "{v}"
    );
    assert!(w.length() < 1e-3, "{w}");
}

#[test]
fn bodies_that_are_apart_break_their_bond_in_the_first_step() {
    let (mut simulation, slots) = simulation([
        BodyDesc::dynamic(cube(), Vec3::ZERO),
        BodyDesc::dynamic(cube(), 3.0 * Vec3::X),
    ]);
    let bond = Bond::new(1e9, 1.0);
    simulation.bond(slots[0], slots[1], bond).expect("usable");
    simulation.step(H);
    assert_eq!(simulation.bonds.broken.len(), 1);
    assert_eq!(simulation.bonds.broken[0].bond, bond);
    simulation.step(H);
    assert!(simulation.bonds.broken.is_empty(), "told once");
}

#[test]
fn a_bond_holds_what_was_bonded_with_an_overlap_or_a_gap_where_it_is() {
    for gap in [-0.01_f32, 0.005] {
        let at = Vec3::new(0.0, -1.0 - gap, 0.0);
        let (mut simulation, slots) =
            simulation([fixed(cube(), Vec3::ZERO), BodyDesc::dynamic(cube(), at)]);
        let bond = Bond::new(5.0 * WEIGHT, 1.0);
        simulation.bond(slots[0], slots[1], bond).expect("usable");
        assert_eq!(first_break(&mut simulation, 300), None);
        let moved = simulation.bodies.center_of_mass(slots[1]) - at;
        assert!(moved.length() < 1e-4, "moved by {moved}");
    }
}

/// A body that something puts aside, as a blow does within a step: what is off by a hundredth of the extent or less is taken
/// back by a bond that bears it, what is off by more is not, whatever the bond bears.
#[test]
fn a_bond_takes_back_what_is_a_little_off_and_lets_go_of_what_was_torn_away() {
    for (shift, holds) in [(0.005_f32, true), (0.02, false)] {
        let (mut simulation, slots) = two_cubes();
        let bond = Bond::new(1e4 * WEIGHT, 1.0);
        simulation.bond(slots[0], slots[1], bond).expect("usable");
        simulation.step(H);
        let pose = simulation.bodies.pose(slots[1]);
        let aside = Pose::new(pose.position + shift * Vec3::X, pose.rotation);
        simulation.bodies.set_pose(slots[1], aside).expect("usable");
        (0..30).for_each(|_| simulation.step(H));
        assert_eq!(simulation.bonds.len(), usize::from(holds), "{shift} m off");
        let off = simulation.bodies.center_of_mass(slots[1]).x;
        let is_back = off < 0.1 * shift;
        assert_eq!(
            is_back, holds,
            "put {shift} m aside, {off} m off in the end"
        );
    }
}
