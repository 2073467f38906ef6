//! Walls of bricks that are one body, what is shot at them, and pictures of both.

use super::Error;
use super::picture::Picture;
use super::render::{Camera, Scene};
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Length, height and thickness of a brick, m.
pub const BRICK: Vec3 = Vec3::new(0.25, 0.1, 0.12);

/// What stands (blue) and what has come loose (red).
pub fn picture(simulation: &Simulation) -> Picture {
    let bodies = &simulation.bodies;
    let mut scene = Scene::default();
    for slot in bodies.iter() {
        let (convex, compound) = (bodies.convex(slot), bodies.compound(slot));
        let color = match bodies.kind(slot) {
            RigidBody::Static => Vec3::new(0.25, 0.38, 0.6),
            _ => Vec3::new(0.62, 0.25, 0.18),
        };
        if let Some(mesh) = convex {
            scene.draw(&mesh.render_mesh(), bodies.pose(slot), color);
        }
        for (index, part) in compound.iter().flat_map(|it| it.parts().iter().enumerate()) {
            // Neighbors can be told apart.
            let shade = 0.8 + 0.1 * (index % 3) as f32;
            let pose = bodies.pose(slot) * part.pose;
            scene.draw(&part.shape.render_mesh(), pose, shade * color);
        }
    }
    let eye = Vec3::new(1.8, 1.9, 4.6);
    let camera = Camera::look_at(eye, Vec3::new(0.2, 0.75, 0.0), Vec3::Y, 42.0, 1280, 720);
    scene.render(&camera)
}

/// An iron ball on its way.
pub fn ball(radius: f32, at: Vec3, velocity: Vec3) -> Result<BodyDesc, Error> {
    let shape = ConvexMesh::sphere(radius)?;
    Ok(BodyDesc {
        density: 7800.0,
        linear_velocity: velocity,
        ..BodyDesc::dynamic(shape, at)
    })
}

/// Bricks in courses, bonded; the foot in the plane y = 0.
pub fn wall(bricks: usize, courses: usize, strength: f32) -> Result<BodyDesc, Error> {
    let size = BRICK * Vec3::new(bricks as f32, courses as f32, 1.0);
    let whole = ConvexMesh::cuboid(size.x, size.y, size.z)?;
    let pattern = FracturePattern::Brick { size: BRICK };
    let cluster = Cluster::cut(&whole, &pattern, 1, strength)?;
    let shape = Shape::Compound(cluster.compound()?);
    Ok(BodyDesc {
        pose: Pose::from_position(0.5 * size.y * Vec3::Y),
        density: 1900.0,
        ..BodyDesc::new(RigidBody::Static, shape)
    })
}
