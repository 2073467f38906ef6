//! How far the paper's three approximations are from the exact mass integrals.
//!
//! Look at: the column `centre` (mean of the vertices as centre of mass, error relative to the box's diagonal),
//! `particles` (vertices as equal masses, about the exact centre) and `diagonal` (products of inertia dropped), the
//! latter two as the norm of the tensor's error relative to the norm of the exact tensor.
//!
//! `cargo run --release --example mass_accuracy`

#![allow(clippy::print_stdout, reason = "an example prints its result")]

use bevy_cleave::geometry::ConvexHull;
use bevy_cleave::mass::{VolumeIntegrals, approximate, principal_axes};
use bevy_cleave::math::Plane;
use bevy_cleave::slice::{HullHalves, slice_hull};
use glam::{DMat3, Vec3};
use std::error::Error;
use std::path::{Path, PathBuf};

/// Pieces in the statistics.
const PIECES: usize = 1000;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/meshes");
    let mut models: Vec<PathBuf> = std::fs::read_dir(folder)?
        .map(|e| Ok(e?.path()))
        .collect::<Result<_, std::io::Error>>()?;
    models.retain(|path| path.extension().is_some_and(|extension| extension == "obj"));
    models.sort();

    println!(
        "Exact integrals of the models' hulls (volume m3, centre m, principal moments at unit density m5),"
    );
    println!("and the errors of the approximations in percent:\n");
    println!(
        "{:<16} {:>10} {:^26} {:^32} {:>7} {:>9} {:>8}",
        "hull of", "volume", "centre", "principal moments", "centre", "particles", "diagonal"
    );
    let mut hulls = Vec::new();
    for path in models {
        let hull = ConvexHull::from_points(&positions(&path)?)?;
        let exact = VolumeIntegrals::of_hull(&hull);
        let [x, y, z] = exact.centroid.to_array();
        let [p, q, r] = principal_axes(exact.inertia).0.to_array();
        let [centre, particles, diagonal] = errors(&hull, &exact).map(|error| 100.0 * error);
        println!(
            "{:<16} {:>10.5} {x:>8.3} {y:>8.3} {z:>8.3} {p:>10.3e} {q:>10.3e} {r:>10.3e} {centre:>7.2} {particles:>9.1} {diagonal:>8.2}",
            path.file_name().unwrap_or_default().to_string_lossy(),
            exact.volume,
        );
        hulls.push(hull);
    }

    let mut random = Random(1);
    let mut found = Vec::with_capacity(PIECES);
    while found.len() < PIECES {
        let whole = &hulls[found.len() % hulls.len()];
        if let Some(piece) = random_piece(whole, &mut random) {
            found.push(errors(&piece, &VolumeIntegrals::of_hull(&piece)));
        }
    }
    println!(
        "\n{PIECES} random pieces of these hulls, each left over after one to three cuts; percent:\n"
    );
    println!("{:<10} {:>8} {:>8} {:>8}", "", "median", "95 %", "max");
    for (column, name) in ["centre", "particles", "diagonal"].into_iter().enumerate() {
        let mut values: Vec<f64> = found.iter().map(|row| 100.0 * row[column]).collect();
        values.sort_by(f64::total_cmp);
        let [median, p95, max] =
            [PIECES / 2, PIECES * 95 / 100, PIECES - 1].map(|rank| values[rank]);
        println!("{name:<10} {median:>8.2} {p95:>8.2} {max:>8.2}");
    }
    Ok(())
}

/// Relative errors of the three approximations.
fn errors(hull: &ConvexHull, exact: &VolumeIntegrals) -> [f64; 3] {
    let size = f64::from(hull.aabb().diagonal());
    let norm = |m: DMat3| m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
    let relative = |approximate: DMat3| norm(approximate - exact.inertia) / norm(exact.inertia);
    let mean = approximate::mean_of_vertices(hull.vertices());
    let particles =
        approximate::vertices_as_particles(hull.vertices(), exact.volume, exact.centroid);
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
        let plane = Plane::through(aabb.centre() + aabb.extents() * inside, normal);
        let HullHalves { below, above } = slice_hull(&piece, plane).ok()?.halves()?;
        piece = if random.signed() < 0.0 { below } else { above };
    }
    Some(piece)
}

fn positions(path: &Path) -> Result<Vec<Vec3>, Box<dyn Error>> {
    let (models, _) = tobj::load_obj(path, &tobj::LoadOptions::default())?;
    let coordinates = models
        .iter()
        .flat_map(|model| model.mesh.positions.chunks_exact(3));
    Ok(coordinates.map(Vec3::from_slice).collect())
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
