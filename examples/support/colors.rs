//! Colors of materials, linear RGB.

use glam::Vec3;

/// Of iron.
pub const IRON: Vec3 = Vec3::new(0.06, 0.07, 0.08);

/// Of the brick of a number: no two neighbors alike.
pub fn clay(number: usize) -> Vec3 {
    (0.75 + 0.05 * (number * 7 % 11) as f32) * Vec3::new(0.55, 0.20, 0.12)
}
