//! Blows: what they break does not depend on the length of a step, and what is weaker breaks no later.

use crate::common::scenes::awake_on_floor;
use crate::shapes::{ball, parts_of, standing, wall};
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Parts that a ball (8 kg at `speed`) breaks off of a wall of this strength.
fn broken_off(strength: f32, speed: f32, rate: f32) -> usize {
    let mut simulation = awake_on_floor();
    let wall = wall(8, 10, strength);
    let count = wall.len();
    let body = simulation.bodies.insert(standing(wall)).expect("usable");
    let at = Vec3::new(0.07, 0.62, 0.3);
    let missile = ball(0.1, 2000.0, at, -speed * Vec3::Z);
    simulation.bodies.insert(missile).expect("usable");
    for _ in 0..(0.3 * rate) as usize {
        simulation.step(1.0 / rate);
        for fracture in &simulation.fractures.done {
            assert!(fracture.ledger.mass_error() < 1e-6);
        }
    }
    count - parts_of(&simulation, body)
}

#[test]
fn a_blow_breaks_at_any_rate_what_it_breaks_at_one() {
    let least = |rate: f32| {
        let (mut low, mut high) = (1e3f32, 1e9f32);
        while high / low > 1.05 {
            let middle = (low * high).sqrt();
            if broken_off(middle, 10.0, rate) > 0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    };
    let limits = [30.0, 60.0, 120.0, 240.0].map(least);
    let (low, high) = (
        limits.iter().copied().fold(f32::INFINITY, f32::min),
        limits.iter().copied().fold(0.0, f32::max),
    );
    assert!(high < 1.3 * low, "{limits:?}");
}

#[test]
fn what_is_weaker_breaks_no_later() {
    for rate in [30.0, 60.0, 240.0] {
        let mut has_held = false;
        let mut strength = 1e4;
        while strength < 1e9 {
            let broken = broken_off(strength, 10.0, rate);
            assert!(!(has_held && broken > 0), "{strength} Pa at {rate} Hz");
            has_held |= broken == 0;
            strength *= 2.0;
        }
        assert!(has_held);
    }
}

#[test]
fn what_falls_apart_into_more_than_a_step_may_make_comes_apart_step_by_step() {
    let fall = |pieces_per_step: usize| {
        let mut simulation = awake_on_floor();
        simulation.budget.pieces_per_step = pieces_per_step;
        let wall = wall(8, 10, 1e3);
        let parts = wall.len();
        let body = BodyDesc {
            linear_velocity: -20.0 * Vec3::Y,
            ..BodyDesc::compound(wall, 0.2 * Vec3::Y)
        };
        simulation.bodies.insert(body).expect("usable");
        let mass = |simulation: &Simulation| -> f64 {
            let bodies = &simulation.bodies;
            bodies.iter().map(|s| f64::from(bodies.mass(s).mass)).sum()
        };
        let (mut most, mut waited) = (0, 0);
        for step in 0..120 {
            simulation.step(1.0 / 60.0);
            let done = &simulation.fractures.done;
            most = most.max(done.iter().map(|f| f.pieces.len()).sum());
            waited = waited.max(simulation.fractures.waiting());
            for fracture in done {
                let ledger = &fracture.ledger;
                assert!(ledger.mass_error() < 1e-6, "{step}");
                assert!(ledger.momentum_error() < 1e-5, "{step}");
                assert!(!matches!(fracture.waited, Some(blow) if blow.impulse == 0.0));
            }
        }
        assert_eq!(simulation.fractures.waiting(), 0);
        let bodies = &simulation.bodies;
        let clusters = bodies.iter().filter_map(|slot| bodies.compound(slot));
        let is_connected = |shape: &Compound| Cluster::from(shape).separated().len() == 1;
        assert!(clusters.into_iter().all(is_connected));
        let whole = 1000.0 * 2.0 * 1.0 * 0.12;
        assert!((mass(&simulation) - whole).abs() < 1e-4 * whole);
        (most, waited, bodies.len(), parts)
    };
    let (most, _, apart, parts) = fall(1000);
    assert!(most > 40 && apart > 40, "{most} of {parts}");
    let (most, waited, apart, _) = fall(9);
    assert!(
        most <= 9 && waited > 0 && apart > 40,
        "{most} {waited} {apart}"
    );
}
