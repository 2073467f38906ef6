//! Rebound: a bouncing body (case 4) and a row that is hit (case 5).

use super::support::{G, H, energy, kinetic_energy, momentum, run, simulation, steps, weightless};
use crate::common::structures::{block, cuboid, floor};
use bevy_cleave::prelude::*;
use glam::Vec3;

/// A cube, and an octahedron that stands on a corner: four contact points and one; with the height of its center.
fn bouncers() -> [(&'static str, ConvexMesh); 2] {
    let corners = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| [0.5 * axis, -0.5 * axis]);
    let octahedron = ConvexMesh::from_points(&corners.concat()).expect("valid size");
    [("cube", cuboid(Vec3::ONE)), ("corner", octahedron)]
}

/// What a body does that is dropped from 1 m.
#[derive(Debug, Default)]
struct Bounces {
    /// Heights of the apexes, m.
    apexes: Vec<f64>,
    /// Time of the first step in which the body rises, s.
    first_impact: f64,
    /// Largest angular velocity, rad/s.
    spin: f32,
    /// Height and speed at the end.
    end: (f64, f32),
    /// Largest and smallest energy after the first step, as a share of the first.
    energy: [f64; 2],
}

fn drop_from_one_metre(shape: &ConvexMesh, e: f32, seconds: f64) -> Bounces {
    let restitution = Restitution::new(e);
    let bodies = [floor(0.5), block(shape, 1.5 * Vec3::Y, 0.5)];
    let mut simulation = simulation(bodies.map(|body| BodyDesc {
        restitution,
        ..body
    }));
    let mut seen = Bounces {
        energy: [1.0, 1.0],
        ..Default::default()
    };
    let (mut last_speed, mut start) = (0.0_f64, None);
    for k in 0..steps(seconds) {
        simulation.step(H);
        let (v, omega) = simulation.bodies.velocity(1);
        let (height, speed) = (
            f64::from(simulation.bodies.center_of_mass(1).y) - 0.5,
            f64::from(v.y),
        );
        if last_speed > 0.0 && speed <= 0.0 {
            // The apex lies between two steps: as high above here as a fall to this speed is deep.
            seen.apexes.push(height + speed * speed / (2.0 * G));
        }
        if last_speed < 0.0 && speed > 0.0 && seen.first_impact == 0.0 {
            seen.first_impact = k as f64 * f64::from(H);
        }
        seen.spin = seen.spin.max(omega.length());
        let energy = energy(&simulation);
        // Above the height of a body on the floor.
        let weight = f64::from(simulation.bodies.mass(1).mass) * G;
        let above = (energy - 0.5 * weight) / weight;
        let first = *start.get_or_insert(above);
        seen.energy = [
            seen.energy[0].max(above / first),
            seen.energy[1].min(above / first),
        ];
        seen.end = (height, v.length());
        last_speed = speed;
    }
    seen
}

/// Hard because the impact falls between two steps: contact found early or late changes speed and height; with `e = 0.5`
/// the apexes are 1/4, 1/16, 1/64 m, the first impact after 0.45152 s and rest after 1.35457 s.
#[test]
fn rebound_reaches_a_quarter_of_the_height_each_time_and_comes_to_rest() {
    for (name, shape) in bouncers() {
        let seen = drop_from_one_metre(&shape, 0.5, 2.0);
        let errors: Vec<f64> = (seen.apexes.iter().zip([0.25, 0.0625, 0.015625]))
            .map(|(apex, exact)| apex / exact - 1.0)
            .collect();
        println!(
            "case 4: {name}: apexes {errors:+.4?} off, spin {:.1e} rad/s, end {:?}",
            seen.spin, seen.end
        );
        assert!(errors.len() == 3, "{} apexes", errors.len());
        assert!(
            (seen.first_impact - 0.45152).abs() <= 1.01 * f64::from(H),
            "{} s",
            seen.first_impact
        );
        assert!(
            seen.spin < 1e-3,
            "a flat impact must not spin: {} rad/s",
            seen.spin
        );
        assert!(
            seen.end.0.abs() < 2e-3 && seen.end.1 < 1e-2,
            "not at rest: {:?}",
            seen.end
        );
        for (error, bar) in errors.iter().zip([0.01, 0.02, 0.03]) {
            assert!(error.abs() < bar, "{name}: apexes {errors:?} off");
        }
    }
}

/// Hard because every impact adds its error to the energy, with one sign; with `e = 1` it never changes.
#[test]
fn perfect_rebound_keeps_its_energy_over_twenty_bounces() {
    for (name, shape) in bouncers() {
        let seen = drop_from_one_metre(&shape, 1.0, 18.5);
        let [most, least] = seen.energy;
        println!(
            "case 4: {name}, e = 1: {} bounces, energy {least:.5} to {most:.5}, spin {:.1e} rad/s",
            seen.apexes.len(),
            seen.spin
        );
        assert!(seen.apexes.len() >= 20, "{} bounces", seen.apexes.len());
        assert!(
            most < 1.01 && least > 0.99,
            "{name}: energy {least} to {most}"
        );
    }
}

/// Hard because all contacts act at once. Velocity-level Newton restitution has the answer `(2/n - 1, 2/n, ..)`: all but
/// the first leave together, momentum and energy are kept. (Newton's cradle, one after the other, would give 0, .., 0, 1.)
#[test]
fn row_that_is_hit_conserves_momentum_and_energy_as_newtons_law_has_it() {
    for n in [3_u8, 5] {
        let shape = cuboid(Vec3::ONE);
        let place =
            |i: u8| f32::from(i) * Vec3::X - if i == 0 { 0.1 * Vec3::X } else { Vec3::ZERO };
        let row = (0..n).map(|i| BodyDesc {
            restitution: Restitution::new(1.0),
            linear_velocity: if i == 0 { Vec3::X } else { Vec3::ZERO },
            ..block(&shape, place(i), 0.0)
        });
        let mut simulation = weightless(row);
        run(&mut simulation, 0.5);
        let slots = || (0..u32::from(n)).map(|slot| simulation.bodies.velocity(slot).0.x);
        let p: f64 = (0..u32::from(n))
            .map(|slot| momentum(&simulation, slot).x)
            .sum();
        let (p, e) = (p / 1000.0 - 1.0, kinetic_energy(&simulation) / 500.0 - 1.0);
        let speeds: Vec<f32> = slots().collect();
        println!("case 5: row of {n}: {speeds:.5?} m/s, momentum {p:+.1e}, energy {e:+.1e}");
        assert!(
            p.abs() < 1e-5 && e.abs() < 1e-5,
            "row of {n}: momentum {p} off, energy {e} off, {speeds:?}"
        );
        let share = 2.0 / f32::from(n);
        for (i, v) in slots().enumerate() {
            let exact = if i == 0 { share - 1.0 } else { share };
            assert!(
                (v - exact).abs() < 1e-4,
                "body {i} of {n}: {v} m/s, not {exact}"
            );
        }
    }
}
