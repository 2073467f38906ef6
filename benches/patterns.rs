//! Cutting general meshes and breaking bodies into many pieces. `cargo bench --bench patterns`; `cargo test` runs each
//! once.
#![allow(
    missing_docs,
    reason = "criterion's macros make undocumented functions"
)]
#![allow(
    clippy::disallowed_methods,
    reason = "shapes of benches may differ in the last bit between platforms"
)]

#[path = "../tests/common/dice.rs"]
mod dice;
#[path = "../tests/it/models.rs"]
mod models;

use bevy_cleave::prelude::*;
use bevy_cleave::slice::{
    Cutting, Halves, HullSlicer, Impact, MeshSlicer, PieceCutter, SliceOptions, slice_mesh,
};
use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use dice::Dice;
use glam::Vec3;
use models::model_mesh;
use std::hint::black_box;

/// Planes of a sample: a cut through the middle and one that takes off a tip cost differently.
const PLANES: usize = 64;

/// A torus about the y axis of so many quadrilaterals, each two triangles.
fn torus(around: u32, across: u32) -> TriMesh {
    let turn = |i: u32, n: u32| std::f32::consts::TAU * i as f32 / n as f32;
    let corners = (0..around).flat_map(|i| (0..across).map(move |k| (i, k)));
    let positions = corners.clone().map(|(i, k)| {
        let ((sin, cos), (height, out)) = (turn(i, around).sin_cos(), turn(k, across).sin_cos());
        let radius = 1.0 + 0.4 * out;
        Vec3::new(radius * cos, 0.4 * height, radius * sin)
    });
    let vertex = |i: u32, k: u32| i % around * across + k % across;
    let triangles = corners.flat_map(|(i, k)| {
        let [a, b] = [vertex(i, k), vertex(i, k + 1)];
        let [c, d] = [vertex(i + 1, k + 1), vertex(i + 1, k)];
        [[a, b, c], [a, c, d]]
    });
    TriMesh::new(positions.collect(), triangles.collect()).expect("finite")
}

/// Cuts of a general mesh by random planes through it; time per cut. The first cut of a mesh also finds out that it is
/// closed; later ones know.
fn mesh_cuts(c: &mut Criterion) {
    let sphere = ConvexMesh::icosphere(0.5, 3).expect("valid size");
    let meshes = [
        ("crate", model_mesh("crate.obj")),
        ("torus", torus(60, 40)),
        ("spot", model_mesh("spot.obj")),
        ("scorpion", model_mesh("scorpion.obj")),
        ("ico1280", sphere.hull().to_mesh()),
    ];
    let mut group = c.benchmark_group("slice_mesh");
    for (name, mesh) in &meshes {
        let mut dice = Dice::new(1);
        let planes: Vec<Plane> = (0..PLANES)
            .map(|_| dice.plane_through(mesh.positions()))
            .collect();
        let mut next = 0;
        let mut plane = || {
            next = (next + 1) % PLANES;
            planes[next]
        };
        let options = SliceOptions::default();
        group.bench_function(BenchmarkId::new("first", name), |b| {
            let fresh = || TriMesh::new(mesh.positions().to_vec(), mesh.triangles().to_vec());
            let fresh = || (fresh().expect("as before"), plane());
            let slice = |(mesh, plane)| (slice_mesh(&mesh, plane, options), mesh);
            b.iter_batched(fresh, slice, BatchSize::SmallInput);
        });
        let (mut slicer, mut halves) = (MeshSlicer::default(), Halves::default());
        group.bench_function(BenchmarkId::new("again", name), |b| {
            b.iter(|| slicer.slice_into(black_box(mesh), plane(), options, &mut halves));
        });
    }
}

/// Voronoi cells of a cube in one batch, and the same cells made by cuts one after the other: for each cell the cube is
/// cut by the bisectors with all other points, and the near part kept.
fn voronoi(c: &mut Criterion) {
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    let impact = Impact {
        point: Vec3::new(0.5, 0.0, 0.0),
        normal: Vec3::NEG_X,
        impulse: 1.0,
        energy: 1.0,
    };
    let mut group = c.benchmark_group("voronoi");
    for cells in [20, 100] {
        let pattern = FracturePattern::Voronoi { cells, focus: 0.5 };
        let cutting = pattern.cutting(&impact, cube.hull(), 1, u32::MAX);
        let Some(Cutting::Sites(sites)) = cutting else {
            continue;
        };
        let mut cutter = PieceCutter::default();
        let cutting = Cutting::Sites(sites.clone());
        let options = SliceOptions::default();
        group.bench_function(BenchmarkId::new("batch", cells), |b| {
            b.iter(|| cutter.cut(black_box(cube.hull()), None, &cutting, usize::MAX, options));
        });
        let mut slicer = HullSlicer::default();
        group.bench_function(BenchmarkId::new("one_by_one", cells), |b| {
            b.iter(|| {
                let cells = sites.iter().map(|&site| {
                    let mut cell = black_box(cube.hull()).clone();
                    for &other in sites.iter().filter(|&&other| other != site) {
                        let plane = Plane::through(0.5 * (site + other), other - site);
                        let slice = slicer.slice(&cell, plane).expect("usable plane");
                        if let Some(halves) = slice.halves() {
                            cell = halves.below;
                        }
                    }
                    cell
                });
                cells.collect::<Vec<_>>()
            });
        });
    }
}

/// A mesh of 28 800 triangles in 50 cells, with the mesh.
fn large_mesh(c: &mut Criterion) {
    let mesh = torus(120, 120);
    let shape = ConvexMesh::from_points(mesh.positions()).expect("solid");
    let impact = Impact {
        point: Vec3::X,
        normal: Vec3::NEG_X,
        impulse: 1.0,
        energy: 1.0,
    };
    let pattern = FracturePattern::Voronoi {
        cells: 50,
        focus: 0.0,
    };
    let Some(cutting) = pattern.cutting(&impact, shape.hull(), 1, u32::MAX) else {
        return;
    };
    let (mut cutter, options) = (PieceCutter::default(), SliceOptions::default());
    c.bench_function("voronoi/large_mesh", |b| {
        b.iter(|| {
            let mesh = Some(black_box(&mesh));
            cutter.cut(shape.hull(), mesh, &cutting, usize::MAX, options)
        });
    });
}

criterion_group!(benches, mesh_cuts, voronoi, large_mesh);
criterion_main!(benches);
