//! Crowds of balls that fall on a floor, or at each other in free space: none ends a step inside of another one, whoever struck it.
//!
//! A ball that is stopped or struck goes another way than its contacts knew of, into those that fell beside it or behind it. How far two
//! balls overlap is known exactly.

use crate::common::dice::Dice;
use bevy_cleave::prelude::*;
use glam::Vec3;

const STEPS: usize = 60;

/// Overlap of two balls after a step, as a share of the smaller one's diameter, that is too much: contacts hold far less, and a blow that
/// presses them together leaves some.
const INSIDE: f32 = 0.25;

/// A crowd, and the radii of its balls, m.
pub(crate) struct Crowd {
    pub(crate) simulation: Simulation,
    pub(crate) balls: Vec<(u32, f32)>,
    pub(crate) step_dt: f32,
}

/// Balls of sizes 1 : 3 in no order, nearly dense, that move by up to their size in a step.
pub(crate) fn crowd(seed: u64) -> Crowd {
    let dice = &mut Dice::new(seed);
    let size = [0.25, 0.5, 1.0, 2.0][dice.below(4)];
    let in_space = dice.below(3) == 0;
    let step_dt = 1.0 / [30.0, 60.0, 120.0][dice.below(3)];
    let gravity = if in_space {
        0.0
    } else {
        size / (step_dt * step_dt) * dice.in_range(0.002, 0.3)
    };
    let mut simulation = Simulation {
        gravity: Gravity(gravity * Vec3::NEG_Y),
        ..Simulation::default()
    };
    simulation.config.sleep = SleepConfig::off();
    if !in_space {
        let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
        simulation.bodies.insert(floor).expect("a floor");
    }
    let restitution = dice.in_range(0.0, 0.8);
    let speed = size / step_dt * dice.in_range(0.05, 1.0);
    let mut balls: Vec<(u32, f32, Vec3)> = Vec::new();
    for _ in 0..3 + dice.below(18) {
        let radius = 0.5 * size * dice.in_range(0.35, 1.0);
        let free = |at: Vec3, balls: &[(u32, f32, Vec3)]| {
            balls
                .iter()
                .all(|(_, other, there)| at.distance(*there) > 1.02 * (radius + other))
        };
        let place = |dice: &mut Dice| {
            let at = Vec3::new(
                dice.in_range(-1.0, 1.0),
                dice.in_range(0.55, 3.0),
                dice.in_range(-1.0, 1.0),
            );
            size * at
        };
        let Some(at) = (0..30).map(|_| place(dice)).find(|at| free(*at, &balls)) else {
            continue;
        };
        let mesh = ConvexMesh::sphere(radius).expect("a radius");
        let mut desc = BodyDesc::dynamic(mesh, at);
        desc.density = dice.in_range(500.0, 1500.0);
        desc.restitution = Restitution::new(restitution);
        desc.linear_velocity = if in_space {
            speed * dice.direction() * dice.in_range(0.0, 1.0)
        } else {
            speed * Vec3::NEG_Y
        };
        let slot = simulation.bodies.insert(desc).expect("usable");
        balls.push((slot, radius, at));
    }
    let balls = balls.iter().map(|&(slot, radius, _)| (slot, radius));
    Crowd {
        balls: balls.collect(),
        simulation,
        step_dt,
    }
}

/// The deepest overlap of two balls after any step, as a share of the smaller one's diameter.
pub(crate) fn deepest(crowd: &mut Crowd) -> f32 {
    let mut deepest = 0.0_f32;
    for _ in 0..STEPS {
        crowd.simulation.step(crowd.step_dt);
        let bodies = &crowd.simulation.bodies;
        for (at, &(a, radius)) in crowd.balls.iter().enumerate() {
            for &(b, other) in &crowd.balls[..at] {
                let distance = bodies.center_of_mass(a).distance(bodies.center_of_mass(b));
                deepest = deepest.max((radius + other - distance) / (2.0 * radius.min(other)));
            }
        }
    }
    deepest
}

const CROWDS: u64 = 120;

/// Most that may break the law, as many as do (14 of the first 300, and 58 before who meets what takes local steps took them too). What is left
/// has most often a pair without a contact in a local step.
const KNOWN: usize = 4;

#[test]
fn none_of_a_crowd_ends_a_step_inside_of_another_one() {
    let depths = (0..CROWDS).map(|seed| deepest(&mut crowd(seed)));
    let failing: Vec<f32> = depths.filter(|&depth| depth > INSIDE).collect();
    println!("crowds of which two overlap by more than {INSIDE}: {failing:?}");
    assert!(failing.len() <= KNOWN);
}
