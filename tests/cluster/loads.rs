//! Sustained loads: what theory says breaks does, and nothing else.

use crate::common::scenes::awake;
use crate::shapes::{row, standing};
use bevy_cleave::prelude::*;
use glam::Vec3;

const RATES: [f32; 4] = [30.0, 60.0, 120.0, 240.0];

/// Whether a cantilever of this strength falls within three seconds; and how many parts are left of what stands.
fn falls(shape: &Compound, load: Option<f32>, rate: f32) -> (bool, usize) {
    let mut simulation = awake();
    let end = shape.aabb().max;
    let body = simulation.bodies.insert(standing(shape.clone()));
    let body = body.expect("usable");
    // The first part is in a wall.
    let wall = Anchors::none().and_behind(Vec3::X, 0.01);
    simulation
        .bodies
        .set_anchors(body, Some(wall))
        .expect("usable");
    if let Some(mass) = load {
        let weight = ConvexMesh::cuboid(0.1, 0.1, 0.1).expect("a box");
        let at = Vec3::new(end.x - 0.05, end.y + 0.05, 0.0);
        let desc = BodyDesc {
            density: mass / 1e-3,
            ..BodyDesc::dynamic(weight, at)
        };
        simulation.bodies.insert(desc).expect("usable");
    }
    let mut is_broken = false;
    for _ in 0..(3.0 * rate) as usize {
        simulation.step(1.0 / rate);
        is_broken |= !simulation.fractures.done.is_empty();
    }
    let left = simulation.bodies.compound(body).map_or(1, Compound::len);
    (is_broken, left)
}

/// Stress at the root of a cantilever of `count` parts of `size` under its own weight and one at its end, Pa: moment over section modulus.
fn root_stress(count: usize, size: Vec3, density: f32, load: Option<f32>) -> f32 {
    let g = 9.81;
    // Behind the root is what is held.
    let free = (count - 1) as f32 * size.x;
    let weight = density * size.y * size.z * free * g;
    let end = load.map_or(0.0, |mass| mass * g * (free - 0.05));
    let moment = 0.5 * weight * free + end;
    moment / (size.z * size.y * size.y / 6.0)
}

#[test]
fn a_cantilever_collapses_where_theory_says() {
    let shapes = [
        (4, Vec3::splat(0.2)),
        (8, Vec3::new(0.15, 0.2, 0.3)),
        (20, Vec3::new(0.1, 0.15, 0.1)),
    ];
    for (count, size) in shapes {
        for load in [None, Some(5.0), Some(50.0)] {
            let stress = root_stress(count, size, 1000.0, load);
            for rate in RATES {
                let weak = falls(&row(count, size, 0.95 * stress), load, rate);
                assert_eq!(weak, (true, 1), "{count} parts, {load:?} kg, {rate} Hz");
                let strong = falls(&row(count, size, 1.05 * stress), load, rate);
                assert_eq!(
                    strong,
                    (false, count),
                    "{count} parts, {load:?} kg, {rate} Hz"
                );
            }
        }
    }
}
