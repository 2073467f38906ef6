//! Area over which two shapes touch face to face.

use crate::geometry::ConvexHull;
use crate::geometry::face::Face;
use crate::geometry::polygon::{Polygon, area_of, behind};
use crate::math::{Plane, Pose, rotate};
use glam::Vec3;

/// Cosine of the largest angle between two faces that touch flatly: 1 degree.
const FLAT: f32 = 0.999_848;

/// Area of the faces of `a` and `b` that lie on each other with a gap or overlap of at most `gap` (m), m2.
///
/// `b_in_a` is the pose of B in A's frame.
pub(crate) fn of_hulls(a: &ConvexHull, b: &ConvexHull, b_in_a: &Pose, gap: f32) -> f32 {
    let mut area = 0.0;
    patches_of_hulls(a, b, b_in_a, gap, |patch, _| area += area_of(patch));
    area
}

/// Visits what lies on each other so: polygons in A's frame, with the outward normals of A's faces.
pub(crate) fn patches_of_hulls(
    a: &ConvexHull,
    b: &ConvexHull,
    b_in_a: &Pose,
    gap: f32,
    mut visit: impl FnMut(&[Vec3], Vec3),
) {
    for face in b.faces() {
        let outline = || {
            let corners = b.face_loop(face).iter();
            corners.map(|&v| b_in_a.transform_point(b.vertices()[v as usize]))
        };
        let normal = rotate(b_in_a.rotation, face.plane.normal);
        for other in a.faces() {
            if lies_on(&other.plane, normal, outline(), gap) {
                visit(&overlap(outline().collect(), a, other), other.plane.normal);
            }
        }
    }
}

/// Area of the faces of a hull that lie on a half-space, whose surface is `plane` in the hull's frame, m2.
pub(crate) fn on_half_space(hull: &ConvexHull, plane: &Plane, gap: f32) -> f32 {
    let outline = |face: &Face| {
        let corners = hull.face_loop(face).iter();
        corners.map(|&v| hull.vertices()[v as usize])
    };
    let faces = hull.faces().iter();
    let lying = faces.filter(|face| lies_on(plane, face.plane.normal, outline(face), gap));
    lying
        .map(|face| area_of(&outline(face).collect::<Polygon>()))
        .sum()
}

/// Faces of a hull that a plane with this normal could lie on.
pub(crate) fn faces_opposed(hull: &ConvexHull, normal: Vec3) -> impl Iterator<Item = &Face> {
    let faces = hull.faces().iter();
    faces.filter(move |face| face.plane.normal.dot(normal) <= -FLAT)
}

/// Whether a face with this normal and outline is opposed to a plane and within `gap` of it.
fn lies_on(plane: &Plane, normal: Vec3, mut outline: impl Iterator<Item = Vec3>, gap: f32) -> bool {
    plane.normal.dot(normal) <= -FLAT && outline.any(|at| plane.distance(at).abs() <= gap)
}

/// What of a convex polygon lies within the outline of a face, seen along the face's normal: Sutherland and Hodgman's
/// clipping.
pub(crate) fn overlap(mut polygon: Polygon, hull: &ConvexHull, face: &Face) -> Polygon {
    let outline = hull.face_loop(face);
    let corner = |i: usize| hull.vertices()[outline[i % outline.len()] as usize];
    for i in 0..outline.len() {
        let (from, to) = (corner(i), corner(i + 1));
        let outward = (to - from).cross(face.plane.normal);
        polygon = behind(&polygon, |at| outward.dot(at - from));
    }
    polygon
}
