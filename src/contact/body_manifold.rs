//! Contact manifolds: feature clipping, reduction to four points, normal from A to B.

use crate::contact::local_manifold::LocalManifold;
use crate::contact::manifolds::{Manifold, ManifoldHead};
use crate::contact::narrow::scratch::SatCache;
use crate::contact::point::ContactPoint;
use crate::contact::point::MAX_POINTS;
use crate::geometry::hull_lanes::{LANES, Points4};
use crate::geometry::{KdBox, KdCode};
use crate::math::{Pose, rotate};
use glam::{Mat3, Quat, Vec3};

/// What a manifold needs to know of one of its two bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldBody {
    /// Slot of the body.
    pub slot: u32,
    /// `world_from_body`.
    pub pose: Pose,
    /// Center of mass, body's frame, m.
    pub center: Vec3,
    /// Box that the body's contact codes refer to; `None` for a body without bounds (code 0).
    pub code_box: Option<KdBox>,
}

impl Manifold {
    /// The manifold of a patch: anchors in world axes and contact codes, all impulses zero.
    ///
    /// The combined `friction` and `restitution` are copied.
    #[doc(hidden)]
    pub fn from_local(
        a: &ManifoldBody,
        b: &ManifoldBody,
        patch: &LocalManifold,
        friction: f32,
        restitution: f32,
    ) -> Self {
        let place = |body: &ManifoldBody| BodyPlace {
            center: body.pose.transform_point(body.center),
            turn: Mat3::from_quat(body.pose.rotation),
        };
        let turn = a.pose.rotation.inverse() * b.pose.rotation;
        let (centers, boxes) = ([a.center, b.center], [a.code_box, b.code_box]);
        let patch = BodyManifold::new(patch, turn, centers, boxes);
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
    /// Center of mass, world, m.
    pub(crate) center: Vec3,
    /// `world_from_body` rotation.
    pub(crate) turn: Mat3,
}

/// A patch whose points are bound to the two bodies, so that it can be seen anew after they have moved a little.
///
/// A point is kept as two: one on A's surface, one on B's, which faced each other when the patch was made. The normal is
/// bound to the body whose face it belongs to. The gap between a corner of one body and a face of the other along that
/// normal is then exact however the two have moved; that of a cut edge or of two crossing edges is exact to first order.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BodyManifold {
    /// Unit normal from A to B in the frame of the body it is bound to.
    normal: Vec3,
    normal_of_b: bool,
    /// See [`LocalManifold::recycle_distance`].
    pub(crate) recycle_distance: f32,
    /// See [`LocalManifold::slide`].
    pub(crate) slide: f32,
    /// See [`LocalManifold::off_surface`].
    off_surface: f32,
    pub(crate) count: u32,
    /// From each body's center of mass, body's frame, m.
    on_a: Points4,
    on_b: Points4,
    /// See [`LocalPoint`]; `along` in the same frame as the normal.
    share_b: [f32; MAX_POINTS],
    along: Points4,
    code_a: [KdCode; MAX_POINTS],
    code_b: [KdCode; MAX_POINTS],
    /// Whether `on_a` and `on_b` are not on the surfaces but inside of them, by `radii` along the normal.
    is_round: bool,
    /// Radii of curvature of A and B, m: those of the first point and those of the others, of which a cone has one.
    radii: [[f32; 2]; 2],
}

const _: () = assert!(MAX_POINTS == LANES, "one lane for each point");

impl BodyManifold {
    /// Binds a patch to bodies with the given centers of mass (body's frame, m) and code boxes; `turn` is the rotation
    /// from B's frame to A's.
    pub(crate) fn new(
        patch: &LocalManifold,
        turn: Quat,
        centers: [Vec3; 2],
        boxes: [Option<KdBox>; 2],
    ) -> Self {
        let mut bound = Self {
            normal: patch.normal_in_b.unwrap_or(patch.normal),
            normal_of_b: patch.normal_in_b.is_some(),
            recycle_distance: patch.recycle_distance,
            slide: patch.slide,
            off_surface: patch.off_surface,
            count: patch.count,
            ..Self::default()
        };
        let code = |b: Option<KdBox>, at: Vec3| b.map_or(KdCode::default(), |b| b.encode(at));
        bound.is_round = patch.points().iter().any(|p| p.radii != [0.0; 2]);
        bound.radii = [patch.points[0].radii, patch.points[1].radii];
        let inward = rotate(turn.inverse(), patch.normal);
        for (l, point) in patch.points().iter().enumerate() {
            // What rolls is known by a place that turns with it, and has one code all the while.
            let radii = bound.radii_of(l);
            let on_a = point.on_a - radii[0] * patch.normal;
            let on_b = point.on_b + radii[1] * inward;
            bound.on_a.set(l, on_a - centers[0]);
            bound.on_b.set(l, on_b - centers[1]);
            bound.share_b[l] = point.share_b;
            let along = if bound.normal_of_b {
                rotate(turn.inverse(), point.along)
            } else {
                point.along
            };
            bound.along.set(l, along);
            bound.code_a[l] = code(boxes[0], on_a);
            bound.code_b[l] = code(boxes[1], on_b);
        }
        bound
    }

    /// Radii of curvature of A and B at a point, m.
    #[inline]
    fn radii_of(&self, point: usize) -> [f32; 2] {
        self.radii[usize::from(point > 0)]
    }

    /// The normal as one of the bodies sees it, B if `of_b`; `turn` is the rotation from the other's frame to its own.
    pub(crate) fn normal_for(&self, of_b: bool, turn: Quat) -> Vec3 {
        if self.normal_of_b == of_b {
            self.normal
        } else {
            rotate(turn, self.normal)
        }
    }

    /// The normal, and where each point is on the two bodies, from their centers of mass; world axes, m.
    pub(crate) fn arms(
        &self,
        a: &BodyPlace,
        b: &BodyPlace,
    ) -> (Vec3, impl Iterator<Item = [Vec3; 2]>) {
        let turns = [a.turn, b.turn];
        let normal = turns[usize::from(self.normal_of_b)] * self.normal;
        let arms = move |l| {
            let [radius_a, radius_b] = self.radii_of(l);
            [
                turns[0] * self.on_a.get(l) + radius_a * normal,
                turns[1] * self.on_b.get(l) - radius_b * normal,
            ]
        };
        (normal, (0..self.count as usize).map(arms))
    }

    /// What the patch says about two bodies that have moved since, with the given centers of mass (own frames, m).
    pub(crate) fn hint(&self, b_in_a: &Pose, [center_a, center_b]: [Vec3; 2]) -> SatCache {
        let mut gap = f32::INFINITY;
        for l in 0..self.count as usize {
            let on_b = b_in_a.transform_point(self.on_b.get(l) + center_b);
            gap = gap.min(on_b.distance_squared(self.on_a.get(l) + center_a));
        }
        let is_of_edges = self.count == 1 && self.share_b[0] == 0.5;
        SatCache {
            gap: gap.sqrt() + 2.0 * self.off_surface,
            axis: is_of_edges.then_some(self.normal),
            faces: None,
        }
    }

    /// Writes the points, of which there are `count`, as the bodies are now, with impulses of zero; returns the normal.
    ///
    /// All lengths come from the bodies' own frames and the difference of the two centers, which is exact, so they are as
    /// good far from the world's origin as near it.
    pub(crate) fn write(&self, a: &BodyPlace, b: &BodyPlace, points: &mut [ContactPoint]) -> Vec3 {
        let turn = if self.normal_of_b { &b.turn } else { &a.turn };
        let normal = *turn * self.normal;
        let apart = b.center - a.center;
        let (mut on_a, mut on_b) = (turned(&self.on_a, &a.turn), turned(&self.on_b, &b.turn));
        if self.is_round {
            self.lift_to_surface(normal, &mut on_a, &mut on_b);
        }
        let along = turned(&self.along, turn);
        let placed = self.place(normal, apart, &on_a, &on_b, &along);
        for (l, point) in points.iter_mut().enumerate() {
            *point = ContactPoint {
                anchor_a: placed.anchor_a.get(l),
                anchor_b: placed.anchor_b.get(l),
                separation: placed.separation[l],
                code_a: self.code_a[l],
                code_b: self.code_b[l],
                radii: self.radii_of(l),
                ..ContactPoint::default()
            };
        }
        normal
    }

    /// The least gap of its points, m; negative where the bodies overlap.
    pub(crate) fn gap(&self, a: &BodyPlace, b: &BodyPlace) -> f32 {
        let mut points = [ContactPoint::default(); MAX_POINTS];
        let points = &mut points[..self.count as usize];
        self.write(a, b, points);
        let gaps = points.iter().map(|point| point.separation);
        gaps.fold(f32::INFINITY, f32::min)
    }

    /// From places inside of round surfaces to the surfaces, world axes.
    #[inline(never)]
    fn lift_to_surface(&self, normal: Vec3, on_a: &mut Points4, on_b: &mut Points4) {
        for l in 0..self.count as usize {
            let [radius_a, radius_b] = self.radii_of(l);
            on_a.set(l, on_a.get(l) + radius_a * normal);
            on_b.set(l, on_b.get(l) - radius_b * normal);
        }
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

/// What [`BodyManifold::place`] finds for each point, world axes, m.
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
