//! Contact manifolds: feature clipping, reduction to four points, normal from A to B.

use crate::geometry::{KdBox, KdCode};
use crate::math::{Pose, rotate, tangents};
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
    /// Normal impulse that a whole step would have at the rate of its last sub-step, N s: where the solve started before
    /// it, and where the next one will start after it.
    pub normal_impulse: f32,
    /// Friction impulse on B at the same rate, world axes, perpendicular to the normal, N s.
    pub friction_impulse: Vec3,
    /// Normal impulse of the whole step, blows included, N s.
    pub total_impulse: f32,
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

/// What a manifold needs to know of one of its two bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldBody {
    /// Slot of the body.
    pub slot: u32,
    /// `world_from_body`.
    pub pose: Pose,
    /// Centre of mass, body's frame, m.
    pub centre: Vec3,
    /// Box that the body's contact codes refer to; `None` for a body without bounds (code 0).
    pub code_box: Option<KdBox>,
}

impl ManifoldBody {
    /// World-axes vector from the centre of mass to `point` (body's frame), and the code of `on_surface`.
    fn anchor_and_code(&self, point: Vec3, on_surface: Vec3) -> (Vec3, KdCode) {
        let code = self
            .code_box
            .map_or(KdCode::default(), |b| b.encode(on_surface));
        (rotate(self.pose.rotation, point - self.centre), code)
    }
}

impl Manifold {
    /// The manifold of a patch: anchors in world axes and contact codes, all impulses zero.
    ///
    /// Anchors come from each body's own frame, never from world positions, so they are as exact far from the world's
    /// origin as near it. The combined `friction` and `restitution` are copied.
    pub fn from_patch(
        a: &ManifoldBody,
        b: &ManifoldBody,
        patch: &Patch,
        friction: f32,
        restitution: f32,
    ) -> Self {
        let normal = rotate(a.pose.rotation, patch.normal);
        let normal_in_b = rotate(b.pose.rotation.inverse(), normal);
        let mut manifold = Self {
            a: a.slot,
            b: b.slot,
            normal,
            friction,
            restitution,
            count: patch.count,
            points: [ContactPoint::default(); MAX_POINTS],
        };
        for (to, from) in manifold.points_mut().iter_mut().zip(patch.points()) {
            let half_gap = 0.5 * from.separation;
            let mid_in_a = from.on_a + half_gap * patch.normal;
            let mid_in_b = from.on_b - half_gap * normal_in_b;
            (to.anchor_a, to.code_a) = a.anchor_and_code(mid_in_a, from.on_a);
            (to.anchor_b, to.code_b) = b.anchor_and_code(mid_in_b, from.on_b);
            to.separation = from.separation;
        }
        manifold
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

impl Patch {
    /// The valid points.
    pub fn points(&self) -> &[PatchPoint] {
        &self.points[..self.count as usize]
    }

    /// The patch with the two bodies exchanged: in B's frame, normal from B to A.
    pub fn swapped(&self, b_in_a: &Pose) -> Self {
        let mut patch = Self {
            normal: rotate(b_in_a.rotation.inverse(), -self.normal),
            ..*self
        };
        for point in &mut patch.points {
            std::mem::swap(&mut point.on_a, &mut point.on_b);
        }
        patch
    }

    /// Appends a point; ignored once the patch is full.
    pub(super) fn push(&mut self, point: PatchPoint) {
        if let Some(slot) = self.points.get_mut(self.count as usize) {
            *slot = point;
            self.count += 1;
        }
    }
}

/// Chooses at most [`MAX_POINTS`] of `candidates` that carry a load as well as all of them would, and keeps their order.
///
/// `candidates` are (position, separation) in one frame; `normal` is the unit contact normal; points nearer to each
/// other than `merge` (m) count as one. First the deepest point, then the one farthest from it, then the one that spans
/// the largest triangle with these two, then the one that adds most area outside the triangle. Points within `merge`
/// of the deepest are taken as equally deep, and the most extreme of them in a fixed direction is chosen, so that
/// rounding noise on a flat face does not change the choice from step to step; any other tie goes to the first.
pub(super) fn reduce(candidates: &mut Vec<(Vec3, f32)>, normal: Vec3, merge: f32) {
    remove_duplicates(candidates, merge);
    if candidates.len() <= MAX_POINTS {
        return;
    }
    let chosen = choose_four(candidates, normal, merge);
    let mut index = 0;
    candidates.retain(|_| {
        index += 1;
        chosen.contains(&(index - 1))
    });
}

/// Drops each point that lies within `merge` of an earlier one, which keeps the smaller of both separations.
fn remove_duplicates(candidates: &mut Vec<(Vec3, f32)>, merge: f32) {
    let mut kept = 0;
    for i in 0..candidates.len() {
        let (point, separation) = candidates[i];
        let twin = candidates[..kept]
            .iter_mut()
            .find(|(other, _)| other.distance_squared(point) <= merge * merge);
        match twin {
            Some(twin) => twin.1 = twin.1.min(separation),
            None => {
                candidates[kept] = (point, separation);
                kept += 1;
            }
        }
    }
    candidates.truncate(kept);
}

/// The four points of [`reduce`], as indices; fewer distinct ones if the points lie on a line.
fn choose_four(candidates: &[(Vec3, f32)], normal: Vec3, merge: f32) -> [usize; MAX_POINTS] {
    let best = |score: &dyn Fn(Vec3) -> f32| {
        let mut best = (f32::NEG_INFINITY, 0);
        for (i, &(point, _)) in candidates.iter().enumerate() {
            let value = score(point);
            if value > best.0 {
                best = (value, i);
            }
        }
        best.1
    };
    let deepest = candidates
        .iter()
        .fold(f32::INFINITY, |d, &(_, separation)| d.min(separation));
    let [along, _] = tangents(normal);
    let mut first = (f32::NEG_INFINITY, 0);
    for (i, &(point, separation)) in candidates.iter().enumerate() {
        let extreme = along.dot(point);
        if separation <= deepest + merge && extreme > first.0 {
            first = (extreme, i);
        }
    }
    let first = first.1;
    let p = candidates[first].0;
    let second = best(&|point| point.distance_squared(p));
    let q = candidates[second].0;
    // Twice the signed area of the triangle (from, to, point), seen against the normal.
    let area = |from: Vec3, to: Vec3, point: Vec3| normal.dot((to - from).cross(point - from));
    let third = best(&|point| area(p, q, point).abs());
    let r = candidates[third].0;
    // Edges of the triangle run so that outside is negative for all three.
    let turn = 1.0_f32.copysign(area(p, q, r));
    let fourth = best(&|point| {
        let outside = |from, to| -turn * area(from, to, point);
        outside(p, q).max(outside(q, r)).max(outside(r, p))
    });
    [first, second, third, fourth]
}
