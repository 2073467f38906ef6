//! Levels, cuts, and what a cluster is built from.

use crate::common::dice::Dice;
use crate::common::scenes::{awake, awake_on_floor};
use crate::shapes::{parts_of, row, wall};
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

const H: f32 = 1.0 / 60.0;

/// Big chunks that break into small ones: inside of a chunk the bonds are twenty times as strong.
fn levels(strength: f32) -> Compound {
    let block = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box");
    let chunks = FracturePattern::Voronoi {
        cells: 6,
        focus: 0.0,
    };
    let coarse = Cluster::cut(&block, &chunks, 3, strength).expect("chunks");
    let crumbs = FracturePattern::Voronoi {
        cells: 5,
        focus: 0.0,
    };
    let fine = coarse.refined(&crumbs, 4, 20.0 * strength).expect("crumbs");
    fine.compound().expect("one block")
}

/// Shares of the bonds between chunks and within them that break when the block falls with a speed.
fn broken_by_fall(shape: &Compound, speed: f32) -> [f32; 2] {
    let mut simulation = awake_on_floor();
    let turn = Quat::from_xyzw(0.2, 0.1, 0.3, 0.9).normalize();
    let desc = BodyDesc {
        pose: Pose::new(Vec3::Y, turn),
        linear_velocity: -speed * Vec3::Y,
        ..BodyDesc::compound(shape.clone(), Vec3::ZERO)
    };
    simulation.bodies.insert(desc).expect("usable");
    (0..60).for_each(|_| simulation.step(H));
    let bodies = &simulation.bodies;
    let dynamic = bodies
        .iter()
        .filter(|&slot| bodies.kind(slot) == RigidBody::Dynamic);
    let parts = dynamic.map(|slot| parts_of(&simulation, slot));
    assert_eq!(parts.sum::<usize>(), shape.len());
    let weak = shape.bonds().iter().map(|bond| bond.strength);
    let weak = weak.fold(f32::INFINITY, f32::min);
    let count = |shape: &Compound, is_weak: bool| {
        let bonds = shape.bonds().iter();
        bonds
            .filter(|bond| (bond.strength == weak) == is_weak)
            .count()
    };
    [true, false].map(|is_weak| {
        let compounds = bodies.iter().filter_map(|slot| bodies.compound(slot));
        let left: usize = compounds.map(|shape| count(shape, is_weak)).sum();
        1.0 - left as f32 / count(shape, is_weak) as f32
    })
}

#[test]
fn chunks_come_apart_before_they_crumble() {
    let shape = levels(2e5);
    assert_eq!(shape.len(), 30);
    let mut speed = 0.2;
    let gentle = loop {
        let broken = broken_by_fall(&shape, speed);
        if broken[0] > 0.2 {
            break broken;
        }
        speed *= 1.25;
    };
    assert!(gentle[1] < 0.25 * gentle[0], "{gentle:?} at {speed} m/s");
    let hard = broken_by_fall(&shape, 60.0);
    assert!(hard[0] > 0.8 && hard[1] > 0.4, "{hard:?}");
}

#[test]
fn a_cut_leaves_bonds_where_faces_are_still_shared() {
    let mut simulation = awake();
    let body = simulation.bodies.insert(BodyDesc::compound(
        row(6, Vec3::splat(0.2), 1e5),
        Vec3::ZERO,
    ));
    let body = body.expect("usable");
    // Along the row, through all of its parts.
    simulation
        .slice(body, Plane::through(Vec3::ZERO, Vec3::Y))
        .expect("a body");
    simulation.step(H);
    let pieces = simulation.fractures.done[0].pieces.clone();
    assert_eq!(pieces.len(), 2);
    for piece in pieces {
        let shape = simulation.bodies.compound(piece).expect("several parts");
        assert!(shape.is_bonded());
        assert_eq!((shape.len(), shape.bonds().len()), (6, 5));
        for bond in shape.bonds() {
            assert!((bond.area - 0.02).abs() < 1e-5, "{bond:?}");
            assert_eq!(bond.strength, 1e5);
        }
    }
}

#[test]
fn bonds_of_a_scaled_cluster_are_those_of_scaled_parts() {
    let factor = Vec3::new(2.0, 0.5, 3.0);
    let scaled = wall(4, 4, 1e5).scaled(factor).expect("usable");
    let anew = scaled.clone().bonded(1e5).expect("one wall");
    assert_eq!(scaled.bonds().len(), anew.bonds().len());
    for (a, b) in scaled.bonds().iter().zip(anew.bonds()) {
        assert_eq!(a.parts, b.parts);
        assert!((a.area - b.area).abs() < 1e-4 * b.area, "{a:?} {b:?}");
        assert!((a.center - b.center).length() < 1e-4, "{a:?} {b:?}");
        assert!((a.normal - b.normal).length() < 1e-4, "{a:?} {b:?}");
    }
}

#[test]
fn bad_input_is_told() {
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box");
    for strength in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let made = Cluster::new([cube.clone()], strength);
        assert!(matches!(made, Err(ClusterError::Strength { .. })));
    }
    let apart = [0.0, 3.0].map(|x| (Pose::from_position(Vec3::X * x), cube.clone()));
    let cluster = Cluster::new(apart, 1e5).expect("parts");
    assert_eq!(
        cluster.compound().map(|it| it.len()),
        Err(CompoundError::Unbonded { part: 1 })
    );
    assert_eq!(cluster.separated().len(), 2);
    let far = FracturePattern::Planes([Plane::through(9.0 * Vec3::X, Vec3::X)].into());
    let uncut = Cluster::cut(&cube, &far, 0, 1e5).map(|it| it.parts.len());
    assert_eq!(uncut, Err(ClusterError::NoPieces));
}

#[test]
fn a_relief_is_seen_on_the_faces_of_the_cuts_and_changes_nothing_else() {
    let mut dice = Dice::new(347);
    for round in 0..6 {
        let size = dice.vector(0.5, 1.5);
        let whole = ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box");
        let cells = dice.in_range(4.0, 16.0) as u16;
        let pattern = FracturePattern::Voronoi { cells, focus: 0.0 };
        let relief = Relief::of_size(dice.in_range(0.1, 0.2));
        let flat = Cluster::cut(&whole, &pattern, round, 1e5).expect("cells");
        let rough = Cluster::cut_rough(&whole, &pattern, round, 1e5, relief).expect("cells");
        assert_eq!(flat.bonds, rough.bonds);
        let (mut seen, mut triangles) = (0.0, [0, 0]);
        for (flat, rough) in flat.parts.iter().zip(&rough.parts) {
            assert_eq!(flat.shape.hull().vertices(), rough.shape.hull().vertices());
            let mesh = rough.shape.visual().expect("drawn");
            assert!(mesh.is_closed());
            seen += mesh.volume();
            triangles[0] += flat.shape.render_mesh().triangles().len();
            triangles[1] += mesh.triangles().len();
        }
        let volume = f64::from(size.element_product());
        assert!((seen - volume).abs() < 1e-5 * volume, "{seen} of {volume}");
        assert!(triangles[1] > 2 * triangles[0], "{triangles:?}");
        let compound = rough.compound().expect("one body");
        assert_eq!(compound.len(), flat.parts.len());
    }
    let whole = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box");
    let flat = Relief::of_size(0.0);
    let halves = FracturePattern::Slabs { count: 2 };
    let refused = Cluster::cut_rough(&whole, &halves, 1, 1e5, flat);
    assert!(matches!(refused, Err(ClusterError::Relief(_))));
}

/// Parts are what they would be without relief, whatever level has it; walls of both levels fit, and are rough.
#[test]
fn relief_of_a_level_changes_what_is_drawn_and_nothing_else() {
    let mut dice = Dice::new(348);
    for round in 0..8 {
        let size = dice.vector(0.6, 1.5);
        let whole = ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box");
        let mut cells = |least: f32| {
            let cells = dice.in_range(least, 2.5 * least) as u16;
            FracturePattern::Voronoi { cells, focus: 0.0 }
        };
        let (chunks, crumbs) = (cells(4.0), cells(3.0));
        let relief = Relief::of_size(dice.in_range(0.08, 0.16));
        let smooth = Cluster::cut(&whole, &chunks, round, 1e5).expect("cells");
        let coarse = [
            smooth.clone(),
            Cluster::cut_rough(&whole, &chunks, round, 1e5, relief).expect("cells"),
        ];
        let flat = smooth.refined(&crumbs, 7, 1e6).expect("crumbs");
        let mut triangles = Vec::new();
        for coarse in &coarse {
            let rough = coarse.refined_rough(&crumbs, 7, 1e6, relief);
            for fine in [coarse.refined(&crumbs, 7, 1e6), rough] {
                let fine = fine.expect("crumbs");
                assert_eq!(fine.bonds, flat.bonds, "round {round}");
                let (mut seen, mut count) = (0.0, 0);
                for (flat, fine) in flat.parts.iter().zip(&fine.parts) {
                    assert_eq!(flat.shape.hull().vertices(), fine.shape.hull().vertices());
                    let mesh = fine.shape.render_mesh();
                    assert!(mesh.is_closed());
                    seen += mesh.volume();
                    count += mesh.triangles().len();
                }
                let volume = f64::from(size.element_product());
                assert!((seen - volume).abs() < 1e-5 * volume, "{seen} of {volume}");
                triangles.push(count);
            }
        }
        let is_rougher = |a: usize, b: usize| triangles[b] as f32 > 1.3 * triangles[a] as f32;
        assert!(is_rougher(0, 1) && is_rougher(0, 2), "{triangles:?}");
        assert!(is_rougher(1, 3) && is_rougher(2, 3), "{triangles:?}");
    }
    let whole = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box");
    let halves = FracturePattern::Slabs { count: 2 };
    let cluster = Cluster::cut(&whole, &halves, 1, 1e5).expect("halves");
    let refused = cluster.refined_rough(&halves, 1, 1e5, Relief::of_size(f32::NAN));
    assert!(matches!(refused, Err(ClusterError::Relief(_))));
}
