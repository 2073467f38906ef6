//! Random numbers that stay what they are.

use glam::{EulerRot, Quat, Vec3, vec3};
use std::f32::consts::PI;

/// SplitMix64.
pub(crate) struct Rng(pub(crate) u64);

impl Rng {
    pub(crate) fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 40) as f32 / (1u64 << 24) as f32
    }

    pub(crate) fn range(&mut self, lo: f32, hi: f32) -> f32 {
        lo + (hi - lo) * self.unit()
    }

    pub(crate) fn direction(&mut self) -> Vec3 {
        let (y, a) = (self.range(-1.0, 1.0), self.range(0.0, 2.0 * PI));
        let r = (1.0 - y * y).max(0.0).sqrt();
        vec3(r * a.cos(), y, r * a.sin())
    }

    pub(crate) fn rotation(&mut self) -> Quat {
        let (a, b, c) = (
            self.range(-PI, PI),
            self.range(-1.5, 1.5),
            self.range(-PI, PI),
        );
        Quat::from_euler(EulerRot::YXZ, a, b, c)
    }
}
