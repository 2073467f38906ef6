//! What strikes an edge of a body that hangs flies on.

use crate::common::dice::Dice;
use crate::kit::*;
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Most energy that a step may make of nothing, as a share of what flies: contacts are soft, and give back what they took.
const RISE: f64 = 2e-3;

/// A box that hangs, or floats, and cubes that fly at its edges.
fn hung(dice: &mut Dice) -> Simulation {
    let mut simulation = awake();
    if dice.below(3) == 0 {
        simulation.config = SolverConfig::precise();
    }
    let size = dice.vector(0.3, 0.8);
    let at = 5.0 * Vec3::Y;
    let slot = simulation
        .bodies
        .insert(BodyDesc::dynamic(cuboid(size), at))
        .expect("usable");
    let top = 0.5 * size.y * Vec3::Y;
    let (joint, up) = [
        (Joint::ball(), 0.0),
        (Joint::rod(0.5), 0.5),
        (Joint::hinge(), 0.0),
    ][dice.below(3)];
    let joint = joint.with_anchors(at + top + up * Vec3::Y, top);
    simulation.join(None, slot, joint).expect("joined");
    for _ in 0..3 {
        let mut edge = size * dice.vector(-0.5, 0.5);
        let free = dice.below(3);
        for axis in (0..3).filter(|&axis| axis != free) {
            edge[axis] = 0.5 * size[axis] * edge[axis].signum();
        }
        let side = dice.in_range(0.04, 0.12);
        let target = at + edge + 0.5 * side * dice.vector(-1.0, 1.0);
        let from = target + 1.5 * (edge.normalize() + 0.7 * dice.direction());
        let speed = dice.in_range(4.0, 12.0);
        let cube = BodyDesc::dynamic(cuboid(Vec3::splat(side)), from);
        let desc = BodyDesc {
            density: 1000.0 * 10.0_f32.powf(dice.in_range(0.0, 1.0)),
            linear_velocity: speed * (target - from).normalize(),
            angular_velocity: dice.vector(-20.0, 20.0),
            ..cube
        };
        simulation.bodies.insert(desc).expect("usable");
    }
    simulation.step(1e-6);
    simulation
}

/// Nothing is held in the air while gravity makes it faster.
pub(crate) fn judge(seed: u64) -> Verdict {
    let dice = &mut Dice::new(seed);
    let mut simulation = hung(dice);
    let h = [1.0 / 30.0, 1.0 / 60.0][dice.below(2)];
    let slots: Vec<u32> = simulation.bodies.iter().collect();
    let flying = |simulation: &Simulation| -> f64 {
        let bodies = &simulation.bodies;
        slots.iter().map(|&slot| bodies.kinetic_energy(slot)).sum()
    };
    let scale = flying(&simulation);
    let mut last = energy(&simulation);
    let mut strikes = 0;
    for number in 0..40 {
        let before = flying(&simulation);
        simulation.step(h);
        let now = energy(&simulation);
        let rise = (now - last) / scale;
        ask!(rise < RISE, "step {number}: energy rises by {rise:.1e}");
        strikes += usize::from(flying(&simulation) < 0.9 * before);
        last = now;
    }
    Ok(strikes)
}
