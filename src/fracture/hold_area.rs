//! Whether a convex piece holds on to something that stands: face to face, or by reaching into it.

use crate::bodies::body::Shape;
use crate::bodies::store::Bodies;
use crate::geometry::polygon::{Polygon, area_of, behind};
use crate::geometry::shared_area::{self, faces_opposed, overlap};
use crate::geometry::{Compound, ConvexHull, StaticMesh};
use crate::math::{Aabb, Plane, Pose, rotate};

/// Least area by which something holds, as a share of the square of the piece's least extent: more than rounding makes of two
/// edges that touch.
const MIN_AREA: f32 = 1e-3;

/// Something that stands, seen from the frame of a piece.
pub(super) enum Standing<'s> {
    /// What is behind a plane.
    HalfSpace(Plane),
    /// A hull, and its pose.
    Hull(&'s ConvexHull, Pose),
    /// A level, and its pose.
    Level(&'s StaticMesh, Pose),
    /// Several parts, and their pose.
    Compound(&'s Compound, Pose),
}

impl<'s> Standing<'s> {
    /// The body in `slot`, seen from a piece at `pose` in the world.
    pub(super) fn of(bodies: &'s Bodies, slot: u32, pose: &Pose) -> Self {
        let piece_from_world = pose.inverse();
        let other = bodies.pose(slot);
        let seen = Pose::new(
            piece_from_world.transform_point(other.position),
            piece_from_world.rotation * other.rotation,
        );
        Self::seen(&bodies.info(slot).shape, seen)
    }

    /// A shape whose frame is seen so.
    fn seen(shape: &'s Shape, seen: Pose) -> Self {
        match shape {
            Shape::Convex(mesh) => Self::Hull(mesh.hull(), seen),
            Shape::HalfSpace(half_space) => Self::HalfSpace(Plane::through(
                seen.position,
                rotate(seen.rotation, half_space.normal),
            )),
            Shape::Level(level) => Self::Level(level, seen),
            Shape::Compound(compound) => Self::Compound(compound, seen),
        }
    }
}

/// Whether a piece holds on to what stands, over a gap of at most `reach` (m).
pub(super) fn holds(hull: &ConvexHull, standing: &Standing, reach: f32) -> bool {
    let extent = hull.aabb().extents().min_element();
    let enough = MIN_AREA * extent * extent;
    // Most that hold do so face to face.
    match standing {
        Standing::HalfSpace(plane) => {
            shared_area::on_half_space(hull, plane, reach) > enough
                || behind_plane(hull, plane) > enough
        }
        Standing::Hull(other, pose) => {
            shared_area::of_hulls(hull, other, pose, reach) > enough
                || within_each_other(hull, other, pose) > enough
        }
        Standing::Level(level, pose) => on_level(hull, level, pose, reach, enough),
        Standing::Compound(compound, pose) => {
            let part_holds = |&index: &u32| {
                let part = &compound.parts()[index as usize];
                let part = Standing::Hull(part.shape.hull(), *pose * part.pose);
                holds(hull, &part, reach)
            };
            let seen = pose.inverse();
            let corners = hull.vertices().iter();
            let around = Aabb::of_points(corners.map(|&v| seen.transform_point(v)));
            let mut near = Vec::new();
            compound.within(&around.fattened(reach), |part| near.push(part));
            near.iter().any(part_holds)
        }
    }
}

/// Outline of each face of a hull, seen from the outer frame of `pose`.
fn outlines(hull: &ConvexHull, pose: Pose) -> impl Iterator<Item = Polygon> {
    hull.faces().iter().map(move |face| {
        let corners = hull.face_loop(face).iter();
        corners
            .map(|&v| pose.transform_point(hull.vertices()[v as usize]))
            .collect()
    })
}

/// Area of a hull's faces behind a plane, m2.
fn behind_plane(hull: &ConvexHull, plane: &Plane) -> f32 {
    let faces = outlines(hull, Pose::IDENTITY);
    faces
        .map(|outline| area_of(&behind(&outline, |at| plane.distance(at))))
        .sum()
}

/// Area of the faces of two hulls that lie within the other one, m2.
fn within_each_other(hull: &ConvexHull, other: &ConvexHull, pose: &Pose) -> f32 {
    let inside = |outlines: &mut dyn Iterator<Item = Polygon>, hull: &ConvexHull| -> f32 {
        outlines
            .map(|outline| area_of(&inside_of(outline, hull)))
            .sum()
    };
    inside(&mut outlines(other, *pose), hull) + inside(&mut outlines(hull, pose.inverse()), other)
}

/// What of a polygon is inside a hull.
fn inside_of(mut polygon: Polygon, hull: &ConvexHull) -> Polygon {
    for face in hull.faces() {
        if polygon.is_empty() {
            break;
        }
        polygon = behind(&polygon, |at| face.plane.distance(at));
    }
    polygon
}

/// Whether triangles lie on faces of the hull or within it over more than `enough` area, m2.
fn on_level(hull: &ConvexHull, level: &StaticMesh, pose: &Pose, reach: f32, enough: f32) -> bool {
    let level_from_piece = pose.inverse();
    let corners = hull.vertices().iter();
    let around = Aabb::of_points(corners.map(|&v| level_from_piece.transform_point(v)));
    let mut area = 0.0;
    level
        .tree()
        .within(level.triangles(), &around.fattened(reach), |leaf| {
            if area > enough {
                return;
            }
            let triangle = &level.triangles()[leaf as usize];
            let outline = triangle.corners.map(|corner| pose.transform_point(corner));
            let normal = rotate(pose.rotation, triangle.plane.normal);
            area += area_of(&inside_of(Polygon::from_slice(&outline), hull));
            for face in faces_opposed(hull, normal) {
                let on_face = overlap(Polygon::from_slice(&outline), hull, face);
                if on_face
                    .iter()
                    .any(|&at| face.plane.distance(at).abs() <= reach)
                {
                    area += area_of(&on_face);
                }
            }
        });
    area > enough
}
