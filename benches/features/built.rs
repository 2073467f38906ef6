//! Scenes that are built for the part that they show.

use crate::common::scenes::{awake, awake_on_floor};
use crate::common::structures;
use crate::heaps::{beside, insert, run, step};
use crate::news::watch_all;
use crate::pair::{Pair, Row, is_bench};
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Bodies of a scene.
const BODIES: usize = 200;

fn cube(size: f32) -> ConvexMesh {
    ConvexMesh::cuboid(size, size, size).expect("valid size")
}

/// Free bodies that spin.
fn spinning(edges: Vec3) -> Simulation {
    let mut simulation = awake();
    let shape = ConvexMesh::cuboid(edges.x, edges.y, edges.z).expect("valid size");
    for i in 0..BODIES {
        let mut desc = BodyDesc::dynamic(shape.clone(), 3.0 * i as f32 * Vec3::X);
        desc.angular_velocity = Vec3::new(0.1, 5.0, 0.1);
        insert(&mut simulation, desc);
    }
    simulation.gravity = Gravity(Vec3::ZERO);
    simulation
}

/// Crates on a floor of static slabs: ordinary ones, or such as may break and are anchored.
fn standing(may_break: bool) -> Simulation {
    let mut simulation = awake();
    let slab = ConvexMesh::cuboid(2.0, 0.2, 2.0).expect("valid size");
    for i in 0..BODIES {
        let at = Vec3::new(2.0 * (i % 20) as f32, 0.0, 2.0 * (i / 20) as f32);
        let desc = BodyDesc {
            kind: RigidBody::Static,
            fracturable: may_break.then(|| Fracturable::with_strength(1e9)),
            ..BodyDesc::dynamic(slab.clone(), at - 0.1 * Vec3::Y)
        };
        let slot = insert(&mut simulation, desc);
        if may_break {
            let anchors = Anchors::none().and_behind(Vec3::Y, 0.0);
            let taken = simulation.bodies.set_anchors(slot, Some(anchors));
            taken.expect("usable");
        }
        let crate_at = at + 0.5 * Vec3::Y;
        insert(&mut simulation, BodyDesc::dynamic(cube(1.0), crate_at));
    }
    run(&mut simulation, 120);
    simulation
}

/// A heap of pieces that nobody looks at, or one with rules by which none of them goes.
fn debris(max_age: f32) -> Simulation {
    let mut simulation = awake_on_floor();
    simulation.budget.debris.max_age = max_age;
    for i in 0..BODIES / 8 {
        let at = Vec3::new(1.5 * (i % 5) as f32, 3.0, 1.5 * (i / 5) as f32);
        let mut desc = BodyDesc::dynamic(cube(1.0), at);
        desc.fracturable = Some(Fracturable {
            pattern: FracturePattern::Voronoi {
                cells: 8,
                focus: 0.0,
            },
            generations: 0,
            ..Fracturable::with_strength(100.0)
        });
        insert(&mut simulation, desc);
    }
    run(&mut simulation, 600);
    simulation
}

/// What holds neighbors of a row together.
#[derive(Clone, Copy)]
pub(crate) enum Held<'j> {
    No,
    Joints(&'j Joint),
    Bonds,
}

/// Rows of ten crates on a plane, which touch each other, in each the next held to the one before.
pub(crate) fn crates(held: Held) -> Simulation {
    let mut simulation = awake_on_floor();
    let mut slots = Vec::new();
    for i in 0..BODIES {
        let at = Vec3::new((i % 10) as f32, 0.5, 3.0 * (i / 10) as f32);
        let slot = insert(&mut simulation, BodyDesc::dynamic(cube(1.0), at));
        if let Held::Joints(joint) = held
            && i % 10 > 0
        {
            let half = 0.5 * Vec3::X;
            let joint = joint.with_anchors(half, -half);
            let made = simulation.join(slots.last().copied(), slot, joint);
            made.expect("usable");
        }
        slots.push(slot);
    }
    if let Held::Bonds = held {
        let made = simulation.bond_neighbors(&slots, 1e6).expect("usable");
        assert_eq!(made, BODIES / 10 * 9, "neighbors of a row touch");
    }
    run(&mut simulation, 120);
    simulation
}

/// Crates on a plane, or on a level of triangles in its place.
fn on_ground(is_level: bool, steps: usize) -> Simulation {
    let mut simulation = awake();
    let floor = if is_level {
        BodyDesc::level(flat_level(64))
    } else {
        BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y })
    };
    insert(&mut simulation, floor);
    for i in 0..BODIES {
        let (column, row) = ((i % 20) as f32, (i / 20) as f32);
        let at = Vec3::new(2.3 * column + 5.0, 0.6, 2.3 * row + 5.0);
        insert(&mut simulation, BodyDesc::dynamic(cube(1.0), at));
    }
    run(&mut simulation, steps);
    simulation
}

/// Triangles of 1 m in a plane.
fn flat_level(cells: usize) -> StaticMesh {
    let heights = vec![0.0; (cells + 1) * (cells + 1)];
    StaticMesh::from_heights(&heights, cells + 1, 1.0).expect("a valid grid")
}

/// Boxes that stand apart.
fn apart(size: f32, max_local_steps: u32) -> Simulation {
    let mut simulation = awake_on_floor();
    simulation.config.method = SoftStep {
        max_local_steps,
        ..SoftStep::default()
    }
    .into();
    for i in 0..BODIES {
        let at = Vec3::new(3.0 * i as f32, 0.5, 0.0) * size;
        insert(&mut simulation, BodyDesc::dynamic(cube(size), at));
    }
    run(&mut simulation, 60);
    simulation
}

/// Ten thousand bodies that touch; as a test fewer.
fn columns(is_watched: bool) -> Simulation {
    let mut simulation = awake();
    for desc in structures::columns(if is_bench() { 10_000 } else { 100 }) {
        insert(&mut simulation, desc);
    }
    if is_watched {
        watch_all(&mut simulation);
    }
    run(&mut simulation, 20);
    simulation
}

pub(crate) fn rows() -> Vec<Row> {
    vec![
        Row::new(
            "Bodies",
            "200 that fly and spin: plates, without: cubes, which turn alike about all axes",
            || of_two(spinning(Vec3::ONE), spinning(Vec3::new(1.0, 0.5, 0.2))),
        ),
        Row::new(
            "What stands",
            "200 crates on 200 slabs, which may break and are anchored",
            || of_two(standing(false), standing(true)),
        ),
        Row::new("What stands", "200 pieces under `DebrisRules`", || {
            of_two(debris(f32::INFINITY), debris(1e9))
        }),
        Row::new("Bonds", "20 rows of 10 crates, bonded", || {
            of_two(crates(Held::No), crates(Held::Bonds))
        }),
        Row::new(
            "Levels",
            "a level of 8192 triangles below the floor",
            || {
                beside(|s| {
                    let mut level = BodyDesc::level(flat_level(64));
                    level.pose.position = Vec3::new(-32.0, -20.0, -32.0);
                    insert(s, level);
                })
            },
        ),
        Row::new(
            "Levels",
            "200 crates that lie on triangles, without: on a plane",
            || of_two(on_ground(false, 300), on_ground(true, 300)),
        ),
        Row::new(
            "Effort",
            "200 boxes of 5 cm: local steps, without: none",
            || of_two(apart(0.05, 1), apart(0.05, 16)),
        ),
        Row::new(
            "Effort",
            "200 boxes of 30 cm, which need none: the same",
            || of_two(apart(0.3, 1), apart(0.3, 16)),
        ),
        Row::new(
            "Events, sensors, forces",
            "10 000 crates in columns, news of all contacts",
            || of_two(columns(false), columns(true)),
        ),
    ]
}

pub(crate) fn of_two(without: Simulation, with: Simulation) -> Pair {
    Pair::new(step(without), step(with))
}
