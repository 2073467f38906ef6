//! Blows: what they break does not depend on the length of a step, and what is weaker breaks no later.

use crate::common::scenes::awake_on_floor;
use crate::shapes::{ball, parts_of, standing, wall};
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
