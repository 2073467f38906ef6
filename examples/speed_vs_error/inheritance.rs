//! Cuts in place: how much pieces move at first, with the multipliers of their parent and without.

use crate::measure::{H, simulation_with, steps};
use crate::structures::{block, cuboid, cuts_of_block, floor, tower};
use bevy_cleave::prelude::*;
use glam::Vec3;

/// A cut under one setting.
pub(crate) struct Spike {
    pub(crate) title: &'static str,
    pub(crate) setting: &'static str,
    /// With inheritance, and without.
    pub(crate) outcomes: [Outcome; 2],
}

/// What a cut did.
#[derive(Clone, Copy)]
pub(crate) struct Outcome {
    /// Relative residual of the contact problem in the step of the cut.
    pub(crate) residual: f32,
    /// Fastest piece at the end of that step, m/s.
    pub(crate) first: f32,
    /// Fastest piece within a second, m/s.
    pub(crate) peak: f32,
    /// Farthest way of a piece within a second, m.
    pub(crate) moved: f32,
}

/// Cuts a settled body; what it is called, and how.
type Cut = (&'static str, fn(SolverConfig) -> Simulation);

pub(crate) fn measure() -> Vec<Spike> {
    let plain = SolverConfig::fast();
    let settings = [
        ("default", SolverConfig::default()),
        ("4 sub-steps, 1 + 1 sweeps", plain),
        ("`paper()`", SolverConfig::paper()),
    ];
    let cuts: [Cut; 2] = [
        ("block of 4 x 2 x 4 m into 4 x 2 x 4", block_to_be_cut),
        ("column of ten cubes by a vertical plane", column_to_be_cut),
    ];
    let all = cuts.into_iter().flat_map(|(title, scene)| {
        settings.map(|(setting, config)| Spike {
            title,
            setting,
            outcomes: [true, false].map(|inherits| cut(scene(config), inherits)),
        })
    });
    all.collect()
}

fn block_to_be_cut(config: SolverConfig) -> Simulation {
    let bodies = [
        floor(0.6),
        block(&cuboid(Vec3::new(4.0, 2.0, 4.0)), Vec3::Y, 0.6),
    ];
    let mut simulation = settled(config, bodies.into());
    for (at, normal) in cuts_of_block() {
        let plane = Plane::through(at * normal, normal);
        simulation.slice(1, plane).expect("a body");
    }
    simulation
}

fn column_to_be_cut(config: SolverConfig) -> Simulation {
    let mut simulation = settled(config, tower(10));
    let plane = Plane::through(-0.2 * Vec3::X, Vec3::X);
    for slot in 1..=10 {
        simulation.slice(slot, plane).expect("a body");
    }
    simulation
}

fn settled(config: SolverConfig, bodies: Vec<BodyDesc>) -> Simulation {
    let config = SolverConfig {
        measure_error: true,
        ..config
    };
    let mut simulation = simulation_with(config, bodies);
    (0..steps(1.0)).for_each(|_| simulation.step(H));
    simulation
}

/// Makes the cuts that were asked for. Without inheritance all multipliers are forgotten first.
fn cut(mut simulation: Simulation, inherits: bool) -> Outcome {
    if !inherits {
        simulation.cache = ContactCache::default();
    }
    simulation.step(H);
    let error = simulation.report.error.as_ref();
    let residual = error.map_or(f32::NAN, |error| error.residual.relative);
    let first = fastest(&simulation);
    let bodies = &simulation.bodies;
    let start: Vec<(u32, Vec3)> = (bodies.iter().map(|s| (s, bodies.center_of_mass(s)))).collect();
    let mut peak = first;
    for _ in 0..steps(1.0) {
        simulation.step(H);
        peak = peak.max(fastest(&simulation));
    }
    let ways = start
        .iter()
        .map(|&(slot, center)| simulation.bodies.center_of_mass(slot).distance(center));
    Outcome {
        residual,
        first,
        peak,
        moved: ways.fold(0.0, f32::max),
    }
}

fn fastest(simulation: &Simulation) -> f32 {
    let bodies = &simulation.bodies;
    let speeds = bodies.iter().map(|s| bodies.velocity(s).0.length());
    speeds.fold(0.0, f32::max)
}
