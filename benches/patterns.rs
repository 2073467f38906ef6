//! Cutting general meshes and breaking bodies into many pieces. `cargo bench --bench patterns`; `cargo test` runs each
//! once.
#![allow(
    missing_docs,
    reason = "criterion's macros make undocumented functions"
)]

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/dice/mod.rs"]
mod dice;

use bevy_cleave::prelude::*;
use bevy_cleave::slice::{SliceOptions, slice_mesh};
use common::model_mesh;
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use dice::Dice;
use std::hint::black_box;

/// Planes of a sample: a cut through the middle and one that takes off a tip cost differently.
const PLANES: usize = 64;

/// Cuts of a general mesh by random planes through it; time per cut.
fn mesh_cuts(c: &mut Criterion) {
    let sphere = ConvexMesh::icosphere(0.5, 3).expect("valid size");
    let meshes = [
        ("crate", model_mesh("crate.obj")),
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
        group.bench_function(BenchmarkId::from_parameter(name), |b| {
            b.iter(|| {
                next = (next + 1) % PLANES;
                slice_mesh(black_box(mesh), planes[next], SliceOptions::default())
            });
        });
    }
}

criterion_group!(benches, mesh_cuts);
criterion_main!(benches);
