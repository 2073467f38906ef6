//! Far from the origin, where positions of f32 are coarse.

use super::scene::*;
use super::support::*;
use crate::common::dice::Dice;
use crate::common::structures::*;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// A floor and ten unit cubes on it, placed askew by up to 1 mm, all shifted by `offset`.
fn tower(offset: Vec3) -> Simulation {
    let mut simulation = simulation([]);
    let mut floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    floor.friction = Friction::new(0.6);
    floor.pose.position = offset;
    add(&mut simulation, floor);
    let mut dice = Dice::new(22);
    let shape = cuboid(Vec3::ONE);
    for i in 0..10_u8 {
        let askew = dice.vector(-0.001, 0.001).with_y(0.0);
        let place = offset + askew + (0.5 + f32::from(i)) * Vec3::Y;
        add(&mut simulation, block(&shape, place, 0.6));
    }
    simulation
}

/// What became of a tower in ten seconds, m: deepest overlap at the end, farthest a cube went, and largest way of a cube
/// within one of the last 300 steps.
#[derive(Debug)]
struct Outcome {
    overlap: f32,
    drift: f32,
    jitter: f32,
}

fn stand(offset: Vec3) -> Outcome {
    let mut simulation = tower(offset);
    let places = |simulation: &Simulation| -> Vec<Vec3> {
        let bodies = &simulation.bodies;
        bodies
            .iter()
            .skip(1)
            .map(|b| bodies.center_of_mass(b))
            .collect()
    };
    let farthest = |a: &[Vec3], b: &[Vec3]| {
        a.iter()
            .zip(b)
            .map(|(a, b)| a.distance(*b))
            .fold(0.0, f32::max)
    };
    let start = places(&simulation);
    (0..300).for_each(|_| simulation.step(H));
    let mut last = places(&simulation);
    let mut jitter = 0.0_f32;
    for _ in 0..300 {
        simulation.step(H);
        let now = places(&simulation);
        jitter = jitter.max(farthest(&now, &last));
        last = now;
    }
    let manifolds = simulation.contacts.manifolds().iter();
    let overlaps = manifolds.flat_map(|m| m.points()).map(|p| -p.separation);
    Outcome {
        overlap: overlaps.fold(0.0, f32::max),
        drift: farthest(&start, &last),
        jitter,
    }
}

/// Hard because a coordinate of 1000 m is a multiple of 0.061 mm, more than a step at rest moves anything: results must
/// be within twice those at the origin (and one such multiple).
#[test]
fn tower_of_ten_stands_1_km_from_the_origin() {
    let near = stand(Vec3::ZERO);
    let far = stand(Vec3::new(1000.0, 1000.0, -1000.0));
    println!("22 tower of 10: {near:?}, at 1 km {far:?}");
    let unit = 6.2e-5;
    assert!(
        far.overlap < 2.0 * near.overlap + unit,
        "{far:?} against {near:?}"
    );
    assert!(
        far.drift < 2.0 * near.drift + 2.0 * unit,
        "{far:?} against {near:?}"
    );
    assert!(
        far.jitter < 2.0 * near.jitter + unit,
        "{far:?} against {near:?}"
    );
}

/// At 10 km coordinates are multiples of 0.98 mm: no explosion, at most 2 mm of jitter.
#[test]
fn tower_of_ten_does_not_explode_10_km_from_the_origin() {
    let far = stand(Vec3::new(10_000.0, 10_000.0, -10_000.0));
    println!("22 tower of 10 at 10 km: {far:?}");
    assert!(far.jitter <= 0.002, "{far:?}");
    assert!(far.drift < 0.1, "{far:?}");
}

/// How far a cube slides in ten seconds on a slope of `tilt_deg`, mu 0.6, at `offset`, m.
fn slide(tilt_deg: f32, offset: Vec3) -> f32 {
    let mut simulation = simulation([]);
    let rotation = Quat::from_rotation_z(-tilt_deg.to_radians());
    let mut slope = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    slope.friction = Friction::new(0.6);
    slope.pose = Pose::new(offset, rotation);
    add(&mut simulation, slope);
    let place = offset + rotation * Vec3::new(0.0, 0.5, 0.0);
    let mut desc = block(&cuboid(Vec3::ONE), place, 0.6);
    desc.pose.rotation = rotation;
    let slot = add(&mut simulation, desc);
    (0..60).for_each(|_| simulation.step(H));
    let settled = simulation.bodies.center_of_mass(slot);
    (0..600).for_each(|_| simulation.step(H));
    simulation.bodies.center_of_mass(slot).distance(settled)
}

/// Hard for the same reason: what sticks must not creep from rounding, what slides must not be held by it. The slope
/// slips at atan 0.6 = 30.96 degrees, where the force that moves it is 0.9 % of its weight.
#[test]
fn slope_threshold_is_the_same_1_km_from_the_origin() {
    let far = Vec3::new(1000.0, 1000.0, -1000.0);
    let [near_creep, far_creep] = [Vec3::ZERO, far].map(|offset| slide(30.5, offset));
    let [near_slide, far_slide] = [Vec3::ZERO, far].map(|offset| slide(31.4, offset));
    println!(
        "22 slope: creep {near_creep:.2e} m, at 1 km {far_creep:.2e} m; slide {near_slide:.3} m, at 1 km {far_slide:.3} m"
    );
    assert!(
        near_creep < 0.001 && far_creep < 0.001,
        "creep {near_creep} and {far_creep} m in 10 s"
    );
    // g (sin - mu cos) t^2 / 2 between the first second and the eleventh.
    let (sine, cosine) = 31.4_f64.to_radians().sin_cos();
    let exact = G * (sine - 0.6 * cosine) * (11.0 * 11.0 - 1.0) / 2.0;
    let [near_error, far_error] = [near_slide, far_slide].map(|way| f64::from(way) / exact - 1.0);
    assert!(near_error.abs() < 0.02, "{near_slide} m instead of {exact}");
    assert!(far_error.abs() < 0.05, "{far_slide} m instead of {exact}");
}
