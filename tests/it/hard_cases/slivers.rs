//! Needles and plates: inertia ratios up to a million.

use super::scene::*;
use super::support::*;
use crate::common::structures::*;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

/// Edges of the slivers, m, and their ratio of moments of inertia.
const SLIVERS: [(&str, Vec3); 4] = [
    ("needle 1:5000", Vec3::new(1.0, 0.01, 0.01)),
    ("splinter 1:5e5", Vec3::new(1.0, 0.001, 0.001)),
    ("splinter 1:1e6", Vec3::new(1.0, 0.0007, 0.0007)),
    ("plate 1:2", Vec3::new(1.0, 0.002, 1.0)),
];

fn shape_of(edges: Vec3) -> ConvexMesh {
    cuboid(edges)
}

/// Layers of two crossed bodies each, like logs; plates lie on one another, turned by a quarter.
fn crossed_pile(edges: Vec3, layers: u8) -> Simulation {
    let mut simulation = with_floor(0.5);
    let shape = shape_of(edges);
    let is_plate = edges.z > 0.1;
    for layer in 0..layers {
        let turn = if layer % 2 == 0 {
            Quat::IDENTITY
        } else {
            Quat::from_rotation_y(std::f32::consts::FRAC_PI_2)
        };
        let height = (f32::from(layer) + 0.5) * edges.y;
        let sides: &[f32] = if is_plate { &[0.0] } else { &[-0.3, 0.3] };
        for &side in sides {
            let place = turn * Vec3::new(0.0, height, side);
            let mut desc = block(&shape, place, 0.5);
            desc.pose.rotation = turn;
            add(&mut simulation, desc);
        }
    }
    simulation
}

/// Largest angular velocity (rad/s) of any body in 10 s, and how far any center ended from its start, m.
fn unrest(simulation: &mut Simulation) -> [f32; 2] {
    let places = |simulation: &Simulation| -> Vec<Vec3> {
        let bodies = &simulation.bodies;
        bodies
            .iter()
            .skip(1)
            .map(|b| bodies.center_of_mass(b))
            .collect()
    };
    let before = places(simulation);
    let mut spin = 0.0_f32;
    for _ in 0..600 {
        simulation.step(H);
        let bodies = &simulation.bodies;
        for slot in bodies.iter() {
            let omega = bodies.velocity(slot).1.length();
            assert!(omega.is_finite(), "omega {omega}");
            spin = spin.max(omega);
        }
        assert!(
            simulation.report.problems.is_empty(),
            "{:?}",
            simulation.report
        );
    }
    let moved = places(simulation);
    let moved = moved.iter().zip(&before).map(|(a, b)| a.distance(*b));
    [spin, moved.fold(0.0, f32::max)]
}

/// Hard because a turn about the long axis costs 1e-6 of one across it: the rows of one contact differ by that much in
/// effective mass. At rest nothing may turn at 0.1 rad/s within 10 s.
#[test]
fn slivers_at_rest_and_in_crossed_piles_do_not_spin_up() {
    let mut fails = Vec::new();
    for (name, edges) in SLIVERS {
        for layers in [1, 4] {
            let [spin, moved] = unrest(&mut crossed_pile(edges, layers));
            println!("21 {name}, {layers} layers: omega <= {spin:.2e} rad/s, moved {moved:.2e} m");
            let is_at_rest = spin < 0.1 && moved < 0.005;
            if !is_at_rest {
                fails.push((name, layers, spin, moved));
            }
        }
    }
    assert!(fails.is_empty(), "layers, rad/s, m moved: {fails:?}");
}

/// Energy of a sliver dropped from 1 m, tilted by 10 degrees and turned: most of it against that at the start.
fn drop(edges: Vec3) -> [f64; 2] {
    let mut simulation = with_floor(0.5);
    let mut desc = block(&shape_of(edges), Vec3::Y, 0.5);
    let tilt = 10.0_f32.to_radians();
    desc.pose.rotation = Quat::from_rotation_z(tilt) * Quat::from_rotation_x(0.3);
    let slot = add(&mut simulation, desc);
    weigh(&mut simulation);
    let before = energy(&simulation);
    let mut most = 0.0_f64;
    for _ in 0..300 {
        simulation.step(H);
        let now = energy(&simulation);
        assert!(now.is_finite(), "energy {now}");
        most = most.max(now / before);
    }
    let height = simulation.bodies.center_of_mass(slot).y;
    [most, f64::from(height)]
}

/// Hard because the tip meets the floor with a lever of half a metre and nearly no inertia to take it: the explicit
/// gyroscopic term and a missed impact both blow up. Energy never passes that of the start by 1 %,
/// and the sliver ends lying on the floor.
#[test]
fn dropped_slivers_gain_no_energy() {
    let mut fails = Vec::new();
    for (name, edges) in SLIVERS {
        let [most, height] = drop(edges);
        println!("21 {name} dropped: energy at most x {most:.5}, lies at {height:.5} m");
        let flat = 0.5 * f64::from(edges.y);
        let lies = (height - flat).abs() < 0.5 * flat;
        if !(lies && most < 1.01) {
            fails.push((name, most, height));
        }
    }
    assert!(
        fails.is_empty(),
        "energy over that of the start, m of height: {fails:?}"
    );
}
