//! Cuboid, regular prism, icosphere, wedge.
//!
//! All are centered on the origin of their bounding box and are built as the hull of their corners, which are computed in
//! `f64` from `+ - * /` and `sqrt` alone, so that they have the same bits on every platform.

use crate::geometry::convex::ConvexHull;
use crate::geometry::hull_error::HullError;
use glam::{DVec2, DVec3, Vec3};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4};
use std::ops::RangeInclusive;

/// Numbers of sides a prism may have. More would be finer than `f32` resolves against the convexity tolerance.
pub const PRISM_SIDES: RangeInclusive<u32> = 3..=256;

/// How often an icosphere may be subdivided: 4 gives 2562 vertices and 5120 faces.
pub const ICOSPHERE_SUBDIVISIONS: RangeInclusive<u32> = 0..=4;

/// A box with edges of length `x`, `y`, `z`, m.
///
/// # Errors
/// [`HullError`] if a length is not positive and finite, or the box too flat, small or large.
pub fn cuboid(x: f32, y: f32, z: f32) -> Result<ConvexHull, HullError> {
    let half = half_lengths(x, y, z)?;
    let corner = |k: u32| half * Vec3::new(sign(k & 1), sign(k & 2), sign(k & 4));
    ConvexHull::from_points(&(0..8).map(corner).collect::<Vec<_>>())
}

/// A ramp: the box with edges of length `x`, `y`, `z` (m) without the half above the plane that falls from its upper edge
/// at `-x` to its lower edge at `+x`.
///
/// # Errors
/// [`HullError`] if a length is not positive and finite, or the wedge too flat, small or large.
pub fn wedge(x: f32, y: f32, z: f32) -> Result<ConvexHull, HullError> {
    let half = half_lengths(x, y, z)?;
    let profile = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)];
    let corners = profile.map(|(x, y)| [Vec3::new(x, y, -1.0), Vec3::new(x, y, 1.0)]);
    ConvexHull::from_points(
        &corners
            .concat()
            .iter()
            .map(|&c| half * c)
            .collect::<Vec<_>>(),
    )
}

/// A prism over a regular polygon with `sides` corners on a circle of `circumradius` (m) in the xz plane, the first of
/// them on the x axis, and `height` (m) along y.
///
/// # Errors
/// [`HullError`] if `sides` is outside [`PRISM_SIDES`], a length is not positive and finite, or the prism too flat,
/// small or large.
pub fn regular_prism(sides: u32, circumradius: f32, height: f32) -> Result<ConvexHull, HullError> {
    check_count("sides", sides, &PRISM_SIDES)?;
    check_length("circumradius", circumradius)?;
    check_length("height", height)?;
    let corner = |k: u32| {
        let rim = f64::from(circumradius) * unit_circle(k, sides);
        [-0.5, 0.5].map(|level| Vec3::new(rim.x as f32, level * height, rim.y as f32))
    };
    ConvexHull::from_points(&(0..sides).flat_map(corner).collect::<Vec<_>>())
}

/// An icosahedron whose triangles have been split into four `subdivisions` times, with all vertices on a sphere of
/// `radius`, m.
///
/// # Errors
/// [`HullError`] if `subdivisions` is outside [`ICOSPHERE_SUBDIVISIONS`], or `radius` is not positive and finite, or too
/// small or large.
pub fn icosphere(radius: f32, subdivisions: u32) -> Result<ConvexHull, HullError> {
    check_count("subdivisions", subdivisions, &ICOSPHERE_SUBDIVISIONS)?;
    check_length("radius", radius)?;
    let points: Vec<Vec3> = icosphere_directions(subdivisions)
        .iter()
        .map(|&d| (f64::from(radius) * d).as_vec3())
        .collect();
    ConvexHull::from_points(&points)
}

/// Unit vectors to the vertices of an icosphere, some of them twice.
pub(crate) fn icosphere_directions(subdivisions: u32) -> Vec<DVec3> {
    // The edges of an icosahedron with golden-ratio corners have length 2, all other distances are longer than 3.2.
    let corners = icosahedron_corners();
    let neighbors = |a: usize, b: usize| corners[a].distance_squared(corners[b]) < 5.0;
    let mut directions: Vec<DVec3> = corners.to_vec();
    // Neighboring triangles both add the midpoint of their edge, bit by bit the same but for the order of a sum, which
    // does not matter; the hull drops repeated points.
    for a in 0..12 {
        for b in (0..a).filter(|&b| neighbors(a, b)) {
            for c in (0..b).filter(|&c| neighbors(a, c) && neighbors(b, c)) {
                split(
                    [corners[a], corners[b], corners[c]],
                    subdivisions,
                    &mut directions,
                );
            }
        }
    }
    directions.iter().map(|d| d.normalize()).collect()
}

/// Adds the midpoints of the triangle's edges, projected onto the sphere through its corners, and so on in its quarters.
fn split(triangle: [DVec3; 3], depth: u32, directions: &mut Vec<DVec3>) {
    if depth == 0 {
        return;
    }
    let [a, b, c] = triangle.map(DVec3::normalize);
    let [ab, bc, ca] = [
        (a + b).normalize(),
        (b + c).normalize(),
        (c + a).normalize(),
    ];
    directions.extend([ab, bc, ca]);
    for quarter in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
        split(quarter, depth - 1, directions);
    }
}

/// The corners of three golden rectangles at right angles to each other.
fn icosahedron_corners() -> [DVec3; 12] {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    std::array::from_fn(|k| {
        let (one, long) = (
            f64::from(sign(k as u32 & 1)),
            golden * f64::from(sign(k as u32 & 2)),
        );
        match k / 4 {
            0 => DVec3::new(0.0, one, long),
            1 => DVec3::new(one, long, 0.0),
            _ => DVec3::new(long, 0.0, one),
        }
    })
}

/// Cosine and sine of `2 pi k / n`, with an error below 1e-15 and without the platform's mathematics library.
///
/// The angle is reduced to an eighth of the circle in integers, so corners that mirror each other do so exactly. There,
/// with `t <= pi / 4`, the Taylor series up to `t^17` and `t^18` leave a remainder below `t^19 / 19! < 1e-19`.
pub(crate) fn unit_circle(k: u32, n: u32) -> DVec2 {
    let eighths = 8 * (u64::from(k) % u64::from(n));
    let (octant, rest) = (eighths / u64::from(n), eighths % u64::from(n));
    let rest = if octant % 2 == 0 {
        rest
    } else {
        u64::from(n) - rest
    };
    let t = FRAC_PI_4 * (rest as f64 / f64::from(n));
    // Horner's scheme: 1 - t^2/(1 2) (1 - t^2/(3 4) (...)), and the like for the sine.
    let series = |first: u32| {
        (0..9).rev().fold(1.0, |sum, term| {
            let m = f64::from(first + 2 * term);
            1.0 - t * t / (m * (m + 1.0)) * sum
        })
    };
    // On the diagonal the two series may differ in the last bit, and which is which depends on the octant.
    let (cos, sin) = if rest == u64::from(n) {
        (FRAC_1_SQRT_2, FRAC_1_SQRT_2)
    } else {
        (series(1), t * series(2))
    };
    let (x, y) = if matches!(octant % 4, 1 | 2) {
        (sin, cos)
    } else {
        (cos, sin)
    };
    match octant / 2 {
        0 => DVec2::new(x, y),
        1 => DVec2::new(-x, y),
        2 => DVec2::new(-x, -y),
        _ => DVec2::new(x, -y),
    }
}

fn sign(bit: u32) -> f32 {
    if bit == 0 { -1.0 } else { 1.0 }
}

fn half_lengths(x: f32, y: f32, z: f32) -> Result<Vec3, HullError> {
    check_length("x", x)?;
    check_length("y", y)?;
    check_length("z", z)?;
    Ok(0.5 * Vec3::new(x, y, z))
}

pub(crate) fn check_length(name: &'static str, value: f32) -> Result<(), HullError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(HullError::Length { name, value })
}

pub(crate) fn check_count(
    name: &'static str,
    value: u32,
    allowed: &RangeInclusive<u32>,
) -> Result<(), HullError> {
    if allowed.contains(&value) {
        return Ok(());
    }
    let (least, most) = (*allowed.start(), *allowed.end());
    Err(HullError::Count {
        name,
        value,
        least,
        most,
    })
}

#[cfg(test)]
#[expect(
    clippy::disallowed_methods,
    reason = "the library's functions are what the exact ones are held against"
)]
mod tests {
    use super::*;
    use glam::Vec2Swizzles;

    #[test]
    fn unit_circle_agrees_with_the_library_in_the_first_octant() {
        for n in PRISM_SIDES {
            for k in 0..=n / 8 {
                let (sin, cos) = (std::f64::consts::TAU * (f64::from(k) / f64::from(n))).sin_cos();
                let error = (unit_circle(k, n) - DVec2::new(cos, sin))
                    .abs()
                    .max_element();
                assert!(error < 1e-15, "{k} of {n}: {error}");
            }
        }
    }

    #[test]
    fn unit_circle_continues_into_the_other_octants_by_exact_symmetry() {
        for n in PRISM_SIDES {
            for k in 0..n {
                let point = unit_circle(k, n);
                assert_eq!(
                    unit_circle(n - k, n),
                    point * DVec2::new(1.0, -1.0),
                    "{k} of {n}"
                );
                assert_eq!(unit_circle(4 * k + n, 4 * n), point.perp(), "{k} of {n}");
                assert_eq!(
                    unit_circle(8 * k + n, 8 * n),
                    unit_circle(8 * n + n - 8 * k, 8 * n).yx(),
                    "{k} of {n}"
                );
            }
        }
    }
}
