//! Time of each kernel and system, and of the whole step. `cargo bench`; `cargo test` runs each once.

#[path = "../tests/scenes/mod.rs"]
mod scenes;

use bevy_cleave::contact::broadphase::{Broadphase, Proxy, ProxyKind, ProxyShape};
use bevy_cleave::contact::sat::{NarrowScratch, collide_half_space, collide_hulls};
use bevy_cleave::prelude::*;
use bevy_cleave::slice::{SliceOptions, slice_hull, slice_mesh};
use bevy_cleave::solver::{integrate, pgs};
use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use glam::{Quat, Vec3};
use scenes::{pile, random_points};
use std::hint::black_box;
use std::time::Duration;

const H: f32 = 1.0 / 60.0;

fn sphere(subdivisions: u32) -> ConvexMesh {
    ConvexMesh::icosphere(0.5, subdivisions).expect("valid size")
}

fn hull_build(c: &mut Criterion) {
    let mut group = c.benchmark_group("hull_build");
    for count in [8, 32, 128, 1024] {
        let points = random_points(count, 1);
        group.bench_with_input(BenchmarkId::from_parameter(count), &points, |b, points| {
            b.iter(|| ConvexHull::from_points(black_box(points)));
        });
    }
}

fn mass(c: &mut Criterion) {
    let mut group = c.benchmark_group("mass_properties");
    for subdivisions in [0, 2, 3] {
        let mesh = sphere(subdivisions);
        let faces = mesh.hull().faces().len();
        group.bench_with_input(
            BenchmarkId::from_parameter(faces),
            mesh.hull(),
            |b, hull| {
                b.iter(|| MassProperties::of_hull(black_box(hull), 1000.0));
            },
        );
    }
}

fn slice(c: &mut Criterion) {
    let plane = Plane::through(Vec3::splat(0.01), Vec3::new(0.3, 1.0, 0.2));
    let cuboid = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    let shapes = [
        ("cube", cuboid),
        ("ico320", sphere(2)),
        ("ico1280", sphere(3)),
    ];
    let mut group = c.benchmark_group("slice");
    for (name, shape) in &shapes {
        group.bench_function(BenchmarkId::new("hull", name), |b| {
            b.iter(|| slice_hull(black_box(shape.hull()), plane));
        });
        let mesh = shape.hull().to_mesh();
        group.bench_function(BenchmarkId::new("mesh", name), |b| {
            b.iter(|| slice_mesh(black_box(&mesh), plane, SliceOptions::default()));
        });
    }
}

fn broadphase(c: &mut Criterion) {
    let mut group = c.benchmark_group("broadphase");
    for count in [100, 1000, 5000_u32] {
        let side = (count as f32).cbrt();
        let centres = random_points(count as usize, 2)
            .into_iter()
            .map(|p| 0.5 * p * side);
        let proxies: Vec<_> = centres
            .zip(0..)
            .map(|(p, id)| {
                Some(Proxy {
                    id: BodyId(id),
                    kind: ProxyKind::Moving,
                    layers: CollisionLayers::default(),
                    shape: ProxyShape::Box(Aabb {
                        min: p - 0.5,
                        max: p + 0.5,
                    }),
                })
            })
            .collect();
        let mut moved = proxies.clone();
        for proxy in moved.iter_mut().flatten().step_by(10) {
            if let ProxyShape::Box(aabb) = &mut proxy.shape {
                *aabb = Aabb {
                    min: aabb.min + 0.2,
                    max: aabb.max + 0.2,
                };
            }
        }
        // A tenth of the bodies leaves its box, there and back again.
        let mut broadphase = Broadphase::new();
        let mut flip = false;
        group.bench_function(BenchmarkId::from_parameter(count), |b| {
            b.iter(|| {
                broadphase.update(if flip { &moved } else { &proxies }, 0.1);
                flip = !flip;
                broadphase.pairs().len()
            });
        });
    }
}

fn manifold(c: &mut Criterion) {
    let mut group = c.benchmark_group("manifold");
    let mut scratch = NarrowScratch::new();
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    let above = Pose::new(Vec3::new(0.1, 0.995, 0.05), Quat::from_rotation_y(0.3));
    for (name, a, b) in [("cubes", &cube, &cube), ("ico320", &sphere(2), &sphere(2))] {
        group.bench_function(name, |bench| {
            bench.iter(|| collide_hulls(a.hull(), b.hull(), black_box(above), 0.02, &mut scratch));
        });
    }
    let plane = Plane {
        normal: Vec3::Y,
        offset: -0.495,
    };
    group.bench_function("half_space", |bench| {
        let pose = Pose::new(Vec3::new(0.0, -0.495, 0.0), Quat::IDENTITY);
        bench.iter(|| collide_half_space(cube.hull(), black_box(plane), pose, 0.02, &mut scratch));
    });
}

fn solve(c: &mut Criterion) {
    let mut group = c.benchmark_group("solve_16_sweeps");
    for count in [100, 1000] {
        let simulation = settled(count);
        let bodies = simulation.bodies.solver_bodies();
        let rows = simulation.contacts.rows();
        group.throughput(criterion::Throughput::Elements(16 * 3 * rows.len() as u64));
        group.bench_function(BenchmarkId::from_parameter(count), |b| {
            b.iter_batched_ref(
                || (rows.to_vec(), bodies.to_vec()),
                |(rows, bodies)| pgs::solve(rows, bodies, &simulation.config),
                BatchSize::LargeInput,
            );
        });
    }
}

fn integrate_positions(c: &mut Criterion) {
    let mut simulation = settled(1000);
    c.bench_function("integrate/1000", |b| {
        let mut problems = Vec::new();
        b.iter(|| integrate::integrate_positions(&mut simulation.bodies, &mut problems, 1e-9));
    });
}

fn whole_step(c: &mut Criterion) {
    let mut group = c.benchmark_group("step");
    group.sample_size(10);
    for count in [100, 1000, 5000] {
        let mut simulation = settled(count);
        group.bench_function(BenchmarkId::from_parameter(count), |b| {
            b.iter(|| simulation.step(H))
        });
    }
}

/// A pile of `count` bodies that has come down; fewer steps in a test run, where nobody reads the time.
fn settled(count: usize) -> Simulation {
    let mut simulation = pile(count);
    let steps = if cfg!(debug_assertions) { 5 } else { 120 };
    for _ in 0..steps {
        simulation.step(H);
    }
    simulation
}

criterion_group! {
    name = kernels;
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2));
    targets = hull_build, mass, slice, broadphase, manifold, solve, integrate_positions, whole_step
}
criterion_main!(kernels);
