//! Motion as bits, to be compared.

use bevy_cleave::math::Pose;
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Position, rotation and velocities as bits.
pub(crate) fn bits(pose: &Pose, linear: Vec3, angular: Vec3) -> Vec<u32> {
    let parts = [
        &pose.position.to_array()[..],
        &pose.rotation.to_array(),
        &linear.to_array(),
        &angular.to_array(),
    ];
    parts.concat().into_iter().map(f32::to_bits).collect()
}

/// Pose and velocity of every body as bits, by body id.
pub(crate) fn bits_by_id(simulation: &Simulation) -> Vec<(u32, [u32; 13])> {
    let bodies = &simulation.bodies;
    let state = |slot| {
        let (x, r, (v, w)) = (
            bodies.center_of_mass(slot),
            bodies.pose(slot).rotation,
            bodies.velocity(slot),
        );
        let numbers = [
            x.x, x.y, x.z, r.x, r.y, r.z, r.w, v.x, v.y, v.z, w.x, w.y, w.z,
        ];
        (bodies.id(slot).0, numbers.map(f32::to_bits))
    };
    let mut all: Vec<_> = bodies.iter().map(state).collect();
    all.sort_unstable();
    all
}
