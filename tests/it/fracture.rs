//! Bodies break when they should, into pieces that add up.

use crate::common::scenes::awake;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3, Vec4};

const H: f32 = 1.0 / 60.0;

fn cuboid(x: f32, y: f32, z: f32) -> ConvexMesh {
    ConvexMesh::cuboid(x, y, z).expect("valid size")
}

fn with_floor() -> Simulation {
    let mut simulation = awake();
    let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    simulation.bodies.insert(floor).expect("usable");
    simulation
}

/// Drops a block from `height` above the floor; fractures of the first second.
fn drop_block(height: f32, fracturable: Fracturable) -> (Simulation, Vec<Fracture>) {
    let mut simulation = with_floor();
    let mut desc = BodyDesc::dynamic(cuboid(1.0, 0.5, 0.4), Vec3::new(0.0, 0.25 + height, 0.0));
    desc.pose.rotation = Quat::from_rotation_z(0.3);
    desc.angular_velocity = Vec3::new(1.0, 2.0, -0.5);
    desc.fracturable = Some(fracturable);
    simulation.bodies.insert(desc).expect("usable");
    let mut done = Vec::new();
    for _ in 0..60 {
        simulation.step(H);
        done.append(&mut simulation.fractures.done.clone());
    }
    (simulation, done)
}

fn check_ledger(fracture: &Fracture) {
    let ledger = &fracture.ledger;
    assert!(ledger.mass_error() < 1e-6, "mass {:e}", ledger.mass_error());
    assert!(
        ledger.momentum_error() < 1e-5,
        "momentum {:e}",
        ledger.momentum_error()
    );
    let angular = ledger.angular_momentum_error();
    assert!(angular < 1e-5, "angular momentum {angular:e}");
    assert!(
        ledger.energy_gain().abs() < 1e-5,
        "energy {:e}",
        ledger.energy_gain()
    );
}

#[test]
fn body_breaks_only_when_the_impulse_passes_its_strength() {
    let weak = Fracturable {
        strength: 200.0,
        ..Default::default()
    };
    // 200 kg at 2 m/s: about 400 N s and more.
    assert!(!drop_block(1.0, weak).1.is_empty());
    let strong = Fracturable {
        strength: 5000.0,
        ..Default::default()
    };
    assert!(drop_block(1.0, strong).1.is_empty());
}

#[test]
fn every_pattern_conserves_mass_momentum_and_energy() {
    for pattern in [
        FracturePattern::SinglePlane,
        FracturePattern::RandomPlane,
        FracturePattern::Star { planes: 4 },
    ] {
        for seed in 0..10 {
            let breaking = Fracturable {
                strength: 100.0,
                pattern: pattern.clone(),
                seed,
                generations: 3,
                ..Default::default()
            };
            let (simulation, done) = drop_block(2.0, breaking);
            assert!(!done.is_empty(), "{pattern:?} {seed}");
            done.iter().for_each(check_ledger);
            let mass: f64 = simulation
                .bodies
                .iter()
                .map(|s| f64::from(simulation.bodies.mass(s).mass))
                .sum();
            let dropped: f64 = done.iter().map(|f| f.ledger.dropped.mass).sum();
            assert!(
                (mass + dropped - 200.0).abs() < 200.0 * 1e-6,
                "{mass} + {dropped} kg"
            );
        }
    }
}

#[test]
fn pieces_are_valid_hulls_and_stop_breaking_after_their_generations() {
    let breaking = Fracturable {
        strength: 1.0,
        generations: 2,
        ..Default::default()
    };
    let (simulation, done) = drop_block(2.0, breaking);
    assert!(done.len() > 2, "pieces break again");
    for slot in simulation.bodies.iter() {
        let Some(mesh) = simulation.bodies.convex(slot) else {
            continue;
        };
        mesh.hull().validate().expect("a valid hull");
        let center = simulation.bodies.mass(slot).center;
        assert!(
            center.length() < 1e-5,
            "pieces live in a frame about their center, not {center}"
        );
    }
    // One plane each time: 2 pieces, then 4, then 8 at the most.
    assert!(
        simulation.bodies.len() <= 1 + 8,
        "{} bodies",
        simulation.bodies.len()
    );
}

#[test]
fn pieces_below_the_least_volume_are_accounted_for() {
    let mut simulation = awake();
    let mut desc = BodyDesc::dynamic(cuboid(1.0, 1.0, 1.0), Vec3::ZERO);
    desc.linear_velocity = Vec3::new(1.0, 2.0, 3.0);
    desc.fracturable = Some(Fracturable {
        min_volume: 0.01,
        strength: f32::INFINITY,
        ..Default::default()
    });
    let slot = simulation.bodies.insert(desc).expect("usable");
    // Two halves, of which one loses a corner of 0.001 m3.
    let planes = [
        Plane::through(Vec3::ZERO, Vec3::X),
        Plane::through(Vec3::new(0.5, 0.5, 0.5) - 0.182 / 3.0, Vec3::ONE),
    ];
    simulation.gravity = Gravity(Vec3::ZERO);
    let h = 1e-6;
    for plane in planes {
        simulation.slice(slot, plane).expect("a body");
    }
    simulation.step(h);
    let [fracture] = &simulation.fractures.done[..] else {
        panic!("{:?}", simulation.fractures)
    };
    assert_eq!(
        (fracture.pieces.len(), fracture.ledger.dropped_pieces),
        (2, 1)
    );
    assert!(
        (fracture.ledger.dropped.mass - 1.0).abs() < 0.02,
        "{:?}",
        fracture.ledger.dropped
    );
    check_ledger(fracture);
}

#[test]
fn cut_that_would_leave_one_piece_is_refused_and_nothing_is_lost() {
    let mut simulation = Simulation {
        gravity: Gravity(Vec3::ZERO),
        ..awake()
    };
    let mut desc = BodyDesc::dynamic(cuboid(1.0, 1.0, 1.0), Vec3::ZERO);
    desc.fracturable = Some(Fracturable {
        min_volume: 0.01,
        strength: f32::INFINITY,
        ..Default::default()
    });
    let slot = simulation.bodies.insert(desc).expect("usable");
    let body = simulation.bodies.id(slot);
    let plane = Plane::through(Vec3::new(0.499, 0.0, 0.0), Vec3::X);
    simulation.slice(slot, plane).expect("a body");
    simulation.step(H);
    assert!(matches!(
        simulation.fractures.refused[..],
        [(_, CutError::TooSmall)]
    ));
    assert_eq!(
        (simulation.bodies.len(), simulation.bodies.id(slot)),
        (1, body)
    );
}

#[test]
fn pieces_of_a_spinning_body_move_as_its_parts_did() {
    let mut simulation = Simulation {
        gravity: Gravity(Vec3::ZERO),
        ..awake()
    };
    let mut desc = BodyDesc::dynamic(cuboid(2.0, 1.0, 1.0), Vec3::new(5.0, -3.0, 2.0));
    desc.linear_velocity = Vec3::new(3.0, 1.0, -2.0);
    desc.angular_velocity = Vec3::new(0.0, 5.0, 0.0);
    let slot = simulation.bodies.insert(desc).expect("usable");
    let h = 1e-6;
    simulation.step(h);
    let center = simulation.bodies.center_of_mass(slot);
    let plane = Plane::through(center, Vec3::X);
    simulation.slice(slot, plane).expect("a body");
    simulation.step(h);
    let [fracture] = &simulation.fractures.done[..] else {
        panic!("{:?}", simulation.fractures)
    };
    for &piece in &fracture.pieces {
        let lever = simulation.bodies.center_of_mass(piece) - center;
        let (v, omega) = simulation.bodies.velocity(piece);
        assert!((lever.length() - 0.5).abs() < 1e-3);
        assert!(
            (v - Vec3::new(3.0, 1.0, -2.0) - omega.cross(lever)).length() < 1e-3,
            "{v}"
        );
        assert!(
            (omega - Vec3::new(0.0, 5.0, 0.0)).length() < 1e-4,
            "{omega}"
        );
    }
    check_ledger(fracture);
}

#[test]
fn same_seed_gives_the_same_pieces() {
    let run = |seed| {
        let breaking = Fracturable {
            strength: 100.0,
            pattern: FracturePattern::Star { planes: 3 },
            seed,
            generations: 2,
            ..Default::default()
        };
        let (simulation, _) = drop_block(2.0, breaking);
        simulation
            .bodies
            .iter()
            .map(|s| simulation.bodies.pose(s).position.to_array())
            .collect::<Vec<_>>()
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

#[test]
fn box_that_lands_flat_breaks_by_every_pattern() {
    for pattern in [
        FracturePattern::SinglePlane,
        FracturePattern::RandomPlane,
        FracturePattern::Star { planes: 3 },
    ] {
        for shape in [cuboid(1.0, 1.0, 1.0), cuboid(2.0, 0.5, 0.5)] {
            let mut simulation = with_floor();
            let mut desc = BodyDesc::dynamic(shape, Vec3::new(0.0, 3.0, 0.0));
            desc.fracturable = Some(Fracturable {
                pattern: pattern.clone(),
                ..Fracturable::with_strength(100.0)
            });
            simulation.bodies.insert(desc).expect("usable");
            for _ in 0..60 {
                simulation.step(H);
            }
            assert!(simulation.bodies.len() > 2, "{pattern:?} leaves it whole");
        }
    }
}

#[test]
fn cut_goes_where_the_body_was_seen_however_fast_it_is() {
    let mut simulation = awake();
    let mut desc = BodyDesc::dynamic(cuboid(1.0, 1.0, 1.0), Vec3::ZERO);
    desc.linear_velocity = Vec3::new(20.0, 0.0, 0.0);
    desc.angular_velocity = Vec3::new(0.0, 0.0, 6.0);
    let slot = simulation.bodies.insert(desc).expect("usable");
    for _ in 0..10 {
        simulation.step(H);
    }
    let pose = simulation.bodies.pose(slot);
    let along = bevy_cleave::testing::math::rotate(pose.rotation, Vec3::X);
    simulation
        .slice(slot, Plane::through(pose.position, along))
        .expect("a body");
    simulation.step(H);
    let [fracture] = &simulation.fractures.done[..] else {
        panic!("{:?}", simulation.fractures)
    };
    for &piece in &fracture.pieces {
        let mass = simulation.bodies.mass(piece).mass;
        assert!((mass - 500.0).abs() < 1e-2, "{mass} kg of 1000");
    }
}

#[test]
fn mesh_that_rides_in_a_body_is_cut_with_it() {
    let hull = cuboid(1.0, 0.5, 0.4).hull().clone();
    let mesh = hull.to_mesh();
    let dark = vec![Vec4::new(0.2, 0.2, 0.2, 1.0); mesh.positions().len()];
    let mesh = mesh.with_colors(dark).expect("one for each vertex");
    let mut simulation = with_floor();
    let shape = ConvexMesh::from_parts(hull, Some(mesh));
    let mut desc = BodyDesc::dynamic(shape, Vec3::new(0.0, 3.0, 0.0));
    // The halves must hit the floor again: a break in which the parent was stopped leaves them at rest.
    desc.restitution = Restitution::new(1.0);
    let pale = Vec4::ONE;
    desc.fracturable = Some(Fracturable {
        cut_color: Some(pale),
        generations: 2,
        ..Fracturable::with_strength(100.0)
    });
    simulation.bodies.insert(desc).expect("usable");
    for _ in 0..90 {
        simulation.step(H);
    }
    let bodies = &simulation.bodies;
    let pieces: Vec<_> = bodies
        .iter()
        .filter_map(|slot| bodies.convex(slot))
        .collect();
    assert!(pieces.len() >= 4, "{} pieces", pieces.len());
    for piece in pieces {
        let mesh = piece.visual().expect("rides in every piece");
        mesh.check_closed().expect("closed");
        let volume = piece.hull().volume();
        assert!((mesh.volume() - volume).abs() < 1e-6 * volume);
        let (normals, colors) = (mesh.normals(), mesh.colors());
        assert_eq!(
            (normals.len(), colors.len()),
            (mesh.positions().len(), normals.len())
        );
        assert!(colors.contains(&pale) && colors.iter().any(|c| c.x < 0.3));
    }
}
