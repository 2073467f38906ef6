//! The point of a triangle that is nearest to another point.

use glam::{DVec3, Vec3};

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

/// Square of the distance of a triangle with an area, whose unit normal this is, to the origin, m2: as good as `f32` has it.
pub(crate) fn rough_square([a, b, c]: [Vec3; 3], normal: Vec3) -> f32 {
    let is_over = |from: Vec3, to: Vec3| normal.dot(from.cross(to)) >= 0.0;
    if is_over(a, b) && is_over(b, c) && is_over(c, a) {
        let height = normal.dot(a);
        return height * height;
    }
    let to_edge = |from: Vec3, to: Vec3| {
        let along = to - from;
        let share = -along.dot(from) / along.length_squared();
        (from + share.clamp(0.0, 1.0) * along).length_squared()
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

#[cfg(test)]
mod tests {
    use super::{nearest_on_triangle, rough_square};
    use glam::{DVec3, Vec3};

    #[test]
    fn rough_squares_are_those_of_the_nearest_points() {
        let mut state = 1_u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            2.0 * (state >> 8) as f32 / (1 << 24) as f32 - 1.0
        };
        let mut point = || Vec3::new(next(), next(), next());
        for _ in 0..10_000 {
            let corners = [point(), point(), point()];
            let [a, b, c] = corners.map(|at| at.as_dvec3());
            let normal = (b - a).cross(c - a).normalize().as_vec3();
            let nearest = nearest_on_triangle([a, b, c], DVec3::ZERO);
            let (rough, exact) = (rough_square(corners, normal), nearest.length_squared());
            assert!((f64::from(rough) - exact).abs() < 1e-5, "{corners:?}");
        }
    }
}
