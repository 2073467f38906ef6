//! Bodies of several convex parts: chairs at a table, a cup that holds a ball, an arch, and the letter that a mesh was decomposed into. Then
//! the table is cut.
//!
//! `cargo run --release --example furniture` prints what happened as `name: value` lines and writes a picture to
//! `target/furniture/furniture.png`. Look for the ball in the cup, and for what the cut leaves of the table. The last line says what a wall of 500
//! bricks in one body costs, as a share of what a box in its place costs.
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
use std::time::Instant;
use support::picture::{Picture, contact_sheet};
use support::render::{Camera, Scene};

const H: f32 = 1.0 / 60.0;

fn main() -> ExitCode {
    match show() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("furniture: {error}");
            ExitCode::FAILURE
        }
    }
}

type Part = (Pose, ConvexMesh);

/// A box of `size` whose middle is at a place, m.
fn brick(size: Vec3, at: Vec3) -> Result<Part, HullError> {
    let shape = ConvexMesh::cuboid(size.x, size.y, size.z)?;
    Ok((Pose::from_position(at), shape))
}

/// A plate and four legs below its corners.
fn on_legs(plate: Vec3, height: f32, leg: f32) -> Result<Vec<Part>, HullError> {
    let mut parts = vec![brick(plate, (height - 0.5 * plate.y) * Vec3::Y)?];
    let length = height - plate.y;
    for [x, z] in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
        let corner = 0.5 * (plate - leg) * Vec3::new(x, 0.0, z);
        let at = corner + 0.5 * length * Vec3::Y;
        parts.push(brick(Vec3::new(leg, length, leg), at)?);
    }
    Ok(parts)
}

fn chair() -> Result<Compound, support::Error> {
    let mut parts = on_legs(Vec3::new(0.45, 0.04, 0.45), 0.46, 0.04)?;
    parts.push(brick(
        Vec3::new(0.03, 0.5, 0.45),
        Vec3::new(-0.21, 0.71, 0.0),
    )?);
    Ok(Compound::new(parts)?)
}

/// A square cup with a bottom, open above.
fn cup() -> Result<Compound, support::Error> {
    let wall = 0.015;
    let mut parts = vec![brick(Vec3::new(0.24, wall, 0.24), 0.5 * wall * Vec3::Y)?];
    for side in [-1.0, 1.0] {
        let at = Vec3::new(0.1125 * side, 0.125, 0.0);
        parts.push(brick(Vec3::new(wall, 0.22, 0.24), at)?);
        let at = Vec3::new(0.0, 0.125, 0.1125 * side);
        parts.push(brick(Vec3::new(0.21, 0.22, wall), at)?);
    }
    Ok(Compound::new(parts)?)
}

fn arch() -> Result<Compound, support::Error> {
    Ok(Compound::new([
        brick(Vec3::new(0.2, 1.2, 0.3), Vec3::new(-0.5, 0.6, 0.0))?,
        brick(Vec3::new(0.2, 1.2, 0.3), Vec3::new(0.5, 0.6, 0.0))?,
        brick(Vec3::new(1.2, 0.2, 0.3), 1.3 * Vec3::Y)?,
    ])?)
}

/// A ring of round beads: parts need not be hulls.
fn ring() -> Result<Compound, support::Error> {
    let beads = (0..10).map(|i| {
        let turn = Quat::from_rotation_y(i as f32 * std::f32::consts::TAU / 10.0);
        let bead = ConvexMesh::capsule(0.05, 0.15)?;
        let lying = turn * Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
        Ok((Pose::new(turn * (0.28 * Vec3::X), lying), bead))
    });
    let beads = beads.collect::<Result<Vec<Part>, HullError>>()?;
    Ok(Compound::new(beads)?)
}

fn room() -> Result<(Simulation, [u32; 3]), support::Error> {
    let mut simulation = Simulation::default();
    let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    simulation.bodies.insert(floor)?;
    let table = Compound::new(on_legs(Vec3::new(1.4, 0.05, 0.8), 0.75, 0.06)?)?;
    let table = simulation
        .bodies
        .insert(BodyDesc::compound(table, Vec3::ZERO))?;
    for (at, turn) in [(-1.1, 0.0), (1.1, std::f32::consts::PI)] {
        let pose = Pose::new(at * Vec3::X, Quat::from_rotation_y(turn));
        simulation.bodies.insert(BodyDesc {
            pose,
            ..BodyDesc::compound(chair()?, Vec3::ZERO)
        })?;
    }
    let stand = Vec3::new(0.25, 0.76, 0.1);
    let vessel = simulation
        .bodies
        .insert(BodyDesc::compound(cup()?, stand))?;
    let ball = ConvexMesh::sphere(0.08)?;
    let ball = BodyDesc::dynamic(ball, stand + 0.5 * Vec3::Y);
    let ball = simulation.bodies.insert(ball)?;
    let behind = Vec3::new(0.0, 0.0, -1.4);
    simulation
        .bodies
        .insert(BodyDesc::compound(arch()?, behind))?;
    let thrown = BodyDesc::compound(ring()?, Vec3::new(-0.35, 1.3, 0.0));
    simulation.bodies.insert(thrown)?;
    Ok((simulation, [table, vessel, ball]))
}

fn run(simulation: &mut Simulation, seconds: f32) {
    for _ in 0..(seconds / H) as usize {
        simulation.step(H);
    }
}

fn show() -> Result<(), support::Error> {
    let (mut simulation, [table, vessel, ball]) = room()?;
    run(&mut simulation, 3.0);
    let inside = simulation
        .bodies
        .pose(vessel)
        .inverse_transform_point(simulation.bodies.center_of_mass(ball));
    let is_held = inside.x.abs().max(inside.z.abs()) < 0.1 && (0.0..0.24).contains(&inside.y);
    println!("ball in the cup: {is_held}");
    let before = picture(&simulation);
    let mass = simulation.bodies.mass(table).mass;
    println!("table: {mass:.1} kg in 5 parts");
    // Slanting, through two of the legs.
    let plane = Plane::through(
        Vec3::new(0.1, 0.0, 0.0),
        Vec3::new(1.0, -0.35, 0.0).normalize(),
    );
    simulation.slice(table, plane)?;
    simulation.step(H);
    for fracture in &simulation.fractures.done {
        let parts = |&slot: &u32| simulation.bodies.compound(slot).map_or(1, Compound::len);
        let parts: Vec<usize> = fracture.pieces.iter().map(parts).collect();
        println!("table cut: pieces of {parts:?} parts");
        println!(
            "table cut, mass off by: {:.0e}",
            fracture.ledger.mass_error()
        );
    }
    run(&mut simulation, 2.0);
    let pictures = [
        ("at rest".to_owned(), before),
        ("the table cut".to_owned(), picture(&simulation)),
    ];
    contact_sheet(&pictures, 1, 2).save("target/furniture/furniture.png")?;
    let [wall, whole] = [true, false].map(|is_bricks| settled(is_bricks).map(time_of_steps));
    println!(
        "500 bricks in one body, share of a box: {:.2}",
        wall? / whole?
    );
    Ok(())
}

fn picture(simulation: &Simulation) -> Picture {
    let bodies = &simulation.bodies;
    let mut scene = Scene::default();
    for slot in bodies.iter() {
        let color = match bodies.compound(slot).map(Compound::len) {
            Some(5) => Vec3::new(0.62, 0.42, 0.25),
            Some(6) => Vec3::new(0.35, 0.45, 0.6),
            Some(_) => Vec3::new(0.55, 0.55, 0.5),
            None => Vec3::new(0.75, 0.3, 0.2),
        };
        if let Some(compound) = bodies.compound(slot) {
            scene.draw(&compound.render_mesh(), bodies.pose(slot), color);
        }
        if let Some(mesh) = bodies.convex(slot) {
            scene.draw(&mesh.render_mesh(), bodies.pose(slot), color);
        }
    }
    let eye = Vec3::new(1.8, 1.9, 3.0);
    let camera = Camera::look_at(eye, Vec3::new(0.0, 0.5, -0.2), Vec3::Y, 40.0, 1280, 720);
    scene.render(&camera)
}

/// A wall 5 m wide and 2 m high with boxes that rest on its top, awake: of 500 bricks, or in one.
fn settled(is_bricks: bool) -> Result<Simulation, support::Error> {
    let mut simulation = Simulation {
        config: SolverConfig {
            sleep: SleepConfig::off(),
            ..SolverConfig::default()
        },
        ..Simulation::default()
    };
    let wall = if is_bricks {
        let bricks = (0..500).map(|i| {
            let at = Vec3::new(
                (i % 25) as f32 * 0.2 - 2.4,
                (i / 25) as f32 * 0.1 + 0.05,
                0.0,
            );
            brick(Vec3::new(0.2, 0.1, 0.4), at)
        });
        Shape::Compound(Compound::new(bricks.collect::<Result<Vec<_>, _>>()?)?)
    } else {
        let points =
            [-2.5, 2.5].map(|x| [0.0, 2.0].map(|y| [-0.2, 0.2].map(|z| Vec3::new(x, y, z))));
        Shape::Convex(ConvexMesh::from_points(
            points.as_flattened().as_flattened(),
        )?)
    };
    let wall = BodyDesc::new(RigidBody::Static, wall);
    simulation.bodies.insert(wall)?;
    let cube = ConvexMesh::cuboid(0.25, 0.25, 0.25)?;
    for i in 0..16 {
        let at = Vec3::new(i as f32 * 0.3 - 2.25, 2.13, 0.0);
        simulation
            .bodies
            .insert(BodyDesc::dynamic(cube.clone(), at))?;
    }
    run(&mut simulation, 3.0);
    Ok(simulation)
}

/// s.
fn time_of_steps(mut simulation: Simulation) -> f64 {
    let start = Instant::now();
    run(&mut simulation, 10.0);
    start.elapsed().as_secs_f64()
}
