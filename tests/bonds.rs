//! exploration

use bevy_cleave::prelude::*;
use glam::Vec3;

const H: f32 = 1.0 / 60.0;

fn cube() -> ConvexMesh {
    ConvexMesh::cuboid(1.0, 1.0, 1.0).unwrap()
}

fn chain(n: usize, along: Vec3, strength: f32) -> (Simulation, Vec<u32>) {
    let mut s = Simulation::default();
    let mut slots = vec![];
    for i in 0..=n {
        let mut d = BodyDesc::dynamic(cube(), along * i as f32);
        if i == 0 {
            d.kind = RigidBody::Static;
        }
        slots.push(s.bodies.insert(d).unwrap());
    }
    assert_eq!(s.bond_neighbours(&slots, strength).unwrap(), n);
    (s, slots)
}

fn wall(strength: f32) -> (Simulation, Vec<u32>, usize) {
    let mut s = Simulation::default();
    let brick = ConvexMesh::cuboid(0.4, 0.2, 0.2).unwrap();
    let mut slots = vec![];
    for x in [-0.4 * 5.0, 0.4 * 5.0] {
        let mut d = BodyDesc::dynamic(
            ConvexMesh::cuboid(0.4, 0.2, 0.2).unwrap(),
            Vec3::new(x, -0.2, 0.0),
        );
        d.kind = RigidBody::Static;
        s.bodies.insert(d).unwrap();
    }
    for row in 0..10 {
        for col in 0..10 {
            let x = (col as f32 - 4.5 + if row % 2 == 0 { -0.25 } else { 0.25 }) * 0.4;
            let mut d = BodyDesc::dynamic(brick.clone(), Vec3::new(x, row as f32 * 0.2, 0.0));
            d.density = 2000.0;
            slots.push(s.bodies.insert(d).unwrap());
        }
    }
    let n = s.bond_neighbours(&slots, strength).unwrap();
    (s, slots, n)
}

#[test]
fn explore_wall() {
    for mode in ["plain", "ramp"] {
        for strength in [2e5_f32, 1e5, 5e4, 2e4, 1e4, 5e3] {
            let (mut s, slots, n) = wall(strength);
            let starts: Vec<_> = slots.iter().map(|&x| s.bodies.centre_of_mass(x)).collect();
            let mut broken = 0;
            let (mut worst, mut residual) = (0.0_f32, 0.0);
            let mut first = None;
            s.config.measure_error = true;
            for step in 0..600 {
                match mode {
                    "first 32" => s.config.substeps = if step < 2 { 32 } else { 8 },
                    "all 32" => s.config.substeps = 32,
                    "ramp" => s.gravity.0 = Vec3::Y * -9.81 * (step as f32 / 60.0).min(1.0),
                    _ => {}
                }
                s.step(H);
                broken += s.bonds.broken.len();
                if broken > 0 && first.is_none() {
                    first = Some(step);
                }
                worst = slots
                    .iter()
                    .zip(&starts)
                    .map(|(&x, p)| (s.bodies.centre_of_mass(x) - *p).length())
                    .fold(worst, f32::max);
                residual = s.report.error.unwrap().residual.relative;
            }
            let end = slots
                .iter()
                .zip(&starts)
                .map(|(&x, p)| (s.bodies.centre_of_mass(x) - *p).length())
                .fold(0.0, f32::max);
            println!(
                "{mode} {strength} bonds {n} broken {broken} first {first:?} worst {:.4} mm end {:.4} residual {residual:e}",
                1e3 * worst,
                1e3 * end
            );
        }
    }
}
