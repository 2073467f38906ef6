//! Plane polygons: what of one is behind a plane, and its area.

use glam::Vec3;
use smallvec::SmallVec;

/// Corners of a convex polygon in a plane, counter-clockwise seen from its front, m.
pub(crate) type Polygon = SmallVec<[Vec3; 8]>;

/// What of a polygon has no positive height: a step of Sutherland and Hodgman's clipping.
pub(crate) fn behind(polygon: &[Vec3], height: impl Fn(Vec3) -> f32) -> Polygon {
    let mut kept = Polygon::new();
    let Some(&last) = polygon.last() else {
        return kept;
    };
    let (mut from, mut from_height) = (last, height(last));
    for &to in polygon {
        let to_height = height(to);
        if (from_height > 0.0) != (to_height > 0.0) {
            kept.push(from + (to - from) * (from_height / (from_height - to_height)));
        }
        if to_height <= 0.0 {
            kept.push(to);
        }
        (from, from_height) = (to, to_height);
    }
    kept
}

/// Area of a plane polygon, m2.
pub(crate) fn area_of(polygon: &[Vec3]) -> f32 {
    let Some(&first) = polygon.first() else {
        return 0.0;
    };
    let corners = polygon.windows(2);
    let twice: Vec3 = corners
        .map(|pair| (pair[0] - first).cross(pair[1] - first))
        .sum();
    0.5 * twice.length()
}
