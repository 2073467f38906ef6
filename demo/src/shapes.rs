//! Shapes whose meshes have slots for the outside and for the faces of cuts, and edges that catch the light.

use crate::look::OUTSIDE;
use bevy::math::Vec3;
use bevy_cleave::geometry::primitives;
use bevy_cleave::import::{ImportOptions, Model};
use bevy_cleave::prelude::*;

/// A hull that is drawn as it is, all of it outside.
fn drawn(hull: ConvexHull, visual: TriMesh) -> ConvexMesh {
    let slots = vec![OUTSIDE; visual.triangles().len()];
    let visual = visual.with_materials(slots).expect("a slot per triangle");
    ConvexMesh::from_parts(hull, Some(visual))
}

/// A box, drawn with chamfers of `chamfer` (m).
pub(crate) fn block(size: Vec3, chamfer: f32) -> Result<ConvexMesh, HullError> {
    let hull = primitives::cuboid(size.x, size.y, size.z)?;
    let mut points = Vec::with_capacity(24);
    for corner in hull.vertices() {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            // On one face: drawn in along the two other axes.
            points.push(*corner - chamfer * (Vec3::ONE - axis) * corner.signum());
        }
    }
    let visual = ConvexHull::from_points(&points)?.to_mesh();
    Ok(drawn(hull, visual))
}

/// A convex rock from an uneven ball.
pub(crate) fn boulder(radius: f32) -> Result<ConvexMesh, HullError> {
    let ball = primitives::icosphere(radius, 2)?;
    let points: Vec<Vec3> = ball
        .vertices()
        .iter()
        .enumerate()
        .filter(|(i, _)| i % 5 < 2)
        .map(|(i, v)| *v * (0.85 + 0.05 * (i * 7 % 5) as f32))
        .collect();
    let hull = ConvexHull::from_points(&points)?;
    let visual = hull.to_mesh();
    Ok(drawn(hull, visual))
}

/// A model of an OBJ file, with its bounding box centered and `height` high (m).
pub(crate) fn model(obj: &str, height: f32) -> Result<ConvexMesh, Box<dyn std::error::Error>> {
    let mesh = Model::from_obj(obj)?
        .import(&ImportOptions::default())?
        .mesh;
    let bounds = mesh.aabb();
    let moved = mesh.transformed(&Pose::new(-bounds.center(), bevy::math::Quat::IDENTITY));
    let scaled = moved.scaled(Vec3::splat(height / bounds.extents().y))?;
    let whole = ConvexMesh::from_mesh(scaled)?;
    let visual = whole.visual().expect("made from a mesh").clone();
    Ok(drawn(whole.hull().clone(), visual))
}
