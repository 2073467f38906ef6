//! A cloud without gravity: nothing from outside, so momentum must stay.

use super::scene::*;
use super::support::*;
use crate::common::dice::Dice;
use crate::common::structures::*;
use bevy_cleave::prelude::*;
use glam::{DVec3, Vec3};

/// 200 cubes of half a metre on a jittered grid that fly towards each other, e = 0.5, mu = 0.5.
fn cloud() -> Simulation {
    let mut simulation = Simulation {
        gravity: Gravity(Vec3::ZERO),
        ..simulation([])
    };
    let mut dice = Dice::new(32);
    let shape = cuboid(Vec3::splat(0.5));
    for i in 0..200_u8 {
        let cell = Vec3::new(f32::from(i % 6), f32::from(i / 6 % 6), f32::from(i / 36)) - 2.5;
        let mut desc = block(&shape, 0.9 * cell, 0.5);
        desc.pose.rotation = dice.rotation();
        desc.linear_velocity = 2.0 * dice.vector(-1.0, 1.0) - 0.5 * cell;
        desc.angular_velocity = 3.0 * dice.vector(-1.0, 1.0);
        desc.restitution = Restitution::new(0.5);
        add(&mut simulation, desc);
    }
    weigh(&mut simulation);
    simulation
}

/// Momentum, angular momentum about the origin, and the sums of their bodies' sizes.
struct Totals {
    momentum: DVec3,
    angular: DVec3,
    scale: f64,
    angular_scale: f64,
}

fn totals(simulation: &Simulation) -> Totals {
    let bodies = &simulation.bodies;
    let mut totals = Totals {
        momentum: DVec3::ZERO,
        angular: DVec3::ZERO,
        scale: 0.0,
        angular_scale: 0.0,
    };
    for slot in bodies.iter() {
        let (v, omega) = bodies.velocity(slot);
        let mass = bodies.mass(slot);
        let momentum = f64::from(mass.mass) * v.as_dvec3();
        let orbit = bodies.center_of_mass(slot).as_dvec3().cross(momentum);
        // Of a cube: one moment about all axes.
        let spin = f64::from(mass.principal.x) * omega.as_dvec3();
        totals.momentum += momentum;
        totals.angular += orbit + spin;
        totals.scale += momentum.length();
        totals.angular_scale += orbit.length() + spin.length();
    }
    totals
}

/// Hard because an impulse that acts at two different points of two bodies, or not with the same size on both, shows
/// after thousands of collisions: 1e-5 of the momenta, 1e-4 of the angular momenta, no step gains 0.1 % of energy.
#[test]
fn cloud_of_two_hundred_keeps_its_momentum() {
    let mut simulation = cloud();
    let before = totals(&simulation);
    let start = energy(&simulation);
    let (mut last, mut rise, mut contacts) = (start, 0.0_f64, 0);
    for _ in 0..600 {
        simulation.step(H);
        let now = energy(&simulation);
        rise = rise.max(now / last - 1.0);
        last = now;
        contacts += simulation.report.contacts;
    }
    let after = totals(&simulation);
    let momentum = (after.momentum - before.momentum).length() / before.scale;
    let angular = (after.angular - before.angular).length() / before.angular_scale;
    println!(
        "32 cloud: momentum {momentum:.2e}, angular momentum {angular:.2e}, energy rises by {rise:.2e} of itself in a \
         step at most, {:.3} is left, {contacts} contacts",
        last / start
    );
    assert!(
        contacts > 1000 && last < 0.9 * start,
        "they collide: {contacts} contacts, {last} J of {start}"
    );
    assert!(momentum < 1e-5, "momentum {momentum:e}");
    assert!(angular < 1e-4, "angular momentum {angular:e}");
    assert!(rise < 1e-3, "a step gained {rise} of the energy");
}
