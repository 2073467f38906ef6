//! Heaps of 200 hulls: with something of the part elsewhere in the scene, and with all of them having it.

use crate::common::scenes;
use crate::pair::{Pair, Row, Step, is_bench};
use bevy_cleave::prelude::*;
use glam::Vec3;
use std::cell::Cell;

/// Length of a step, s.
pub(crate) const H: f32 = 1.0 / 60.0;

/// Bodies of the heap.
const BODIES: usize = 200;

/// Where what is added to the scene stands, so that the heap does not meet it, m.
pub(crate) const ASIDE: Vec3 = Vec3::new(50.0, 0.0, 50.0);

pub(crate) fn step(mut simulation: Simulation) -> Step {
    Box::new(move || simulation.step(H))
}

/// Lets a scene come to rest.
pub(crate) fn run(simulation: &mut Simulation, steps: usize) {
    let steps = if is_bench() { steps } else { 2 };
    (0..steps).for_each(|_| simulation.step(H));
}

pub(crate) fn insert(simulation: &mut Simulation, desc: BodyDesc) -> u32 {
    simulation.bodies.insert(desc).expect("usable")
}

/// A heap whose bodies are made by `change`, 10 s after it was let go.
pub(crate) fn heap(change: &dyn Fn(&mut BodyDesc), config: SolverConfig) -> Simulation {
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
        insert(&mut simulation, desc);
    }
    run(&mut simulation, 600);
    simulation
}

pub(crate) fn plain() -> Simulation {
    heap(&|_| {}, SolverConfig::default())
}

/// The heap, and the same in a scene that something is added to.
pub(crate) fn beside(add: impl FnOnce(&mut Simulation)) -> Pair {
    let (mut without, mut with) = (plain(), plain());
    add(&mut with);
    run(&mut without, 120);
    run(&mut with, 120);
    Pair::new(step(without), step(with))
}

/// The heap, and the same of other bodies.
pub(crate) fn of(change: &dyn Fn(&mut BodyDesc)) -> Pair {
    Pair::new(step(plain()), step(heap(change, SolverConfig::default())))
}

/// The heap, and the same by another configuration.
fn by(change: impl FnOnce(&mut SolverConfig)) -> Pair {
    let mut config = SolverConfig::default();
    change(&mut config);
    Pair::new(step(plain()), step(heap(&|_| {}, config)))
}

/// Gives every second body another shape.
pub(crate) fn every_second(shape: Shape) -> impl Fn(&mut BodyDesc) {
    let number = Cell::new(0_u32);
    move |desc| {
        number.set(number.get() + 1);
        if number.get().is_multiple_of(2) {
            desc.shape = shape.clone();
        }
    }
}

fn ball() -> ConvexMesh {
    bevy_cleave::sphere!(0.3)
}

/// A brick of two halves.
fn halves() -> Compound {
    let half = |side: f32| {
        let at = Pose::from_position(0.15 * side * Vec3::X);
        (at, bevy_cleave::cuboid!(0.3, 0.5, 0.5))
    };
    Compound::new([-1.0, 1.0].map(half)).expect("usable")
}

/// The same, held by bonds.
pub(crate) fn cluster() -> Compound {
    halves().bonded(1e6).expect("they touch")
}

fn shapes() -> Vec<Row> {
    vec![
        Row::new("Bodies", "all have restitution", || {
            of(&|desc| desc.restitution = Restitution::new(0.3))
        }),
        Row::new("Bodies", "all without friction", || {
            let slippery = Friction::new(0.0).with_combine(CombineRule::Min);
            of(&|desc| desc.friction = slippery)
        }),
        Row::new("Bodies", "all carry a mesh", || {
            of(&|desc| {
                if let Shape::Convex(shape) = &desc.shape {
                    let mesh = shape.hull().to_mesh();
                    desc.shape = Shape::Convex(ConvexMesh::from_mesh(mesh).expect("a closed mesh"));
                }
            })
        }),
        Row::new("Round shapes", "one ball aside", || {
            beside(|s| {
                insert(s, BodyDesc::dynamic(ball(), ASIDE + 0.3 * Vec3::Y));
            })
        }),
        Row::new("Round shapes", "half of them balls", || {
            of(&every_second(Shape::Convex(ball())))
        }),
        Row::new("Compounds", "one aside", || {
            beside(|s| {
                insert(s, BodyDesc::compound(halves(), ASIDE + 0.25 * Vec3::Y));
            })
        }),
        Row::new("Compounds", "half of them of two parts", || {
            of(&every_second(Shape::Compound(halves())))
        }),
        Row::new("Clusters", "one aside", || {
            beside(|s| {
                insert(s, BodyDesc::compound(cluster(), ASIDE + 0.25 * Vec3::Y));
            })
        }),
        Row::new(
            "Clusters",
            "half of them two parts with a bond, without: the same unbonded",
            || {
                let without = heap(
                    &every_second(Shape::Compound(halves())),
                    SolverConfig::default(),
                );
                let with = heap(
                    &every_second(Shape::Compound(cluster())),
                    SolverConfig::default(),
                );
                Pair::new(step(without), step(with))
            },
        ),
    ]
}

fn breaking() -> Vec<Row> {
    vec![
        Row::new("Cuts", "two pieces of one aside", || {
            beside(|s| {
                let body = BodyDesc::dynamic(bevy_cleave::cuboid!(0.6, 0.6, 0.6), ASIDE + Vec3::Y);
                let slot = insert(s, body);
                let plane = Plane::through(ASIDE, Vec3::X);
                s.slice(slot, plane).expect("the body is there");
            })
        }),
        Row::new("Fracture", "all may break", || {
            let unbroken = Fracturable::with_strength(f32::MAX);
            of(&|desc| desc.fracturable = Some(unbroken.clone()))
        }),
        Row::new("Fracture", "all wear out", || {
            let unbroken = Fracturable::with_strength(1e9);
            let mut simulation = heap(
                &|desc| desc.fracturable = Some(unbroken.clone()),
                SolverConfig::default(),
            );
            for slot in 1..simulation.bodies.slots() as u32 {
                let taken = simulation.bodies.set_fatigue(slot, Some(Fatigue::new(1e9)));
                taken.expect("usable");
            }
            Pair::new(step(plain()), step(simulation))
        }),
        Row::new("Joints", "a pendulum aside", || {
            beside(|s| {
                let bob = bevy_cleave::cuboid!(0.3, 0.3, 0.3);
                let bob = insert(s, BodyDesc::dynamic(bob, ASIDE + 9.0 * Vec3::Y));
                let joint = Joint::ball().with_anchors(ASIDE + 10.0 * Vec3::Y, Vec3::Y);
                s.join(None, bob, joint).expect("usable");
            })
        }),
        Row::new("Bonds", "two bonded bodies aside", || {
            beside(|s| {
                let brick = bevy_cleave::cuboid!(0.5, 0.5, 0.5);
                let slots = [0.25, 0.75]
                    .map(|y| insert(s, BodyDesc::dynamic(brick.clone(), ASIDE + y * Vec3::Y)));
                let made = s.bond_neighbors(&slots, 1e6).expect("usable");
                assert_eq!(made, 1, "they touch");
            })
        }),
    ]
}

fn effort() -> Vec<Row> {
    vec![
        Row::new("Effort", "`SolverConfig::fast()`", || {
            by(|c| *c = SolverConfig::fast())
        }),
        Row::new("Effort", "`SolverConfig::precise()`", || {
            by(|c| *c = SolverConfig::precise())
        }),
        Row::new("Effort", "`SolverConfig::paper()`", || {
            by(|c| *c = SolverConfig::paper())
        }),
        Row::new("Effort", "without a warm start", || {
            by(|c| c.warm_start = false)
        }),
        Row::new("Effort", "a fixed number of sweeps", || {
            by(|c| {
                let fixed = SoftStep {
                    tolerance: None,
                    ..SoftStep::default()
                };
                c.method = fixed.into();
            })
        }),
        Row::new("Effort", "each step tells its error", || {
            by(|c| c.measure_error = true)
        }),
        Row::new("Effort", "and that of each island", || {
            by(|c| (c.measure_error, c.measure_islands) = (true, true))
        }),
    ]
}

pub(crate) fn rows() -> Vec<Row> {
    [shapes(), breaking(), effort()].concat()
}
