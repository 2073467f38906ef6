//! Scenes of destruction by the names that other engines give to their samples: cantilever, bridge span, wall smash, demolition, and a pane
//! that is broken as it is hit.
//!
//! `cargo run --release --example peers` prints for each how much broke, how long the steps took (time of the thread), and how far the
//! books are off, and writes pictures under `target/peers/`; `docs/report/peers_destruction.md` holds a run. What stands is blue, what has come
//! loose is red. Where a beam's theory says what must happen, the figure is told as a ratio to it.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "an example prints what it shows"
)]

#[path = "support/mod.rs"]
mod support;

use bevy_cleave::prelude::*;
use cpu_time::ThreadTime;
use glam::Vec3;
use std::path::Path;
use std::process::ExitCode;
use support::film::on_floor;
use support::masonry::{ball, picture, wall};
use support::picture::contact_sheet;
use support::{Error, stats};

const FOLDER: &str = "target/peers";
const H: f32 = 1.0 / 60.0;

/// Side of the cubes that beams are made of, m.
const SIDE: f32 = 0.2;

fn main() -> ExitCode {
    match show_all() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("peers: {error}");
            ExitCode::FAILURE
        }
    }
}

fn show_all() -> Result<(), Error> {
    for kind in [Beam::Cantilever, Beam::Span] {
        println!("{kind:?}_strength_over_theory: {:.3}", kind.limit()?);
    }
    run("cantilever", Beam::Cantilever.scene(0.95, 0.8)?)?;
    let mut span = Beam::Span.scene(4.0, 1.0)?;
    let shot = ball(0.1, Vec3::new(0.1, 1.0, 2.0), -20.0 * Vec3::Z)?;
    span.bodies.insert(shot)?;
    run("bridge_span", span)?;
    let shot = ball(0.25, Vec3::new(0.2, 1.0, 3.0), -15.0 * Vec3::Z)?;
    run("wall_smash", on_floor([wall(14, 18, 3e5)?, shot])?)?;
    run("demolition", demolition()?)?;
    run("pane", pane()?)
}

/// Steps a scene for two seconds, tells what happened, and writes pictures.
fn run(name: &str, mut simulation: Simulation) -> Result<(), Error> {
    let (mut times, mut pictures, mut ledgers) = (Vec::new(), Vec::new(), Vec::new());
    let mut worst_break = 0.0_f64;
    let mut pieces = 0;
    for step in 0..=120 {
        if [0, 12, 36, 120].contains(&step) {
            let time = step as f32 * H;
            pictures.push((format!("{name}, t = {time:.1} s"), picture(&simulation)));
        }
        let start = ThreadTime::now();
        simulation.step(H);
        let time = start.elapsed().as_secs_f64() * 1e3;
        times.push(time);
        let done = &simulation.fractures.done;
        if !done.is_empty() {
            worst_break = worst_break.max(time);
        }
        pieces += done.iter().map(|f| f.pieces.len()).sum::<usize>();
        ledgers.extend(done.iter().map(|f| f.ledger));
    }
    let worst = |error: fn(&Ledger) -> f64| ledgers.iter().map(error).fold(0.0, f64::max);
    println!("{name}_fractures: {}", ledgers.len());
    println!("{name}_pieces: {pieces}");
    println!("{name}_bodies: {}", simulation.bodies.len());
    println!("{name}_step_ms_median: {:.3}", stats::median(&times));
    println!("{name}_step_ms_worst: {:.3}", stats::max(&times));
    println!("{name}_step_ms_worst_with_a_break: {worst_break:.3}");
    println!("{name}_mass_error_rel: {:.1e}", worst(Ledger::mass_error));
    println!(
        "{name}_momentum_error_rel: {:.1e}",
        worst(Ledger::momentum_error)
    );
    println!("{name}_energy_gain_rel: {:.1e}", worst(Ledger::energy_gain));
    contact_sheet(&pictures, 2, 2).save(Path::new(FOLDER).join(format!("{name}.png")))
}

/// A row of ten cubes along x, one body of bonded parts.
#[derive(Clone, Copy, Debug)]
enum Beam {
    /// The first cube is in a wall.
    Cantilever,
    /// The first and the last one are.
    Span,
}

impl Beam {
    /// A beam whose strength is so many times what theory asks for, at a height (m).
    ///
    /// Moment at the root under its own weight `w` (N/m): `w l^2 / 2` of a cantilever, `w l^2 / 12` of a beam that is clamped at both ends, over
    /// the section modulus `b h^2 / 6`.
    fn scene(self, share: f32, height: f32) -> Result<Simulation, Error> {
        let count = 10;
        let cube = ConvexMesh::cuboid(SIDE, SIDE, SIDE)?;
        let at = |i: usize| Pose::from_position(Vec3::X * SIDE * (i as f32 + 0.5));
        let held = [Vec3::splat(-1.0), Vec3::new(0.5 * SIDE, 1.0, 1.0)];
        let anchors = Anchors::none().and_within(held[0], held[1]);
        let (free, part, anchors) = match self {
            Self::Cantilever => (9.0 * SIDE, 2.0, anchors),
            Self::Span => {
                let end = Vec3::X * 9.5 * SIDE;
                let anchors = anchors.and_within(end - Vec3::new(0.0, 1.0, 1.0), end + Vec3::ONE);
                (8.0 * SIDE, 12.0, anchors)
            }
        };
        let weight = 1000.0 * SIDE * SIDE * 9.81;
        let strength = share * weight * free * free / part / (SIDE * SIDE * SIDE / 6.0);
        let cluster = Cluster::new((0..count).map(|i| (at(i), cube.clone())), strength)?;
        let shape = Shape::Compound(cluster.compound()?);
        let mut simulation = on_floor([])?;
        let body = simulation.bodies.insert(BodyDesc {
            pose: Pose::from_position(Vec3::new(-0.8, height, 0.0)),
            ..BodyDesc::new(RigidBody::Static, shape)
        })?;
        simulation.bodies.set_anchors(body, Some(anchors))?;
        Ok(simulation)
    }

    /// The least strength that bears the weight, over that of theory.
    fn limit(self) -> Result<f32, Error> {
        let (mut low, mut high) = (0.5, 2.0);
        while high - low > 1e-3 {
            let share = 0.5 * (low + high);
            let mut simulation = self.scene(share, 1.0)?;
            let mut falls = false;
            for _ in 0..12 {
                simulation.step(H);
                falls |= !simulation.fractures.done.is_empty();
            }
            *(if falls { &mut low } else { &mut high }) = share;
        }
        Ok(high)
    }
}

/// A house of three storeys, slabs on four columns each, of lumps: two of its columns are shot away.
fn demolition() -> Result<Simulation, Error> {
    let column = ConvexMesh::cuboid(0.16, 0.5, 0.16)?;
    let slab = ConvexMesh::cuboid(1.6, 0.1, 1.2)?;
    let mut parts = Vec::new();
    for storey in 0..3u8 {
        let foot = 0.6 * f32::from(storey);
        for (x, z) in [(-0.7, -0.5), (0.7, -0.5), (-0.7, 0.5), (0.7, 0.5)] {
            let at = Vec3::new(x, foot + 0.25, z);
            parts.push((Pose::from_position(at), column.clone()));
        }
        let at = Vec3::Y * (foot + 0.55);
        parts.push((Pose::from_position(at), slab.clone()));
    }
    let lumps = FracturePattern::EvenVoronoi { cells: 10 };
    let cluster = Cluster::new(parts, 4e5)?.refined(&lumps, 1, 4e5)?;
    let house = BodyDesc {
        density: 2400.0,
        ..BodyDesc::new(RigidBody::Static, Shape::Compound(cluster.compound()?))
    };
    let shots = [-0.7, 0.7].map(|x| ball(0.12, Vec3::new(x, 0.3, 2.0), -25.0 * Vec3::Z));
    let [left, right] = shots;
    on_floor([house, left?, right?])
}

/// A pane that stands, broken into fifty cells where a ball hits it, with rough edges.
fn pane() -> Result<Simulation, Error> {
    let (cells, focus) = (50, 0.6);
    let pane = ConvexMesh::cuboid(1.6, 1.4, 0.06)?;
    let fracturable = Fracturable::with_strength(20.0)
        .with_pattern(FracturePattern::Voronoi { cells, focus })
        .with_relief(Relief::of_size(0.03));
    let pane = BodyDesc {
        pose: Pose::from_position(0.7 * Vec3::Y),
        density: 2500.0,
        fracturable: Some(fracturable),
        ..BodyDesc::new(RigidBody::Static, Shape::Convex(pane))
    };
    let shot = ball(0.06, Vec3::new(0.2, 0.8, 2.0), -20.0 * Vec3::Z)?;
    on_floor([pane, shot])
}
