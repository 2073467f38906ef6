//! Side-of-plane tests: the one place where geometric tolerances are defined.
//!
//! Every tolerance is a pure number times a length of the body, so that a grain of sand and a mountain are treated
//! alike. The length is [`length_scale`]: the box's diagonal, or the farthest coordinate if the body lies far from its
//! own origin, because the spacing of `f32` numbers grows with the coordinate and not with the body.
//!
//! With `u = 2^-24 = 6.0e-8`, the largest relative rounding error of one `f32` operation, and `s` the length scale,
//! the distance `n . p - d` of a point that was computed to lie on the plane is off by at most
//!
//! - `sqrt(3) u s` because the three coordinates of `p` were rounded,
//! - `sqrt(3) u s` because the three components of `n` were rounded after scaling to unit length,
//! - `4 u s` because `d` is a dot product in `f32` (three products and two sums, a bound of 3, and its own rounding),
//!
//! together `7.5 u s = 4.5e-7 s`. The distance itself is evaluated in `f64`, which adds nothing to that.
//!
//! # References
//! - N. J. Higham, *Accuracy and Stability of Numerical Algorithms*, 2nd ed., section 3.1 (error of a dot product).
//! - J. R. Shewchuk, *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates*, 1997.

use crate::math::{Aabb, Plane};
use glam::Vec3;
use std::ops::RangeInclusive;

/// Half the thickness of a plane, relative to the length scale: points nearer than this are on it.
///
/// Twice the rounding bound of the module's head, rounded up to a power of ten. Smaller, and a point that was put on
/// the plane can be seen off it, so that a second cut along the same plane makes slivers; larger, and features that the
/// file really holds are flattened.
pub const ON_PLANE_RELATIVE: f32 = 1.0e-6;

/// How far a corner may lie from the plane of a face that it is joined to when a hull is made, relative to the length
/// scale.
///
/// Corners of a face that was planar before its coordinates were rounded: each moved by up to `sqrt(3) u s / 2` (a body
/// around its origin has coordinates up to `s / 2`), and the fourth corner of a parallelogram is seen from the plane of
/// the other three with all four errors, `2.1e-7 s`. Larger than needed, and joined faces cost volume: this value keeps
/// the volume of all real hulls in the tests to 1e-6.
pub(crate) const MERGE_RELATIVE: f32 = 2.5e-7;

/// How far a vertex may lie outside the plane of a face of a valid hull, relative to the length scale.
///
/// A polygon whose vertices are within [`ON_PLANE_RELATIVE`] of a plane has a best-fit plane that differs from it by a
/// tilt; over the polygon that is at most another two thicknesses, and merging two such polygons doubles it. Ten
/// thicknesses cover that and stay far below the penetration that contacts allow (about 5e-3 of a body).
pub const CONVEX_RELATIVE: f32 = 10.0 * ON_PLANE_RELATIVE;

/// Thickness below which a point cloud is flat, relative to the length scale.
///
/// A body must be thicker than the convexity tolerance, or all its faces lie within the tolerance of each other's
/// planes and outside is not defined.
pub const FLAT_RELATIVE: f32 = 2.0 * CONVEX_RELATIVE;

/// Length scales (m) that a body may have.
///
/// Inertia grows with the fifth power of the length: with this range and densities of solids it stays within what `f32`
/// can hold, as do its inverse and the squares of areas.
pub(crate) const SIZE_RANGE: RangeInclusive<f64> = 1.0e-6..=1.0e6;

/// How far the length of a unit normal may be from 1.
///
/// Normalising and rotating by an `f32` quaternion each leave a few `u`; a hundred such operations in a row stay below.
/// A plane whose normal has length `1 + e` is displaced by `e` times its distance from the origin.
pub(crate) const UNIT_NORMAL_TOLERANCE: f32 = 1.0e-5;

/// The length that tolerances of geometry in this box are relative to, m: see the module's head.
pub fn length_scale(aabb: &Aabb) -> f32 {
    let farthest = aabb.min.abs().max(aabb.max.abs()).max_element();
    aabb.diagonal().max(farthest)
}

/// Half the thickness of a plane for a body of length scale `size` (m), m.
pub fn plane_tolerance(size: f32) -> f32 {
    ON_PLANE_RELATIVE * size
}

/// How far a corner may lie from the plane of the face it is joined to, in a hull of length scale `size` (m), m.
pub(crate) fn merge_tolerance(size: f32) -> f32 {
    MERGE_RELATIVE * size
}

/// How far a vertex may lie outside a face of a hull of length scale `size` (m), m.
pub fn convex_tolerance(size: f32) -> f32 {
    CONVEX_RELATIVE * size
}

/// Where a point lies with respect to a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Side {
    /// Behind: the normal points away from it.
    Below,
    /// Within the tolerance.
    On,
    /// In front: the normal points to it.
    Above,
}

/// Signed distance of `point` from `plane`, positive in front, m; evaluated in `f64`.
pub fn signed_distance(plane: &Plane, point: Vec3) -> f64 {
    plane.normal.as_dvec3().dot(point.as_dvec3()) - f64::from(plane.offset)
}

/// On which side of `plane` the `point` lies; nearer than or at `tolerance` (m) is [`Side::On`].
pub fn side(plane: &Plane, point: Vec3, tolerance: f32) -> Side {
    let distance = signed_distance(plane, point);
    if distance > f64::from(tolerance) {
        Side::Above
    } else if distance < -f64::from(tolerance) {
        Side::Below
    } else {
        Side::On
    }
}

/// Why a plane is not usable.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlaneError {
    /// A number is NaN or infinite; [`Plane::through`] makes this of a zero normal.
    #[error(
        "the plane is not finite, or was made from a zero normal: normal {normal}, offset {offset} m"
    )]
    NotFinite {
        /// Normal.
        normal: Vec3,
        /// Offset, m.
        offset: f32,
    },
    /// The normal is zero.
    #[error("the normal of the plane is zero")]
    ZeroNormal,
    /// The normal does not have unit length.
    #[error("the normal of the plane has length {length}, not 1")]
    NotUnit {
        /// Length found.
        length: f64,
    },
}

/// Checks that `plane` is finite and its normal of unit length.
///
/// # Errors
/// [`PlaneError`], which says what is wrong.
pub fn check_plane(plane: &Plane) -> Result<(), PlaneError> {
    let Plane { normal, offset } = *plane;
    if !normal.is_finite() || !offset.is_finite() {
        return Err(PlaneError::NotFinite { normal, offset });
    }
    let length = normal.as_dvec3().length();
    if length == 0.0 {
        return Err(PlaneError::ZeroNormal);
    }
    if (length - 1.0).abs() > f64::from(UNIT_NORMAL_TOLERANCE) {
        return Err(PlaneError::NotUnit { length });
    }
    Ok(())
}
