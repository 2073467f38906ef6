//! More contacts than degrees of freedom.

use super::scene::*;
use super::support::*;
use crate::common::structures::*;
use bevy_cleave::prelude::*;
use glam::Vec3;

/// A plate of 2 x 1.4 x 0.2 m that touches sixteen fixed blocks at 64 points.
fn plate_on_blocks() -> (Simulation, u32) {
    let mut simulation = simulation([]);
    let shape = cuboid(Vec3::new(0.3, 0.1, 0.2));
    for i in 0..16_u8 {
        let place = Vec3::new(
            0.5 * f32::from(i % 4) - 0.75,
            -0.05,
            0.35 * f32::from(i / 4) - 0.525,
        );
        add(
            &mut simulation,
            BodyDesc {
                kind: RigidBody::Static,
                ..block(&shape, place, 0.5)
            },
        );
    }
    let plate = add(
        &mut simulation,
        block(&cuboid(Vec3::new(2.0, 0.2, 1.4)), 0.1 * Vec3::Y, 0.5),
    );
    (simulation, plate)
}

/// Speed of any point of the plate, at most, m/s, and sum of the normal impulses against weight times step, less 1.
fn unrest(simulation: &Simulation, plate: u32) -> [f64; 2] {
    let (v, omega) = simulation.bodies.velocity(plate);
    let carried: f64 = simulation
        .contacts
        .manifolds()
        .iter()
        .flat_map(|m| m.points())
        .map(|p| f64::from(p.normal_impulse))
        .sum();
    let weight = f64::from(simulation.bodies.mass(plate).mass * H) * G;
    [
        f64::from(v.length() + 1.23 * omega.length()),
        carried / weight - 1.0,
    ]
}

/// Hard because 192 rows act on six degrees of freedom: A has rank 6, and pivots fail or multipliers drift. Velocity
/// after one step is 0 and the multipliers sum to m g h, however they are shared out.
#[test]
fn plate_on_64_contacts_rests_from_the_first_step() {
    let (mut simulation, plate) = plate_on_blocks();
    simulation.step(H);
    assert_eq!(simulation.report.contacts, 64);
    let [speed, excess] = unrest(&simulation, plate);
    let most = |simulation: &Simulation| {
        let manifolds = simulation.contacts.manifolds().iter();
        let impulses = manifolds.flat_map(|m| m.points()).map(|p| p.normal_impulse);
        impulses.fold(0.0, f32::max)
    };
    (0..59).for_each(|_| simulation.step(H));
    let early = most(&simulation);
    (0..540).for_each(|_| simulation.step(H));
    let late = most(&simulation);
    let [speed_late, excess_late] = unrest(&simulation, plate);
    println!(
        "20 plate on 64 contacts: {speed:.2e} m/s and weight {excess:.2e} after a step, \
         {speed_late:.2e} and {excess_late:.2e} after 10 s; largest multiplier {early:.3}, then {late:.3} N s"
    );
    assert!(speed < 1e-3 * G * f64::from(H), "{speed} m/s after a step");
    assert!(
        excess.abs() < 1e-4,
        "carries {excess} too much after a step"
    );
    assert!(speed_late < 1e-5, "{speed_late} m/s after 10 s");
    assert!(excess_late.abs() < 1e-4, "carries {excess_late} too much");
    assert!(
        late < 1.5 * early,
        "multipliers drift: {early}, then {late}"
    );
}
