//! Contact manifolds: feature clipping, reduction to four points, normal from A to B.

use crate::geometry::KdCode;
use glam::Vec3;

/// Most points a manifold keeps.
pub const MAX_POINTS: usize = 4;

/// One point where two bodies touch or nearly touch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactPoint {
    /// From A's centre of mass to the contact point (midway between the two surfaces), world axes, m.
    pub anchor_a: Vec3,
    /// From B's centre of mass to the same point, world axes, m.
    pub anchor_b: Vec3,
    /// Gap along the normal, m; negative where the bodies overlap.
    pub separation: f32,
    /// Cell of the point in A's box.
    pub code_a: KdCode,
    /// Cell of the point in B's box.
    pub code_b: KdCode,
    /// Normal impulse: the warm start before the solve, the result after it, N s.
    pub normal_impulse: f32,
    /// Friction impulse on B, world axes, perpendicular to the normal, N s.
    pub friction_impulse: Vec3,
}

/// All points where two bodies touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Manifold {
    /// Slot of body A (the one with the smaller id).
    pub a: u32,
    /// Slot of body B.
    pub b: u32,
    /// Unit normal from A to B, world axes.
    pub normal: Vec3,
    /// Coefficient of friction of the pair.
    pub friction: f32,
    /// Coefficient of restitution of the pair.
    pub restitution: f32,
    /// Number of valid points.
    pub count: u32,
    /// The points; those beyond `count` are meaningless.
    pub points: [ContactPoint; MAX_POINTS],
}

impl Manifold {
    /// The valid points.
    pub fn points(&self) -> &[ContactPoint] {
        &self.points[..self.count as usize]
    }

    /// The valid points, for writing.
    pub fn points_mut(&mut self) -> &mut [ContactPoint] {
        &mut self.points[..self.count as usize]
    }
}

/// A contact point as the narrow phase finds it, in the two bodies' own frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PatchPoint {
    /// The point on A's surface, A's frame, m.
    pub on_a: Vec3,
    /// The point on B's surface, B's frame, m.
    pub on_b: Vec3,
    /// Gap along the normal, m; negative where the bodies overlap.
    pub separation: f32,
}

/// What the narrow phase finds for one pair: in A's frame, so that nothing is lost far from the origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Patch {
    /// Unit normal from A to B, A's frame.
    pub normal: Vec3,
    /// Number of valid points.
    pub count: u32,
    /// The points.
    pub points: [PatchPoint; MAX_POINTS],
}
