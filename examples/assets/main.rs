//! Models as artists make them, cut: what each needs, what is done about it, and what the pieces look like.
//!
//! `cargo run --release --features gltf,obj --example assets -- [MODELS]` takes .glb, .gltf and .obj files, or the open models of
//! `assets/meshes`. It prints the report of each import, cuts the result by 40 planes and checks that all halves are closed and
//! lose nothing, and writes pictures of the models broken in eight to `target/assets/contact_sheet.png`: new faces are light.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "an example prints what it shows"
)]

#[path = "../support/mod.rs"]
mod support;

use bevy_cleave::import::{Import, ImportOptions, Model, OpenParts};
use bevy_cleave::prelude::*;
use bevy_cleave::slice::{Cut, Cutting, PieceCutter, SliceOptions, slice_mesh};
use glam::{Quat, Vec3};
use std::path::Path;
use std::process::ExitCode;
use support::picture::{Picture, contact_sheet};
use support::render::{Camera, Scene, palette};

const PICTURE: &str = "target/assets/contact_sheet.png";
const OPEN_MODELS: [&str; 8] = [
    "assets/meshes/barrel.obj",
    "assets/meshes/floor_tile.obj",
    "assets/meshes/rubble.obj",
    "assets/meshes/wall_broken.obj",
    "assets/meshes/demosthenes.obj",
    "assets/meshes/building.obj",
    "assets/meshes/candle.obj",
    "assets/meshes/stairs.obj",
];
/// Cuts of each model.
const CUTS: u16 = 40;
/// Most pictures on the sheet.
const MOST_PICTURES: usize = 24;
/// How far pieces move from the middle, as a fraction of how far away they are.
const APART: f32 = 0.18;

fn main() -> ExitCode {
    match assets() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("assets: {error}");
            ExitCode::FAILURE
        }
    }
}

/// What is asked for when the default refuses a model.
fn on_request() -> ImportOptions {
    ImportOptions {
        max_fill: 1.0,
        open_parts: OpenParts::Thicken(0.01),
        ..ImportOptions::default()
    }
}

fn assets() -> Result<(), support::Error> {
    let mut paths: Vec<String> = std::env::args().skip(1).collect();
    if paths.is_empty() {
        paths = OPEN_MODELS.map(String::from).to_vec();
    }
    let (mut by_default, mut requested) = (0, 0);
    let mut pictures = Vec::new();
    for path in &paths {
        let model = match Model::load(path) {
            Ok(model) => model,
            Err(error) => {
                println!("{path}: {error}");
                continue;
            }
        };
        println!("{path}");
        let import = match model.import(&ImportOptions::default()) {
            Ok(import) => {
                by_default += 1;
                import
            }
            Err(error) => {
                println!("  by default: {error}");
                match model.import(&on_request()) {
                    Ok(import) => import,
                    Err(error) => {
                        println!("  on request: {error}");
                        continue;
                    }
                }
            }
        };
        requested += 1;
        for line in import.report.to_string().lines() {
            println!("  {line}");
        }
        check_cuts(&import.mesh)?;
        if pictures.len() < MOST_PICTURES {
            let name = Path::new(path).file_stem().unwrap_or_default();
            pictures.push((name.to_string_lossy().into_owned(), draw(&import)?));
        }
    }
    println!("models: {}", paths.len());
    println!("work by default: {by_default}");
    println!("work on request: {requested}");
    contact_sheet(&pictures, 4, 2).save(PICTURE)?;
    println!("picture: {PICTURE}");
    Ok(())
}

/// Cuts a mesh by planes in all directions; an error if a half is open or something is lost.
fn check_cuts(mesh: &TriMesh) -> Result<(), support::Error> {
    let (low, size) = (mesh.aabb().min, mesh.aabb().extents());
    // Steps by the golden ratio and its powers spread points and directions evenly.
    let spread = |index: u16, step: f32| (f32::from(index) * step).fract();
    for index in 0..CUTS {
        let place = [0.618_034, 0.754_878, 0.569_84].map(|step| spread(index, step));
        let normal = [0.819_173, 0.671_044, 0.549_7].map(|step| spread(index, step) - 0.5);
        let plane = Plane::through(low + size * Vec3::from(place), Vec3::from(normal));
        let Cut::Cut(halves) = slice_mesh(mesh, plane, SliceOptions::default())? else {
            continue;
        };
        for half in [&halves.below, &halves.above] {
            // As if nothing were known of it.
            half.clone().with_sheets(half.sheets())?.check_closed()?;
        }
        let sum = halves.below.volume() + halves.above.volume();
        if (sum - mesh.volume()).abs() > 1e-5 * mesh.volume() {
            return Err(format!("a cut makes {sum} m3 of {} m3", mesh.volume()).into());
        }
    }
    Ok(())
}

fn draw(import: &Import) -> Result<Picture, support::Error> {
    let shape = import.shape()?;
    let (aabb, mesh) = (shape.aabb(), shape.visual());
    let center = aabb.center();
    let normals = [
        Vec3::new(1.0, 0.2, 0.1),
        Vec3::new(-0.2, 1.0, 0.15),
        Vec3::new(0.1, -0.2, 1.0),
    ];
    let planes = normals.map(|normal| Plane::through(center, normal));
    let cutting = Cutting::Planes(planes.into_iter().collect());
    let options = SliceOptions {
        cap_color: Some(Vec3::splat(0.8).extend(1.0)),
        ..SliceOptions::default()
    };
    let pieces = PieceCutter::default().cut(shape.hull(), mesh, &cutting, usize::MAX, options)?;
    let mut scene = Scene::default();
    for (number, piece) in pieces.iter().enumerate() {
        let apart = APART * (piece.hull.aabb().center() - center);
        let lifted = apart - Vec3::new(center.x, aabb.min.y - 0.1 * aabb.extents().y, center.z);
        if let Some(mesh) = piece.visual.as_ref().filter(|m| !m.triangles().is_empty()) {
            scene.draw(mesh, Pose::new(lifted, Quat::IDENTITY), palette(number));
        }
    }
    let reach = aabb.diagonal();
    let eye = reach * Vec3::new(0.9, 0.8, 1.2);
    let target = Vec3::new(0.0, 0.5 * aabb.extents().y, 0.0);
    let camera = Camera::look_at(eye, target, Vec3::Y, 40.0, 640, 480);
    Ok(scene.render(&camera))
}
