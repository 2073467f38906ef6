//! What stands breaks where it is hit, and goes on standing where it holds on to the world.
//!
//! `cargo run --release --example fixed_wall` prints what happened as `name: value` lines and writes pictures under
//! `target/fixed_wall/`. Look for what is left: the foot of the wall, the rim of the pane in its frame, the ends of the bridge. Blue
//! stands, red has come loose.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "an example prints what it shows"
)]

#[path = "support/mod.rs"]
mod support;

use bevy_cleave::prelude::*;
use glam::Vec3;
use std::process::ExitCode;
use support::film::{film, on_floor};
use support::picture::Picture;
use support::render::{Camera, Scene};

const FOLDER: &str = "target/fixed_wall";

/// Times at which pictures are taken, s.
const PICTURES: [f32; 4] = [0.0, 0.2, 0.6, 3.0];

fn main() -> ExitCode {
    match show_all() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("fixed_wall: {error}");
            ExitCode::FAILURE
        }
    }
}

fn show_all() -> Result<(), support::Error> {
    show("wall", wall()?)?;
    show("pane", pane()?)?;
    show("bridge", bridge()?)
}

/// Runs a scene, and writes pictures of it.
fn show(name: &str, mut simulation: Simulation) -> Result<(), support::Error> {
    let ledgers = film((FOLDER, name), &mut simulation, PICTURES, picture)?;
    let bodies = &simulation.bodies;
    let count = |kind: RigidBody| {
        let convex = bodies.iter().filter(|&slot| bodies.convex(slot).is_some());
        convex.filter(|&slot| bodies.kind(slot) == kind).count()
    };
    let worst = ledgers.iter().map(Ledger::mass_error).fold(0.0, f64::max);
    println!("{name}_fractures: {}", ledgers.len());
    println!("{name}_standing: {}", count(RigidBody::Static));
    println!("{name}_loose: {}", count(RigidBody::Dynamic));
    println!("{name}_mass_error_rel: {worst:.1e}");
    Ok(())
}

fn picture(simulation: &Simulation) -> Picture {
    let bodies = &simulation.bodies;
    let mut scene = Scene::default();
    for slot in bodies.iter() {
        let Some(mesh) = bodies.convex(slot) else {
            continue;
        };
        let color = match bodies.kind(slot) {
            RigidBody::Static => Vec3::new(0.25, 0.38, 0.6),
            _ if bodies.fracturable(slot).is_some() => Vec3::new(0.62, 0.25, 0.18),
            _ => Vec3::new(0.7, 0.42, 0.3),
        };
        scene.draw(&mesh.render_mesh(), bodies.pose(slot), color);
    }
    let eye = Vec3::new(3.6, 2.8, 5.4);
    let camera = Camera::look_at(eye, Vec3::new(0.0, 1.0, 0.0), Vec3::Y, 42.0, 1280, 720);
    scene.render(&camera)
}

fn standing(size: Vec3, at: Vec3) -> Result<BodyDesc, support::Error> {
    let shape = ConvexMesh::cuboid(size.x, size.y, size.z)?;
    Ok(BodyDesc {
        kind: RigidBody::Static,
        ..BodyDesc::dynamic(shape, at)
    })
}

/// An iron ball on its way.
fn ball(radius: f32, at: Vec3, velocity: Vec3) -> Result<BodyDesc, support::Error> {
    let shape = ConvexMesh::icosphere(radius, 2)?;
    Ok(BodyDesc {
        density: 7800.0,
        linear_velocity: velocity,
        ..BodyDesc::dynamic(shape, at)
    })
}

/// A wall on the ground, which holds it, and a ball through its upper half.
fn wall() -> Result<Simulation, support::Error> {
    let wall = BodyDesc {
        density: 1900.0,
        fracturable: Some(Fracturable {
            strength: 200.0,
            pattern: FracturePattern::Voronoi {
                cells: 60,
                focus: 0.6,
            },
            generations: 0,
            ..Fracturable::default()
        }),
        ..standing(Vec3::new(3.6, 2.2, 0.25), 1.1 * Vec3::Y)?
    };
    on_floor([
        wall,
        ball(0.15, Vec3::new(0.4, 1.4, 3.0), Vec3::new(0.0, 0.0, -24.0))?,
    ])
}

/// A pane in a frame of four bars: what touches a bar stays in it.
fn pane() -> Result<Simulation, support::Error> {
    let at = 1.2 * Vec3::Y;
    let pane = BodyDesc {
        density: 2500.0,
        fracturable: Some(Fracturable {
            strength: 5.0,
            pattern: FracturePattern::Radial { rays: 16, rings: 6 },
            generations: 0,
            ..Fracturable::default()
        }),
        ..standing(Vec3::new(2.0, 2.0, 0.02), at)?
    };
    let across = Vec3::new(2.3, 0.15, 0.15);
    let up = Vec3::new(0.15, 2.0, 0.15);
    on_floor([
        pane,
        standing(across, at + 1.075 * Vec3::Y)?,
        standing(across, at - 1.075 * Vec3::Y)?,
        standing(up, at + 1.075 * Vec3::X)?,
        standing(up, at - 1.075 * Vec3::X)?,
        ball(0.1, Vec3::new(0.2, 1.3, 2.0), Vec3::new(0.0, 0.0, -15.0))?,
    ])
}

/// A bridge on two posts that are set into the ground, under a falling weight: what lies on a post stays.
fn bridge() -> Result<Simulation, support::Error> {
    let deck = BodyDesc {
        density: 2400.0,
        fracturable: Some(Fracturable {
            strength: 500.0,
            pattern: FracturePattern::Voronoi {
                cells: 40,
                focus: 0.6,
            },
            generations: 0,
            ..Fracturable::default()
        }),
        ..standing(Vec3::new(4.4, 0.25, 1.2), 1.425 * Vec3::Y)?
    };
    let post = Vec3::new(0.4, 1.8, 1.2);
    on_floor([
        deck,
        standing(post, Vec3::new(-1.8, 0.4, 0.0))?,
        standing(post, Vec3::new(1.8, 0.4, 0.0))?,
        ball(0.25, Vec3::new(0.1, 2.3, 0.0), Vec3::new(0.0, -9.0, 0.0))?,
    ])
}
