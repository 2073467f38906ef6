//! Bodies that go fifty times their own length in a step.

use super::scene::*;
use super::support::*;
use crate::common::dice::Dice;
use crate::common::structures::*;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// Half of the wall's thickness, m.
const HALF_WALL: f32 = 0.01;

/// A projectile and a wall that is a hundred metres wide, about the origin, across x.
struct Range {
    simulation: Simulation,
    bullet: u32,
}

impl Range {
    fn new(bullet: BodyDesc) -> Self {
        let mut simulation = simulation([]);
        let mut wall = block(
            &cuboid(Vec3::new(2.0 * HALF_WALL, 100.0, 100.0)),
            Vec3::ZERO,
            0.5,
        );
        wall.kind = RigidBody::Static;
        add(&mut simulation, wall);
        let bullet = add(&mut simulation, bullet);
        Self { simulation, bullet }
    }

    fn place(&self) -> Vec3 {
        self.simulation.bodies.center_of_mass(self.bullet)
    }

    /// Whether the bullet's center was ever beyond the middle of the wall within `steps`.
    fn passes(&mut self, steps: usize) -> bool {
        (0..steps).any(|_| {
            self.simulation.step(H);
            self.place().x > 0.0
        })
    }
}

/// A cube of 0.1 m at 300 m/s that flies at `angle` (rad) to the wall's normal towards its middle, from `distance` m.
fn bullet(distance: f32, angle: f32, rotation: Quat) -> BodyDesc {
    let direction = Quat::from_rotation_z(angle) * Vec3::X;
    let mut desc = block(
        &cuboid(Vec3::new(0.1, 0.1, 0.1)),
        -distance * direction,
        0.5,
    );
    desc.pose.rotation = rotation;
    desc.linear_velocity = 300.0 * direction;
    desc
}

/// Hard because the cube goes 5 m in a step and the wall is 2 cm thick. It meets the wall's face at
/// (10 - 0.05 - 0.01) m / 300 m/s = 0.03313 s, within the second step, and stays there.
#[test]
fn bullet_stops_at_the_face_of_the_wall() {
    let mut range = Range::new(bullet(10.0, 0.0, Quat::IDENTITY));
    range.simulation.step(H);
    let after_one = range.place().x;
    assert!(
        (after_one + 5.0).abs() < 1e-3,
        "at {after_one} m after a step"
    );
    range.simulation.step(H);
    let gaps: Vec<f32> = (0..10)
        .map(|_| {
            range.simulation.step(H);
            -range.place().x - 0.05 - HALF_WALL
        })
        .collect();
    println!("26 bullet: gaps to the wall {gaps:.4?} m");
    // What is left of 300 m/s is less than a ten-thousandth.
    let speed = 6.0 * (gaps[9] - gaps[0]) * 10.0 / 9.0;
    assert!(gaps[0].abs() < 0.002 && speed < 0.03, "gaps {gaps:?} m");
}

/// The same from twenty distances (phases of the step) at five angles, turned at random: 0 of 100 pass.
#[test]
fn no_bullet_of_a_hundred_passes_the_wall() {
    let mut dice = Dice::new(26);
    let mut passed = 0;
    for degrees in [0.0_f32, 15.0, 30.0, 45.0, 60.0] {
        for phase in 0..20_u8 {
            let distance = 10.0 + 0.25 * f32::from(phase);
            let desc = bullet(distance, degrees.to_radians(), dice.rotation());
            passed += usize::from(Range::new(desc).passes(12));
        }
    }
    println!("26 bullets: {passed} of 100 pass");
    assert_eq!(passed, 0, "of 100 pass");
}

/// Hard because the plate of 5 mm, edge on and spinning at up to 100 rad/s, hits with one corner first: the others come
/// round within the same step.
#[test]
fn no_spinning_plate_of_a_hundred_passes_the_wall() {
    let mut dice = Dice::new(27);
    let shape = cuboid(Vec3::new(0.2, 0.2, 0.005));
    let mut passed = 0;
    for spin in [0.0, 5.0, 20.0, 50.0, 100.0] {
        for phase in 0..20_u8 {
            let mut desc = bullet(10.0 + 0.25 * f32::from(phase), 0.2, Quat::IDENTITY);
            desc.shape = Shape::Convex(shape.clone());
            desc.angular_velocity = spin * dice.direction();
            passed += usize::from(Range::new(desc).passes(12));
        }
    }
    println!("26 spinning plates: {passed} of 100 pass");
    assert_eq!(passed, 0, "of 100 pass");
}
