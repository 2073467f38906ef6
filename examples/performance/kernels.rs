//! The kernels that are counted.

use crate::H;
use crate::contacts::{Source, four_substeps, pass, settled};
use crate::heaps::{heap, random_points};
use crate::structures::{pyramid, tower};
use bevy_cleave::contact::{NarrowScratch, collide_hulls};
use bevy_cleave::geometry::KdBox;
use bevy_cleave::prelude::*;
use bevy_cleave::slice::{SliceOptions, slice_hull, slice_mesh};
use bevy_cleave::step;
use bevy_cleave::testing::batch::Batch;
use bevy_cleave::testing::simd::LaneWidth;
use bevy_cleave::testing::wide::Pass;
use glam::{Quat, Vec3};
use std::hint::black_box;

/// Name of the function within which instructions are counted.
pub(crate) const COUNTED: &str = "counted_kernel";
/// Name of the function after which the count is written.
pub(crate) const DUMPED: &str = "dumped_kernel";

/// Callgrind collects while this runs.
#[inline(never)]
fn counted_kernel(kernel: &mut dyn FnMut()) {
    kernel();
    // Something must come after the call, or it would become a jump that never returns here.
    black_box(());
}

/// Callgrind writes what it has collected when this returns.
#[inline(never)]
fn dumped_kernel(kernel: &mut dyn FnMut()) {
    counted_kernel(kernel);
    black_box(());
}

/// A number of items, and what is done to them.
type Work = (usize, Box<dyn FnMut()>);

/// Name, unit of the items, and what makes the work.
type Kernel = (&'static str, &'static str, fn() -> Work);

const ALL: [Kernel; 21] = [
    ("collide two boxes", "pair", || hulls(boxes(), 0.995)),
    ("collide two hulls of 20 vertices", "pair", || {
        hulls(clouds(), 1.75)
    }),
    (
        "contact generation: pyramid at rest",
        "pair",
        contact_generation,
    ),
    ("broadphase: pile of 100 at rest", "body", broadphase),
    ("cache warm start: pile of 100", "point", || cache(true)),
    ("cache store: pile of 100", "point", || cache(false)),
    ("batch load: pyramid of 10", "point", batch_load),
    (
        "first sweep with targets: pyramid of 10",
        "point",
        first_sweep,
    ),
    ("solve sweep: widest lanes", "point", || {
        solve(LaneWidth::Widest)
    }),
    ("solve sweep: four lanes", "point", || {
        solve(LaneWidth::Four)
    }),
    ("solve sweep: one lane", "point", || solve(LaneWidth::One)),
    ("relax sweep: widest lanes", "point", || {
        relax(LaneWidth::Widest)
    }),
    ("relax sweep: four lanes", "point", || {
        relax(LaneWidth::Four)
    }),
    ("relax sweep: one lane", "point", || relax(LaneWidth::One)),
    ("step: tower of 10", "step", || {
        whole_step(tower(10), SolverConfig::default(), 60)
    }),
    ("step: pyramid of 10; soft; 4 sub-steps", "step", || {
        whole_step(pyramid(10), four_substeps(), 60)
    }),
    ("step: pile of 100 at rest", "step", || {
        whole_step(heap(100), SolverConfig::default(), 120)
    }),
    (
        "mass properties: sphere of 1280 triangles",
        "triangle",
        mass,
    ),
    ("slice: hull of a cube", "cut", || slice_of_hull(cube())),
    ("slice: hull of 1280 triangles", "cut", || {
        slice_of_hull(sphere())
    }),
    ("slice: mesh of 1280 triangles", "cut", slice_of_mesh),
];

/// Runs each kernel twice, and counts the second time, when buffers have grown to their size. Prints name, unit and number
/// of items.
pub(crate) fn run_all() {
    for (name, unit, make) in ALL {
        let (items, mut work) = make();
        work();
        dumped_kernel(&mut work);
        println!("{name},{unit},{items}");
    }
}

fn cube() -> ConvexMesh {
    ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size")
}

fn sphere() -> ConvexMesh {
    ConvexMesh::icosphere(0.5, 3).expect("valid size")
}

fn boxes() -> [ConvexMesh; 2] {
    [cube(), cube()]
}

/// Two different hulls of 20 random directions, radius 1 m.
fn clouds() -> [ConvexMesh; 2] {
    [11, 12].map(|seed| {
        let points = random_points(20, seed).into_iter().map(Vec3::normalize);
        let hull = ConvexMesh::from_points(&points.collect::<Vec<_>>()).expect("not flat");
        assert_eq!(hull.hull().vertices().len(), 20);
        hull
    })
}

/// Two hulls that touch, one above the other, without anything known from before.
fn hulls([a, b]: [ConvexMesh; 2], height: f32) -> Work {
    let mut scratch = NarrowScratch::new();
    let turn = Quat::from_xyzw(0.0, 0.15, 0.0, 1.0).normalize();
    let above = Pose::new(Vec3::new(0.1, height, 0.05), turn);
    let work = move || {
        let patch = collide_hulls(a.hull(), b.hull(), black_box(above), 0.3, &mut scratch);
        assert!(patch.is_some(), "the hulls touch");
    };
    (1, Box::new(work))
}

fn settings(simulation: &Simulation, warm_start: bool) -> StepSettings {
    StepSettings {
        config: SolverConfig {
            warm_start,
            ..simulation.config
        },
        ..simulation.settings(H)
    }
}

/// Manifolds of bodies at rest: with all that the narrow phase remembers of its pairs, without the cache.
fn contact_generation() -> Work {
    let mut simulation = settled(pyramid(10), four_substeps(), 60);
    let settings = settings(&simulation, false);
    let pairs = simulation.report.pairs;
    let work = move || {
        let Simulation {
            bodies,
            contacts,
            cache,
            report,
            ..
        } = &mut simulation;
        step::generate_contacts(bodies, contacts, cache, &settings, report);
    };
    (pairs, Box::new(work))
}

fn broadphase() -> Work {
    let mut simulation = settled(heap(100), SolverConfig::default(), 120);
    let settings = settings(&simulation, true);
    let count = simulation.bodies.len();
    let work = move || {
        let Simulation {
            bodies,
            contacts,
            report,
            ..
        } = &mut simulation;
        step::broadphase(bodies, contacts, &settings, report);
    };
    (count, Box::new(work))
}

/// Either half of what the cache does in a step.
fn cache(is_warm_start: bool) -> Work {
    let Simulation {
        bodies,
        contacts,
        mut cache,
        ..
    } = settled(heap(100), SolverConfig::default(), 120);
    let slots = 0..bodies.slots() as u32;
    let ids: Vec<_> = slots.clone().map(|slot| bodies.id(slot)).collect();
    let rotations: Vec<_> = slots
        .clone()
        .map(|slot| bodies.pose(slot).rotation)
        .collect();
    let boxes = slots.map(|slot| bodies.convex(slot).map(|mesh| KdBox::around(mesh.aabb())));
    let boxes: Vec<_> = boxes.collect();
    let mut manifolds = contacts.manifolds().clone();
    let points = manifolds.points().len();
    cache.warm_start(&mut manifolds, &ids, &rotations, &boxes, H);
    let work = move || {
        if is_warm_start {
            cache.warm_start(&mut manifolds, &ids, &rotations, &boxes, H);
        } else {
            cache.store_and_age(&manifolds, &ids, &rotations, H);
        }
    };
    (points, Box::new(work))
}

/// A pyramid at rest.
fn source() -> Source {
    Source::new(settled(pyramid(10), four_substeps(), 60))
}

fn batch_load() -> Work {
    let source = source();
    let mut batch = Batch::default();
    (source.points(), Box::new(move || source.load(&mut batch)))
}

fn first_sweep() -> Work {
    let source = source();
    let mut batch = source.batch();
    let of_step = Pass::SolveFirst {
        bias: batch.settings.bias(),
        is_first: false,
        softness: batch.settings.softness(),
        measure: false,
    };
    let work = move || pass(&mut batch, LaneWidth::Widest, of_step);
    (source.points(), Box::new(work))
}

fn solve(width: LaneWidth) -> Work {
    let source = source();
    let mut batch = source.batch();
    let softness = batch.settings.softness();
    let measure = false;
    let work = move || pass(&mut batch, width, Pass::Solve { softness, measure });
    (source.points(), Box::new(work))
}

fn relax(width: LaneWidth) -> Work {
    let source = source();
    let mut batch = source.batch();
    let measure = false;
    let work = move || pass(&mut batch, width, Pass::Relax { measure });
    (source.points(), Box::new(work))
}

fn whole_step(bodies: Vec<BodyDesc>, config: SolverConfig, steps: u32) -> Work {
    let mut simulation = settled(bodies, config, steps);
    (1, Box::new(move || simulation.step(H)))
}

fn mass() -> Work {
    let mesh = sphere();
    let count = mesh.hull().faces().len();
    let work = move || {
        black_box(MassProperties::of_hull(black_box(mesh.hull()), 1000.0)).expect("a solid");
    };
    (count, Box::new(work))
}

/// A cut past the middle.
fn plane() -> Plane {
    Plane::through(Vec3::splat(0.01), Vec3::new(0.3, 1.0, 0.2))
}

fn slice_of_hull(shape: ConvexMesh) -> Work {
    let work = move || {
        black_box(slice_hull(black_box(shape.hull()), plane())).expect("a valid plane");
    };
    (1, Box::new(work))
}

fn slice_of_mesh() -> Work {
    let mesh = sphere().hull().to_mesh();
    let work = move || {
        let slice = slice_mesh(black_box(&mesh), plane(), SliceOptions::default());
        black_box(slice).expect("a valid plane");
    };
    (1, Box::new(work))
}
