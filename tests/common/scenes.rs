//! Scenes that tests and benches share.

use super::dice::Dice;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// A floor and a heap of different bodies that fall on it; some break on impact.
pub(crate) fn falling_and_breaking() -> Vec<BodyDesc> {
    let breakable = |strength, pattern, seed| Fracturable {
        strength,
        pattern,
        seed,
        generations: 2,
        min_volume: 1e-4,
        ..Default::default()
    };
    let shapes = [
        ConvexMesh::cuboid(1.0, 0.8, 0.6),
        ConvexMesh::icosphere(0.5, 1),
        ConvexMesh::regular_prism(6, 0.4, 1.0),
        ConvexMesh::wedge(1.0, 0.5, 0.7),
    ]
    .map(|shape| shape.expect("valid sizes"));
    let patterns = [
        FracturePattern::SinglePlane,
        FracturePattern::RandomPlane,
        FracturePattern::Star { planes: 3 },
    ];
    let mut bodies = vec![BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y })];
    for i in 0..12_u8 {
        let n = f32::from(i);
        let position = Vec3::new(0.9 * (n % 3.0) - 0.8, 1.0 + 0.9 * n, 0.4 * (n % 2.0));
        let mut body = BodyDesc::dynamic(shapes[usize::from(i) % 4].clone(), position);
        body.pose.rotation = Quat::from_xyzw(0.1 * n, 0.2, -0.05 * n, 1.0).normalize();
        body.angular_velocity = Vec3::new(0.5, -0.3 * n, 0.2);
        body.restitution = Restitution::new(0.2);
        if i % 3 != 2 {
            body.fracturable = Some(breakable(
                900.0,
                patterns[usize::from(i) % 3].clone(),
                u64::from(i),
            ));
        }
        bodies.push(body);
    }
    bodies
}

/// One of the patterns, with few pieces.
pub(crate) fn pattern(dice: &mut Dice) -> FracturePattern {
    match dice.below(6) {
        0 => FracturePattern::SinglePlane,
        1 => FracturePattern::RandomPlane,
        2 => FracturePattern::Star { planes: 3 },
        3 => FracturePattern::Voronoi {
            cells: 6,
            focus: 0.5,
        },
        4 => FracturePattern::Slabs { count: 3 },
        _ => FracturePattern::Radial { rays: 5, rings: 1 },
    }
}

/// Kinetic and potential energy of what moves by itself, J.
pub(crate) fn energy(simulation: &Simulation) -> f64 {
    let bodies = &simulation.bodies;
    let dynamic = bodies
        .iter()
        .filter(|&slot| bodies.kind(slot) == RigidBody::Dynamic);
    let of = |slot: u32| {
        let mass = bodies.mass(slot);
        let height = bodies.center_of_mass(slot).y;
        let weight = f64::from(simulation.gravity.0.y) * f64::from(mass.mass);
        bodies.kinetic_energy(slot) - weight * f64::from(height)
    };
    dynamic.map(of).sum()
}

/// Seeded random points in the cube from -1 to 1.
pub(crate) fn random_points(count: usize, seed: u64) -> Vec<Vec3> {
    let mut dice = Dice::new(seed);
    (0..count).map(|_| dice.vector(-1.0, 1.0)).collect()
}

/// Edge of the smallest cube of cells that holds `count`.
fn least_cube(count: usize) -> usize {
    (1..).find(|n| n * n * n >= count).unwrap_or(1)
}

/// A floor and a heap of `count` bodies of four shapes that falls on it.
pub(crate) fn heap(count: usize) -> Vec<BodyDesc> {
    let shapes = [
        ConvexMesh::cuboid(0.8, 0.6, 0.5),
        ConvexMesh::icosphere(0.4, 1),
        ConvexMesh::regular_prism(6, 0.4, 0.6),
        ConvexMesh::wedge(0.8, 0.5, 0.6),
    ]
    .map(|shape| shape.expect("valid sizes"));
    let side = least_cube(count);
    let jitter = random_points(count, 3);
    let falling = (0..count).map(|i| {
        let cell = Vec3::new(
            (i % side) as f32,
            (i / side / side) as f32,
            (i / side % side) as f32,
        );
        let position = cell + 0.5 * Vec3::Y + 0.1 * jitter[i];
        let mut desc = BodyDesc::dynamic(shapes[i % 4].clone(), position);
        desc.pose.rotation = Quat::from_vec4(jitter[i].extend(1.0)).normalize();
        desc
    });
    let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    std::iter::once(floor).chain(falling).collect()
}

/// A simulation in which nothing falls asleep: what is asleep proves nothing about contacts.
pub(crate) fn awake() -> Simulation {
    let mut simulation = Simulation::default();
    simulation.config.sleep = SleepConfig::off();
    simulation
}

/// The same with a floor at height 0.
pub(crate) fn awake_on_floor() -> Simulation {
    let mut simulation = awake();
    let floor = HalfSpaceShape { normal: Vec3::Y };
    simulation
        .bodies
        .insert(BodyDesc::floor(floor))
        .expect("usable");
    simulation
}

/// The simulation of a [`heap`].
pub(crate) fn pile(count: usize) -> Simulation {
    let mut simulation = awake();
    for desc in heap(count) {
        simulation.bodies.insert(desc).expect("usable");
    }
    simulation
}
