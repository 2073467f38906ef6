//! Pieces that lie around go again, and what goes with them is told.

use crate::scenes::*;
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Drops a block that breaks into about `cells` pieces every half a second; what `look` says after each step.
fn rain(rules: DebrisRules, seconds: f32, mut look: impl FnMut(&Simulation)) -> Simulation {
    let mut simulation = scene([floor()]);
    simulation.budget.debris = rules;
    simulation.config.sleep = SleepConfig::default();
    for step in 0..(seconds / H) as usize {
        if step % 30 == 0 {
            let x = 0.7 * ((step / 30) % 5) as f32;
            let mut block = BodyDesc::dynamic(cuboid(Vec3::splat(0.5)), Vec3::new(x, 2.5, 0.0));
            block.fracturable = Some(Fracturable {
                generations: 0,
                ..voronoi(8, 50.0, step as u64)
            });
            simulation.bodies.insert(block).expect("usable");
        }
        simulation.step(H);
        look(&simulation);
    }
    simulation
}

fn pieces(simulation: &Simulation) -> usize {
    let bodies = &simulation.bodies;
    let dynamic = of_kind(bodies, RigidBody::Dynamic).into_iter();
    dynamic
        .filter(|&slot| bodies.fracturable(slot).is_none())
        .count()
}

/// All mass that was ever put into the scene.
fn check_mass(simulation: &Simulation, dropped: f64, blocks: usize) {
    let bodies = &simulation.bodies;
    let there: f64 = of_kind(bodies, RigidBody::Dynamic)
        .into_iter()
        .map(|slot| f64::from(bodies.mass(slot).mass))
        .sum();
    let sum = there + dropped + simulation.fractures.removed.mass;
    let all = 125.0 * blocks as f64;
    assert!((sum / all - 1.0).abs() < 2e-6, "{sum} of {all} kg");
}

#[test]
fn the_oldest_go_first_at_a_cap_and_their_mass_is_told() {
    let rules = DebrisRules {
        max_pieces: 40,
        ..Default::default()
    };
    let (mut dropped, mut last, mut most) = (0.0, None, 0);
    let simulation = rain(rules, 20.0, |simulation| {
        let fractures = &simulation.fractures;
        dropped += fractures
            .done
            .iter()
            .map(|f| f.ledger.dropped.mass)
            .sum::<f64>();
        for piece in &fractures.expired {
            assert!(last < Some(piece.body), "an older one was left");
            last = Some(piece.body);
        }
        most = most.max(pieces(simulation));
    });
    assert!((40..=50).contains(&most), "{most} pieces at a time");
    assert!(simulation.fractures.removed.pieces > 200);
    check_mass(&simulation, dropped, 40);
}

#[test]
fn pieces_fade_before_they_go() {
    let rules = DebrisRules {
        max_age: 2.0,
        fade: 0.5,
        ..Default::default()
    };
    let mut fading: Vec<(BodyId, usize)> = Vec::new();
    let simulation = rain(rules, 8.0, |simulation| {
        let fractures = &simulation.fractures;
        for piece in &fractures.fading {
            match fading.iter_mut().find(|(id, _)| *id == piece.body) {
                Some((_, steps)) => {
                    *steps += 1;
                    assert!(piece.remaining < 0.5);
                }
                None => {
                    assert_eq!(piece.remaining, 0.5);
                    fading.push((piece.body, 1));
                }
            }
        }
        for piece in &fractures.expired {
            let faded = fading
                .iter()
                .find(|(id, _)| *id == piece.body)
                .expect("it faded");
            assert!((29..=31).contains(&faded.1), "{} steps", faded.1);
        }
    });
    assert!(simulation.fractures.removed.pieces > 40);
    assert!(pieces(&simulation) <= 9 * 6);
}

/// What is told after a step is there: a piece may break in the step in which it fades.
#[test]
fn what_fades_is_there() {
    let mut simulation = scene([floor()]);
    simulation.budget.debris = DebrisRules {
        max_pieces: 4,
        fade: 0.5,
        ..Default::default()
    };
    let (mut fading, mut broken) = (0, 0);
    for step in 0..120 {
        if step % 15 == 0 {
            let mut block = BodyDesc::dynamic(cuboid(Vec3::splat(0.5)), 1.5 * Vec3::Y);
            block.linear_velocity = -6.0 * Vec3::Y;
            block.fracturable = Some(voronoi(5, 10.0, step));
            simulation.bodies.insert(block).expect("usable");
        }
        let told = simulation.fractures.fading.clone();
        simulation.step(H);
        let done = simulation.fractures.done.iter();
        let is_told = |&parent: &BodyId| told.iter().any(|piece| piece.body == parent);
        broken += done.map(|f| f.parent).filter(is_told).count();
        for piece in &simulation.fractures.fading {
            fading += 1;
            assert!(simulation.bodies.is_current(piece.slot, piece.body));
        }
    }
    assert!(fading > 100 && broken > 3, "{fading}, {broken}");
}

#[test]
fn dust_goes_when_it_sleeps_and_what_is_large_stays() {
    let rules = DebrisRules {
        dust_volume: 0.02,
        ..Default::default()
    };
    let simulation = rain(rules, 6.0, |simulation| {
        for piece in &simulation.fractures.expired {
            assert!(piece.mass < 20.0);
        }
    });
    assert!(simulation.fractures.removed.pieces > 10);
    let mut simulation = simulation;
    (0..600).for_each(|_| simulation.step(H));
    let bodies = &simulation.bodies;
    for slot in of_kind(bodies, RigidBody::Dynamic) {
        assert!(bodies.mass(slot).mass > 19.9 || !bodies.is_asleep(slot));
    }
    let rules = DebrisRules {
        max_age: 0.5,
        max_volume: 0.02,
        ..Default::default()
    };
    let simulation = rain(rules, 6.0, |_| {});
    let bodies = &simulation.bodies;
    let heavy = of_kind(bodies, RigidBody::Dynamic);
    assert!(heavy.iter().any(|&slot| bodies.mass(slot).mass > 20.0));
}

/// What stands is no debris, however old it is.
#[test]
fn what_stands_stays() {
    let mut wall = standing(Vec3::new(3.0, 2.0, 0.2), Vec3::Y);
    wall.fracturable = Some(voronoi(20, 50.0, 1));
    let ball = ball(Vec3::new(0.3, 1.2, 2.0), Vec3::new(0.0, 0.0, -25.0));
    let mut simulation = scene([floor(), wall, ball]);
    simulation.budget.debris.max_age = 1.0;
    simulation.budget.debris.max_pieces = 0;
    run(&mut simulation, 3.0);
    let bodies = &simulation.bodies;
    assert!(!of_kind(bodies, RigidBody::Static).is_empty());
    assert_eq!(of_kind(bodies, RigidBody::Dynamic), [2], "the ball");
}
