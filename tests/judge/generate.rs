//! Scenes that nobody named, from a family and a seed.
//!
//! A family draws a scene in its own units: the length 1 is that of its larger bodies, gravity is 1 along -y, so that the
//! time 1 is some 0.7 of what a fall by one length takes. [`Draft::finish`] then draws the size, gravity, the rate of steps
//! and which way is down.

mod broken;
pub(crate) mod compounds;
mod flights;
pub(crate) mod forms;
mod grounds;
mod heaps;
mod passes;
mod piles;
mod slides;
mod structures;

use super::dice::Dice;
use super::laws::Law;
use super::scene::{Actor, Scene};
use bevy_cleave::prelude::RigidBody;
use glam::{Quat, Vec3};

/// Draws a scene of a family.
pub(crate) type Draw = fn(&mut Dice) -> Draft;

/// Families by name.
pub(crate) const FAMILIES: [(&str, Draw); 31] = [
    ("boxes", heaps::boxes),
    ("hulls", heaps::hulls),
    ("round", heaps::round),
    ("plates", heaps::plates),
    ("rods", heaps::rods),
    ("needles", heaps::needles),
    ("wedges", heaps::wedges),
    ("sizes", heaps::sizes),
    ("masses", heaps::masses),
    ("broken", heaps::broken),
    ("stacks", heaps::stacks),
    ("lifts", heaps::lifts),
    ("towers", structures::towers),
    ("decks", structures::decks),
    ("slopes", structures::slopes),
    ("turntables", structures::turntables),
    ("arches", structures::arches),
    ("houses", structures::houses),
    ("soft_houses", structures::soft_houses),
    ("soft_arches", structures::soft_arches),
    ("bounces", flights::bounces),
    ("swarms", flights::swarms),
    ("shots", flights::shots),
    ("ledges", slides::ledges),
    ("slides", slides::slides),
    ("passes", passes::passes),
    ("copies", heaps::copies),
    ("steps", heaps::steps),
    ("compounds", heaps::compounds),
    ("terrains", grounds::terrains),
    ("mixtures", grounds::mixtures),
];

/// Steps of the unit of time, at least: of 1, a body falls from rest by half of its length in one step.
const COARSEST: f32 = 1.0;

/// Most steps of a scene, and the least that it is given to come to rest.
const MAX_STEPS: f32 = 2500.0;
const MIN_STEPS_TO_REST: f32 = 120.0;

/// How long a body must rest until it sleeps (`SleepConfig::time`), and half of it more, s.
const FALL_ASLEEP: f32 = 0.75;

/// A scene in units of its own.
pub(crate) struct Draft {
    pub(crate) actors: Vec<Actor>,
    /// How long it is given.
    pub(crate) time: f32,
    pub(crate) laws: Vec<Law>,
    /// Steps of the unit of time, at least [`COARSEST`].
    pub(crate) min_steps_per_unit: f32,
    /// See [`Scene::soft`].
    pub(crate) soft: u32,
    /// Which way gravity acts, a unit vector; zero: not at all.
    pub(crate) down: Vec3,
}

/// The scene of a family and a seed; `None` if there is no such family.
pub(crate) fn scene(family: &str, seed: u64) -> Option<Scene> {
    let (_, draw) = FAMILIES.iter().find(|(name, _)| *name == family)?;
    // Different streams for families, whatever their order.
    let name = family.bytes().fold(0_u64, |hash, byte| {
        hash.wrapping_mul(1_000_003).wrapping_add(byte.into())
    });
    let mut dice = Dice::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ name);
    let draft = draw(&mut dice);
    let mut scene = draft.finish(&mut dice);
    scene.family = family.into();
    scene.seed = seed;
    Some(scene)
}

impl Draft {
    /// How many steps the scene takes if its unit of time is `unit` of them and there are `rate` in a second.
    fn steps(&self, unit: f32, rate: f32) -> f32 {
        let has = |law| self.laws.contains(&law);
        let pause = if has(Law::Sleep) {
            FALL_ASLEEP * rate
        } else {
            0.0
        };
        let min = if has(Law::Rest) {
            MIN_STEPS_TO_REST
        } else {
            1.0
        };
        (self.time * unit).max(min) + pause
    }

    /// Draws units and turns the scene into SI.
    fn finish(self, dice: &mut Dice) -> Scene {
        let (length, gravity, rate, steps) = loop {
            let length = match dice.below(2) {
                0 => dice.in_range(0.2, 2.0),
                _ => log_range(dice, 1e-3, 100.0),
            };
            let gravity = match dice.below(5) {
                0 | 1 => log_range(dice, 0.1, 100.0),
                _ => 9.81,
            };
            let rate = [60.0, 60.0, 60.0, 60.0, 30.0, 50.0, 120.0, 240.0][dice.below(8)];
            let unit = rate * (length / gravity).sqrt();
            let steps = self.steps(unit, rate);
            if unit >= self.min_steps_per_unit && steps <= MAX_STEPS {
                break (length, gravity, rate, steps.ceil() as u32);
            }
        };
        let mut scene = Scene {
            family: String::new(),
            seed: 0,
            laws: self.laws,
            gravity: gravity * self.down,
            rate,
            soft: self.soft,
            steps,
            actors: self.actors,
        };
        for actor in &mut scene.actors {
            actor.form.scaled(length);
            actor.pose.position *= length;
            actor.linear *= (gravity * length).sqrt();
            actor.angular *= (gravity / length).sqrt();
        }
        if dice.below(5) == 0 {
            turn(&mut scene, dice.rotation());
        }
        scene
    }
}

/// Turns the whole scene about the origin.
pub(crate) fn turn(scene: &mut Scene, turn: Quat) {
    scene.gravity = turn * scene.gravity;
    for actor in &mut scene.actors {
        actor.pose.position = turn * actor.pose.position;
        actor.pose.rotation = (turn * actor.pose.rotation).normalize();
        actor.linear = turn * actor.linear;
        actor.angular = turn * actor.angular;
    }
}

/// From `from` to `to`, each order of magnitude as likely as every other; with square roots only, so that all platforms
/// draw the same.
pub(crate) fn log_range(dice: &mut Dice, from: f32, to: f32) -> f32 {
    let (mut root, mut number) = (to / from, from);
    for _ in 0..16 {
        root = root.sqrt();
        if dice.below(2) == 1 {
            number *= root;
        }
    }
    number
}

/// True once in `times`.
pub(crate) fn once_in(dice: &mut Dice, times: usize) -> bool {
    dice.below(times) == 0
}

/// Gives all bodies the same friction and restitution.
pub(crate) fn set_material(actors: &mut [Actor], friction: f32, restitution: f32) {
    for actor in actors {
        (actor.friction, actor.restitution) = (friction, restitution);
    }
}

/// Makes a body one that moves steadily whatever touches it.
pub(crate) fn drive(actor: &mut Actor, linear: Vec3, angular: Vec3) {
    actor.kind = RigidBody::Kinematic;
    (actor.linear, actor.angular) = (linear, angular);
}
