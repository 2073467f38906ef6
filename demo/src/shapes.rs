//! Shapes whose meshes have slots for the outside and for the faces of cuts, and edges that catch the light.

use crate::look::OUTSIDE;
use bevy::math::{Vec3, ops};
use bevy_cleave::geometry::primitives;
use bevy_cleave::import::{ImportOptions, Model};
use bevy_cleave::prelude::*;

/// A hull that is drawn as it is, all of it with the material of one slot.
fn drawn(hull: ConvexHull, visual: TriMesh, slot: u16) -> ConvexMesh {
    let slots = vec![slot; visual.triangles().len()];
    let visual = visual.with_materials(slots).expect("a slot per triangle");
    ConvexMesh::from_parts(hull, Some(visual))
}

/// Eight corners, drawn with chamfers of `chamfer` (m). `corner` tells where one is, by the side that it is on along each axis (-1 or 1),
/// when the faces of the three axes are drawn in by so much (m).
fn chamfered(
    chamfer: f32,
    slot: u16,
    corner: impl Fn(Vec3, Vec3) -> Vec3,
) -> Result<ConvexMesh, HullError> {
    let mut corners = Vec::with_capacity(8);
    let mut drawn_in = Vec::with_capacity(24);
    for number in 0..8 {
        let side = |axis: u8| if number >> axis & 1 == 0 { -1.0 } else { 1.0 };
        let sides = Vec3::new(side(0), side(1), side(2));
        corners.push(corner(sides, Vec3::ZERO));
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            // On one face: drawn in along the two other axes.
            drawn_in.push(corner(sides, chamfer * (Vec3::ONE - axis)));
        }
    }
    let hull = ConvexHull::from_points(&corners)?;
    let visual = ConvexHull::from_points(&drawn_in)?.to_mesh();
    Ok(drawn(hull, visual, slot))
}

/// A box, drawn with chamfers of `chamfer` (m).
pub(crate) fn block(size: Vec3, chamfer: f32) -> Result<ConvexMesh, HullError> {
    chamfered(chamfer, OUTSIDE, |sides, inset| {
        sides * (0.5 * size - inset)
    })
}

/// A stone of a round wall about the y axis, which it sees within `angle` (rad), from `radii` (m) inside to outside; it looks along +z.
pub(crate) fn wedge(
    angle: f32,
    radii: [f32; 2],
    height: f32,
    chamfer: f32,
    slot: u16,
) -> Result<ConvexMesh, HullError> {
    let [inner, outer] = radii;
    let slope = ops::tan(0.5 * angle);
    chamfered(chamfer, slot, |sides, inset| {
        let z = 0.5 * (inner + outer) + sides.z * (0.5 * (outer - inner) - inset.z);
        let half = Vec3::new(slope * z, 0.5 * height, 0.0) - inset;
        (sides * half).with_z(z)
    })
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
    Ok(drawn(hull, visual, OUTSIDE))
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
    Ok(drawn(whole.hull().clone(), visual, OUTSIDE))
}
