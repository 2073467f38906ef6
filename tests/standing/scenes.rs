//! Bodies that stand, and what is asked of all of them after they broke.

use crate::common::scenes::awake;
use bevy_cleave::prelude::*;
use glam::Vec3;

pub(crate) const H: f32 = 1.0 / 60.0;

pub(crate) fn cuboid(size: Vec3) -> ConvexMesh {
    ConvexMesh::cuboid(size.x, size.y, size.z).expect("valid size")
}

/// A body that stands.
pub(crate) fn standing(size: Vec3, at: Vec3) -> BodyDesc {
    BodyDesc {
        kind: RigidBody::Static,
        ..BodyDesc::dynamic(cuboid(size), at)
    }
}

pub(crate) fn voronoi(cells: u16, strength: f32, seed: u64) -> Fracturable {
    Fracturable {
        strength,
        pattern: FracturePattern::Voronoi { cells, focus: 0.5 },
        generations: 3,
        seed,
        ..Default::default()
    }
}

pub(crate) fn floor() -> BodyDesc {
    BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y })
}

pub(crate) fn scene(bodies: impl IntoIterator<Item = BodyDesc>) -> Simulation {
    let mut simulation = awake();
    for body in bodies {
        simulation.bodies.insert(body).expect("usable");
    }
    simulation
}

/// A ball of 20 kg on its way.
pub(crate) fn ball(at: Vec3, velocity: Vec3) -> BodyDesc {
    let mut ball = BodyDesc::dynamic(ConvexMesh::icosphere(0.15, 2).expect("valid"), at);
    ball.density = 1450.0;
    ball.linear_velocity = velocity;
    ball
}

/// Steps for `seconds`; the fractures, each of which has an exact ledger.
pub(crate) fn run(simulation: &mut Simulation, seconds: f32) -> Vec<Fracture> {
    let mut done = Vec::new();
    for _ in 0..(seconds / H) as usize {
        simulation.step(H);
        for fracture in &simulation.fractures.done {
            let ledger = &fracture.ledger;
            assert!(ledger.mass_error() < 1e-6, "{:e}", ledger.mass_error());
            assert!(
                ledger.momentum_error() < 1e-5,
                "{:e}",
                ledger.momentum_error()
            );
        }
        done.extend_from_slice(&simulation.fractures.done);
    }
    done
}

/// Slots of bodies of this kind that are convex.
pub(crate) fn of_kind(bodies: &Bodies, kind: RigidBody) -> Vec<u32> {
    let slots = bodies.iter();
    slots
        .filter(|&slot| bodies.kind(slot) == kind && bodies.convex(slot).is_some())
        .collect()
}

/// Corners of a convex body, world, m.
pub(crate) fn corners(bodies: &Bodies, slot: u32) -> impl Iterator<Item = Vec3> {
    let pose = bodies.pose(slot);
    let hull = bodies.convex(slot).expect("convex").hull();
    hull.vertices()
        .iter()
        .map(move |&v| pose.transform_point(v))
}

/// Lowest point of a body, m.
pub(crate) fn lowest(bodies: &Bodies, slot: u32) -> f32 {
    corners(bodies, slot)
        .map(|v| v.y)
        .fold(f32::INFINITY, f32::min)
}

/// Corners of a body that come within `reach` (m) of the region behind a plane of the world.
pub(crate) fn corners_behind(bodies: &Bodies, slot: u32, plane: &Plane, reach: f32) -> usize {
    let near = corners(bodies, slot).filter(|&v| plane.distance(v) <= reach);
    near.count()
}

/// Nothing hangs in the air: each dynamic body has come to lie on something, or still falls.
pub(crate) fn check_nothing_floats(simulation: &Simulation) {
    let bodies = &simulation.bodies;
    for slot in of_kind(bodies, RigidBody::Dynamic) {
        let (v, omega) = bodies.velocity(slot);
        let moves = v.length() > 0.05 || omega.length() > 0.05;
        let manifolds = simulation.contacts.manifolds();
        let is_borne = manifolds.iter().any(|m| {
            let touches = m.a == slot || m.b == slot;
            touches && m.points().iter().any(|p| p.total_impulse > 0.0)
        });
        assert!(
            moves || is_borne,
            "body {slot} at {} hangs in the air",
            bodies.center_of_mass(slot)
        );
    }
}
