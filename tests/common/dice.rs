//! One seeded source of random numbers for all tests and benches: every run, on every platform, sees the same.
#![allow(dead_code, reason = "each test uses some of them")]

use bevy_cleave::math::Plane;
use bevy_cleave::testing::bodies::SolverBody;
use glam::{Mat3, Quat, Vec3};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg32;

/// A seeded source of numbers, points, rotations and planes.
pub(crate) struct Dice(Pcg32);

impl Dice {
    pub(crate) fn new(seed: u64) -> Self {
        Self(Pcg32::seed_from_u64(seed))
    }

    pub(crate) fn below(&mut self, count: usize) -> usize {
        self.0.next_u32() as usize % count
    }

    /// From [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.0.next_u32() >> 8) as f32 / 16_777_216.0
    }

    /// From [from, to), up to rounding.
    pub(crate) fn in_range(&mut self, from: f32, to: f32) -> f32 {
        from + (to - from) * self.unit()
    }

    /// Each component from [from, to).
    pub(crate) fn vector(&mut self, from: f32, to: f32) -> Vec3 {
        Vec3::from_array([(); 3].map(|()| self.in_range(from, to)))
    }

    pub(crate) fn direction(&mut self) -> Vec3 {
        loop {
            let v = 2.0 * Vec3::new(self.unit(), self.unit(), self.unit()) - Vec3::ONE;
            if (0.01..=1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }

    pub(crate) fn rotation(&mut self) -> Quat {
        loop {
            let q = Quat::from_vec4(self.vector(-1.0, 1.0).extend(self.in_range(-1.0, 1.0)));
            if (0.1..1.0).contains(&q.length_squared()) {
                return q.normalize();
            }
        }
    }

    /// A body that moves and turns by up to 1 m/s and 1 rad/s along each axis, and its inverse inertia, 1/(kg m2).
    pub(crate) fn solver_body(&mut self, inverse_mass: f32) -> (SolverBody, Mat3) {
        let r = Mat3::from_quat(self.rotation());
        let principal = inverse_mass * self.vector(2.0, 20.0);
        let inverse_inertia = r * Mat3::from_diagonal(principal) * r.transpose();
        let body = SolverBody {
            linear: self.vector(-1.0, 1.0),
            inverse_mass,
            angular: self.vector(-1.0, 1.0),
            unused: 0.0,
        };
        (body, inverse_inertia)
    }

    /// A plane of random direction through a random point between two of the points.
    pub(crate) fn plane_through(&mut self, points: &[Vec3]) -> Plane {
        let a = points[self.below(points.len())];
        let b = points[self.below(points.len())];
        Plane::through(a.lerp(b, self.unit()), self.direction())
    }
}
