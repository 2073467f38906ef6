//! Whatever lies on one of its faces touches the one-sided level under it, also if the middle of the box around it is below the ground: that of
//! a corner cut from a cube is outside of it.

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};

const H: f32 = 1.0 / 60.0;

/// A corner of a box, or the hull of some points, anywhere in its own frame; nothing if the points make none.
fn shard(dice: &mut Dice) -> Option<ConvexMesh> {
    let size = dice.vector(0.1, 1.0);
    let off = dice.vector(-1.0, 1.0);
    let points: Vec<Vec3> = match dice.below(3) {
        0 => vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z],
        1 => (0..4).map(|_| dice.vector(-0.5, 0.5)).collect(),
        _ => (0..12).map(|_| dice.vector(-0.5, 0.5)).collect(),
    };
    let points: Vec<Vec3> = points.iter().map(|&at| size * at + off).collect();
    let shape = ConvexMesh::from_points(&points).ok()?;
    Some(match dice.below(4) {
        0 => shape.rounded(0.01 + 0.05 * dice.unit()).ok()?,
        _ => shape,
    })
}

/// The pose in which a shape lies on a face of its hull, the ground at zero.
fn lying(shape: &ConvexMesh, dice: &mut Dice) -> Pose {
    let faces = shape.hull().faces();
    let down = faces[dice.below(faces.len())].plane.normal;
    let turn = Quat::from_rotation_arc(down, -Vec3::Y);
    let turn = Quat::from_rotation_y(dice.in_range(-3.0, 3.0)) * turn;
    let heights = shape.hull().vertices().iter().map(|&v| (turn * v).y);
    let lowest = heights.fold(f32::INFINITY, f32::min);
    Pose::new(Vec3::new(0.3, -lowest, 0.2), turn)
}

/// A pose above the ground, turned at random.
fn above(shape: &ConvexMesh, dice: &mut Dice) -> Pose {
    let turn = dice.rotation();
    let corners = shape.hull().vertices();
    let middle = corners.iter().sum::<Vec3>() / corners.len() as f32;
    Pose::new(3.0 * Vec3::Y - turn * middle, turn)
}

/// Flat ground of 60 m around the origin, of two triangles or of many.
fn ground(cells: usize) -> BodyDesc {
    let heights = vec![0.0; (cells + 1) * (cells + 1)];
    let level = StaticMesh::from_heights(&heights, cells + 1, 60.0 / cells as f32);
    let mut ground = BodyDesc::level(level.expect("usable"));
    ground.pose.position = Vec3::new(-30.0, 0.0, -30.0);
    ground
}

#[test]
fn what_lies_on_any_of_its_faces_touches_the_level() {
    let mut dice = Dice::new(41);
    let mut members = 0;
    for member in 0..400 {
        let Some(shape) = shard(&mut dice) else {
            continue;
        };
        let pose = lying(&shape, &mut dice);
        let mut simulation = awake();
        let level = simulation.bodies.insert(ground([1, 150][member % 2]));
        let level = level.expect("usable");
        let queries = simulation.queries();
        let (query, all) = (QueryShape::hull(shape.hull()), QueryFilter::all());
        let mut hits = Vec::new();
        let near = queries.near_shape(&query, &pose, 0.1, &all, &mut hits);
        near.expect("usable");
        assert!(hits.iter().any(|hit| hit.body == level), "{member}: near");
        let cast = ShapeCast::new(query, pose, -Vec3::Y, 1.0).expect("usable");
        let hit = queries.cast_shape(&cast, &all);
        assert!(hit.is_some_and(|hit| hit.body == level), "{member}: cast");
        // Let go there, or shot down from above, it stays above.
        let is_shot = member % 3 == 0;
        let pose = if is_shot {
            above(&shape, &mut dice)
        } else {
            pose
        };
        let body = simulation.bodies.insert(BodyDesc {
            pose,
            linear_velocity: if is_shot { -60.0 * Vec3::Y } else { Vec3::ZERO },
            ..BodyDesc::new(RigidBody::Dynamic, Shape::Convex(shape))
        });
        // What is too thin to have a mass is refused.
        let Ok(body) = body else {
            continue;
        };
        members += 1;
        (0..45).for_each(|_| simulation.step(H));
        let at = simulation.bodies.center_of_mass(body);
        assert!(at.y > 0.0, "{member} is below the ground: {at}");
    }
    assert!(members > 300, "{members}");
}
