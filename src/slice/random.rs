//! Random numbers, points and directions of the patterns, without functions of the platform's library.

use crate::geometry::ConvexHull;
use glam::{DVec3, Vec3};
use rand_core::Rng;
use rand_pcg::Pcg32;

/// A number from [0, 1), a multiple of 2^-24.
pub(super) fn unit_interval(random: &mut Pcg32) -> f32 {
    (random.next_u32() >> 8) as f32 / 16_777_216.0
}

/// A number from [-1/2, 1/2).
pub(super) fn centered(random: &mut Pcg32) -> f32 {
    unit_interval(random) - 0.5
}

/// A unit vector, all directions alike: the first random point of a cube that falls into the unit ball, scaled.
pub(super) fn unit_vector(random: &mut Pcg32) -> Vec3 {
    loop {
        let [x, y, z] = std::array::from_fn(|_| 2.0 * unit_interval(random) - 1.0);
        let point = Vec3::new(x, y, z);
        let square = point.length_squared();
        // Too near the middle the direction is rounding error.
        if (1.0e-4..=1.0).contains(&square) {
            return point / square.sqrt();
        }
    }
}

/// Random points inside a hull, all places alike.
#[derive(Debug)]
pub(super) struct PointsInHull {
    /// Tetrahedra from the first vertex to the triangles of the faces, m.
    tetrahedra: Vec<[DVec3; 4]>,
    /// Six times the volume of the tetrahedra up to and with each one, m3.
    volumes: Vec<f64>,
}

impl PointsInHull {
    pub(super) fn new(hull: &ConvexHull) -> Self {
        let point = |vertex: u32| hull.vertices()[vertex as usize].as_dvec3();
        let apex = point(0);
        let tetrahedra: Vec<[DVec3; 4]> = hull
            .triangles()
            .map(|[a, b, c]| [apex, point(a), point(b), point(c)])
            .collect();
        let mut sum = 0.0;
        let volumes = tetrahedra
            .iter()
            .map(|[o, a, b, c]| {
                sum += (a - o).dot((b - o).cross(c - o)).max(0.0);
                sum
            })
            .collect();
        Self {
            tetrahedra,
            volumes,
        }
    }

    /// The next point, m.
    ///
    /// A random point of the unit cube is folded into the tetrahedron at its origin; C. Rocchini, P. Cignoni, "Generating
    /// Random Points in a Tetrahedron", Journal of Graphics Tools 5(4), 2000.
    pub(super) fn next(&self, random: &mut Pcg32) -> Vec3 {
        let total = self.volumes.last().copied().unwrap_or(0.0);
        let wanted = f64::from(unit_interval(random)) * total;
        let index = self.volumes.partition_point(|&volume| volume <= wanted);
        let [o, a, b, c] = self.tetrahedra[index.min(self.tetrahedra.len() - 1)];
        let [mut s, mut t, mut u] = [(); 3].map(|()| f64::from(unit_interval(random)));
        if s + t > 1.0 {
            (s, t) = (1.0 - s, 1.0 - t);
        }
        if t + u > 1.0 {
            (t, u) = (1.0 - u, 1.0 - s - t);
        } else if s + t + u > 1.0 {
            (s, u) = (1.0 - t - u, s + t + u - 1.0);
        }
        (o + s * (a - o) + t * (b - o) + u * (c - o)).as_vec3()
    }
}
