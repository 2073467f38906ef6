//! How far the paper's three approximations are from the exact mass integrals.
//!
//! Look at: the column `center` (mean of the vertices as center of mass, error relative to the box's diagonal),
//! `particles` (vertices as equal masses, about the exact center) and `diagonal` (products of inertia dropped), the
//! latter two as the norm of the tensor's error relative to the norm of the exact tensor.
//!
//! `cargo run --release --example mass_accuracy`

#![allow(clippy::print_stdout, reason = "an example prints its result")]

#[path = "support/mod.rs"]
mod support;

use bevy_cleave::geometry::ConvexHull;
use bevy_cleave::mass::{VolumeIntegrals, principal_axes};
use bevy_cleave::math::{Aabb, Plane};
use bevy_cleave::slice::{HullHalves, slice_hull};
use bevy_cleave::testing::approximate;
use glam::{DMat3, Vec3};
use std::path::{Path, PathBuf};
use support::{Error, model, stats};

/// Pieces in the statistics.
const PIECES: usize = 1000;

fn main() -> Result<(), Error> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/meshes");
    println!("Exact integrals (volume m3, center m, principal moments at unit density m5),");
    println!("and the errors of the approximations in percent:\n");
    println!(
        "{:<22} {:>10} {:^26} {:^32} {:>7} {:>9} {:>8}",
        "", "volume", "center", "principal moments", "center", "particles", "diagonal"
    );
    let mut hulls = Vec::new();
    for path in models(&folder)? {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let mesh = model::into_mesh(model::load(&path)?)?;
        let hull = ConvexHull::from_points(mesh.positions())?;
        let exact = VolumeIntegrals::of_hull(&hull);
        print_row(&format!("{name} hull"), hull.vertices(), &exact);
        if mesh.is_closed() {
            let exact = VolumeIntegrals::of_mesh(&mesh);
            print_row(&format!("{name} mesh"), mesh.positions(), &exact);
        }
        hulls.push(hull);
    }
    let clouds = game_hulls(&folder)?;
    let found: Vec<_> = clouds.iter().map(errors_of_hull).collect();
    print_summary(&format!("{} hulls of a game", found.len()), &found);

    let mut random = Random(1);
    let mut found = Vec::with_capacity(PIECES);
    while found.len() < PIECES {
        let whole = &hulls[found.len() % hulls.len()];
        found.extend(
            random_piece(whole, &mut random)
                .as_ref()
                .map(errors_of_hull),
        );
    }
    let title = "random pieces of the models' hulls, left over after one to three cuts";
    print_summary(&format!("{PIECES} {title}"), &found);
    Ok(())
}

/// The OBJ files in `folder`, sorted.
fn models(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let entries = std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path()));
    let mut models = entries.collect::<Result<Vec<_>, std::io::Error>>()?;
    models.retain(|path| path.extension().is_some_and(|extension| extension == "obj"));
    models.sort();
    Ok(models)
}

/// The convex hulls of the clouds in the JSON file, without the two flat ones.
fn game_hulls(folder: &Path) -> Result<Vec<ConvexHull>, Error> {
    let text = std::fs::read_to_string(folder.join("horizon_hull_points.json"))?;
    let file: serde_json::Value = serde_json::from_str(&text)?;
    let clouds: Vec<Vec<[f32; 3]>> = serde_json::from_value(file["hulls"].clone())?;
    let hulls = clouds.iter().map(|cloud| {
        let points: Vec<Vec3> = cloud.iter().copied().map(Vec3::from_array).collect();
        ConvexHull::from_points(&points)
    });
    Ok(hulls.filter_map(Result::ok).collect())
}

fn print_row(name: &str, vertices: &[Vec3], exact: &VolumeIntegrals) {
    let [x, y, z] = exact.centroid.to_array();
    let [p, q, r] = principal_axes(exact.inertia).0.to_array();
    let [center, particles, diagonal] = errors(vertices, exact).map(|error| 100.0 * error);
    println!(
        "{name:<22} {:>10.5} {x:>8.3} {y:>8.3} {z:>8.3} {p:>10.3e} {q:>10.3e} {r:>10.3e} {center:>7.2} {particles:>9.1} {diagonal:>8.2}",
        exact.volume,
    );
}

fn print_summary(title: &str, found: &[[f64; 3]]) {
    println!("\n{title}; percent:\n");
    println!("{:<10} {:>8} {:>8} {:>8}", "", "median", "95 %", "max");
    for (column, name) in ["center", "particles", "diagonal"].into_iter().enumerate() {
        let values: Vec<f64> = found.iter().map(|row| 100.0 * row[column]).collect();
        let (median, p95) = (stats::median(&values), stats::percentile(&values, 0.95));
        println!(
            "{name:<10} {median:>8.2} {p95:>8.2} {:>8.2}",
            stats::max(&values)
        );
    }
}

fn errors_of_hull(hull: &ConvexHull) -> [f64; 3] {
    errors(hull.vertices(), &VolumeIntegrals::of_hull(hull))
}

/// Relative errors of the three approximations.
fn errors(vertices: &[Vec3], exact: &VolumeIntegrals) -> [f64; 3] {
    let size = f64::from(Aabb::of_points(vertices.iter().copied()).diagonal());
    let norm = |m: DMat3| m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
    let relative = |approximate: DMat3| norm(approximate - exact.inertia) / norm(exact.inertia);
    let mean = approximate::mean_of_vertices(vertices);
    let particles = approximate::vertices_as_particles(vertices, exact.volume, exact.centroid);
    [
        mean.distance(exact.centroid) / size,
        relative(particles),
        relative(approximate::off_diagonals_dropped(exact.inertia)),
    ]
}

/// Cuts `whole` by one to three random planes and goes on with either part after each; `None` if a plane misses.
fn random_piece(whole: &ConvexHull, random: &mut Random) -> Option<ConvexHull> {
    let mut piece = whole.clone();
    for _ in 0..1 + random.next() % 3 {
        let normal = Vec3::from_array([(); 3].map(|()| random.signed()));
        let inside = Vec3::from_array([(); 3].map(|()| 0.25 * random.signed()));
        let aabb = piece.aabb();
        let plane = Plane::through(aabb.center() + aabb.extents() * inside, normal);
        let HullHalves { below, above } = slice_hull(&piece, plane).ok()?.halves()?;
        piece = if random.signed() < 0.0 { below } else { above };
    }
    Some(piece)
}

/// SplitMix64 (Steele, Lea, Flood 2014): the pieces are the same on every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number between -1 and 1.
    fn signed(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1_u64 << 23) as f32 - 1.0
    }
}
