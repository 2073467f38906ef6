//! A contact point as the solver and the cache see it.

use crate::geometry::KdCode;
use glam::Vec3;

/// Most points a manifold keeps.
pub const MAX_POINTS: usize = 4;

/// One point where two bodies touch or nearly touch. A cache line, because blocks ask for points in any order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(64))]
pub struct ContactPoint {
    /// From A's center of mass to the contact point (midway between the two surfaces), world axes, m.
    pub anchor_a: Vec3,
    /// From B's center of mass to the same point, world axes, m.
    pub anchor_b: Vec3,
    /// Gap along the normal, m; negative where the bodies overlap. Where they are bonded, how far they have come apart since.
    pub separation: f32,
    /// Cell of the point in A's box.
    pub code_a: KdCode,
    /// Cell of the point in B's box.
    pub code_b: KdCode,
    /// Normal impulse that a whole step would have at the rate of its last sub-step, N s: where the solve started before
    /// it, and where the next one will start after it.
    pub normal_impulse: f32,
    /// Friction impulse on B at the same rate, world axes, perpendicular to the normal, N s.
    pub friction_impulse: Vec3,
    /// Normal impulse of the whole step, blows included, N s.
    pub total_impulse: f32,
    /// Radii of curvature of A's and B's surface there, m: a body that turns within the step turns the place so far inside, along
    /// the normal, and not the point. 0 for faces, edges and corners.
    pub radii: [f32; 2],
}

const _: () = assert!(size_of::<ContactPoint>() == 64);
