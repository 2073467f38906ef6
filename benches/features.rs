//! What a scene pays for a feature: one step of the same settled heap with it and without it.
#![allow(
    missing_docs,
    reason = "criterion's macros make undocumented functions"
)]

#[path = "../tests/common/mod.rs"]
mod common;

use bevy_cleave::prelude::*;
use common::scenes::{self, awake};
use common::structures;
use criterion::{Criterion, criterion_group, criterion_main};
use glam::Vec3;

/// Length of a step, s.
const H: f32 = 1.0 / 60.0;

/// Bodies of the heap.
const BODIES: usize = 200;

/// A heap whose bodies are made by `change`, 10 s after it was let go.
fn settled(change: impl Fn(&mut BodyDesc), config: SolverConfig) -> Simulation {
    let mut simulation = Simulation {
        config: SolverConfig {
            sleep: SleepConfig::off(),
            ..config
        },
        ..Default::default()
    };
    for mut desc in scenes::heap(BODIES) {
        if desc.kind == RigidBody::Dynamic {
            change(&mut desc);
        }
        simulation.bodies.insert(desc).expect("usable");
    }
    for _ in 0..600 {
        simulation.step(H);
    }
    simulation
}

fn bench(c: &mut Criterion, name: &str, mut simulation: Simulation) {
    c.bench_function(&format!("feature/{name}"), |b| {
        b.iter(|| simulation.step(H))
    });
}

fn features(c: &mut Criterion) {
    let default = SolverConfig::default();
    let with = |change: &dyn Fn(&mut SolverConfig)| {
        let mut config = default;
        change(&mut config);
        settled(|_| {}, config)
    };
    bench(c, "none", with(&|_| {}));
    bench(c, "no_friction", {
        let slippery = Friction::new(0.0).with_combine(CombineRule::Min);
        settled(|desc| desc.friction = slippery, default)
    });
    bench(
        c,
        "restitution",
        settled(|desc| desc.restitution = Restitution::new(0.3), default),
    );
    bench(c, "fracturable", {
        let unbroken = Fracturable::with_strength(f32::MAX);
        settled(|desc| desc.fracturable = Some(unbroken.clone()), default)
    });
    bench(c, "fatigue", {
        let unbroken = Fracturable::with_strength(1e9);
        let mut simulation = settled(|desc| desc.fracturable = Some(unbroken.clone()), default);
        for slot in 1..simulation.bodies.slots() as u32 {
            let taken = simulation.bodies.set_fatigue(slot, Some(Fatigue::new(1e9)));
            taken.expect("usable");
        }
        simulation
    });
    bench(
        c,
        "no_warm_start",
        with(&|config| config.warm_start = false),
    );
    bench(
        c,
        "no_tolerance",
        with(&|config| {
            config.method = SoftStep {
                tolerance: None,
                ..SoftStep::default()
            }
            .into();
        }),
    );
    bench(
        c,
        "measure_error",
        with(&|config| config.measure_error = true),
    );
    bench(
        c,
        "measure_islands",
        with(&|config| {
            config.measure_error = true;
            config.measure_islands = true;
        }),
    );
    bench(c, "paper", settled(|_| {}, SolverConfig::paper()));
    // A heap of hulls in a scene that has a ball too, and one that is half of balls.
    bench(c, "one_round", {
        let mut simulation = settled(|_| {}, default);
        let ball = BodyDesc::dynamic(bevy_cleave::sphere!(0.3), Vec3::new(50.0, 0.3, 50.0));
        simulation.bodies.insert(ball).expect("usable");
        simulation
    });
    bench(c, "half_round", {
        let ball = Shape::Convex(bevy_cleave::sphere!(0.3));
        settled(every_second(ball), default)
    });
    // A heap of hulls in a scene that has a table too, and one that is half of bricks of two parts.
    let brick = |side: f32| {
        let at = Pose::from_position(0.15 * side * Vec3::X);
        (at, bevy_cleave::cuboid!(0.3, 0.5, 0.5))
    };
    let halves = Compound::new([-1.0, 1.0].map(brick)).expect("usable");
    bench(c, "one_compound", {
        let mut simulation = settled(|_| {}, default);
        let desc = BodyDesc::compound(halves.clone(), Vec3::new(50.0, 0.25, 50.0));
        simulation.bodies.insert(desc).expect("usable");
        simulation
    });
    bench(c, "half_compound", {
        let brick = Shape::Compound(halves.clone());
        settled(every_second(brick), default)
    });
    // A scene that has two bonded bricks too, and a heap half of which are such.
    let bonded = halves.clone().bonded(1e6).expect("they touch");
    bench(c, "one_cluster", {
        let mut simulation = settled(|_| {}, default);
        let desc = BodyDesc::compound(bonded.clone(), Vec3::new(50.0, 0.25, 50.0));
        simulation.bodies.insert(desc).expect("usable");
        simulation
    });
    bench(c, "half_cluster", {
        let bonded = Shape::Compound(bonded.clone());
        settled(every_second(bonded), default)
    });
    // The same heap in a scene that has a pendulum too.
    bench(c, "one_joint", {
        let mut simulation = settled(|_| {}, default);
        let bob = BodyDesc::dynamic(
            bevy_cleave::cuboid!(0.3, 0.3, 0.3),
            Vec3::new(50.0, 9.0, 50.0),
        );
        let bob = simulation.bodies.insert(bob).expect("usable");
        let joint = Joint::ball().with_anchors(Vec3::new(50.0, 10.0, 50.0), Vec3::Y);
        simulation.join(None, bob, joint).expect("usable");
        simulation
    });
    bench(c, "contact_events", {
        let mut simulation = settled(|_| {}, default);
        watch_all(&mut simulation);
        simulation
    });
    bench(c, "drives", {
        let mut simulation = settled(|_| {}, default);
        let damped = BodyDrive {
            linear_damping: 0.01,
            ..BodyDrive::default()
        };
        for slot in 0..simulation.bodies.slots() as u32 {
            let taken = simulation.bodies.set_drive(slot, damped);
            taken.expect("usable");
        }
        simulation
    });
}

/// Gives every second body another shape.
fn every_second(shape: Shape) -> impl Fn(&mut BodyDesc) {
    let number = std::cell::Cell::new(0_u32);
    move |desc| {
        number.set(number.get() + 1);
        if number.get().is_multiple_of(2) {
            desc.shape = shape.clone();
        }
    }
}

/// Asks for all news of all bodies, of loads that no contact bears.
fn watch_all(simulation: &mut Simulation) {
    let watch = ContactWatch {
        touches: true,
        force: f32::MAX,
    };
    let Simulation {
        bodies, contacts, ..
    } = simulation;
    for slot in 0..bodies.slots() as u32 {
        contacts.events_mut().watch(bodies, slot, watch);
    }
}

/// Ten thousand bodies that touch: with events of contacts and without, in turn.
fn many(c: &mut Criterion) {
    // Without `--bench` it is a test that the bench runs.
    let is_bench = std::env::args().any(|arg| arg == "--bench");
    let count = if is_bench { 10_000 } else { 100 };
    for is_watched in [false, true] {
        let mut simulation = awake();
        for desc in structures::columns(count) {
            simulation.bodies.insert(desc).expect("usable");
        }
        if is_watched {
            watch_all(&mut simulation);
        }
        for _ in 0..20 {
            simulation.step(H);
        }
        let name = ["many", "many_with_events"][usize::from(is_watched)];
        bench(c, name, simulation);
    }
}

/// Rows of ten crates on a plane, and the same with each joined to the next; and ten chains of twenty links that hang.
fn joints(c: &mut Criterion) {
    let block = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    for (name, is_joined) in [("crates", false), ("crates_joined", true)] {
        let mut simulation = awake();
        let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
        simulation.bodies.insert(floor).expect("usable");
        let mut last = None;
        for i in 0..BODIES {
            let at = Vec3::new(1.5 * (i % 10) as f32, 0.5, 3.0 * (i / 10) as f32);
            let desc = BodyDesc::dynamic(block.clone(), at);
            let slot = simulation.bodies.insert(desc).expect("usable");
            if is_joined && i % 10 > 0 {
                let half = Vec3::new(0.75, 0.0, 0.0);
                let joint = Joint::ball().with_anchors(half, -half);
                simulation.join(last, slot, joint).expect("usable");
            }
            last = Some(slot);
        }
        (0..120).for_each(|_| simulation.step(H));
        bench(c, name, simulation);
    }
    let mut simulation = awake();
    for i in 0..BODIES {
        let at = Vec3::new(0.0, -1.5 * (i % 20) as f32, 5.0 * (i / 20) as f32);
        let desc = BodyDesc::dynamic(block.clone(), at);
        let slot = simulation.bodies.insert(desc).expect("usable");
        let half = Vec3::new(0.0, 0.75, 0.0);
        let (above, on_a) = match i % 20 {
            0 => (None, at + half),
            _ => (Some(slot - 1), -half),
        };
        let joint = Joint::ball().with_anchors(on_a, half);
        simulation.join(above, slot, joint).expect("usable");
    }
    bench(c, "chains", simulation);
}

/// Free bodies that spin: those with one moment about all axes pay nothing for their rotation.
fn spin(c: &mut Criterion) {
    for (name, edges) in [("cubes", Vec3::ONE), ("plates", Vec3::new(1.0, 0.5, 0.2))] {
        let mut simulation = awake();
        let shape = ConvexMesh::cuboid(edges.x, edges.y, edges.z).expect("valid size");
        for i in 0..BODIES {
            let mut desc = BodyDesc::dynamic(shape.clone(), 3.0 * i as f32 * Vec3::X);
            desc.angular_velocity = Vec3::new(0.1, 5.0, 0.1);
            simulation.bodies.insert(desc).expect("usable");
        }
        simulation.gravity = Gravity(Vec3::ZERO);
        bench(c, &format!("spinning_{name}"), simulation);
    }
}

/// Crates on a floor of static slabs: ordinary ones, and such as may break and are anchored.
fn standing(c: &mut Criterion) {
    for (name, may_break) in [("static_slabs", false), ("fracturable_slabs", true)] {
        let mut simulation = awake();
        let slab = ConvexMesh::cuboid(2.0, 0.2, 2.0).expect("valid size");
        let block = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
        for i in 0..BODIES {
            let at = Vec3::new(2.0 * (i % 20) as f32, 0.0, 2.0 * (i / 20) as f32);
            let mut desc = BodyDesc {
                kind: RigidBody::Static,
                ..BodyDesc::dynamic(slab.clone(), at - 0.1 * Vec3::Y)
            };
            desc.fracturable = may_break.then(|| Fracturable::with_strength(1e9));
            let slot = simulation.bodies.insert(desc).expect("usable");
            if may_break {
                let anchors = Anchors::none().and_behind(Vec3::Y, 0.0);
                let taken = simulation.bodies.set_anchors(slot, Some(anchors));
                taken.expect("usable");
            }
            let desc = BodyDesc::dynamic(block.clone(), at + 0.5 * Vec3::Y);
            simulation.bodies.insert(desc).expect("usable");
        }
        (0..120).for_each(|_| simulation.step(H));
        bench(c, name, simulation);
    }
}

/// A heap of pieces that nobody looks at, and one with rules by which none of them goes.
fn debris(c: &mut Criterion) {
    for (name, max_age) in [("pieces", f32::INFINITY), ("pieces_with_rules", 1e9)] {
        let mut simulation = awake();
        simulation.budget.debris.max_age = max_age;
        let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
        simulation.bodies.insert(floor).expect("usable");
        let block = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
        for i in 0..BODIES / 8 {
            let at = Vec3::new(1.5 * (i % 5) as f32, 3.0, 1.5 * (i / 5) as f32);
            let mut desc = BodyDesc::dynamic(block.clone(), at);
            desc.fracturable = Some(Fracturable {
                pattern: FracturePattern::Voronoi {
                    cells: 8,
                    focus: 0.0,
                },
                generations: 0,
                ..Fracturable::with_strength(100.0)
            });
            simulation.bodies.insert(desc).expect("usable");
        }
        (0..600).for_each(|_| simulation.step(H));
        bench(c, name, simulation);
    }
}

/// Crates that come to rest on a plane, and on a level of triangles in its place.
fn level(c: &mut Criterion) {
    let cells = 64;
    let heights = vec![0.0; (cells + 1) * (cells + 1)];
    let ground = StaticMesh::from_heights(&heights, cells + 1, 1.0).expect("a valid grid");
    let plane = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    for (name, floor) in [("plane", plane), ("level", BodyDesc::level(ground))] {
        for (state, steps) in [("falling", 0), ("resting", 300)] {
            let mut simulation = awake();
            simulation.bodies.insert(floor.clone()).expect("usable");
            let shape = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
            for i in 0..BODIES {
                let at = Vec3::new(
                    2.3 * (i % 20) as f32 + 5.0,
                    0.6,
                    2.3 * (i / 20) as f32 + 5.0,
                );
                let desc = BodyDesc::dynamic(shape.clone(), at);
                simulation.bodies.insert(desc).expect("usable");
            }
            (0..steps).for_each(|_| simulation.step(H));
            bench(c, &format!("{state}_on_{name}"), simulation);
        }
    }
}

/// Boxes that stand apart: as large as a step is made for, and smaller ones, which take local steps; and those without any.
fn small(c: &mut Criterion) {
    for (name, size, max_local_steps) in [
        ("apart_30_cm", 0.3, 16),
        ("apart_5_cm", 0.05, 16),
        ("apart_5_cm_without_local_steps", 0.05, 1),
        ("apart_1_cm", 0.01, 16),
        ("apart_1_cm_without_local_steps", 0.01, 1),
    ] {
        let mut simulation = awake();
        simulation.config.method = SoftStep {
            max_local_steps,
            ..SoftStep::default()
        }
        .into();
        let up = HalfSpaceShape { normal: Vec3::Y };
        let floor = BodyDesc::floor(up);
        simulation.bodies.insert(floor).expect("usable");
        let shape = ConvexMesh::cuboid(size, size, size).expect("valid size");
        for i in 0..BODIES {
            let at = Vec3::new(3.0 * i as f32, 0.5, 0.0) * size;
            let desc = BodyDesc::dynamic(shape.clone(), at);
            simulation.bodies.insert(desc).expect("usable");
        }
        (0..60).for_each(|_| simulation.step(H));
        bench(c, name, simulation);
    }
}

/// A step after which nobody asks anything, and one after which an index for questions is made.
fn queries(c: &mut Criterion) {
    let mut simulation = settled(|_| {}, SolverConfig::default());
    c.bench_function("features/query_index", |b| {
        b.iter(|| simulation.queries().bodies().len());
    });
    let ray = Ray::new(Vec3::new(0.1, 50.0, 0.1), Vec3::NEG_Y, 100.0).expect("usable");
    c.bench_function("features/ray", |b| {
        let queries = simulation.queries();
        b.iter(|| queries.cast_ray(&ray, &QueryFilter::all()));
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(30);
    targets = features, joints, spin, many, small, level, standing, debris, queries
}
criterion_main!(benches);
