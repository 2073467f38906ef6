//! Time per slice into two closed, capped halves: this crate beside parry, on the same meshes and planes.
//!
//! All take turns within a round, and the medians over the rounds of the thread's CPU time are printed: on a machine that
//! others use too, the ratios say more than the times.

#[path = "../../../tests/dice/mod.rs"]
mod dice;

use bevy_cleave::geometry::{ConvexHull, TriMesh, primitives};
use bevy_cleave::mass::VolumeIntegrals;
use bevy_cleave::math::Plane;
use bevy_cleave::slice::{HullHalves, HullSlicer, SliceOptions, slice_hull, slice_mesh};
use dice::Dice;
use glam::Vec3;
use parry3d::math::Vector;
use parry3d::query::SplitResult;
use parry3d::shape::{TriMesh as Parry, TriMeshFlags};
use std::hint::black_box;

/// Planes of a round.
const PLANES: usize = 200;

/// Rounds, of which the medians are taken.
const ROUNDS: usize = 15;

/// CPU time of the thread, s.
fn cpu_time() -> f64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the pointer is to a timespec that lives through the call.
    unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut time) };
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

fn spot() -> TriMesh {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/meshes/spot.obj");
    let text = std::fs::read_to_string(path).expect("the model is there");
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let numbers: Vec<f32> = words.take(3).map(|w| w.parse().expect("a number")).collect();
                positions.push(Vec3::from_slice(&numbers));
            }
            Some("f") => {
                let index = |word: &str| {
                    let number = word.split('/').next().expect("an index");
                    number.parse::<u32>().expect("an index") - 1
                };
                let corners: Vec<u32> = words.map(index).collect();
                triangles.extend(corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]]));
            }
            _ => {}
        }
    }
    TriMesh::new(positions, triangles).expect("a valid mesh")
}

fn parry_mesh(positions: &[Vec3], triangles: Vec<[u32; 3]>) -> Parry {
    let positions = positions.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
    Parry::with_flags(positions, triangles, TriMeshFlags::ORIENTED).expect("a valid mesh")
}

fn parry_split(mesh: &Parry, plane: &Plane) -> bool {
    let normal = Vector::new(plane.normal.x, plane.normal.y, plane.normal.z);
    let result = black_box(mesh.local_split(normal, plane.offset, 1e-6));
    matches!(result, SplitResult::Pair(..))
}

/// One way to slice.
struct Entry<'a> {
    name: &'static str,
    slice: Box<dyn FnMut(&Plane) + 'a>,
    times: Vec<f64>,
}

impl<'a> Entry<'a> {
    fn new(name: &'static str, slice: impl FnMut(&Plane) + 'a) -> Self {
        Self { name, slice: Box::new(slice), times: Vec::new() }
    }

    fn median(&mut self) -> f64 {
        self.times.sort_by(f64::total_cmp);
        self.times[self.times.len() / 2]
    }
}

/// Measures the entries in turn and prints a row for each; the last one is what the others are compared with.
fn compare(shape: &str, planes: &[Plane], mut entries: Vec<Entry>) {
    for _ in 0..=ROUNDS {
        for entry in &mut entries {
            let start = cpu_time();
            planes.iter().for_each(|plane| (entry.slice)(plane));
            entry.times.push((cpu_time() - start) / planes.len() as f64);
        }
    }
    // The first round fills memory and caches.
    entries.iter_mut().for_each(|entry| {
        entry.times.remove(0);
    });
    let parry = entries.last_mut().expect("parry").median();
    for entry in &mut entries {
        let time = entry.median();
        println!("| {shape} | {} | {:.2} | {:.1} |", entry.name, 1e6 * time, parry / time);
    }
}

fn compare_hull(shape: &str, hull: &ConvexHull) {
    let mut dice = Dice::new(1);
    let planes: Vec<Plane> = (0..PLANES).map(|_| dice.plane_through(hull.vertices())).collect();
    let (mut slicer, mut halves) = (HullSlicer::default(), HullHalves::copies_of(hull));
    let mesh = hull.to_mesh();
    let parry = parry_mesh(hull.vertices(), hull.triangles().collect());
    compare(
        shape,
        &planes,
        vec![
            Entry::new("`slice_into`: hulls, lanes and mass, kept memory", |&plane| {
                let _ = black_box(slicer.slice_into(black_box(hull), plane, &mut halves));
                black_box([&halves.below, &halves.above].map(VolumeIntegrals::of_hull));
            }),
            Entry::new("`slice_hull`: the same, new memory", |&plane| {
                let _ = black_box(slice_hull(black_box(hull), plane));
            }),
            Entry::new("`slice_mesh`: triangles with normals and texture coordinates", |&plane| {
                let _ = black_box(slice_mesh(black_box(&mesh), plane, SliceOptions::default()));
            }),
            Entry::new("parry3d 0.31, f32", |plane| {
                parry_split(black_box(&parry), plane);
            }),
        ],
    );
}

fn compare_mesh(shape: &str, mesh: &TriMesh) {
    let mut dice = Dice::new(2);
    let planes: Vec<Plane> = (0..PLANES).map(|_| dice.plane_through(mesh.positions())).collect();
    let parry = parry_mesh(mesh.positions(), mesh.triangles().to_vec());
    compare(
        shape,
        &planes,
        vec![
            Entry::new("`slice_mesh`", |&plane| {
                let _ = black_box(slice_mesh(black_box(mesh), plane, SliceOptions::default()));
            }),
            Entry::new("parry3d 0.31, f32, set-up in every slice", |plane| {
                let parry = parry_mesh(mesh.positions(), mesh.triangles().to_vec());
                parry_split(&parry, plane);
            }),
            Entry::new("parry3d 0.31, f32", |plane| {
                parry_split(black_box(&parry), plane);
            }),
        ],
    );
}

fn main() {
    println!("| mesh | slicer | us per slice | parry's time over it |\n|---|---|---|---|");
    let spot = spot();
    let hull_of_spot = ConvexHull::from_points(spot.positions()).expect("a valid hull");
    let shapes = [
        ("cube", primitives::cuboid(1.0, 1.0, 1.0).expect("valid sizes")),
        ("icosphere, 320 triangles", primitives::icosphere(0.5, 2).expect("valid sizes")),
        ("hull of spot, 606 triangles", hull_of_spot),
        ("icosphere, 1280 triangles", primitives::icosphere(0.5, 3).expect("valid sizes")),
    ];
    for (shape, hull) in &shapes {
        compare_hull(shape, hull);
    }
    compare_mesh("spot, 5856 triangles, not convex", &spot);
}
