//! The point of a triangle that is nearest to another point.

use glam::DVec3;

/// The point of a triangle, which may have no area, that is nearest to `point`: below it if that is over the triangle, or on the
/// nearest edge.
pub(crate) fn nearest_on_triangle([a, b, c]: [DVec3; 3], point: DVec3) -> DVec3 {
    let normal = (b - a).cross(c - a);
    let is_over = |from: DVec3, to: DVec3| normal.dot((to - from).cross(point - from)) >= 0.0;
    let area = normal.length_squared();
    if area > 0.0 && is_over(a, b) && is_over(b, c) && is_over(c, a) {
        return point - normal.dot(point - a) / area * normal;
    }
    let on_edges = [[a, b], [b, c], [c, a]].map(|[from, to]| {
        let along = to - from;
        let share = along.dot(point - from) / along.length_squared();
        // Not a number where both ends are one.
        let share = if share.is_finite() {
            share.clamp(0.0, 1.0)
        } else {
            0.0
        };
        from + share * along
    });
    let nearer = |first: DVec3, other: DVec3| {
        let is_nearer = point.distance_squared(other) < point.distance_squared(first);
        if is_nearer { other } else { first }
    };
    let [first, second, third] = on_edges;
    nearer(nearer(first, second), third)
}
