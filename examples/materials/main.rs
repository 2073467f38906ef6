//! Glass, brick, wood, stone and concrete from the parameters of this crate; `docs/materials.md` explains them.
//!
//! `cargo run --release --example materials` breaks each, prints what came of it as `name: value` lines, and writes one
//! picture of each, before and after, to `target/materials/`; with `-- --publish` to `docs/`.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "an example prints what it shows"
)]

#[path = "../support/mod.rs"]
mod support;

mod concrete;
mod recipes;
mod scenes;

use glam::Vec3;
use scenes::Demo;
use std::path::Path;
use std::process::ExitCode;
use support::Error;
use support::picture::{Picture, contact_sheet};
use support::render::{Camera, Scene};

const H: f32 = 1.0 / 60.0;

fn main() -> ExitCode {
    let is_published = std::env::args().any(|argument| argument == "--publish");
    let (folder, prefix) = if is_published {
        ("docs", "material_")
    } else {
        ("target/materials", "")
    };
    for scene in [
        scenes::glass,
        scenes::brick,
        scenes::wood,
        scenes::stone,
        scenes::concrete,
    ] {
        let show = |demo: Demo| {
            let path = Path::new(folder).join(format!("{prefix}{}.png", demo.name));
            show(demo)?.save(path)
        };
        if let Err(error) = scene().and_then(show) {
            eprintln!("materials: {error}");
            return ExitCode::FAILURE;
        }
    }
    println!("pictures: {folder}/");
    ExitCode::SUCCESS
}

/// Runs a scene; its pictures side by side.
fn show(mut demo: Demo) -> Result<Picture, Error> {
    let (mut fractures, mut energy, mut broken) = (0, 0.0, 0);
    let mut pictures = Vec::new();
    let bonds = demo.simulation.bonds.len();
    for step in 1..=demo.shown[1] {
        demo.simulation.step(H);
        broken += demo.simulation.bonds.broken.len();
        for fracture in &demo.simulation.fractures.done {
            let color = demo.colors[fracture.parent_slot as usize];
            for &piece in &fracture.pieces {
                let needed = demo.colors.len().max(piece as usize + 1);
                demo.colors.resize(needed, color);
                demo.colors[piece as usize] = color;
            }
            energy += fracture.blow.map_or(0.0, |blow| blow.borne_energy());
        }
        fractures += demo.simulation.fractures.done.len();
        if demo.shown.contains(&step) {
            let label = format!("{:.2} s", step as f32 * H);
            pictures.push((label, draw(&demo)));
        }
    }
    println!("{}:", demo.name);
    println!("  bodies: {}", demo.simulation.bodies.len());
    println!("  fractures: {fractures}");
    println!("  energy_that_breaking_took_J: {energy:.1}");
    println!("  bonds: {bonds}");
    println!("  bonds_broken: {broken}");
    Ok(contact_sheet(&pictures, 2, 2))
}

fn draw(demo: &Demo) -> Picture {
    let bodies = &demo.simulation.bodies;
    let mut scene = Scene::default();
    for slot in bodies.iter() {
        let (color, pose) = (demo.colors[slot as usize], bodies.pose(slot));
        if let Some(mesh) = bodies.convex(slot) {
            scene.draw(&mesh.render_mesh(), pose, color);
        }
        if let Some(compound) = bodies.compound(slot) {
            scene.draw(&compound.render_mesh(), pose, color);
        }
    }
    let camera = Camera::look_at(demo.eye, demo.target, Vec3::Y, 40.0, 800, 560);
    scene.render(&camera)
}
