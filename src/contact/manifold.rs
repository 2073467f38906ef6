//! Contact manifolds: feature clipping, reduction to four points, normal from A to B.

use super::manifolds::{Manifold, ManifoldHead};
use super::sat::Hint;
use crate::geometry::lanes::{LANES, Points4};
use crate::geometry::{KdBox, KdCode};
use crate::math::{Pose, rotate, tangents};
use glam::{Mat3, Quat, Vec3};

/// Most points a manifold keeps.
pub const MAX_POINTS: usize = 4;

/// One point where two bodies touch or nearly touch. A cache line, because blocks ask for points in any order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(64))]
pub struct ContactPoint {
    /// From A's centre of mass to the contact point (midway between the two surfaces), world axes, m.
    pub anchor_a: Vec3,
    /// From B's centre of mass to the same point, world axes, m.
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

impl Manifold {
    /// The manifold of a patch: anchors in world axes and contact codes, all impulses zero.
    ///
    /// The combined `friction` and `restitution` are copied.
    pub fn from_patch(
        a: &ManifoldBody,
        b: &ManifoldBody,
        patch: &Patch,
        friction: f32,
        restitution: f32,
    ) -> Self {
        let place = |body: &ManifoldBody| BodyPlace {
            centre: body.pose.transform_point(body.centre),
            turn: Mat3::from_quat(body.pose.rotation),
        };
        let turn = a.pose.rotation.inverse() * b.pose.rotation;
        let (centres, boxes) = ([a.centre, b.centre], [a.code_box, b.code_box]);
        let patch = BoundPatch::new(patch, turn, centres, boxes);
        let mut points = [ContactPoint::default(); MAX_POINTS];
        let count = patch.count as usize;
        let normal = patch.write(&place(a), &place(b), &mut points[..count]);
        let head = ManifoldHead {
            a: a.slot,
            b: b.slot,
            normal,
            friction,
            restitution,
            count: patch.count,
        };
        Self { head, points }
    }
}

/// Where a body is: one cache line, because pairs ask for their bodies in any order.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(crate) struct BodyPlace {
    /// Centre of mass, world, m.
    pub(crate) centre: Vec3,
    /// `world_from_body` rotation.
    pub(crate) turn: Mat3,
}

/// A patch whose points are bound to the two bodies, so that it can be seen anew after they have moved a little.
///
/// A point is kept as two: one on A's surface, one on B's, which faced each other when the patch was made. The normal is
/// bound to the body whose face it belongs to. The gap between a corner of one body and a face of the other along that
/// normal is then exact however the two have moved; that of a cut edge or of two crossing edges is exact to first order.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BoundPatch {
    /// Unit normal from A to B in the frame of the body it is bound to.
    normal: Vec3,
    normal_of_b: bool,
    /// See [`Patch::steady`].
    pub(crate) steady: f32,
    /// See [`Patch::slide`].
    pub(crate) slide: f32,
    /// See [`Patch::off_surface`].
    off_surface: f32,
    pub(crate) count: u32,
    /// From each body's centre of mass, body's frame, m.
    on_a: Points4,
    on_b: Points4,
    /// See [`PatchPoint`]; `along` in the same frame as the normal.
    share_b: [f32; MAX_POINTS],
    along: Points4,
    code_a: [KdCode; MAX_POINTS],
    code_b: [KdCode; MAX_POINTS],
}

const _: () = assert!(MAX_POINTS == LANES, "one lane for each point");

impl BoundPatch {
    /// Binds a patch to bodies with the given centres of mass (body's frame, m) and code boxes; `turn` is the rotation
    /// from B's frame to A's.
    pub(crate) fn new(
        patch: &Patch,
        turn: Quat,
        centres: [Vec3; 2],
        boxes: [Option<KdBox>; 2],
    ) -> Self {
        let mut bound = Self {
            normal: patch.normal_in_b.unwrap_or(patch.normal),
            normal_of_b: patch.normal_in_b.is_some(),
            steady: patch.steady,
            slide: patch.slide,
            off_surface: patch.off_surface,
            count: patch.count,
            ..Self::default()
        };
        let code = |b: Option<KdBox>, at: Vec3| b.map_or(KdCode::default(), |b| b.encode(at));
        for (l, point) in patch.points().iter().enumerate() {
            bound.on_a.set(l, point.on_a - centres[0]);
            bound.on_b.set(l, point.on_b - centres[1]);
            bound.share_b[l] = point.share_b;
            let along = if bound.normal_of_b {
                rotate(turn.inverse(), point.along)
            } else {
                point.along
            };
            bound.along.set(l, along);
            bound.code_a[l] = code(boxes[0], point.on_a);
            bound.code_b[l] = code(boxes[1], point.on_b);
        }
        bound
    }

    /// The normal as one of the bodies sees it, B if `of_b`; `turn` is the rotation from the other's frame to its own.
    pub(crate) fn normal_for(&self, of_b: bool, turn: Quat) -> Vec3 {
        if self.normal_of_b == of_b {
            self.normal
        } else {
            rotate(turn, self.normal)
        }
    }

    /// What the patch says about two bodies that have moved since, with the given centres of mass (own frames, m).
    pub(crate) fn hint(&self, b_in_a: &Pose, [centre_a, centre_b]: [Vec3; 2]) -> Hint {
        let mut gap = f32::INFINITY;
        for l in 0..self.count as usize {
            let on_b = b_in_a.transform_point(self.on_b.get(l) + centre_b);
            gap = gap.min(on_b.distance_squared(self.on_a.get(l) + centre_a));
        }
        let is_of_edges = self.count == 1 && self.share_b[0] == 0.5;
        Hint {
            gap: gap.sqrt() + 2.0 * self.off_surface,
            axis: is_of_edges.then_some(self.normal),
            faces: None,
        }
    }

    /// Writes the points, of which there are `count`, as the bodies are now, with impulses of zero; returns the normal.
    ///
    /// All lengths come from the bodies' own frames and the difference of the two centres, which is exact, so they are as
    /// good far from the world's origin as near it.
    pub(crate) fn write(&self, a: &BodyPlace, b: &BodyPlace, points: &mut [ContactPoint]) -> Vec3 {
        let turn = if self.normal_of_b { &b.turn } else { &a.turn };
        let normal = *turn * self.normal;
        let apart = b.centre - a.centre;
        let (on_a, on_b) = (turned(&self.on_a, &a.turn), turned(&self.on_b, &b.turn));
        let along = turned(&self.along, turn);
        let placed = self.place(normal, apart, &on_a, &on_b, &along);
        for (l, point) in points.iter_mut().enumerate() {
            *point = ContactPoint {
                anchor_a: placed.anchor_a.get(l),
                anchor_b: placed.anchor_b.get(l),
                separation: placed.separation[l],
                code_a: self.code_a[l],
                code_b: self.code_b[l],
                ..ContactPoint::default()
            };
        }
        normal
    }

    /// Separations and anchors, given the points' places on the two bodies in world axes.
    ///
    /// The contact is midway between the surfaces, and goes with the body that its point belongs to. Kept apart from the
    /// copying to single points, which would have the compiler mix the lanes.
    #[inline(never)]
    fn place(&self, n: Vec3, apart: Vec3, a: &Points4, b: &Points4, along: &Points4) -> Placed {
        let mut placed = Placed::default();
        for l in 0..LANES {
            let gap_x = apart.x + b.x[l] - a.x[l];
            let gap_y = apart.y + b.y[l] - a.y[l];
            let gap_z = apart.z + b.z[l] - a.z[l];
            let separation = n.x * gap_x + n.y * gap_y + n.z * gap_z;
            let slide = along.x[l] * gap_x + along.y[l] * gap_y + along.z[l] * gap_z;
            let share = self.share_b[l];
            let lift = (0.5 - share) * separation;
            let slide = (1.0 - 2.0 * share) * slide;
            let shift_x = lift * n.x + slide * along.x[l];
            let shift_y = lift * n.y + slide * along.y[l];
            let shift_z = lift * n.z + slide * along.z[l];
            let rest = 1.0 - share;
            placed.separation[l] = separation;
            placed.anchor_a.x[l] = a.x[l] + share * gap_x + shift_x;
            placed.anchor_a.y[l] = a.y[l] + share * gap_y + shift_y;
            placed.anchor_a.z[l] = a.z[l] + share * gap_z + shift_z;
            placed.anchor_b.x[l] = b.x[l] - rest * gap_x + shift_x;
            placed.anchor_b.y[l] = b.y[l] - rest * gap_y + shift_y;
            placed.anchor_b.z[l] = b.z[l] - rest * gap_z + shift_z;
        }
        placed
    }
}

/// What [`BoundPatch::place`] finds for each point, world axes, m.
#[derive(Clone, Copy, Debug, Default)]
struct Placed {
    separation: [f32; LANES],
    anchor_a: Points4,
    anchor_b: Points4,
}

/// Points turned from a body's frame to world axes.
#[inline(never)]
fn turned(points: &Points4, turn: &Mat3) -> Points4 {
    let rows = turn.transpose();
    Points4 {
        x: points.along(rows.x_axis),
        y: points.along(rows.y_axis),
        z: points.along(rows.z_axis),
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
    /// With which body the point goes while the two slide: 0 with A, 1 with B (a corner of B on a face of A), 0.5 half
    /// with each (where two edges cross).
    pub share_b: f32,
    /// Unit vector, A's frame, along which the point goes with the other body instead: where an edge of the one crosses
    /// an edge of the other's face, the point stays on both. Zero if there is none.
    pub along: Vec3,
}

/// What the narrow phase finds for one pair: in A's frame, so that nothing is lost far from the origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Patch {
    /// Unit normal from A to B, A's frame.
    pub normal: Vec3,
    /// The same vector in B's frame, if it is the normal of a face of B and turns with B; otherwise it turns with A.
    pub normal_in_b: Option<Vec3>,
    /// How far the bodies may slide until a corner reaches an edge, m: the points stay what they are so long.
    pub steady: f32,
    /// How far the bodies may slide along the face without turning, m, until another corner comes over it or one of these
    /// leaves it: all points are corners of the one on the other's face so long, and exact. 0 if some are not.
    pub slide: f32,
    /// How far `on_a` and `on_b` of its points may be from the two surfaces, m.
    pub off_surface: f32,
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
        let normal_in_b = rotate(b_in_a.rotation.inverse(), self.normal);
        let mut patch = Self {
            normal: -self.normal_in_b.unwrap_or(normal_in_b),
            normal_in_b: self.normal_in_b.is_none().then_some(-self.normal),
            ..*self
        };
        for point in &mut patch.points {
            std::mem::swap(&mut point.on_a, &mut point.on_b);
            point.share_b = 1.0 - point.share_b;
            point.along = rotate(b_in_a.rotation.inverse(), point.along);
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

/// A contact point before reduction, in the frame of one body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    /// On the surface of the body that the reference face does not belong to, m.
    pub(super) at: Vec3,
    /// Gap along the normal, m.
    pub(super) separation: f32,
    pub(super) kind: CornerKind,
    /// Whether the polygon runs on along an edge of the reference face.
    pub(super) leaves_on_cut: bool,
}

/// What a corner of a cut face is.
#[derive(Clone, Copy, Debug)]
pub(super) enum CornerKind {
    /// A vertex of the incident body.
    Incident,
    /// Where an edge of the incident body crosses an edge of the reference face, which runs along this unit vector.
    Crossing(Vec3),
    /// A vertex of the reference face.
    Reference,
}

/// Chooses at most [`MAX_POINTS`] of `candidates` that carry a load as well as all of them would, and keeps their order.
///
/// `candidates` are in one frame; `normal` is the unit contact normal; points nearer to each
/// other than `merge` (m) count as one. First the deepest point, then the one farthest from it, then the one that spans
/// the largest triangle with these two, then the one that adds most area outside the triangle. Points within `merge`
/// of the deepest are taken as equally deep, and the most extreme of them in a fixed direction is chosen, so that
/// rounding noise on a flat face does not change the choice from step to step; any other tie goes to the first.
pub(super) fn reduce(candidates: &mut Vec<Candidate>, normal: Vec3, merge: f32) {
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
fn remove_duplicates(candidates: &mut Vec<Candidate>, merge: f32) {
    let mut kept = 0;
    for i in 0..candidates.len() {
        let candidate = candidates[i];
        let twin = candidates[..kept]
            .iter_mut()
            .find(|other| other.at.distance_squared(candidate.at) <= merge * merge);
        match twin {
            Some(twin) => twin.separation = twin.separation.min(candidate.separation),
            None => {
                candidates[kept] = candidate;
                kept += 1;
            }
        }
    }
    candidates.truncate(kept);
}

/// The four points of [`reduce`], as indices; fewer distinct ones if the points lie on a line.
fn choose_four(candidates: &[Candidate], normal: Vec3, merge: f32) -> [usize; MAX_POINTS] {
    let best = |score: &dyn Fn(Vec3) -> f32| {
        let mut best = (f32::NEG_INFINITY, 0);
        for (i, candidate) in candidates.iter().enumerate() {
            let value = score(candidate.at);
            if value > best.0 {
                best = (value, i);
            }
        }
        best.1
    };
    let deepest = candidates
        .iter()
        .fold(f32::INFINITY, |d, candidate| d.min(candidate.separation));
    let [along, _] = tangents(normal);
    let mut first = (f32::NEG_INFINITY, 0);
    for (i, candidate) in candidates.iter().enumerate() {
        let extreme = along.dot(candidate.at);
        if candidate.separation <= deepest + merge && extreme > first.0 {
            first = (extreme, i);
        }
    }
    let first = first.1;
    let p = candidates[first].at;
    let second = best(&|point| point.distance_squared(p));
    let q = candidates[second].at;
    // Twice the signed area of the triangle (from, to, point), seen against the normal.
    let area = |from: Vec3, to: Vec3, point: Vec3| normal.dot((to - from).cross(point - from));
    let third = best(&|point| area(p, q, point).abs());
    let r = candidates[third].at;
    // Edges of the triangle run so that outside is negative for all three.
    let turn = 1.0_f32.copysign(area(p, q, r));
    let fourth = best(&|point| {
        let outside = |from, to| -turn * area(from, to, point);
        outside(p, q).max(outside(q, r)).max(outside(r, p))
    });
    [first, second, third, fourth]
}
