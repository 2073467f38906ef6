//! Pieces whose visual meshes fall apart: which parts become pieces of their own, and with which hulls.

use crate::common::dice::Dice;
use crate::common::mesh_parts::{cuboid, joined, torus};
use crate::common::scenes::awake;
use bevy_cleave::geometry::{TriMesh, primitives};
use bevy_cleave::math::Plane;
use bevy_cleave::prelude::*;
use bevy_cleave::slice::{Cutting, Piece, PieceCutter, SliceOptions};
use glam::Vec3;

/// A slab of 2 x 0.5 x 1 m with four legs of 0.2 x 1 x 0.2 m that reach 0.1 m into it.
fn table() -> TriMesh {
    let mut parts = vec![(
        cuboid(Vec3::new(2.0, 0.5, 1.0), Vec3::new(0.0, 0.15, 0.0)),
        false,
    )];
    for [x, z] in [[-0.8, -0.3], [0.8, -0.3], [-0.8, 0.3], [0.8, 0.3]] {
        let leg = cuboid(Vec3::new(0.2, 1.0, 0.2), Vec3::new(x, -0.5, z));
        parts.push((leg, false));
    }
    joined(&parts)
}

/// Cuts a mesh in its hull, takes the pieces apart, and checks that each is sound.
fn cut(mesh: TriMesh, planes: &[Plane]) -> Vec<Piece> {
    let volume = mesh.volume();
    let shape = ConvexMesh::from_mesh(mesh).unwrap();
    let cutting = Cutting::Planes(planes.iter().copied().collect());
    let mut cutter = PieceCutter::default();
    let (hull, visual) = (shape.hull(), shape.visual());
    let options = SliceOptions::default();
    let mut pieces = (cutter.cut(hull, visual, &cutting, usize::MAX, options)).unwrap();
    cutter.separate(&mut pieces).unwrap();
    let mut sum = 0.0;
    for piece in &pieces {
        assert!(piece.hull.is_valid());
        assert_eq!(piece.volume, piece.hull.volume());
        let mesh = piece.visual.as_ref().unwrap();
        assert!(mesh.is_closed());
        assert!(mesh.volume() <= piece.volume * (1.0 + 1e-6));
        let around = piece.hull.aabb().fattened(1e-6);
        assert!(around.contains(&mesh.aabb()));
        sum += mesh.volume();
    }
    assert!((sum - volume).abs() <= 1e-6 * volume, "{sum} {volume}");
    pieces
}

fn across(height: f32) -> Plane {
    Plane::through(Vec3::new(0.0, height, 0.0), Vec3::Y)
}

#[test]
fn legs_cut_off_a_table_are_pieces_with_hulls_around_them() {
    let pieces = cut(table(), &[across(-0.6)]);
    let stumps: Vec<&Piece> = (pieces.iter())
        .filter(|piece| piece.hull.aabb().max.y < -0.5)
        .collect();
    assert_eq!(stumps.len(), 4);
    for stump in stumps {
        assert!((stump.volume - 0.2 * 0.2 * 0.4).abs() < 1e-6, "{stump:?}");
        assert_eq!(stump.visual.as_ref().unwrap().aabb(), stump.hull.aabb());
    }
    // The rest of the legs reach into the slab, so that the five parts above the plane stay together.
    assert_eq!(pieces.len(), 5);
}

#[test]
fn parts_whose_hulls_reach_into_each_other_stay_together() {
    // A block in the notch of an L: outside its mesh, inside its hull.
    let l = [
        (Vec3::new(3.0, 1.0, 1.0), Vec3::new(1.5, 0.5, 0.5)),
        (Vec3::new(1.0, 2.0, 1.0), Vec3::new(0.5, 1.9, 0.5)),
    ];
    let block = (Vec3::splat(0.3), Vec3::new(1.3, 1.3, 0.5));
    let far = (Vec3::splat(0.3), Vec3::new(2.8, 2.8, 0.5));
    let parts = l.into_iter().chain([block, far]);
    let mesh = joined(
        &parts
            .map(|(size, at)| (cuboid(size, at), false))
            .collect::<Vec<_>>(),
    );
    let pieces = cut(mesh, &[]);
    let volumes: Vec<f64> = pieces
        .iter()
        .map(|piece| piece.visual.as_ref().unwrap().volume())
        .collect();
    assert_eq!(pieces.len(), 2, "{volumes:?}");
    assert!((volumes[1] - 0.027).abs() < 1e-6, "{volumes:?}");
}

#[test]
fn joining_goes_on_until_no_hulls_overlap() {
    // The hull around the first two blocks, which overlap, reaches into the third, which neither of them does.
    let blocks = [
        (Vec3::new(4.0, 1.0, 1.0), Vec3::ZERO),
        (Vec3::new(1.0, 4.0, 1.0), Vec3::new(-1.5, 1.9, 0.0)),
        (Vec3::splat(0.5), Vec3::new(-0.3, 1.2, 0.0)),
    ];
    let mesh = joined(&blocks.map(|(size, at)| (cuboid(size, at), false)));
    assert_eq!(cut(mesh, &[]).len(), 1);
}

#[test]
fn hollow_and_whole_bodies_stay_as_they_are() {
    let hollow = joined(&[
        (cuboid(Vec3::splat(2.0), Vec3::ZERO), false),
        (cuboid(Vec3::splat(1.0), Vec3::ZERO), true),
    ]);
    let pieces = cut(hollow, &[across(0.8)]);
    assert_eq!(pieces.len(), 2, "a cavity is no part");
    let whole = cuboid(Vec3::ONE, Vec3::ZERO);
    assert_eq!(cut(whole, &[across(0.1)]).len(), 2);
}

#[test]
fn pieces_without_meshes_stay_as_they_are() {
    let hull = primitives::cuboid(1.0, 1.0, 1.0).unwrap();
    let cutting = Cutting::Planes([across(0.1)].into_iter().collect());
    let mut cutter = PieceCutter::default();
    for visual in [None, Some(&TriMesh::default())] {
        let options = SliceOptions::default();
        let mut pieces = (cutter.cut(&hull, visual, &cutting, usize::MAX, options)).unwrap();
        cutter.separate(&mut pieces).unwrap();
        assert_eq!(pieces.len(), 2);
    }
}

/// Volume of the hull around a table, m3: it goes from 1.8 x 0.8 m at the feet to 2 x 1 m at the slab, 0.9 m higher.
const TABLE_HULL: f64 = 0.9 * (1.44 + 0.26 + 0.04 / 3.0) + 1.0;

/// The same of what of it is more than 0.5 m above the feet: legs of 1.8 x 0.8 m, 0.4 m below the slab.
const UPPER_HULL: f64 = 0.4 * (1.44 + 0.26 + 0.04 / 3.0) + 1.0;

/// Cuts a table that turns and flies through its legs, as a body.
fn cut_body(separate_parts: bool) -> Simulation {
    let mut simulation = awake();
    let shape = ConvexMesh::from_mesh(table()).unwrap();
    let mut table = BodyDesc::dynamic(shape, Vec3::ZERO);
    table.linear_velocity = Vec3::new(1.0, 2.0, -3.0);
    table.angular_velocity = Vec3::new(0.5, 1.0, -0.3);
    table.fracturable = Some(Fracturable {
        separate_parts,
        ..Fracturable::with_strength(f32::INFINITY)
    });
    let slot = simulation.bodies.insert(table).unwrap();
    simulation.slice(slot, across(-0.5)).unwrap();
    simulation.step(1.0 / 60.0);
    simulation
}

#[test]
fn legs_of_a_body_fall_on_their_own_and_the_air_between_them_is_in_the_ledger() {
    let simulation = cut_body(true);
    let made = &simulation.fractures.done[0];
    assert_eq!(made.pieces.len(), 5);
    let air = TABLE_HULL - UPPER_HULL - 4.0 * 0.2 * 0.2 * 0.5;
    let density = f64::from(Density::default().0);
    let ledger = &made.ledger;
    assert!((ledger.dropped.mass / (air * density) - 1.0).abs() < 1e-5);
    assert_eq!(ledger.dropped_pieces, 0);
    assert!(ledger.mass_error() < 1e-6);
    assert!(ledger.momentum_error() < 1e-5);
    assert!(ledger.angular_momentum_error() < 1e-5);
    assert!(ledger.energy_gain().abs() < 1e-5);
}

#[test]
fn parts_of_a_body_stay_together_unless_asked_for() {
    let simulation = cut_body(false);
    let made = &simulation.fractures.done[0];
    assert_eq!(made.pieces.len(), 2);
    // The hull around what is seen of each half is smaller than half of the hull.
    let air = TABLE_HULL - UPPER_HULL - 1.8 * 0.8 * 0.5;
    let density = f64::from(Density::default().0);
    assert!((made.ledger.dropped.mass / (air * density) - 1.0).abs() < 1e-5);
    assert!(made.ledger.mass_error() < 1e-6);
}

/// A cup of 12 sides: 1 m high, 1 m wide, its wall and its bottom a tenth of that.
fn cup() -> TriMesh {
    use bevy_cleave::import::{ImportOptions, Model, ModelObject};
    let profile = [(0.5, -0.5), (0.5, 0.5), (0.4, 0.5), (0.4, -0.4)];
    let turn = |k: u16| glam::Quat::from_rotation_y(f32::from(k) * std::f32::consts::FRAC_PI_6);
    let corners: Vec<Vec3> = (0..12).map(|k| turn(k) * Vec3::X).collect();
    let n = corners.len() as u32;
    let at = |(radius, y): (f32, f32)| {
        corners
            .iter()
            .map(move |p| Vec3::new(radius * p.x, y, radius * p.z))
    };
    let positions = profile.into_iter().flat_map(at).collect();
    let quads = (0..3).flat_map(|row| (0..n).map(move |i| (row * n + i, row * n + (i + 1) % n)));
    let triangles = quads
        .flat_map(|(a, b)| [[a, b, b + n], [a, b + n, a + n]])
        .collect();
    // The two bottoms are holes.
    let wall = ModelObject {
        positions,
        triangles,
        ..ModelObject::default()
    };
    Model::from_object(wall)
        .import(&ImportOptions {
            max_fill: 5.0,
            ..Default::default()
        })
        .unwrap()
        .mesh
}

/// A cup in a body, broken into cells by cuts through and through; by its hull or by its wall.
fn break_cup(weighs_visual: bool) -> (Simulation, f64) {
    let mesh = cup();
    let volume = mesh.volume();
    let mut shape = ConvexMesh::from_mesh(mesh).unwrap();
    if weighs_visual {
        shape = shape.with_mass_of_visual();
    }
    let mut simulation = awake();
    let mut body = BodyDesc::dynamic(shape, Vec3::ZERO);
    body.angular_velocity = Vec3::new(0.3, -0.2, 0.5);
    body.linear_velocity = Vec3::new(1.0, 0.0, 0.5);
    let slot = simulation.bodies.insert(body).unwrap();
    for k in [-0.3, -0.1, 0.1, 0.3] {
        for normal in [Vec3::X, Vec3::Y, Vec3::Z] {
            simulation
                .slice(slot, Plane::through(k * normal, normal))
                .unwrap();
        }
    }
    simulation.step(1.0 / 60.0);
    (simulation, volume)
}

#[test]
fn shards_of_a_cup_are_all_seen_and_their_hulls_are_around_what_is_seen() {
    for weighs_visual in [false, true] {
        let (simulation, volume) = break_cup(weighs_visual);
        let made = &simulation.fractures.done[0];
        assert!(made.pieces.len() > 50, "{}", made.pieces.len());
        let density = f64::from(Density::default().0);
        let (mut mass, mut hulls) = (0.0, 0.0);
        for &slot in &made.pieces {
            let shape = simulation.bodies.convex(slot).unwrap();
            let mesh = shape.visual().unwrap();
            assert!(!mesh.triangles().is_empty(), "a shard that is not seen");
            let (hull, seen) = (shape.aabb(), mesh.aabb());
            let gap = (hull.min - seen.min).abs().max((hull.max - seen.max).abs());
            assert!(gap.max_element() <= 1e-3 * seen.diagonal(), "{gap}");
            mass += f64::from(simulation.bodies.mass(slot).mass);
            hulls += shape.hull().volume();
        }
        let ledger = &made.ledger;
        assert!(ledger.mass_error() < 1e-6, "{}", ledger.mass_error());
        assert!(ledger.momentum_error() < 1e-5);
        assert!(ledger.angular_momentum_error() < 1e-5);
        let weighed = if weighs_visual { volume } else { hulls };
        assert!((mass / (weighed * density) - 1.0).abs() < 1e-6, "{mass}");
        if weighs_visual {
            assert!(
                ledger.dropped.mass.abs() < 1e-6 * mass,
                "{}",
                ledger.dropped.mass
            );
            assert!((ledger.before.mass / (volume * density) - 1.0).abs() < 1e-6);
        }
    }
}

/// Hollow solids of many kinds.
fn hollow(dice: &mut Dice) -> TriMesh {
    match dice.below(4) {
        0 => cup(),
        1 => torus(0.5, dice.in_range(0.05, 0.2), 12, 8),
        2 => table(),
        _ => {
            let size = dice.vector(0.4, 1.5);
            let room = dice.in_range(0.6, 0.95) * size;
            joined(&[
                (cuboid(size, Vec3::ZERO), false),
                (cuboid(room, Vec3::ZERO), true),
            ])
        }
    }
}

/// A tip of a hull that nothing is seen in may have next to no volume, and still be a tenth as long as the hull.
#[test]
fn no_tip_of_a_hull_is_far_from_what_is_seen() {
    let mut dice = Dice::new(349);
    let mut cutter = PieceCutter::default();
    for round in 0..120 {
        let shape = ConvexMesh::from_mesh(hollow(&mut dice)).unwrap();
        let extents = shape.aabb().extents();
        let middle = shape.aabb().center();
        let site = |_| middle + 0.6 * extents * dice.vector(-1.0, 1.0);
        let sites: Vec<Vec3> = (0..24).map(site).collect();
        let (hull, visual) = (shape.hull(), shape.visual());
        let sites = Cutting::Sites(sites);
        let mut pieces = (cutter.cut(hull, visual, &sites, 24, SliceOptions::default())).unwrap();
        pieces.retain(|piece| (piece.visual.as_ref()).is_some_and(|m| !m.triangles().is_empty()));
        cutter.separate(&mut pieces).unwrap();
        PieceCutter::fit_hulls(&mut pieces).unwrap();
        for piece in &pieces {
            let mesh = piece.visual.as_ref().unwrap();
            let near = 0.004 * piece.hull.aabb().extents().max_element();
            for corner in piece.hull.vertices() {
                let gaps = mesh.positions().iter().map(|p| p.distance(*corner));
                let gap = gaps.fold(f32::INFINITY, f32::min);
                assert!(gap < near, "round {round}: a tip of {gap} m");
            }
        }
    }
}
