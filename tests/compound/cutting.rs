//! Planes cut compounds part by part; what hangs together stays one body, and nothing is lost.

use crate::common::dice::Dice;
use crate::common::mesh_parts::voxels;
use crate::common::scenes::awake;
use crate::common::structures::floor;
use crate::shapes::{arch, chair, cup, dumbbell, table};
use bevy_cleave::mass::VolumeIntegrals;
use bevy_cleave::prelude::*;
use bevy_cleave::slice::DecompositionOptions;
use glam::Vec3;

const H: f32 = 1.0 / 60.0;

/// The pieces of the only fracture of a step, which keeps mass and momentum. `off`: error of what turns, from rounding, or because a
/// polyhedron stands for what is round.
fn cut_within(simulation: &mut Simulation, slot: u32, planes: &[Plane], off: f64) -> Vec<u32> {
    for &plane in planes {
        simulation.slice(slot, plane).expect("a body");
    }
    simulation.step(H);
    let refused = &simulation.fractures.refused;
    assert!(refused.is_empty(), "{refused:?}");
    let fracture = simulation.fractures.done.first().expect("a fracture");
    let ledger = &fracture.ledger;
    let errors = [ledger.angular_momentum_error(), ledger.energy_gain().abs()];
    assert!(ledger.mass_error() <= 1e-6, "{}", ledger.mass_error());
    assert!(
        ledger.momentum_error() <= 1e-5,
        "{}",
        ledger.momentum_error()
    );
    assert!(errors.iter().all(|&error| error <= off), "{errors:?}");
    fracture.pieces.to_vec()
}

fn cut(simulation: &mut Simulation, slot: u32, planes: &[Plane]) -> Vec<u32> {
    cut_within(simulation, slot, planes, 1e-5)
}

fn parts_of(simulation: &Simulation, slot: u32) -> usize {
    simulation.bodies.compound(slot).map_or(1, Compound::len)
}

#[test]
fn a_table_cut_through_its_legs_leaves_stumps() {
    let mut simulation = awake();
    simulation.bodies.insert(floor(0.6)).expect("usable");
    let desk = simulation
        .bodies
        .insert(BodyDesc::compound(table(), Vec3::ZERO));
    let desk = desk.expect("usable");
    let plane = Plane::through(0.3 * Vec3::Y, Vec3::Y);
    let pieces = cut(&mut simulation, desk, &[plane]);
    let mut counts: Vec<usize> = pieces.iter().map(|&p| parts_of(&simulation, p)).collect();
    counts.sort_unstable();
    assert_eq!(counts, [1, 1, 1, 1, 5]);
    // Stumps are hulls.
    let hulls = pieces
        .iter()
        .filter(|&&p| simulation.bodies.convex(p).is_some());
    assert_eq!(hulls.count(), 4);
    for _ in 0..240 {
        simulation.step(H);
    }
    for &piece in &pieces {
        let height = simulation.bodies.center_of_mass(piece).y;
        assert!(height > 0.02 && height < 0.75, "{height}");
    }
}

#[test]
fn an_arch_cut_in_the_middle_is_two_of_two_parts() {
    let mut simulation = awake();
    let body = simulation
        .bodies
        .insert(BodyDesc::compound(arch(), Vec3::ZERO));
    let body = body.expect("usable");
    let plane = Plane::through(Vec3::ZERO, Vec3::X);
    let pieces = cut(&mut simulation, body, &[plane]);
    let counts: Vec<usize> = pieces.iter().map(|&p| parts_of(&simulation, p)).collect();
    assert_eq!(counts, [2, 2]);
}

#[test]
fn random_cuts_keep_mass_and_momentum() {
    let mut several = 0;
    for seed in 0..80 {
        let dice = &mut Dice::new(seed);
        let shape = match dice.below(5) {
            0 => table(),
            1 => chair(),
            2 => cup(),
            3 => arch(),
            _ => dumbbell(),
        };
        let mut simulation = awake();
        let gravity = &mut simulation.gravity;
        gravity.0 = Vec3::ZERO;
        let aabb = shape.aabb();
        let is_round = shape.parts().iter().any(|part| part.shape.is_round());
        let body = BodyDesc {
            pose: Pose::new(dice.vector(-2.0, 2.0), dice.rotation()),
            linear_velocity: dice.vector(-3.0, 3.0),
            angular_velocity: dice.vector(-3.0, 3.0),
            ..BodyDesc::compound(shape, Vec3::ZERO)
        };
        let pose = body.pose;
        let body = simulation.bodies.insert(body).expect("usable");
        let planes: Vec<Plane> = (0..1 + dice.below(3))
            .map(|_| {
                let at = dice.vector(0.3, 0.7) * aabb.extents() + aabb.min;
                Plane::through(pose.transform_point(at), dice.direction())
            })
            .collect();
        let off = if is_round { 0.02 } else { 1e-5 };
        let pieces = cut_within(&mut simulation, body, &planes, off);
        several += usize::from(pieces.iter().any(|&p| parts_of(&simulation, p) > 1));
        for &piece in &pieces {
            let Some(compound) = simulation.bodies.compound(piece) else {
                continue;
            };
            // All of it hangs together.
            let mut reached = vec![0];
            let mut next = 0;
            while let Some(&part) = reached.get(next) {
                next += 1;
                for &other in compound.neighbors(part) {
                    if !reached.contains(&(other as usize)) {
                        reached.push(other as usize);
                    }
                }
            }
            assert_eq!(reached.len(), compound.len(), "{seed}");
        }
    }
    assert!(several > 30, "{several} had pieces of several parts");
}

/// The mesh that is drawn goes with the parts.
#[test]
fn the_visual_mesh_is_cut_too() {
    let walls = (0..5).flat_map(|x| (0..5).flat_map(move |z| (0..5).map(move |y| [x, y, z])));
    let is_wall = |&[x, y, z]: &[i32; 3]| y == 0 || x == 0 || x == 4 || z == 0 || z == 4;
    let mesh = voxels(&walls.filter(is_wall).collect::<Vec<_>>());
    let volume = mesh.volume();
    let vessel = Compound::from_mesh(mesh, DecompositionOptions::default()).expect("a solid");
    let mut simulation = awake();
    let body = simulation
        .bodies
        .insert(BodyDesc::compound(vessel, Vec3::ZERO));
    let body = body.expect("usable");
    // Through the walls and not the bottom: the upper half of the rim in two.
    let planes = [
        Plane::through(2.63 * Vec3::Y, Vec3::Y),
        Plane::through(Vec3::new(2.37, 0.0, 0.0), Vec3::X),
    ];
    let pieces = cut(&mut simulation, body, &planes);
    assert_eq!(pieces.len(), 4);
    let mut sum = 0.0;
    for piece in pieces {
        let bodies = &simulation.bodies;
        let visual = match bodies.compound(piece) {
            Some(compound) => compound.visual(),
            None => bodies.convex(piece).and_then(ConvexMesh::visual),
        };
        let mesh = visual.expect("what is drawn");
        assert!(mesh.is_closed());
        sum += mesh.volume();
        let mass = f64::from(bodies.mass(piece).mass) / 1000.0;
        assert!((mass / mesh.volume() - 1.0).abs() < 0.05, "{mass}");
    }
    assert!((sum / volume - 1.0).abs() < 1e-5, "{sum} {volume}");
}

#[test]
fn what_of_a_compound_stands_stays_and_the_rest_falls() {
    let mut simulation = awake();
    simulation.bodies.insert(floor(0.6)).expect("usable");
    let desc = BodyDesc {
        kind: RigidBody::Static,
        ..BodyDesc::compound(arch(), Vec3::ZERO)
    };
    let body = simulation.bodies.insert(desc).expect("usable");
    let plane = Plane::through(0.8 * Vec3::Y, Vec3::new(0.1, 1.0, 0.0).normalize());
    let pieces = cut(&mut simulation, body, &[plane]);
    let kinds: Vec<_> = pieces
        .iter()
        .map(|&p| (parts_of(&simulation, p), simulation.bodies.kind(p)))
        .collect();
    let standing = kinds.iter().filter(|k| **k == (1, RigidBody::Static));
    assert_eq!(standing.count(), 2, "{kinds:?}");
    assert!(kinds.contains(&(3, RigidBody::Dynamic)), "{kinds:?}");
}

#[test]
fn a_blow_breaks_the_part_that_it_strikes() {
    let mut broken = 0;
    for seed in 0..12 {
        let dice = &mut Dice::new(seed);
        let mut simulation = awake();
        simulation.bodies.insert(floor(0.6)).expect("usable");
        let desc = BodyDesc {
            pose: Pose::new(2.0 * Vec3::Y, dice.rotation()),
            linear_velocity: -4.0 * Vec3::Y,
            fracturable: Some(Fracturable {
                strength: 20.0,
                pattern: FracturePattern::Voronoi {
                    cells: 4,
                    focus: 0.0,
                },
                generations: 1,
                min_volume: 1e-9,
                seed,
                ..Fracturable::default()
            }),
            density: 600.0,
            ..BodyDesc::compound(chair(), Vec3::ZERO)
        };
        simulation.bodies.insert(desc).expect("usable");
        let whole = VolumeIntegrals::of_compound(&chair()).volume;
        for _ in 0..120 {
            simulation.step(H);
            for fracture in &simulation.fractures.done {
                let ledger = &fracture.ledger;
                assert!(ledger.mass_error() <= 1e-6, "{seed}");
                assert!(ledger.momentum_error() <= 1e-5, "{seed}");
                broken += 1;
            }
        }
        let bodies = &simulation.bodies;
        let mass: f64 = bodies
            .iter()
            .skip(1)
            .map(|s| f64::from(bodies.mass(s).mass))
            .sum();
        assert!(
            (mass / (600.0 * whole) - 1.0).abs() < 1e-5,
            "{seed}: {mass}"
        );
        let up = bodies
            .iter()
            .skip(1)
            .all(|s| bodies.center_of_mass(s).y > 0.0);
        assert!(up, "{seed}");
    }
    assert!(broken > 8, "{broken} fractures");
}

#[test]
fn planes_that_miss_are_refused() {
    let mut simulation = awake();
    let body = simulation
        .bodies
        .insert(BodyDesc::compound(table(), Vec3::ZERO));
    let body = body.expect("usable");
    for plane in [
        Plane::through(5.0 * Vec3::Y, Vec3::Y),
        Plane::through(-5.0 * Vec3::Y, Vec3::Y),
    ] {
        simulation.slice(body, plane).expect("a body");
        simulation.step(H);
        assert!(simulation.fractures.done.is_empty());
        assert_eq!(simulation.fractures.refused[0].1, CutError::Missed);
    }
    assert!(simulation.bodies.contains(body));
}
