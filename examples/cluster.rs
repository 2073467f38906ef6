//! Clusters: walls of many bricks that are one body until they are hit.
//!
//! `cargo run --release --example cluster` prints what happened as `name: value` lines and writes pictures under `target/cluster/`: a wall
//! that is shot at twice, a block of two levels that falls, and a cantilever that bears its load or does not. Blue stands, red has come
//! loose. It also shoots at the same walls built of bonded bodies, and says how many bonds break in both, and how long both take.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "an example prints what it shows"
)]

#[path = "support/mod.rs"]
mod support;

use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};
use std::process::ExitCode;
use std::time::{Duration, Instant};
use support::film::{film, on_floor};
use support::masonry::{BRICK, ball, picture, wall};

const FOLDER: &str = "target/cluster";
const H: f32 = 1.0 / 60.0;

fn main() -> ExitCode {
    match show_all() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cluster: {error}");
            ExitCode::FAILURE
        }
    }
}

fn show_all() -> Result<(), support::Error> {
    show("wall", shot_wall()?, [0.0, 0.1, 0.4, 2.0])?;
    show("levels", falling_block()?, [0.0, 0.36, 0.6, 2.0])?;
    show("cantilevers", cantilevers()?, [0.0, 0.2, 0.5, 1.5])?;
    println!(
        "cantilever_strength_over_theory: {:.3}",
        cantilever_limit()?
    );
    compare()
}

/// Runs a scene, and writes pictures of it.
fn show(name: &str, mut simulation: Simulation, times: [f32; 4]) -> Result<(), support::Error> {
    let ledgers = film((FOLDER, name), &mut simulation, times, picture)?;
    let worst = ledgers.iter().map(Ledger::mass_error).fold(0.0, f64::max);
    println!("{name}_bodies: {}", simulation.bodies.len());
    println!("{name}_fractures: {}", ledgers.len());
    println!("{name}_mass_error_rel: {worst:.1e}");
    Ok(())
}

fn shot_wall() -> Result<Simulation, support::Error> {
    on_floor([
        wall(14, 18, 6e5)?,
        ball(0.12, Vec3::new(-1.1, 1.45, 1.2), -16.0 * Vec3::Z)?,
        ball(0.12, Vec3::new(0.5, 0.9, 6.0), -24.0 * Vec3::Z)?,
    ])
}

/// A block of chunks that break into crumbs.
fn falling_block() -> Result<Simulation, support::Error> {
    let block = ConvexMesh::cuboid(0.8, 0.8, 0.8)?;
    let cells = |cells| FracturePattern::Voronoi { cells, focus: 0.0 };
    let chunks = Cluster::cut(&block, &cells(8), 5, 2e5)?;
    let crumbs = chunks.refined(&cells(8), 6, 2e6)?;
    let shape = crumbs.compound()?;
    println!("levels_parts: {}", shape.len());
    let turn = Quat::from_xyzw(0.3, 0.1, 0.2, 0.9).normalize();
    on_floor([BodyDesc {
        pose: Pose::new(1.6 * Vec3::Y, turn),
        linear_velocity: -3.0 * Vec3::Y,
        ..BodyDesc::compound(shape, Vec3::ZERO)
    }])
}

/// A row of cubes of 0.2 m along x, the first of which is in a wall; its own weight stresses it to a share of its strength.
fn cantilever(count: usize, share: f32) -> Result<(BodyDesc, Anchors), support::Error> {
    let side = 0.2f32;
    let cube = ConvexMesh::cuboid(side, side, side)?;
    let at = |i: usize| Pose::from_position(Vec3::X * side * (i as f32 + 0.5));
    let free = (count - 1) as f32 * side;
    let moment = 0.5 * 1000.0 * side * side * 9.81 * free * free;
    let strength = moment / (side * side * side / 6.0) / share;
    let cluster = Cluster::new((0..count).map(|i| (at(i), cube.clone())), strength)?;
    let shape = Shape::Compound(cluster.compound()?);
    let anchors = Anchors::none().and_behind(Vec3::X, 0.01);
    Ok((BodyDesc::new(RigidBody::Static, shape), anchors))
}

fn cantilevers() -> Result<Simulation, support::Error> {
    let mut simulation = on_floor([])?;
    for (height, share) in [(0.6, 1.05), (1.2, 0.95)] {
        let (desc, anchors) = cantilever(10, share)?;
        let at = Vec3::new(-0.8, height, 0.0);
        let desc = BodyDesc {
            pose: Pose::from_position(at),
            ..desc
        };
        let body = simulation.bodies.insert(desc)?;
        simulation.bodies.set_anchors(body, Some(anchors))?;
    }
    Ok(simulation)
}

/// The strength at which a cantilever just bears its weight, over that of theory.
fn cantilever_limit() -> Result<f32, support::Error> {
    let (mut low, mut high) = (0.5, 2.0);
    while high - low > 1e-3 {
        let share = 0.5 * (low + high);
        let mut simulation = Simulation::default();
        let (desc, anchors) = cantilever(10, share)?;
        let body = simulation.bodies.insert(desc)?;
        simulation.bodies.set_anchors(body, Some(anchors))?;
        let mut falls = false;
        for _ in 0..10 {
            simulation.step(H);
            falls |= !simulation.fractures.done.is_empty();
        }
        if falls {
            high = share;
        } else {
            low = share;
        }
    }
    Ok(1.0 / low)
}

/// A wall under a shot, as one cluster or as bonded bodies.
#[derive(Clone, Copy, Debug)]
struct Shot {
    strength: f32,
    at: Vec3,
    velocity: Vec3,
}

/// Bonds that are broken some time after a shot, as pairs of bricks, and how long the steps took.
struct Outcome {
    broken: Vec<[usize; 2]>,
    time: Duration,
}

/// The same shots at walls of both kinds. What bonds between bodies bear depends on the length of a step, so these are given shorter and
/// shorter ones.
fn compare() -> Result<(), support::Error> {
    let shots: Vec<Shot> = (0..8u8).map(shot).collect();
    let clusters = shots.iter().map(|shot| {
        let wall = wall(12, 12, shot.strength)?;
        Ok((as_cluster(&wall, shot)?, wall))
    });
    let clusters: Vec<_> = clusters.collect::<Result<_, support::Error>>()?;
    for rate in [60.0, 480.0, 3840.0] {
        let mut agreement = Agreement::default();
        let mut broken = [0, 0];
        let mut time = [Duration::ZERO; 2];
        for (shot, (cluster, wall)) in shots.iter().zip(&clusters) {
            let bonded = as_bodies(wall, shot, rate)?;
            agreement.add(wall, [cluster, &bonded]);
            time[0] += cluster.time;
            time[1] += bonded.time;
            broken[0] += cluster.broken.len();
            broken[1] += bonded.broken.len();
        }
        println!(
            "{rate}_hz_broken_by_cluster_and_bonded: {broken:?} of {}",
            agreement.all
        );
        agreement.tell(&format!("{rate}_hz"));
        let ratio = time[1].as_secs_f64() / time[0].as_secs_f64();
        println!("{rate}_hz_bonded_bodies_take_times_as_long: {ratio:.1}");
    }
    compare_with_themselves(&shots, &clusters)?;
    let [cluster, bonded] = standing_times()?;
    let ratio = bonded.as_secs_f64() / cluster.as_secs_f64();
    println!("standing_500_bricks_ms: {:.3}", 1e3 * cluster.as_secs_f64());
    println!("standing_500_bonded_take_times_as_long: {ratio:.0}");
    Ok(())
}

/// How far two outcomes of one more shot agree is no more than how far one model agrees with itself: with the shot a centimeter aside, which is
/// a twelfth of a brick's thickness, and in shorter steps.
fn compare_with_themselves(
    shots: &[Shot],
    clusters: &[(Outcome, BodyDesc)],
) -> Result<(), support::Error> {
    let (mut cluster, mut bonded, mut finer) = (
        Agreement::default(),
        Agreement::default(),
        Agreement::default(),
    );
    for (shot, (as_it_was, wall)) in shots.iter().zip(clusters) {
        let aside = Shot {
            at: shot.at + 0.01 * Vec3::X,
            ..*shot
        };
        cluster.add(wall, [as_it_was, &as_cluster(wall, &aside)?]);
        let coarse = as_bodies(wall, shot, 480.0)?;
        bonded.add(wall, [&coarse, &as_bodies(wall, &aside, 480.0)?]);
        finer.add(wall, [&coarse, &as_bodies(wall, shot, 3840.0)?]);
    }
    cluster.tell("cluster_beside_1_cm_aside");
    bonded.tell("bonded_480_hz_beside_1_cm_aside");
    finer.tell("bonded_480_hz_beside_3840_hz");
    Ok(())
}

/// How far outcomes of shots agree, bond by bond.
#[derive(Debug, Default)]
struct Agreement {
    all: usize,
    /// Whole in both, or broken in both.
    same: usize,
    /// Broken in both.
    both: usize,
    either: usize,
}

impl Agreement {
    fn add(&mut self, wall: &BodyDesc, outcomes: [&Outcome; 2]) {
        for bond in wall.shape_bonds() {
            let [a, b] = outcomes.map(|outcome| outcome.broken.contains(&bond));
            self.all += 1;
            self.same += usize::from(a == b);
            self.both += usize::from(a && b);
            self.either += usize::from(a || b);
        }
    }

    fn tell(&self, name: &str) {
        let share = |count: usize, of: usize| count as f64 / of as f64;
        println!(
            "{name}_bonds_in_the_same_state: {:.3}",
            share(self.same, self.all)
        );
        println!(
            "{name}_broken_in_both_of_either: {:.3}",
            share(self.both, self.either)
        );
    }
}

/// One of many.
fn shot(number: u8) -> Shot {
    let wave = |k: f32| (f32::from(number) * k).fract();
    Shot {
        strength: [1e5, 3e5, 1e6, 3e6][usize::from(number) % 4],
        at: Vec3::new(1.2 - 2.4 * wave(0.381), 0.35 + 0.7 * wave(0.733), 0.2),
        velocity: Vec3::new(0.0, 0.0, -6.0 - 14.0 * wave(0.271)),
    }
}

/// Time of a step of a wall that a box lies on, as a cluster and as bonded bodies, s.
fn standing_times() -> Result<[Duration; 2], support::Error> {
    let wall = wall(20, 25, 1e6)?;
    let cube = ConvexMesh::cuboid(0.2, 0.2, 0.2)?;
    let cube = BodyDesc::dynamic(cube, 2.6 * Vec3::Y);
    let mut times = [Duration::ZERO; 2];
    for (kind, time) in times.iter_mut().enumerate() {
        let mut simulation = on_floor([cube.clone()])?;
        simulation.config.sleep = SleepConfig::off();
        if kind == 0 {
            simulation.bodies.insert(wall.clone())?;
        } else {
            add_bricks(&mut simulation, &wall, 1e6)?;
        }
        (0..60).for_each(|_| simulation.step(H));
        let start = Instant::now();
        (0..60).for_each(|_| simulation.step(H));
        *time = start.elapsed() / 60;
    }
    Ok(times)
}

trait ShapeBonds {
    fn parts(&self) -> &[CompoundPart];
    fn shape_bonds(&self) -> Vec<[usize; 2]>;
}

impl ShapeBonds for BodyDesc {
    fn parts(&self) -> &[CompoundPart] {
        match &self.shape {
            Shape::Compound(compound) => compound.parts(),
            _ => &[],
        }
    }

    fn shape_bonds(&self) -> Vec<[usize; 2]> {
        let bonds = match &self.shape {
            Shape::Compound(compound) => compound.bonds(),
            _ => &[],
        };
        let pairs = bonds.iter();
        pairs
            .map(|bond| bond.parts.map(|part| part as usize))
            .collect()
    }
}

/// Steps for a sixth of a second.
fn run(simulation: &mut Simulation, rate: f32) -> Duration {
    let start = Instant::now();
    (0..(rate / 6.0) as usize).for_each(|_| simulation.step(1.0 / rate));
    start.elapsed()
}

fn as_cluster(wall: &BodyDesc, shot: &Shot) -> Result<Outcome, support::Error> {
    let mut simulation = on_floor([wall.clone(), ball(0.05, shot.at, shot.velocity)?])?;
    let time = run(&mut simulation, 60.0);
    // Parts are known by their shapes.
    let number = |part: &CompoundPart| {
        let mut all = wall.parts().iter();
        all.position(|other| other.shape.is_same(&part.shape))
    };
    let mut left = Vec::new();
    for compound in simulation
        .bodies
        .iter()
        .filter_map(|slot| simulation.bodies.compound(slot))
    {
        for bond in compound.bonds() {
            let [a, b] = bond
                .parts
                .map(|part| number(&compound.parts()[part as usize]));
            left.extend(a.zip(b).map(|(a, b)| [a.min(b), a.max(b)]));
        }
    }
    let mut broken = wall.shape_bonds();
    broken.retain(|bond| !left.contains(bond));
    Ok(Outcome { broken, time })
}

fn as_bodies(wall: &BodyDesc, shot: &Shot, rate: f32) -> Result<Outcome, support::Error> {
    let mut simulation = on_floor([ball(0.05, shot.at, shot.velocity)?])?;
    let slots = add_bricks(&mut simulation, wall, shot.strength)?;
    let time = run(&mut simulation, rate);
    let is_static = |part: usize| simulation.bodies.kind(slots[part]) == RigidBody::Static;
    let mut broken = wall.shape_bonds();
    broken.retain(|&[a, b]| {
        let bond = simulation.bonds.get(&simulation.bodies, slots[a], slots[b]);
        bond.is_none() && !(is_static(a) && is_static(b))
    });
    Ok(Outcome { broken, time })
}

/// The parts of a wall as bodies that are bonded; their slots.
fn add_bricks(
    simulation: &mut Simulation,
    wall: &BodyDesc,
    strength: f32,
) -> Result<Vec<u32>, support::Error> {
    let mut slots = Vec::new();
    for part in wall.parts() {
        let pose = wall.pose * part.pose;
        let height = pose.transform_point(part.shape.hull().aabb().center()).y;
        // The lowest course is held, as it is in the cluster.
        let kind = if height < BRICK.y {
            RigidBody::Static
        } else {
            RigidBody::Dynamic
        };
        slots.push(simulation.bodies.insert(BodyDesc {
            pose,
            density: wall.density,
            ..BodyDesc::new(kind, Shape::Convex(part.shape.clone()))
        })?);
    }
    simulation.bond_neighbors(&slots, strength)?;
    Ok(slots)
}
