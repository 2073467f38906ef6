//! Blows: what they break does not depend on the length of a step, and what is weaker breaks no later.

use crate::common::dice::Dice;
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

/// Share of a wall that a ball breaks off, if a slice of each brick that is `thin` (a share of its length) is a part of its own, in some bricks.
fn share_broken_off(thin: Option<f32>, seed: u64) -> f32 {
    let mut dice = Dice::new(seed);
    let whole = wall(8, 10, 1e6);
    let mut parts = Vec::new();
    for part in whole.parts() {
        let size = part.shape.aabb().extents();
        let is_divided = dice.below(4) == 0;
        let (Some(thin), true) = (thin, is_divided) else {
            parts.push(part.clone());
            continue;
        };
        for (share, side) in [(thin, -1.0), (1.0 - thin, 1.0)] {
            let shape = ConvexMesh::cuboid(share * size.x, size.y, size.z).expect("a slice");
            let middle = part.shape.aabb().center() + 0.5 * side * (1.0 - share) * size.x * Vec3::X;
            let place = Pose::from_position(part.pose.transform_point(middle));
            parts.push(CompoundPart::new(place, shape));
        }
    }
    let cluster = Cluster::new(parts, 1e6).expect("parts");
    let mut simulation = awake_on_floor();
    let shape = cluster.compound().expect("one wall");
    let body = simulation.bodies.insert(standing(shape)).expect("usable");
    let at = Vec3::new(0.07, 0.62, 0.3);
    let missile = ball(0.1, 2000.0, at, -25.0 * Vec3::Z);
    simulation.bodies.insert(missile).expect("usable");
    (0..20).for_each(|_| simulation.step(1.0 / 60.0));
    let bodies = &simulation.bodies;
    let volume = |slot: u32| {
        let parts = bodies
            .compound(slot)
            .map_or(&[][..], Compound::parts)
            .iter();
        parts
            .map(|part| part.shape.hull().volume() as f32)
            .sum::<f32>()
    };
    1.0 - volume(body) / (2.0 * 1.0 * 0.12)
}

/// A part that is much lighter than its neighbors, and has stiffer bonds, vibrates so fast that a blow could not be followed for long enough.
#[test]
fn a_blow_breaks_off_as_much_with_slivers_as_without() {
    let whole = share_broken_off(None, 0);
    assert!((0.05..0.6).contains(&whole), "{whole}");
    for thin in [0.1, 0.01, 0.002] {
        let shares = [1, 2, 3].map(|seed| share_broken_off(Some(thin), seed));
        let mean = shares.iter().sum::<f32>() / 3.0;
        let is_alike = mean > 0.7 * whole && mean < 1.5 * whole;
        assert!(is_alike, "{thin}: {shares:?} beside {whole}");
    }
}
