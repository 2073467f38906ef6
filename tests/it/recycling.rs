//! Pairs that are not tested anew in each step: what is kept of them is what a new test would find.
#![allow(clippy::print_stdout, reason = "figures are told with --nocapture")]

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use bevy_cleave::contact::{ContactPoint, Manifold, ManifoldRef, NarrowScratch, collide_hulls};
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// Length of a step, s.
const H: f32 = 1.0 / 60.0;

/// Share of the least extent of the smaller body at which contacts of resting bodies are found (`src/collide.rs`).
const MARGIN: f32 = 0.02;

fn rock(random: &mut Dice) -> ConvexMesh {
    let points: Vec<Vec3> = (0..8 + random.below(12))
        .map(|_| random.vector(-0.5, 0.5))
        .collect();
    ConvexMesh::from_points(&points).expect("random points are not flat")
}

fn shape(random: &mut Dice) -> ConvexMesh {
    let edge = |random: &mut Dice| random.in_range(0.3, 1.2);
    match random.below(2) {
        0 => ConvexMesh::cuboid(edge(random), edge(random), edge(random)).expect("a box is valid"),
        _ => rock(random),
    }
}

/// Two bodies without gravity.
fn pair(a: &ConvexMesh, b: &ConvexMesh, pose_b: Pose) -> Simulation {
    let mut simulation = Simulation {
        gravity: Gravity(Vec3::ZERO),
        ..awake()
    };
    let mut desc = BodyDesc::dynamic(a.clone(), Vec3::ZERO);
    desc.kind = RigidBody::Static;
    simulation.bodies.insert(desc).expect("a body");
    let mut desc = BodyDesc::dynamic(b.clone(), Vec3::ZERO);
    desc.pose = pose_b;
    simulation.bodies.insert(desc).expect("a body");
    simulation
}

/// The manifold that a step finds with B at rest at `pose_b`.
fn manifold_at(simulation: &mut Simulation, pose_b: Pose) -> Option<Manifold> {
    let bodies = &mut simulation.bodies;
    bodies.set_pose(1, pose_b).expect("a pose");
    bodies
        .set_velocity(1, Vec3::ZERO, Vec3::ZERO)
        .expect("rest");
    simulation.step(H);
    simulation
        .contacts
        .manifolds()
        .get(0)
        .map(ManifoldRef::to_owned)
}

fn deepest(manifold: &Manifold) -> f32 {
    let separations = manifold.points().iter().map(|p| p.separation);
    separations.fold(f32::INFINITY, f32::min)
}

fn min_extent(a: &ConvexMesh, b: &ConvexMesh) -> f32 {
    let extent = |mesh: &ConvexMesh| mesh.hull().aabb().extents().min_element();
    extent(a).min(extent(b))
}

/// Moves a pose by about `step` (m) and turns it by as much (rad).
fn nudged(random: &mut Dice, pose: Pose, step: f32) -> Pose {
    let turn = 0.5 * random.vector(-step, step);
    let turn = Quat::from_xyzw(turn.x, turn.y, turn.z, 1.0).normalize();
    Pose::new(
        pose.position + random.vector(-step, step),
        (turn * pose.rotation).normalize(),
    )
}

/// B above A, the hulls just touching.
fn touching_pose(random: &mut Dice, a: &ConvexMesh, b: &ConvexMesh) -> Pose {
    let mut scratch = NarrowScratch::new();
    let side = random.vector(-0.3, 0.3);
    let rotation = random.rotation();
    let at = |height: f32| Pose::new(Vec3::new(side.x, height, side.z), rotation);
    let (mut low, mut high) = (0.0, 3.0);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        let touches = collide_hulls(a.hull(), b.hull(), at(middle), 0.0, &mut scratch);
        (low, high) = if touches.is_some() {
            (middle, high)
        } else {
            (low, middle)
        };
    }
    at(low)
}

#[test]
fn a_kept_contact_is_what_a_new_test_finds() {
    let mut random = Dice::new(41);
    let mut errors = Vec::new();
    for _ in 0..300 {
        let (a, b) = (shape(&mut random), shape(&mut random));
        let extent = min_extent(&a, &b);
        let mut pose = touching_pose(&mut random, &a, &b);
        let mut kept = pair(&a, &b, pose);
        for _ in 0..20 {
            pose = nudged(&mut random, pose, 2e-4 * extent);
            let old = manifold_at(&mut kept, pose).expect("touching");
            let new = manifold_at(&mut pair(&a, &b, pose), pose).expect("touching");
            errors.push((deepest(&old) - deepest(&new)).abs() / extent);
        }
    }
    errors.sort_by(f32::total_cmp);
    let [median, most, worst] =
        [0.5, 0.99, 1.0].map(|p| errors[((errors.len() - 1) as f64 * p) as usize]);
    println!("median {median:.1e}, 99 % {most:.1e}, worst {worst:.1e} of the least extent");
    assert!(
        median < 1e-6 && most < 1e-5 && worst < 1e-3,
        "{median} {most} {worst}"
    );
}

/// How far the points of two manifolds are from each other, with their separations, m; infinite for another number.
fn difference(a: &Manifold, b: &Manifold) -> f32 {
    if a.count != b.count {
        return f32::INFINITY;
    }
    let nearest = |p: &ContactPoint| {
        let other = b.points().iter().map(|q| {
            (p.anchor_b - q.anchor_b)
                .length()
                .max((p.anchor_a - q.anchor_a).length())
                .max((p.separation - q.separation).abs())
        });
        other.fold(f32::INFINITY, f32::min)
    };
    a.points().iter().map(nearest).fold(0.0, f32::max)
}

/// A box or prism stands on a wide plate, which is body A or body B.
fn on_a_plate(random: &mut Dice, plate_is_a: bool) -> [ConvexMesh; 2] {
    let plate = ConvexMesh::cuboid(3.0, 0.4, 3.0).expect("a box is valid");
    // Of more corners than four a test chooses, on a tie not always the same.
    let sides = 3 + random.below(2) as u32;
    let (radius, height) = (random.in_range(0.2, 0.5), random.in_range(0.2, 0.6));
    let piece = ConvexMesh::regular_prism(sides, radius, height).expect("a prism is valid");
    if plate_is_a {
        [plate, piece]
    } else {
        [piece, plate]
    }
}

#[test]
fn a_contact_kept_on_a_slide_is_what_a_new_test_finds() {
    let mut random = Dice::new(47);
    let (mut worst, mut kept_steps, mut steps) = (0.0_f32, 0, 0);
    for case in 0..100 {
        let plate_is_a = case % 2 == 0;
        let [a, b] = on_a_plate(&mut random, plate_is_a);
        let apart = 0.5 * (a.aabb().extents().y + b.aabb().extents().y);
        let extent = min_extent(&a, &b);
        let side = random.vector(-0.5, 0.5);
        // So that the normal is another one in either body's frame.
        let turn = random.rotation();
        let points: Vec<Vec3> = b.hull().vertices().iter().map(|&v| turn * v).collect();
        let b = ConvexMesh::from_points(&points).expect("a turned piece is valid");
        let mut pose = Pose::new(Vec3::new(side.x, apart, side.z), turn.inverse());
        let way = random.vector(-0.01, 0.01) * Vec3::new(1.0, 1e-3, 1.0);
        let mut kept = pair(&a, &b, pose);
        let mut codes = Vec::new();
        let reach = |at: Vec3| at.x.abs().max(at.z.abs());
        while reach(pose.position) < 1.5 {
            let old = manifold_at(&mut kept, pose).expect("touching");
            let new = manifold_at(&mut pair(&a, &b, pose), pose).expect("touching");
            let at = |p: &ContactPoint| reach(if plate_is_a { p.anchor_a } else { p.anchor_b });
            let farthest = old.points().iter().map(at).fold(0.0, f32::max);
            assert!(farthest < 1.5 + 1e-3 * extent, "case {case}: {farthest}");
            // At the edge there may be more corners than points, and ties among them.
            if new.points().iter().all(|p| at(p) < 1.499) {
                worst = worst.max(difference(&old, &new) / extent);
                // A test finds codes anew.
                let before = codes;
                codes = old.points().iter().map(|p| (p.code_a, p.code_b)).collect();
                steps += 1;
                kept_steps += i32::from(codes == before);
            }
            pose.position += way;
        }
    }
    println!("worst {worst:.1e} of the least extent, {kept_steps} of {steps} contacts kept");
    assert!(worst < 1e-5, "{worst}");
    assert!(2 * kept_steps > steps, "{kept_steps} of {steps} kept");
}

#[test]
fn no_contact_is_missed_on_random_ways() {
    let mut random = Dice::new(43);
    let mut scratch = NarrowScratch::new();
    let (mut touching, mut apart) = (0, 0);
    for case in 0..200 {
        let (a, b) = (shape(&mut random), shape(&mut random));
        let margin = MARGIN * min_extent(&a, &b) * (1.0 - 1e-3);
        let mut pose = Pose::new(random.vector(-1.0, 1.0), random.rotation());
        let mut simulation = pair(&a, &b, pose);
        for step in 0..200 {
            let size = [1e-4, 1e-3, 1e-2, 0.1][random.below(4)];
            pose = nudged(&mut random, pose, size);
            // Back towards A, so that the pair stays near.
            pose.position *= 1.0 - 0.2 * size;
            let found = manifold_at(&mut simulation, pose);
            match collide_hulls(a.hull(), b.hull(), pose, margin, &mut scratch) {
                Some(patch) => {
                    touching += 1;
                    let depth = patch
                        .points()
                        .iter()
                        .map(|p| p.separation)
                        .fold(1.0, f32::min);
                    assert!(
                        found.is_some(),
                        "case {case}, step {step}: {depth} m missed"
                    );
                }
                None => apart += 1,
            }
        }
    }
    assert!(touching > 5000 && apart > 5000, "{touching} {apart}");
}

#[test]
fn a_new_shape_or_place_is_tested_anew() {
    let cube = |edge: f32| ConvexMesh::cuboid(edge, edge, edge).expect("a box is valid");
    let at = |height: f32| Pose::new(Vec3::new(0.0, height, 0.0), Quat::IDENTITY);
    let mut simulation = pair(&cube(1.0), &cube(1.0), at(0.999));
    let first = manifold_at(&mut simulation, at(0.999)).expect("touching");
    assert!((deepest(&first) + 0.001).abs() < 1e-6);

    let larger = BodyDesc::dynamic(cube(1.002), Vec3::ZERO);
    simulation.bodies.redescribe(1, larger).expect("a body");
    let grown = manifold_at(&mut simulation, at(0.999)).expect("touching");
    assert!((deepest(&grown) + 0.002).abs() < 1e-6, "{grown:?}");

    let mut rough = BodyDesc::dynamic(cube(1.002), Vec3::ZERO);
    rough.friction = Friction::new(0.9).with_combine(CombineRule::Max);
    simulation.bodies.redescribe(1, rough).expect("a body");
    let rougher = manifold_at(&mut simulation, at(0.999)).expect("touching");
    assert_eq!(rougher.friction, 0.9);

    assert!(manifold_at(&mut simulation, at(5.0)).is_none());
    let beside = Pose::new(Vec3::new(1.0, 0.0, 0.2), Quat::IDENTITY);
    let moved = manifold_at(&mut simulation, beside).expect("touching");
    assert!((moved.normal - Vec3::X).length() < 1e-6, "{moved:?}");
}
