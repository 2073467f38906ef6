//! Elastic bodies that gained energy: with `e = 1` and no friction a tilted cube had 27 % more of it after a minute, and some
//! bounces gave 5 %, because the speed of a rebound was found along rows of another moment than those it acted along, and
//! because energy was bounded only where linear motion alone had much of it (reported of other engines as
//! JoltPhysics#1286 and rapier#97).
//!
//! Newton's law: along the normal of a contact that hits, the velocity `w` becomes `-e w`. Without friction a single contact
//! with `A = J M^-1 J^T` takes `(1 - e^2) w^2 / (2 A)` out of the energy, and with `e = 1` nothing is ever lost.

use super::support::{H, energy, kinetic_energy, simulation, steps, weightless};
use crate::common::dice::Dice;
use bevy_cleave::prelude::*;
use glam::Vec3;

/// A convex body of some 0.2 to 2 m, of any kind.
fn shape(dice: &mut Dice) -> ConvexMesh {
    let size = dice.in_range(0.3, 1.5);
    let mut edge = || size * dice.in_range(0.3, 1.0);
    let [x, y, z] = [edge(), edge(), edge()];
    let shape = match dice.below(6) {
        0 => ConvexMesh::cuboid(size, size, size),
        1 => ConvexMesh::cuboid(x, y, z),
        2 => ConvexMesh::regular_prism(3 + dice.below(6) as u32, 0.5 * x, y),
        3 => ConvexMesh::wedge(x, y, z),
        4 => ConvexMesh::icosphere(0.5 * size, 1),
        _ => {
            let count = 6 + dice.below(30);
            let points: Vec<_> = (0..count)
                .map(|_| 0.5 * Vec3::new(x, y, z) * dice.direction())
                .collect();
            ConvexMesh::from_points(&points)
        }
    };
    shape.expect("it has a volume")
}

/// A body with restitution `e` and friction `mu`, whatever it meets.
fn bouncing(desc: BodyDesc, e: f32, mu: f32) -> BodyDesc {
    BodyDesc {
        restitution: Restitution::new(e),
        friction: Friction::new(mu),
        ..desc
    }
}

fn floor(e: f32, mu: f32) -> BodyDesc {
    bouncing(BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y }), e, mu)
}

/// A random body at `place`, turned any way, that moves and turns.
fn thrown(dice: &mut Dice, place: Vec3, e: f32, mu: f32) -> BodyDesc {
    let mut body = BodyDesc::dynamic(shape(dice), place);
    body.pose.rotation = dice.rotation();
    body.linear_velocity = dice.vector(-1.0, 1.0);
    body.angular_velocity = dice.in_range(0.0, 6.0) * dice.direction();
    bouncing(body, e, mu)
}

/// What becomes of the energy of a scene: the least and the most of it, and the largest rise in a step, as shares of that after
/// the first step.
fn energies(simulation: &mut Simulation, seconds: f64) -> [f64; 3] {
    simulation.step(H);
    let first = energy(simulation);
    let (mut least, mut most, mut rise, mut last) = (first, first, 0.0_f64, first);
    for _ in 1..steps(seconds) {
        simulation.step(H);
        let now = energy(simulation);
        (least, most) = (least.min(now), most.max(now));
        rise = rise.max(now - last);
        last = now;
    }
    [least, most, rise].map(|energy| energy / first)
}

#[test]
fn elastic_body_keeps_its_energy_for_a_minute() {
    let mut failed = Vec::new();
    for seed in 0..24 {
        let mut dice = Dice::new(seed);
        let place = Vec3::Y * dice.in_range(2.0, 7.0);
        let body = thrown(&mut dice, place, 1.0, 0.0);
        let mut scene = simulation([floor(1.0, 0.0), body]);
        let [least, most, rise] = energies(&mut scene, 60.0);
        println!("body {seed}: {least:.4} to {most:.4} of the energy, largest rise {rise:.1e}");
        if least < 0.99 || most > 1.01 {
            failed.push(seed);
        }
    }
    assert!(failed.is_empty(), "energy of {failed:?} changed");
}

#[test]
fn elastic_bodies_that_hit_each_other_keep_their_energy_for_a_minute() {
    let mut failed = Vec::new();
    for seed in 100..112 {
        let mut dice = Dice::new(seed);
        let count = 2 + dice.below(4);
        let mut bodies = vec![floor(1.0, 0.0)];
        for i in 0..count {
            let side = dice.vector(-0.3, 0.3) * Vec3::new(1.0, 0.0, 1.0);
            let place = (2.0 + 2.5 * i as f32) * Vec3::Y + side;
            let mut body = thrown(&mut dice, place, 1.0, 0.0);
            body.linear_velocity *= 0.1;
            bodies.push(body);
        }
        let mut scene = simulation(bodies);
        let [least, most, rise] = energies(&mut scene, 60.0);
        println!(
            "{count} bodies {seed}: {least:.4} to {most:.4} of the energy, largest rise {rise:.1e}"
        );
        if least < 0.99 || most > 1.01 {
            failed.push(seed);
        }
    }
    assert!(failed.is_empty(), "energy of {failed:?} changed");
}

#[test]
fn rebounds_with_friction_give_no_energy() {
    let mut failed = Vec::new();
    for seed in 200..224 {
        let mut dice = Dice::new(seed);
        let (e, mu) = (dice.in_range(0.2, 1.0), dice.in_range(0.0, 1.0));
        let mut bodies = vec![floor(e, mu)];
        for i in 0..1 + dice.below(3) {
            let place = (2.0 + 2.5 * i as f32) * Vec3::Y;
            bodies.push(thrown(&mut dice, place, e, mu));
        }
        let mut scene = simulation(bodies);
        let [_, _, rise] = energies(&mut scene, 10.0);
        println!("scene {seed}: e {e:.2}, mu {mu:.2}: largest rise {rise:.1e}");
        if rise > 1e-3 {
            failed.push(seed);
        }
    }
    assert!(failed.is_empty(), "{failed:?} gained energy");
}

/// The energy that Newton's law leaves of a body that does not turn and hits the plane `y = 0` with its lowest corner, J.
fn after_first_hit(scene: &Simulation, e: f64) -> f64 {
    let bodies = &scene.bodies;
    let (pose, mass) = (bodies.pose(1), bodies.mass(1));
    let center = bodies.center_of_mass(1);
    let mesh = bodies.convex(1).expect("it is a hull");
    let corners = mesh.hull().vertices().iter();
    let corners = corners.map(|&corner| pose.transform_point(corner) - center);
    let lowest = corners.fold(
        Vec3::ZERO,
        |low, corner| {
            if corner.y < low.y { corner } else { low }
        },
    );
    let frame = (pose.rotation.as_dquat() * mass.principal_frame.as_dquat()).normalize();
    let lever = frame.inverse() * lowest.as_dvec3().cross(glam::DVec3::Y);
    let turning = (lever * lever / mass.principal.as_dvec3()).element_sum();
    let diagonal = 1.0 / f64::from(mass.mass) + turning;
    let speed = f64::from(bodies.velocity(1).0.y);
    kinetic_energy(scene) - 0.5 * (1.0 - e * e) * speed * speed / diagonal
}

#[test]
fn first_hit_of_a_corner_takes_what_newtons_law_takes() {
    let mut failed = Vec::new();
    for seed in 300..340 {
        let mut dice = Dice::new(seed);
        let e = dice.in_range(0.1, 1.0);
        let mut body = thrown(&mut dice, 2.0 * Vec3::Y, e, 0.0);
        body.linear_velocity = dice.vector(-2.0, 2.0) - dice.in_range(3.0, 9.0) * Vec3::Y;
        body.angular_velocity = Vec3::ZERO;
        let mut scene = weightless([floor(e, 0.0), body]);
        scene.step(H);
        let (before, right) = (kinetic_energy(&scene), after_first_hit(&scene, e.into()));
        let mut now = before;
        for _ in 0..60 {
            scene.step(H);
            now = kinetic_energy(&scene);
            if (now / before - 1.0).abs() > 1e-6 || scene.bodies.velocity(1).1 != Vec3::ZERO {
                break;
            }
        }
        let error = (now - right) / before;
        println!(
            "body {seed}: e {e:.2}: {:.4} of the energy, {error:+.1e} off",
            now / before
        );
        // A second corner may hit within the step, and takes more.
        if error > 1e-3 {
            failed.push(seed);
        }
    }
    assert!(failed.is_empty(), "{failed:?} gained energy");
}
