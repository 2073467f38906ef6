//! Bodies on a terrain of a million triangles, beside the same bodies on a plane. Look for the two times of a step, and that nothing
//! is below the ground.
//!
//! `cargo run --release --example level`

#![expect(clippy::print_stdout, reason = "the measured figures are the result")]

use bevy_cleave::prelude::*;
use glam::Vec3;
use std::error::Error;
use std::time::Instant;

/// Length of a step, s.
const H: f32 = 1.0 / 60.0;

/// Corners along each side of the terrain.
const SIDE: usize = 708;

/// Bodies.
const COUNT: usize = 1000;

/// A height between waves of two lengths, without functions of the platform, m.
fn height(i: usize, k: usize) -> f32 {
    let wave = |at: usize, length: usize| {
        let share = (at % length) as f32 / length as f32;
        4.0 * share * (1.0 - share)
    };
    0.6 * wave(i, 97) * wave(k, 61) + 0.2 * wave(i + k, 23)
}

/// The bodies on a ground; seconds of all steps, and of those after everything has come to rest.
fn run(ground: BodyDesc, steps: usize) -> Result<(Simulation, [f64; 2]), Box<dyn Error>> {
    let mut simulation = Simulation::default();
    simulation.bodies.insert(ground)?;
    let shapes = [
        ConvexMesh::cuboid(1.0, 0.6, 0.8)?,
        ConvexMesh::icosphere(0.5, 1)?,
        ConvexMesh::regular_prism(6, 0.5, 0.7)?,
    ];
    for i in 0..COUNT {
        let at = Vec3::new((i % 32) as f32, 1.0, (i / 32) as f32);
        let place = 10.0 * Vec3::ONE.with_y(0.0) + at * Vec3::new(2.0, 1.5, 2.0);
        simulation
            .bodies
            .insert(BodyDesc::dynamic(shapes[i % 3].clone(), place))?;
    }
    let mut seconds = [0.0; 2];
    for step in 0..steps {
        let start = Instant::now();
        simulation.step(H);
        let taken = start.elapsed().as_secs_f64();
        seconds[0] += taken;
        seconds[1] += if step >= steps / 2 { taken } else { 0.0 };
    }
    Ok((simulation, seconds))
}

fn main() -> Result<(), Box<dyn Error>> {
    let heights: Vec<f32> = (0..SIDE * SIDE)
        .map(|i| height(i % SIDE, i / SIDE))
        .collect();
    let start = Instant::now();
    let terrain = StaticMesh::from_heights(&heights, SIDE, 1.0)?;
    let flat = StaticMesh::from_heights(&vec![0.0; SIDE * SIDE], SIDE, 1.0)?;
    println!(
        "two levels of {} triangles each: {:.2} s",
        terrain.len(),
        start.elapsed().as_secs_f64()
    );
    let plane = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    let grounds = [
        ("plane", plane),
        ("flat level", BodyDesc::level(flat)),
        ("terrain", BodyDesc::level(terrain)),
    ];
    let steps = 300;
    for (name, ground) in grounds {
        let (mut simulation, [all, late]) = run(ground, steps)?;
        let lowest = (1..=COUNT as u32)
            .map(|slot| simulation.bodies.center_of_mass(slot).y)
            .fold(f32::INFINITY, f32::min);
        println!(
            "{name:>10}: {:.2} ms a step, {:.2} ms once all rest; {} contacts, lowest center at {lowest:.2} m",
            1e3 * all / steps as f64,
            2e3 * late / steps as f64,
            simulation.report.contacts
        );
        let queries = simulation.queries();
        let start = Instant::now();
        let rays = 100_000;
        let mut hits = 0;
        for i in 0..rays {
            let from = Vec3::new(
                (i % 331) as f32 * 0.2 + 8.0,
                20.0,
                (i / 331) as f32 * 0.2 + 8.0,
            );
            let ray = Ray::new(from, Vec3::new(0.3, -1.0, 0.1), 100.0)?;
            hits += usize::from(queries.cast_ray(&ray, &QueryFilter::all()).is_some());
        }
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "            {:.2} us a ray, {hits} of {rays} hit",
            1e6 * seconds / rays as f64
        );
    }
    Ok(())
}
