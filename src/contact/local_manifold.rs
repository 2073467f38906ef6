//! What the narrow phase finds: normal and points in the frames of the two bodies.

use crate::contact::point::MAX_POINTS;
use crate::math::{Pose, rotate};
use glam::Vec3;

/// A contact point as the narrow phase finds it, in the two bodies' own frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LocalPoint {
    /// The point on A's surface, A's frame, m.
    pub on_a: Vec3,
    /// The point on B's surface, B's frame, m.
    pub on_b: Vec3,
    /// Gap along the normal, m; negative where the bodies overlap.
    pub separation: f32,
    /// With which body the point goes while the two slide: 0 with A, 1 with B (a corner of B on a face of A), 0.5 half
    /// with each (where two edges cross).
    pub share_b: f32,
    /// Unit vector, A's frame, along which the point goes with the other body instead: where an edge of the one crosses
    /// an edge of the other's face, the point stays on both. Zero if there is none.
    pub along: Vec3,
    /// Radii of curvature of A and B there, m: as a round surface rolls, its contact stays so far along the normal from a place
    /// inside of it. 0 for a face, an edge or a corner.
    pub radii: [f32; 2],
}

/// What the narrow phase finds for one pair: in A's frame, so that nothing is lost far from the origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LocalManifold {
    /// Unit normal from A to B, A's frame.
    pub normal: Vec3,
    /// The same vector in B's frame, if it is the normal of a face of B and turns with B; otherwise it turns with A.
    pub normal_in_b: Option<Vec3>,
    /// How far the bodies may slide until a corner reaches an edge, m: the points stay what they are so long.
    pub recycle_distance: f32,
    /// How far the bodies may slide along the face without turning, m, until another corner comes over it or one of these
    /// leaves it: all points are corners of the one on the other's face so long, and exact. 0 if some are not.
    pub slide: f32,
    /// How far `on_a` and `on_b` of its points may be from the two surfaces, m.
    pub off_surface: f32,
    /// Of contacts with a level of several materials: the slot of the triangles.
    pub slot: Option<u16>,
    /// Number of valid points.
    pub count: u32,
    /// The points.
    pub points: [LocalPoint; MAX_POINTS],
}

impl LocalManifold {
    /// The valid points.
    pub fn points(&self) -> &[LocalPoint] {
        &self.points[..self.count as usize]
    }

    /// How deep bodies overlap at the deepest point, m; zero if they do not.
    pub(crate) fn depth(&self) -> f32 {
        let points = self.points().iter();
        points.fold(0.0, |depth, point| depth.max(-point.separation))
    }

    /// The patch with the two bodies exchanged: in B's frame, normal from B to A.
    pub fn swapped(&self, b_in_a: &Pose) -> Self {
        let normal_in_b = rotate(b_in_a.rotation.inverse(), self.normal);
        let mut patch = Self {
            normal: -self.normal_in_b.unwrap_or(normal_in_b),
            normal_in_b: self.normal_in_b.is_none().then_some(-self.normal),
            ..*self
        };
        for point in &mut patch.points {
            std::mem::swap(&mut point.on_a, &mut point.on_b);
            point.radii.swap(0, 1);
            point.share_b = 1.0 - point.share_b;
            point.along = rotate(b_in_a.rotation.inverse(), point.along);
        }
        patch
    }

    /// Appends a point; ignored once the patch is full.
    pub(crate) fn push(&mut self, point: LocalPoint) {
        if let Some(slot) = self.points.get_mut(self.count as usize) {
            *slot = point;
            self.count += 1;
        }
    }
}
