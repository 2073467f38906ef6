//! Breaks a block by every fracture pattern and shows the pieces, moved apart a little.
//!
//! `cargo run --release --example patterns` prints the number of pieces, their volumes and the area of the cracks as
//! `name: value` lines, and writes one contact sheet to `target/patterns/contact_sheet.png`. The impact is on the face to
//! the right, a little above its middle, and goes to the left.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "an example prints what it shows"
)]

#[path = "support/mod.rs"]
mod support;

use bevy_cleave::prelude::*;
use bevy_cleave::slice::{Impact, Piece, PieceCutter, SliceOptions, cells_for_energy};
use glam::{Quat, Vec3};
use std::process::ExitCode;
use support::picture::{Picture, contact_sheet};
use support::render::{Camera, Scene, palette};

const PICTURE: &str = "target/patterns/contact_sheet.png";
/// Edges of the block, m.
const SIZE: Vec3 = Vec3::new(1.2, 1.6, 2.0);
/// How far pieces move from the middle, as a fraction of how far away they are.
const APART: f32 = 0.22;
/// Of concrete, J per m2 of crack.
const TOUGHNESS: f64 = 100.0;

fn main() -> ExitCode {
    match patterns() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("patterns: {error}");
            ExitCode::FAILURE
        }
    }
}

fn patterns() -> Result<(), support::Error> {
    let block = ConvexMesh::cuboid(SIZE.x, SIZE.y, SIZE.z)?;
    let impact = Impact {
        point: Vec3::new(0.5 * SIZE.x, 0.15, 0.2),
        normal: Vec3::NEG_X,
        impulse: 1000.0,
        energy: 2000.0,
    };
    let mut pictures = Vec::new();
    for (name, pattern) in all_patterns() {
        let pieces = pieces_of(&block, &pattern, &impact, 1000)?;
        report(&name, block.hull(), &pieces);
        pictures.push((format!("{name}: {} pieces", pieces.len()), draw(&pieces)));
    }
    let fine = FracturePattern::Voronoi {
        cells: 1000,
        focus: 0.5,
    };
    for energy in [300.0, 600.0, 1200.0, 2400.0] {
        let most = cells_for_energy(energy, TOUGHNESS, block.hull());
        let pieces = pieces_of(&block, &fine, &impact, most)?;
        report(&format!("Voronoi, {energy} J"), block.hull(), &pieces);
        let label = format!("{energy} J at {TOUGHNESS} J/m2: {} pieces", pieces.len());
        pictures.push((label, draw(&pieces)));
    }
    contact_sheet(&pictures, 4, 2).save(PICTURE)?;
    println!("picture: {PICTURE}");
    Ok(())
}

fn all_patterns() -> [(String, FracturePattern); 8] {
    let diagonal = Plane::through(Vec3::ZERO, Vec3::new(0.0, 1.0, 1.0));
    let level = Plane::through(Vec3::new(0.0, 0.3, 0.0), Vec3::Y);
    [
        ("Single plane", FracturePattern::SinglePlane),
        ("Star, 4 planes", FracturePattern::Star { planes: 4 }),
        (
            "Radial, 11 rays, 3 rings",
            FracturePattern::Radial { rays: 11, rings: 3 },
        ),
        (
            "Voronoi, 60 cells",
            FracturePattern::Voronoi {
                cells: 60,
                focus: 0.0,
            },
        ),
        (
            "Voronoi, focus 0.9",
            FracturePattern::Voronoi {
                cells: 150,
                focus: 0.9,
            },
        ),
        ("Slabs", FracturePattern::Slabs { count: 7 }),
        (
            "Brick",
            FracturePattern::Brick {
                size: Vec3::new(0.6, 0.2, 0.4),
            },
        ),
        ("Own planes", FracturePattern::Planes(vec![diagonal, level])),
    ]
    .map(|(name, pattern)| (name.to_owned(), pattern))
}

fn pieces_of(
    block: &ConvexMesh,
    pattern: &FracturePattern,
    impact: &Impact,
    most: u32,
) -> Result<Vec<Piece>, support::Error> {
    let cutting = pattern
        .cutting(impact, block.hull(), 4, most)
        .ok_or("the block does not break")?;
    let mut cutter = PieceCutter::default();
    let options = SliceOptions::default();
    Ok(cutter.cut(block.hull(), None, &cutting, most as usize, options)?)
}

fn report(name: &str, hull: &ConvexHull, pieces: &[Piece]) {
    let area = |hull: &ConvexHull| hull.to_mesh().area();
    let volume: f64 = pieces.iter().map(|piece| piece.volume).sum();
    let all: f64 = pieces.iter().map(|piece| area(&piece.hull)).sum();
    let least = pieces.iter().map(|p| p.volume).fold(f64::MAX, f64::min);
    let greatest = pieces.iter().map(|p| p.volume).fold(0.0, f64::max);
    println!("{name}:");
    println!("  pieces: {}", pieces.len());
    println!("  volume_error_rel: {:.1e}", volume / hull.volume() - 1.0);
    println!("  volume_least_m3: {least:.2e}");
    println!("  volume_greatest_m3: {greatest:.2e}");
    println!("  crack_area_m2: {:.2}", 0.5 * (all - area(hull)));
}

/// The pieces in colors of their own, each moved away from the middle of the block.
fn draw(pieces: &[Piece]) -> Picture {
    let mut scene = Scene::default();
    for (index, piece) in pieces.iter().enumerate() {
        let away = APART * piece.hull.aabb().center();
        let up = 0.5 * (1.0 + APART) * SIZE.y;
        let pose = Pose::new(away + up * Vec3::Y, Quat::IDENTITY);
        scene.draw(&piece.hull.to_mesh(), pose, palette(index));
    }
    let (eye, target) = (Vec3::new(4.6, 3.2, 3.0), Vec3::new(0.0, 0.85, 0.0));
    scene.render(&Camera::look_at(eye, target, Vec3::Y, 38.0, 800, 640))
}
