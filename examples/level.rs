//! Levels of triangles. First bodies of all kinds, and a block that a ball breaks, on a terrain and in a room that stands on it, with pictures in
//! `target/level/level.png`. Then bodies on a terrain of a million triangles, beside the same bodies on a plane: look for the times of a
//! step, and that nothing is below the ground.
//!
//! `cargo run --release --example level`

#![expect(clippy::print_stdout, reason = "the measured figures are the result")]

#[path = "support/mod.rs"]
mod support;

use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};
use std::time::Instant;
use support::Error;
use support::colors::{IRON, clay};
use support::masonry::ball;
use support::picture::{Picture, contact_sheet};
use support::render::{Camera, Scene};

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
fn run(ground: BodyDesc, steps: usize) -> Result<(Simulation, [f64; 2]), Error> {
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

/// Corners along each side of the terrain around the room, half a meter apart.
const CORNERS: usize = 61;

/// A level and where it is, m.
type Ground = (StaticMesh, Vec3);

/// Hills that leave level ground for a room in the middle.
fn hills() -> Result<Ground, Error> {
    let place = |k: usize| 0.5 * k as f32 - 15.0;
    let heights = (0..CORNERS * CORNERS).map(|i| {
        let (i, k) = (i % CORNERS, i / CORNERS);
        let from_room = place(i).abs().max(place(k).abs()) - 5.0;
        2.5 * height(2 * i, 2 * k) * (0.3 * from_room).clamp(0.0, 1.0)
    });
    let heights: Vec<f32> = heights.collect();
    let hills = StaticMesh::from_heights(&heights, CORNERS, 0.5)?;
    Ok((hills, Vec3::new(-15.0, 0.0, -15.0)))
}

/// A floor and three walls, open to the front: one mesh.
fn room() -> Result<Ground, Error> {
    let boxes = [
        (Vec3::new(8.0, 0.4, 8.0), Vec3::ZERO),
        (Vec3::new(8.0, 3.0, 0.3), Vec3::new(0.0, 1.5, -4.0)),
        (Vec3::new(0.3, 3.0, 8.0), Vec3::new(-4.0, 1.5, 0.0)),
        (Vec3::new(0.3, 1.0, 8.0), Vec3::new(4.0, 0.5, 0.0)),
    ];
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (size, at) in boxes {
        let hull = ConvexMesh::cuboid(size.x, size.y, size.z)?;
        let first = positions.len() as u32;
        positions.extend(hull.hull().vertices().iter().map(|&v| v + at));
        triangles.extend(hull.hull().triangles().map(|t| t.map(|v| v + first)));
    }
    Ok((StaticMesh::new(&positions, &triangles)?, Vec3::ZERO))
}

/// A stool of a seat and three legs.
fn stool() -> Result<Shape, Error> {
    let seat = (
        Pose::from_position(0.45 * Vec3::Y),
        ConvexMesh::cylinder(0.3, 0.1)?,
    );
    let leg = ConvexMesh::capsule(0.04, 0.34)?;
    let legs = (0..3).map(|k| {
        let turn = Quat::from_rotation_y(k as f32 * std::f32::consts::TAU / 3.0);
        (
            Pose::from_position(turn * (0.2 * Vec3::X) + 0.21 * Vec3::Y),
            leg.clone(),
        )
    });
    Ok(Shape::Compound(Compound::new(
        std::iter::once(seat).chain(legs),
    )?))
}

/// Shapes of all kinds.
fn shapes() -> Result<Vec<Shape>, Error> {
    let convex = [
        ConvexMesh::sphere(0.35)?,
        ConvexMesh::capsule(0.2, 0.5)?,
        ConvexMesh::cylinder(0.3, 0.5)?,
        ConvexMesh::cone(0.35, 0.7)?,
        ConvexMesh::cuboid(0.5, 0.3, 0.4)?.rounded(0.08)?,
        ConvexMesh::cuboid(0.7, 0.4, 0.5)?,
        ConvexMesh::regular_prism(6, 0.35, 0.4)?,
    ];
    let mut shapes: Vec<Shape> = convex.into_iter().map(Shape::Convex).collect();
    shapes.push(stool()?);
    Ok(shapes)
}

/// Bodies over the hills and in the room, among these a block that breaks.
fn scene(grounds: &[Ground]) -> Result<(Simulation, u32), Error> {
    let mut simulation = Simulation::default();
    for (level, at) in grounds {
        simulation.bodies.insert(BodyDesc {
            pose: Pose::from_position(*at),
            ..BodyDesc::level(level.clone())
        })?;
    }
    let shapes = shapes()?;
    for i in 0..88 {
        let shape = shapes[i % shapes.len()].clone();
        let at = if i < 40 {
            let [x, y, z] = [i % 4, i / 16, i / 4 % 4].map(|k| k as f32);
            Vec3::new(1.1 * x - 2.6, 1.0 + 1.2 * y, 1.2 * z - 3.0)
        } else {
            let turn = Quat::from_rotation_y(0.131 * (i - 40) as f32);
            turn * Vec3::new(7.0 + 1.7 * (i % 4) as f32, 3.5, 0.0)
        };
        let desc = BodyDesc {
            pose: Pose::from_position(at),
            ..BodyDesc::new(RigidBody::Dynamic, shape)
        };
        simulation.bodies.insert(desc)?;
    }
    let block = ConvexMesh::cuboid(1.0, 1.6, 1.0)?;
    let cells = FracturePattern::Voronoi {
        cells: 24,
        focus: 0.5,
    };
    let block = simulation.bodies.insert(BodyDesc {
        fracturable: Some(Fracturable::with_strength(2000.0).with_pattern(cells)),
        ..BodyDesc::dynamic(block, Vec3::new(2.6, 1.02, 1.5))
    })?;
    Ok((simulation, block))
}

/// Lets bodies fall on hills and into a room, breaks one of them, and draws both.
fn show() -> Result<(), Error> {
    let grounds = [hills()?, room()?];
    let (mut simulation, block) = scene(&grounds)?;
    (0..240).for_each(|_| simulation.step(H));
    let before = picture(&simulation, &grounds);
    let target = simulation.bodies.center_of_mass(block);
    let from = target + Vec3::new(0.5, 1.0, 6.0);
    let shot = ball(0.25, from, 25.0 * (target - from).normalize())?;
    simulation.bodies.insert(shot)?;
    let mut pieces = 0;
    for _ in 0..300 {
        simulation.step(H);
        let done = simulation.fractures.done.iter();
        pieces += done.map(|fracture| fracture.pieces.len()).sum::<usize>();
    }
    let bodies = &simulation.bodies;
    let moved = bodies
        .iter()
        .filter(|&slot| bodies.kind(slot) == RigidBody::Dynamic);
    // What rolls off the rim of the hills falls for ever.
    let is_below = |at: Vec3| at.y < -0.05 && at.x.abs().max(at.z.abs()) < 14.9;
    let below = moved.filter(|&slot| is_below(bodies.center_of_mass(slot)));
    println!(
        "{} bodies, {pieces} of them pieces of a block; {} asleep, {} below the ground",
        bodies.len(),
        simulation.report.asleep,
        below.count()
    );
    let pictures = [
        ("fallen".to_owned(), before),
        ("a block is shot".to_owned(), picture(&simulation, &grounds)),
    ];
    contact_sheet(&pictures, 1, 2).save("target/level/level.png")
}

fn picture(simulation: &Simulation, grounds: &[Ground]) -> Picture {
    let bodies = &simulation.bodies;
    let mut scene = Scene::default();
    for (number, slot) in bodies.iter().enumerate() {
        let pose = bodies.pose(slot);
        if let Some(mesh) = bodies.convex(slot) {
            let is_iron = bodies.mass(slot).mass > 400.0 && mesh.is_round();
            scene.draw(
                &mesh.render_mesh(),
                pose,
                if is_iron { IRON } else { clay(number) },
            );
        } else if let Some(compound) = bodies.compound(slot) {
            scene.draw(&compound.render_mesh(), pose, Vec3::new(0.5, 0.35, 0.15));
        }
    }
    let colors = [Vec3::new(0.2, 0.3, 0.12), Vec3::new(0.5, 0.5, 0.47)];
    for ((level, at), color) in grounds.iter().zip(colors) {
        scene.draw(&level.to_mesh(), Pose::from_position(*at), color);
    }
    let eye = Vec3::new(9.0, 8.0, 13.0);
    let camera = Camera::look_at(eye, 0.5 * Vec3::Y, Vec3::Y, 45.0, 1280, 720);
    scene.render(&camera)
}

fn main() -> Result<(), Error> {
    show()?;
    race()
}

/// The same bodies on a plane, on a flat level and on a terrain.
fn race() -> Result<(), Error> {
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
