//! Time of each kernel and system, and of the whole step. `cargo bench`; `cargo test` runs each once.

#[path = "../tests/common/mod.rs"]
mod common;

use bevy_app::{App, TaskPoolPlugin};
use bevy_cleave::contact::{NarrowScratch, collide_hulls};
use bevy_cleave::geometry::KdBox;
use bevy_cleave::prelude::*;
use bevy_cleave::slice::{
    HullHalves, HullSlicer, SliceOptions, cut_by_planes, slice_hull, slice_mesh,
};
use bevy_cleave::testing::batch::{ContactSolver, SubstepSettings};
use bevy_cleave::testing::bodies::integrate_positions;
use bevy_cleave::testing::contact::{Broadphase, Proxy, ProxyKind, ProxyShape, collide_half_space};
use bevy_cleave::testing::pgs;
use bevy_time::Time;
use common::scenes::{heap, pile, random_points};
use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use glam::{Quat, Vec3};
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
        let mut slicer = HullSlicer::default();
        let mut halves = HullHalves::copies_of(shape.hull());
        group.bench_function(BenchmarkId::new("hull_into", name), |b| {
            b.iter(|| slicer.slice_into(black_box(shape.hull()), plane, &mut halves));
        });
        let mesh = shape.hull().to_mesh();
        group.bench_function(BenchmarkId::new("mesh", name), |b| {
            b.iter(|| slice_mesh(black_box(&mesh), plane, SliceOptions::default()));
        });
    }
}

fn cut_by_three_planes(c: &mut Criterion) {
    let shape = sphere(2);
    let mesh = shape.hull().to_mesh();
    let normals = [
        Vec3::new(0.3, 1.0, 0.2),
        Vec3::new(1.0, -0.2, 0.1),
        Vec3::new(-0.1, 0.3, 1.0),
    ];
    let planes = normals.map(|normal| Plane::through(Vec3::splat(0.01), normal));
    c.bench_function("cut_by_planes/3/ico320", |b| {
        b.iter(|| {
            let (hull, options) = (black_box(shape.hull()), SliceOptions::default());
            cut_by_planes(hull, Some(&mesh), &planes, options)
        });
    });
}

fn broadphase(c: &mut Criterion) {
    let mut group = c.benchmark_group("broadphase");
    // Edges of cubes with one body per cubic metre, m.
    for (count, side) in [(100, 4.64), (1000, 10.0), (5000_u32, 17.1)] {
        let centers = random_points(count as usize, 2)
            .into_iter()
            .map(|p| 0.5 * p * side);
        let proxies: Vec<_> = centers
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

/// Warm start and storing of the contacts of a settled pile.
fn contact_cache(c: &mut Criterion) {
    let mut settled = Lazy::new(1000);
    c.bench_function("contact_cache/1000", |b| {
        let Simulation {
            bodies,
            contacts,
            cache,
            ..
        } = settled.get();
        let slots = 0..bodies.slots() as u32;
        let ids: Vec<_> = slots.clone().map(|slot| bodies.id(slot)).collect();
        let rotations: Vec<_> = slots.clone().map(|s| bodies.pose(s).rotation).collect();
        let boxes: Vec<_> = slots
            .map(|slot| bodies.convex(slot).map(|mesh| KdBox::around(mesh.aabb())))
            .collect();
        let mut manifolds = contacts.manifolds().clone();
        b.iter(|| {
            let stats = cache.warm_start(&mut manifolds, &ids, &rotations, &boxes, H);
            cache.store_and_age(&manifolds, &ids, &rotations, H);
            stats
        });
    });
}

fn build_rows(c: &mut Criterion) {
    let mut settled = Lazy::new(1000);
    c.bench_function("build_rows/1000", |b| {
        let Simulation {
            bodies,
            contacts,
            config,
            ..
        } = settled.get();
        let settings = SubstepSettings::new(config, Vec3::ZERO, H);
        let mut solver = ContactSolver::default();
        b.iter(|| solver.find_batches(contacts.manifolds(), bodies, &settings));
    });
}

fn solve(c: &mut Criterion) {
    let mut group = c.benchmark_group("solve_16_sweeps");
    for count in [100, 1000] {
        let mut settled = Lazy::new(count);
        group.bench_function(BenchmarkId::from_parameter(count), |b| {
            let simulation = settled.get();
            let islands = simulation.contacts.solver().islands();
            let island = islands.max_by_key(|i| i.contacts).expect("a heap");
            let mut rows = Vec::new();
            island.rows(&mut rows);
            b.iter_batched_ref(
                || (rows.clone(), island.bodies.to_vec()),
                |(rows, bodies)| pgs::solve(rows, bodies, 16, FrictionModel::Disc),
                BatchSize::LargeInput,
            );
        });
    }
}

fn integrate(c: &mut Criterion) {
    let mut settled = Lazy::new(1000);
    c.bench_function("integrate/1000", |b| {
        let bodies = &mut settled.get().bodies;
        let mut problems = Vec::new();
        b.iter(|| integrate_positions(bodies, &mut problems));
    });
}

fn whole_step(c: &mut Criterion) {
    let mut group = c.benchmark_group("step");
    group.sample_size(10);
    for count in [100, 1000, 5000] {
        let mut settled = Lazy::new(count);
        group.bench_function(BenchmarkId::from_parameter(count), |b| {
            let simulation = settled.get();
            b.iter(|| simulation.step(H));
        });
    }
    let mut app = None;
    group.bench_function("plugin/1000", |b| {
        let app = app.get_or_insert_with(|| settled_app(1000));
        b.iter(|| step_app(app));
    });
}

/// Steps until a pile has come down; fewer in a test run, where nobody reads the time.
const STEPS_TO_SETTLE: u32 = if cfg!(debug_assertions) { 5 } else { 120 };

/// A pile of `count` bodies that has come down, made when it is first asked for: not at all if a filter leaves it out.
struct Lazy {
    count: usize,
    simulation: Option<Simulation>,
}

impl Lazy {
    fn new(count: usize) -> Self {
        Self {
            count,
            simulation: None,
        }
    }

    fn get(&mut self) -> &mut Simulation {
        let Self { count, simulation } = self;
        simulation.get_or_insert_with(|| {
            let mut simulation = pile(*count);
            for _ in 0..STEPS_TO_SETTLE {
                simulation.step(H);
            }
            simulation
        })
    }
}

/// The same pile as entities of an app with the plugin.
fn settled_app(count: usize) -> App {
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin::default(), CleavePlugin::default()))
        .init_resource::<Time>();
    app.finish();
    app.cleanup();
    for desc in heap(count) {
        app.world_mut().spawn_body(desc);
    }
    for _ in 0..STEPS_TO_SETTLE {
        step_app(&mut app);
    }
    app
}

/// One step of the plugin, without the rest of an update.
fn step_app(app: &mut App) {
    let world = app.world_mut();
    world
        .resource_mut::<Time>()
        .advance_by(Duration::from_secs_f32(H));
    world.run_schedule(PhysicsSchedule);
}

criterion_group! {
    name = kernels;
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2));
    targets = hull_build, mass, slice, cut_by_three_planes, broadphase, manifold, contact_cache, build_rows, solve,
        integrate, whole_step
}
criterion_main!(kernels);
