//! Random heights that go over into each other.
//!
//! Value noise: random numbers at the corners of a cubic grid, blended between them. Made of sums, products and rounding down,
//! so that it is the same on every platform.
//!
//! # References
//! - D. S. Ebert et al., *Texturing and Modeling: A Procedural Approach*, 3rd ed., chapter 2 (lattice noises).

use glam::DVec3;

/// Shares of bumps of full and of half size.
const OCTAVES: [f64; 2] = [0.65, 0.35];

/// A number from [-1, 1] for a point, in units of the size of the bumps.
pub(super) fn height(point: DVec3, seed: u64) -> f64 {
    let fine = 2.0 * point + DVec3::splat(0.5);
    OCTAVES[0] * value(point, seed) + OCTAVES[1] * value(fine, !seed)
}

fn value(point: DVec3, seed: u64) -> f64 {
    let cell = point.floor();
    let share = point - cell;
    // 3 s^2 - 2 s^3: no slope at the corners.
    let blend = share * share * (3.0 - 2.0 * share);
    let at = |x: f64, y: f64, z: f64| random(cell + DVec3::new(x, y, z), seed);
    let mix = |a: f64, b: f64, t: f64| a + t * (b - a);
    let row = |y: f64, z: f64| mix(at(0.0, y, z), at(1.0, y, z), blend.x);
    let layer = |z: f64| mix(row(0.0, z), row(1.0, z), blend.y);
    mix(layer(0.0), layer(1.0), blend.z)
}

/// A number from [-1, 1) for a corner of the grid.
fn random(corner: DVec3, seed: u64) -> f64 {
    let mut hash = seed;
    for coordinate in corner.to_array() {
        hash = scramble(hash ^ (coordinate as i64 as u64));
    }
    (hash >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// The finalizer of SplitMix64: G. L. Steele, D. Lea, C. H. Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014.
fn scramble(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}
