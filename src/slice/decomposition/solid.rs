//! A closed mesh that is asked, point by point, how far away it is and whether the point lies in it.

use crate::geometry::TriMesh;
use crate::geometry::bvh::{RayWalk, along_ray, around, tree_box, tree_of, within};
use crate::geometry::triangle_distance::nearest_on_triangle;
use crate::math::Aabb;
use glam::{DVec3, Vec3};
use obvhs::bvh2::Bvh2;
use obvhs::ploc::PlocSearchDistance;

/// Directions of rays that count crossings, one after the other until one meets no edge. Along no axis, plane or diagonal that a model
/// is likely to have.
const DIRECTIONS: [DVec3; 4] = [
    DVec3::new(0.539_7, 0.293_1, 0.789_2),
    DVec3::new(-0.271_3, 0.841_9, 0.466_5),
    DVec3::new(0.683_9, -0.637_1, 0.355_3),
    DVec3::new(-0.430_7, -0.518_9, -0.738_1),
];

/// A ray that passes an edge nearer than this share of the triangle says nothing.
const NEAR_EDGE: f64 = 1e-9;

/// Triangles in a tree.
pub(super) struct Solid {
    pub(super) triangles: Vec<[DVec3; 3]>,
    tree: Bvh2,
}

impl Solid {
    pub(super) fn new(mesh: &TriMesh) -> Self {
        let corners = |t: &[u32; 3]| t.map(|v| mesh.positions()[v as usize]);
        let triangles = mesh.solid().iter().map(corners);
        Self::of_triangles(
            triangles
                .map(|corners| corners.map(Vec3::as_dvec3))
                .collect(),
        )
    }

    /// Of triangles that need not be closed, which is then asked for distances only.
    pub(super) fn of_triangles(triangles: Vec<[DVec3; 3]>) -> Self {
        let box_of = |corners: &[DVec3; 3]| Aabb::of_points(corners.map(|corner| corner.as_vec3()));
        let boxes: Vec<_> = triangles.iter().map(|t| tree_box(&box_of(t))).collect();
        let tree = tree_of(&boxes, PlocSearchDistance::VeryLow);
        Self { triangles, tree }
    }

    /// Whether a triangle comes into a box.
    pub(super) fn meets_box(&self, center: DVec3, half: DVec3) -> bool {
        let bounds = Aabb {
            min: (center - half).as_vec3(),
            max: (center + half).as_vec3(),
        };
        let mut meets = false;
        within(&self.tree, &bounds, |at| {
            meets = meets || meets_box(&self.triangles[at as usize], center, half);
        });
        meets
    }

    /// Distance of a point from the surface, m.
    pub(super) fn distance(&self, point: DVec3) -> f64 {
        let mut nearest = f64::INFINITY;
        around(&self.tree, point.as_vec3(), f32::INFINITY, |at, _| {
            let there = nearest_on_triangle(self.triangles[at as usize], point);
            nearest = nearest.min(point.distance_squared(there));
            nearest.sqrt() as f32
        });
        nearest.sqrt()
    }

    /// Whether the surface goes around a point: a ray from there leaves it more often than it enters it.
    pub(super) fn contains(&self, point: DVec3) -> bool {
        let windings = DIRECTIONS.map(DVec3::normalize);
        let mut windings = windings.into_iter().map(|way| self.winding(point, way));
        let winding = windings.find_map(|winding| winding);
        // Where each ray met an edge the angles around the point decide, which takes longer.
        winding.unwrap_or_else(|| self.winding_by_angles(point)) > 0
    }

    /// How many more triangles a ray leaves through than it comes in by; none if it meets an edge.
    fn winding(&self, point: DVec3, way: DVec3) -> Option<i32> {
        let mut sum = Some(0);
        let dot = Aabb {
            min: Vec3::ZERO,
            max: Vec3::ZERO,
        };
        let ray = RayWalk::new(point.as_vec3(), way.as_vec3(), dot);
        along_ray(&self.tree, ray, f32::MAX, |at, end| {
            sum =
                sum.and_then(|sum| Some(sum + crossing(point, way, &self.triangles[at as usize])?));
            if sum.is_some() { end } else { -1.0 }
        });
        sum
    }

    /// The same from the solid angles of all triangles.
    ///
    /// Source: van Oosterom and Strackee, "The Solid Angle of a Plane Triangle", 1983.
    fn winding_by_angles(&self, point: DVec3) -> i32 {
        let half_angle = |triangle: &[DVec3; 3]| {
            let [a, b, c] = triangle.map(|corner| corner - point);
            let [la, lb, lc] = [a, b, c].map(DVec3::length);
            let down = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            crate::math::atan2(a.dot(b.cross(c)), down)
        };
        let turns: f64 = self.triangles.iter().map(half_angle).sum::<f64>() / std::f64::consts::TAU;
        turns.round() as i32
    }
}

/// 1 if a ray leaves through a triangle, -1 if it comes in by it, 0 if it passes by; none if it is too near to an edge to tell.
fn crossing(point: DVec3, way: DVec3, triangle: &[DVec3; 3]) -> Option<i32> {
    let [a, b, c] = *triangle;
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(ac);
    let down = normal.dot(way);
    if down.abs() <= NEAR_EDGE * normal.length() {
        // Along the plane of the triangle: met only if it lies in it.
        let away = normal.dot(point - a).abs();
        let reach = NEAR_EDGE * normal.length() * (point - a).length();
        return if away > reach { Some(0) } else { None };
    }
    let moment = way.cross(point - a);
    let [u, v] = [ac.dot(moment) / down, -ab.dot(moment) / down];
    let least = u.min(v).min(1.0 - u - v);
    if least < -NEAR_EDGE {
        return Some(0);
    }
    let length = normal.dot(a - point) / down;
    if length < 0.0 {
        return Some(0);
    }
    (least > NEAR_EDGE).then_some(if down > 0.0 { 1 } else { -1 })
}

/// Whether a triangle and a box meet.
///
/// Source: Akenine-Möller, "Fast 3D Triangle-Box Overlap Testing", 2001.
fn meets_box(triangle: &[DVec3; 3], center: DVec3, half: DVec3) -> bool {
    let [a, b, c] = triangle.map(|corner| corner - center);
    let parts = |axis: DVec3| {
        let [a, b, c] = [a, b, c].map(|corner| axis.dot(corner));
        let reach = axis.abs().dot(half);
        a.min(b).min(c) > reach || a.max(b).max(c) < -reach
    };
    let edges = [b - a, c - b, a - c];
    let normal = edges[0].cross(edges[1]);
    let is_parted = DVec3::AXES.into_iter().any(parts)
        || parts(normal)
        || edges
            .iter()
            .any(|edge| DVec3::AXES.iter().any(|axis| parts(edge.cross(*axis))));
    !is_parted
}
