//! What the tests build.

use crate::common::scenes::awake;
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Length of a step, s.
pub(crate) const H: f32 = 1.0 / 60.0;

/// Density of cubes, kg/m3, and gravity, m/s2: a cube of 1 m weighs as many newtons as their product.
pub(crate) const WEIGHT: f32 = 1000.0 * 9.81;

pub(crate) fn cube() -> ConvexMesh {
    ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size")
}

pub(crate) fn fixed(shape: ConvexMesh, at: Vec3) -> BodyDesc {
    BodyDesc {
        kind: RigidBody::Static,
        ..BodyDesc::dynamic(shape, at)
    }
}

/// A simulation of bodies, and their slots.
pub(crate) fn simulation(bodies: impl IntoIterator<Item = BodyDesc>) -> (Simulation, Vec<u32>) {
    let mut simulation = awake();
    let slots = bodies
        .into_iter()
        .map(|desc| simulation.bodies.insert(desc).expect("usable"))
        .collect();
    (simulation, slots)
}

/// Unit cubes side by side `along` a unit vector from the origin, the first one fixed, and bonds between neighbors.
pub(crate) fn chain(count: usize, along: Vec3, bond: Bond) -> (Simulation, Vec<u32>) {
    let bodies = (0..=count).map(|i| {
        let at = i as f32 * along;
        if i == 0 {
            fixed(cube(), at)
        } else {
            BodyDesc::dynamic(cube(), at)
        }
    });
    let (mut simulation, slots) = simulation(bodies);
    for pair in slots.windows(2) {
        simulation.bond(pair[0], pair[1], bond).expect("usable");
    }
    (simulation, slots)
}

/// Steps until a bond breaks, and which ones do in that step; none after `steps`.
pub(crate) fn first_break(simulation: &mut Simulation, steps: usize) -> Option<Vec<[u32; 2]>> {
    (0..steps).find_map(|_| {
        simulation.step(H);
        let broken = &simulation.bonds.broken;
        (!broken.is_empty()).then(|| broken.iter().map(|b| b.slots).collect())
    })
}

/// Lets gravity grow to its full strength within a second, so that nothing swings; the bonds that break meanwhile.
pub(crate) fn load_slowly(simulation: &mut Simulation) -> Option<Vec<[u32; 2]>> {
    let full = simulation.gravity.0;
    let first = (1..=60).find_map(|step| {
        simulation.gravity.0 = full * (step as f32 / 60.0);
        first_break(simulation, 1)
    });
    simulation.gravity.0 = full;
    first
}

/// Size of a brick, m.
pub(crate) const BRICK: Vec3 = Vec3::new(0.4, 0.2, 0.2);

/// A wall in running bond, `rows` of `columns` bricks of 2000 kg/m3, that spans the gap between two fixed bricks at its
/// lower corners; not bonded yet. Slots of its bricks, from the lowest row up, without the two.
pub(crate) fn lintel(rows: usize, columns: usize) -> (Simulation, Vec<u32>) {
    let brick = || ConvexMesh::cuboid(BRICK.x, BRICK.y, BRICK.z).expect("valid size");
    let half = 0.5 * columns as f32;
    let supports = [-half, half].map(|x| fixed(brick(), BRICK * Vec3::new(x, -1.0, 0.0)));
    let bricks = (0..rows * columns).map(|i| {
        let (row, column) = (i / columns, (i % columns) as f32);
        let shift = if row % 2 == 0 { 0.25 } else { 0.75 };
        BodyDesc {
            density: 2000.0,
            ..BodyDesc::dynamic(
                brick(),
                BRICK * Vec3::new(column + shift - half, row as f32, 0.0),
            )
        }
    });
    let (simulation, slots) = simulation(supports.into_iter().chain(bricks));
    (simulation, slots[2..].to_vec())
}

/// Bonds of a [`lintel`]: one for each brick and its neighbor in the row, and two with the row above but for the ends.
pub(crate) fn joints_of_lintel(rows: usize, columns: usize) -> usize {
    rows * (columns - 1) + (rows - 1) * (2 * columns - 1)
}

/// Centers of bodies, m.
pub(crate) fn centers(simulation: &Simulation, slots: &[u32]) -> Vec<Vec3> {
    let center = |&slot: &u32| simulation.bodies.center_of_mass(slot);
    slots.iter().map(center).collect()
}

/// The longest way that a body has gone from where it was, m.
pub(crate) fn farthest(simulation: &Simulation, slots: &[u32], from: &[Vec3]) -> f32 {
    let now = centers(simulation, slots);
    let ways = now.iter().zip(from).map(|(a, b)| a.distance(*b));
    ways.fold(0.0, f32::max)
}

/// Poses and velocities of bodies as bits.
pub(crate) fn bits(simulation: &Simulation) -> Vec<Vec<u32>> {
    let bodies = &simulation.bodies;
    let of_body = |slot| {
        let (pose, (v, omega)) = (bodies.pose(slot), bodies.velocity(slot));
        crate::common::states::bits(&pose, v, omega)
    };
    bodies.iter().map(of_body).collect()
}
