//! What a game asks of a scene: what is under the cursor, where a capsule fits, who is near a blast. Look for the figures it prints.
//!
//! `cargo run --release --example queries`

#![expect(clippy::print_stdout, reason = "the answers are the result")]

use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let mut simulation = Simulation::default();
    let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    let floor = simulation.bodies.insert(floor)?;
    let crate_shape = ConvexMesh::cuboid(1.0, 1.0, 1.0)?;
    for i in 0..25 {
        let place = Vec3::new((i % 5) as f32 * 1.5, 0.5 + 2.0 * (i / 5) as f32, 0.0);
        simulation
            .bodies
            .insert(BodyDesc::dynamic(crate_shape.clone(), place))?;
    }
    (0..120).for_each(|_| simulation.step(1.0 / 60.0));

    let queries = simulation.queries();
    let all = QueryFilter::all();
    let eye = Vec3::new(3.0, 4.0, 12.0);
    let cursor = Ray::between(eye, Vec3::new(3.0, 2.0, 0.0))?;
    match queries.cast_ray(&cursor, &all) {
        Some(hit) => println!(
            "under the cursor: body {} on face {:?}, {:.3} m away, normal {:.2}",
            hit.body, hit.face, hit.distance, hit.normal
        ),
        None => println!("under the cursor: nothing"),
    }

    let mut hits = Vec::new();
    let along = Ray::new(Vec3::new(-5.0, 0.5, 0.0), Vec3::X, 50.0)?;
    queries.cast_ray_all(&along, &all, &mut hits);
    println!(
        "a shot along the lowest row goes through {} bodies",
        hits.len()
    );

    let capsule = QueryShape::capsule(0.3, 1.0)?;
    let above = Pose::new(Vec3::new(-2.0, 3.0, 0.0), Quat::IDENTITY);
    let fall = ShapeCast::new(capsule, above, Vec3::NEG_Y, 10.0)?;
    if let Some(hit) = queries.cast_shape(&fall, &all) {
        let on_floor = hit.body == floor;
        println!(
            "a capsule let go falls {:.3} m, to the floor: {on_floor}",
            hit.distance
        );
    }

    let blast = Vec3::new(3.0, 1.0, 0.0);
    let crates_only = |slot| slot != floor;
    let filter = QueryFilter::all().with_predicate(&crates_only);
    queries.within_radius(blast, 2.0, &filter, &mut hits)?;
    println!("{} crates are within 2 m of {blast}", hits.len());
    for hit in &hits {
        println!("  body {} at {:.3} m", hit.body, hit.distance);
    }
    Ok(())
}
