//! Sustained loads: what theory says breaks does, and nothing else.

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use crate::shapes::{row, standing};
use bevy_cleave::prelude::*;
use glam::Vec3;

const RATES: [f32; 4] = [30.0, 60.0, 120.0, 240.0];

/// Whether a cantilever of this strength falls within three seconds; and how many parts are left of what stands.
fn falls(shape: &Compound, load: Option<f32>, rate: f32) -> (bool, usize) {
    let mut simulation = awake();
    let end = shape.aabb().max;
    let body = simulation.bodies.insert(standing(shape.clone()));
    let body = body.expect("usable");
    // The first part is in a wall.
    let wall = Anchors::none().and_behind(Vec3::X, 0.01);
    simulation
        .bodies
        .set_anchors(body, Some(wall))
        .expect("usable");
    if let Some(mass) = load {
        let weight = ConvexMesh::cuboid(0.1, 0.1, 0.1).expect("a box");
        let at = Vec3::new(end.x - 0.05, end.y + 0.05, 0.0);
        let desc = BodyDesc {
            density: mass / 1e-3,
            ..BodyDesc::dynamic(weight, at)
        };
        simulation.bodies.insert(desc).expect("usable");
    }
    let mut is_broken = false;
    for _ in 0..(3.0 * rate) as usize {
        simulation.step(1.0 / rate);
        is_broken |= !simulation.fractures.done.is_empty();
    }
    let left = simulation.bodies.compound(body).map_or(1, Compound::len);
    (is_broken, left)
}

/// Symptom: what stands bore all of gravity, however much of it acted on what fell off of it.
#[test]
fn what_stands_bears_as_much_of_gravity_as_acts_on_it() {
    for seed in 0..6 {
        let dice = &mut Dice::new(seed);
        let (count, size) = (6 + dice.below(6), dice.vector(0.1, 0.2));
        let scale = [-1.0, 1.0][dice.below(2)] * dice.in_range(0.2, 4.0);
        let stress = root_stress(count, size, 1000.0, None) * scale.abs();
        let falls = |strength: f32, gravity_scale: f32| {
            let mut simulation = awake();
            let shape = row(count, size, strength);
            let body = simulation.bodies.insert(standing(shape)).expect("usable");
            let wall = Anchors::none().and_behind(Vec3::X, 0.01);
            let bodies = &mut simulation.bodies;
            bodies.set_anchors(body, Some(wall)).expect("usable");
            let drive = BodyDrive {
                gravity_scale,
                ..BodyDrive::default()
            };
            bodies.set_drive(body, drive).expect("usable");
            (0..120).any(|_| {
                simulation.step(1.0 / 60.0);
                !simulation.fractures.done.is_empty()
            })
        };
        assert!(falls(stress / 1.05, scale), "{seed}: {scale}");
        assert!(!falls(stress / 0.95, scale), "{seed}: {scale}");
        assert!(!falls(1e-3 * stress, 0.0), "{seed}: without gravity");
    }
}

/// Stress at the root of a cantilever of `count` parts of `size` under its own weight and one at its end, Pa: moment over section modulus.
fn root_stress(count: usize, size: Vec3, density: f32, load: Option<f32>) -> f32 {
    let g = 9.81;
    // Behind the root is what is held.
    let free = (count - 1) as f32 * size.x;
    let weight = density * size.y * size.z * free * g;
    let end = load.map_or(0.0, |mass| mass * g * (free - 0.05));
    let moment = 0.5 * weight * free + end;
    moment / (size.z * size.y * size.y / 6.0)
}

#[test]
fn a_cantilever_collapses_where_theory_says() {
    let shapes = [
        (4, Vec3::splat(0.2)),
        (8, Vec3::new(0.15, 0.2, 0.3)),
        (20, Vec3::new(0.1, 0.15, 0.1)),
    ];
    for (count, size) in shapes {
        for load in [None, Some(5.0), Some(50.0)] {
            let stress = root_stress(count, size, 1000.0, load);
            for rate in RATES {
                let weak = falls(&row(count, size, 0.95 * stress), load, rate);
                assert_eq!(weak, (true, 1), "{count} parts, {load:?} kg, {rate} Hz");
                let strong = falls(&row(count, size, 1.05 * stress), load, rate);
                assert_eq!(
                    strong,
                    (false, count),
                    "{count} parts, {load:?} kg, {rate} Hz"
                );
            }
        }
    }
}

/// Lengths, sections, loads and rates of cantilevers that are slender enough for the theory of beams.
struct Cantilever {
    count: usize,
    size: Vec3,
    load: Option<f32>,
    rate: f32,
}

impl Cantilever {
    fn random(dice: &mut Dice) -> Self {
        let size = dice.vector(0.1, 0.3);
        let slender = (4.0 * size.y / size.x).ceil() as usize;
        let decade = [1.0, 10.0][dice.below(2)];
        let load = decade * dice.in_range(1.0, 10.0);
        Self {
            count: 1 + slender + dice.below(12),
            size,
            load: (dice.below(3) > 0).then_some(load),
            rate: dice.in_range(30.0, 240.0),
        }
    }
}

#[test]
fn cantilevers_of_any_length_section_and_load_collapse_where_theory_says_at_any_rate() {
    for seed in 0..16 {
        let member = Cantilever::random(&mut Dice::new(seed));
        let Cantilever {
            count,
            size,
            load,
            rate,
        } = member;
        let stress = root_stress(count, size, 1000.0, load);
        let about = format!("{seed}: {count} parts, {size}, {load:?} kg, {rate} Hz");
        let weak = falls(&row(count, size, 0.92 * stress), load, rate);
        assert_eq!(weak, (true, 1), "{about}");
        let strong = falls(&row(count, size, 1.08 * stress), load, rate);
        assert_eq!(strong, (false, count), "{about}");
    }
}

/// The step within five seconds in which a wall or slab of blocks that one side holds breaks under a block of so many kilograms that lies on
/// it, with so many light ones between.
fn breaks_at(
    seed: u64,
    (mass, light): (f32, usize),
    strength: f32,
    (config, rate): (SolverConfig, f32),
) -> Option<usize> {
    let mut dice = Dice::new(seed);
    let (columns, rows) = (3 + dice.below(4), 1 + dice.below(3));
    let size = dice.vector(0.3, 0.6);
    let brick = ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box");
    let at = |i: usize| size * Vec3::new((i % columns) as f32, (i / columns) as f32 + 0.5, 0.0);
    let parts = (0..columns * rows).map(|i| (Pose::from_position(at(i)), brick.clone()));
    let cluster = Cluster::new(parts, strength).expect("parts");
    let shape = cluster.compound().expect("a wall");
    let (end, side) = (shape.aabb().max, dice.in_range(0.5, 1.0));
    let block = ConvexMesh::cuboid(side, side, side).expect("a box");
    let x = end.x * dice.in_range(0.4, 0.9);
    let blocks: Vec<BodyDesc> = (0..=light)
        .map(|level| {
            let mass = if level == light {
                mass
            } else {
                dice.in_range(10.0, 500.0)
            };
            let y = end.y + (level as f32 + 0.5) * side;
            BodyDesc {
                density: mass / (side * side * side),
                ..BodyDesc::dynamic(block.clone(), Vec3::new(x, y, 0.0))
            }
        })
        .collect();
    let mut simulation = awake();
    let sleep = simulation.config.sleep;
    simulation.config = SolverConfig { sleep, ..config };
    let body = simulation.bodies.insert(standing(shape.clone()));
    let body = body.expect("usable");
    let wall = Anchors::none().and_behind(Vec3::X, -0.4 * size.x);
    let held = simulation.bodies.set_anchors(body, Some(wall));
    held.expect("usable");
    for block in &blocks {
        simulation.bodies.insert(block.clone()).expect("usable");
    }
    (0..(5.0 * rate) as usize).find(|_| {
        simulation.step(1.0 / rate);
        !simulation.fractures.done.is_empty()
    })
}

fn breaks_under_a_block(
    seed: u64,
    stack: (f32, usize),
    strength: f32,
    at: (SolverConfig, f32),
) -> bool {
    breaks_at(seed, stack, strength, at).is_some()
}

/// Strengths between which a block breaks what it lies on and does not, at 60 Hz.
fn limits(seed: u64, stack: (f32, usize)) -> (f32, f32) {
    let (mut low, mut high) = (1e4f32, 1e10f32);
    while high / low > 1.01 {
        let middle = (low * high).sqrt();
        match breaks_under_a_block(seed, stack, middle, (SolverConfig::default(), 60.0)) {
            true => low = middle,
            false => high = middle,
        }
    }
    (low, high)
}

/// Symptom: points of a contact that pulled against each other strained what they were at by up to a fourth of what it bore, another
/// one for each rate and setting, and after seconds still more.
#[test]
fn what_a_heavy_block_breaks_depends_on_no_setting_and_no_rate() {
    for seed in 5..10 {
        let stack = ([20_000.0, 140_000.0][seed as usize % 2], 0);
        let (low, high) = limits(seed, stack);
        let settings = [
            SolverConfig::default(),
            SolverConfig::fast(),
            SolverConfig::precise(),
        ];
        for config in settings {
            for rate in [30.0, 60.0, 240.0] {
                let breaks = |strength| breaks_under_a_block(seed, stack, strength, (config, rate));
                assert!(breaks(low / 1.1), "{seed}: {config:?}, {rate} Hz");
                assert!(!breaks(high * 1.1), "{seed}: {config:?}, {rate} Hz");
            }
        }
    }
}

/// A heavy block and how many light ones are under it, of a member of the family.
fn random_stack(seed: u64) -> (f32, usize) {
    let dice = &mut Dice::new(1000 + seed);
    let mass = [1e4, 1e5][dice.below(2)] * dice.in_range(0.5, 2.0);
    (mass, 1 + dice.below(3))
}

/// Symptom: what comes to rest on light boxes sags and rebounds, and broke at another rate what bears up to 1.3 times its weight.
#[test]
fn what_stands_on_light_boxes_breaks_no_more_than_its_weight_does() {
    let mut failures = Vec::new();
    for seed in 0..12 {
        let stack = random_stack(seed);
        let (low, high) = limits(seed, stack);
        for rate in [30.0, 60.0, 240.0] {
            let at = (SolverConfig::default(), rate);
            let breaks = |strength| breaks_under_a_block(seed, stack, strength, at);
            let found = (breaks(low / 1.03), breaks(high * 1.03));
            if found != (true, false) {
                failures.push(format!("{seed}: {stack:?}, {rate} Hz: {found:?}"));
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn of_two_that_bear_the_same_load_the_weaker_breaks_no_later() {
    for seed in 100..112 {
        let dice = &mut Dice::new(seed);
        let stack = random_stack(seed);
        let (low, high) = limits(seed, stack);
        let at = (SolverConfig::default(), dice.in_range(30.0, 240.0));
        let mut strength = 0.05 * low;
        let mut last = 0;
        while strength < 1.5 * high {
            let step = breaks_at(seed, stack, strength, at).unwrap_or(usize::MAX);
            assert!(
                step >= last,
                "{seed}: {stack:?}, {strength} Pa: {step} before {last}, {at:?}"
            );
            last = step;
            strength *= dice.in_range(1.02, 1.5);
        }
        assert_eq!(last, usize::MAX, "{seed}: {stack:?}");
    }
}
