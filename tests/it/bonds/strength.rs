//! Loads that mechanics knows.

use super::scene::{H, WEIGHT, chain, cube, first_break, load_slowly, simulation};
use bevy_cleave::prelude::*;
use glam::{DVec3, Vec3};

/// Steps of ten seconds.
const LONG: usize = 600;

/// A face of 1 m2.
fn square(strength: f32) -> Bond {
    Bond::new(strength, 1.0)
}

#[test]
fn a_cube_hangs_by_a_bond_that_bears_its_weight_and_falls_from_one_that_does_not() {
    let (mut simulation, slots) = chain(1, -Vec3::Y, square(1.05 * WEIGHT));
    assert_eq!(first_break(&mut simulation, LONG), None);
    let sag = -1.0 - simulation.bodies.center_of_mass(slots[1]).y;
    assert!(sag.abs() < 1e-4, "{sag} m");

    let (mut simulation, slots) = chain(1, -Vec3::Y, square(0.9 * WEIGHT));
    assert_eq!(first_break(&mut simulation, 30), Some(vec![[0, 1]]));
    let before = simulation.bodies.velocity(slots[1]).0.y;
    simulation.step(H);
    let fall = simulation.bodies.velocity(slots[1]).0.y - before;
    assert!((fall / (-9.81 * H) - 1.0).abs() < 1e-3, "falls freely");
}

#[test]
fn a_hanging_chain_breaks_at_its_top() {
    for count in [2_usize, 5, 10] {
        let weight = count as f32 * WEIGHT;
        let (mut simulation, _) = chain(count, -Vec3::Y, square(1.05 * weight));
        assert_eq!(first_break(&mut simulation, LONG), None, "{count} cubes");
        let (mut simulation, _) = chain(count, -Vec3::Y, square(0.9 * weight));
        let first = first_break(&mut simulation, 30);
        assert_eq!(first, Some(vec![[0, 1]]), "{count} cubes");
    }
}

/// The root of `n` cubes of edge `a` bears the moment `n m g n a / 2`. About the lower edge of the face its two upper points
/// bear at most `2 (sigma a^2 / 4) a`, so `sigma = m g n^2 / a^2`. Shear is made so strong that it is not what breaks.
///
/// The margin is 10 % above and 5 % below: longer ones hold at 1.05, a single cube needs 1.1.
#[test]
fn a_cantilever_breaks_at_its_root_when_the_upper_points_of_the_face_bear_all_they_can() {
    for count in [1_usize, 2, 3, 5] {
        let needed = (count * count) as f32 * WEIGHT;
        let bond = |share: f32| Bond {
            shear_strength: 10.0 * needed,
            ..square(share * needed)
        };
        let (mut simulation, _) = chain(count, Vec3::X, bond(1.1));
        assert_eq!(load_slowly(&mut simulation), None, "{count} cubes");
        let first = first_break(&mut simulation, LONG);
        assert_eq!(first, None, "{count} cubes");

        let (mut simulation, _) = chain(count, Vec3::X, bond(0.95));
        let first = load_slowly(&mut simulation).or_else(|| first_break(&mut simulation, 60));
        assert_eq!(first, Some(vec![[0, 1]]), "{count} cubes");
    }
}

#[test]
fn without_friction_shear_strength_alone_bears_a_weight_at_a_wall() {
    for (share, holds) in [(1.05, true), (0.95, false)] {
        let bond = Bond {
            strength: 100.0 * WEIGHT,
            shear_strength: share * WEIGHT,
            area: 1.0,
        };
        let mut bodies = [Vec3::ZERO, Vec3::X].map(|at| BodyDesc::dynamic(cube(), at));
        bodies[0].kind = RigidBody::Static;
        for body in &mut bodies {
            body.friction = Friction::new(0.0);
        }
        let (mut simulation, slots) = simulation(bodies);
        simulation.bond(slots[0], slots[1], bond).expect("usable");
        let first = load_slowly(&mut simulation).or_else(|| first_break(&mut simulation, LONG));
        assert_eq!(first.is_none(), holds, "{share} of the weight");
    }
}

/// Momentum (kg m/s) and angular momentum about the origin (kg m2/s) of unit cubes.
fn momenta(simulation: &Simulation, slots: &[u32]) -> [DVec3; 2] {
    let bodies = &simulation.bodies;
    slots.iter().fold([DVec3::ZERO; 2], |[p, l], &slot| {
        let mass = bodies.mass(slot);
        let (v, omega) = bodies.velocity(slot);
        let at = bodies.center_of_mass(slot).as_dvec3();
        let part = f64::from(mass.mass) * v.as_dvec3();
        // A cube has the same moment about every axis.
        let spin = f64::from(mass.principal.x) * omega.as_dvec3();
        [p + part, l + at.cross(part) + spin]
    })
}

/// Two cubes that turn about the middle of their common face with `omega`: each needs `m omega^2 a / 2` to stay.
fn turning_pair(omega: f32, strength: f32) -> (Simulation, Vec<u32>) {
    let bodies = [-0.5, 0.5].map(|x| {
        let mut body = BodyDesc::dynamic(cube(), Vec3::X * x);
        body.angular_velocity = omega * Vec3::Y;
        body.linear_velocity = body.angular_velocity.cross(Vec3::X * x) + Vec3::new(1.0, 2.0, 3.0);
        body
    });
    let (mut simulation, slots) = simulation(bodies);
    simulation.gravity = Gravity(Vec3::ZERO);
    let bond = square(strength);
    simulation.bond(slots[0], slots[1], bond).expect("usable");
    (simulation, slots)
}

#[test]
fn a_turning_pair_comes_apart_when_the_bond_cannot_bear_what_keeps_it_on_its_circle() {
    let omega = 2.0_f32;
    let needed = 1000.0 * 0.5 * omega * omega;
    // Half as much again for the way back to the circle, see `bond_constraints`.
    let (mut simulation, slots) = turning_pair(omega, 1.6 * needed);
    assert_eq!(first_break(&mut simulation, LONG), None);
    let (_, w) = simulation.bodies.velocity(slots[0]);
    let slower = (w - omega * Vec3::Y).length() / omega;
    assert!(slower < 0.05, "{slower} of its spin is lost in ten seconds");

    let (mut simulation, slots) = turning_pair(omega, 0.9 * needed);
    assert!(first_break(&mut simulation, 60).is_some());
    (0..60).for_each(|_| simulation.step(H));
    let [a, b] = [0, 1].map(|i| simulation.bodies.center_of_mass(slots[i]));
    assert!(a.distance(b) > 1.5, "they fly apart: {}", a.distance(b));
}

#[test]
fn momentum_and_angular_momentum_stay_while_a_bond_holds_and_when_it_breaks() {
    for strength in [500.0, 1e6] {
        let (mut simulation, slots) = turning_pair(2.0, strength);
        simulation.step(H);
        let before = momenta(&simulation, &slots);
        let scale = 2000.0 * 5.0;
        for step in 0..120 {
            simulation.step(H);
            let now = momenta(&simulation, &slots);
            let error = [0, 1].map(|k| (now[k] - before[k]).length() / scale);
            assert!(error[0] < 1e-5, "step {step}: momentum off by {}", error[0]);
            assert!(error[1] < 1e-3, "step {step}: spin off by {}", error[1]);
        }
        assert_eq!(simulation.bonds.is_empty(), strength < 2000.0);
    }
}
