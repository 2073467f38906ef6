//! The contacts of the parts of two bodies, of which those in one plane become one.

use crate::contact::local_manifold::{LocalManifold, LocalPoint};
use crate::contact::narrow::scratch::MERGE;
use crate::contact::reduce::{Candidate, CornerKind, reduce_uneven};
use crate::math::{Aabb, Pose, tangents};
use glam::{Quat, Vec2, Vec3};
use smallvec::SmallVec;

/// Cosine of the angle between normals that make one manifold.
const SAME: f32 = 0.9999;

/// A contact of two bodies, and how B was turned in A's frame where it was found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    pub(crate) patch: LocalManifold,
    pub(crate) turn: Quat,
    /// Whether that is where the bodies get to within the step.
    pub(crate) is_ahead: bool,
}

impl Found {
    /// The plane that the contact lies in, in the frame of the body that the normal belongs to, and whether that is B.
    fn plane(&self) -> (Vec3, f32, bool) {
        let point = self.patch.points[0];
        match self.patch.normal_in_b {
            Some(normal) => (normal, normal.dot(point.on_b), true),
            None => (self.patch.normal, self.patch.normal.dot(point.on_a), false),
        }
    }

    /// Whether it may be one with others: what is curved has its own radii, and what is found ahead its own moment.
    fn can_join(&self) -> bool {
        !self.is_ahead && self.patch.points().iter().all(|p| p.radii == [0.0; 2])
    }
}

/// Buffers, and the contacts of two bodies.
#[derive(Clone, Debug, Default)]
pub(crate) struct CompoundScratch {
    /// Numbers of parts that are near each other; 0 for a body that has no parts.
    pub(crate) near: Vec<[u32; 2]>,
    pub(crate) found: Vec<Found>,
    /// By contact: the first one in the same plane.
    planes: Vec<usize>,
    points: Vec<LocalPoint>,
    candidates: Vec<Candidate>,
    /// What is as low as these and is not among them.
    lower: Vec<Candidate>,
}

impl CompoundScratch {
    /// Makes one contact of those that lie in one plane: a floor of many parts is as one, and a table stands on four points.
    /// `apart`: how far two planes may be apart and be one, m.
    pub(crate) fn merge_flush(&mut self, b_in_a: &Pose, apart: f32) {
        self.planes.clear();
        for (at, next) in self.found.iter().enumerate() {
            let (normal, offset, of_b) = next.plane();
            let is_same = |&known: &usize| {
                let known = &self.found[known];
                let (other, other_offset, other_of_b) = known.plane();
                of_b == other_of_b
                    && next.patch.slot == known.patch.slot
                    && known.can_join()
                    && other.dot(normal) > SAME
                    && (other_offset - offset).abs() <= apart
            };
            let mut firsts = (0..at).filter(|&known| self.planes[known] == known);
            let same = firsts.find(|known| next.can_join() && is_same(known));
            self.planes.push(same.unwrap_or(at));
        }
        let mut kept = 0;
        for at in 0..self.found.len() {
            if self.planes[at] != at {
                continue;
            }
            // What lies in its plane leaves a place for a second one.
            if let Some(next) = (at + 1..self.planes.len()).find(|&it| self.planes[it] == at)
                && let Some(lower) = self.join(at, b_in_a)
            {
                self.planes[next] = next;
                self.found[next] = Found {
                    patch: lower,
                    ..self.found[at]
                };
            }
            self.found[kept] = self.found[at];
            kept += 1;
        }
        self.found.truncate(kept);
    }

    /// Adds the points of all contacts in the plane of one to it, and keeps at most four of them: none that is between others, as the
    /// points at seams are. What bears beside these, if there is something, makes a contact of its own.
    fn join(&mut self, first: usize, b_in_a: &Pose) -> Option<LocalManifold> {
        let Self {
            found,
            planes,
            points,
            candidates,
            lower,
            ..
        } = self;
        let members = || (planes.iter().zip(found.iter())).filter(|(plane, _)| **plane == first);
        points.clear();
        points.extend(members().flat_map(|(_, it)| it.patch.points()));
        let off = members().map(|(_, it)| it.patch.off_surface);
        let off_surface = off.fold(0.0, f32::max);
        let normal = found[first].patch.normal;
        candidates.clear();
        candidates.extend(points.iter().map(|point| {
            let (on_a, on_b) = (point.on_a, b_in_a.transform_point(point.on_b));
            Candidate {
                at: on_a.lerp(on_b, point.share_b),
                separation: normal.dot(on_b - on_a),
                kind: CornerKind::Incident,
                leaves_on_cut: false,
            }
        }));
        let places: Vec<Vec3> = candidates.iter().map(|it| it.at).collect();
        let size = Aabb::of_points(places.iter().copied()).diagonal();
        keep_outline(candidates, normal, MERGE * size);
        reduce_uneven(candidates, lower, normal, MERGE * size, 0.0);
        let of = |candidates: &[Candidate]| {
            let mut patch = LocalManifold {
                count: 0,
                off_surface,
                ..found[first].patch
            };
            for candidate in candidates {
                if let Some(at) = places.iter().position(|&at| at == candidate.at) {
                    patch.push(points[at]);
                }
            }
            patch
        };
        let (joined, lower) = (of(candidates), of(lower));
        found[first].patch = joined;
        (lower.count > 0).then_some(lower)
    }
}

/// Leaves out points that are between others, or within `merge` (m) of a line between two, seen along a normal; but not those that are
/// lower than what is around them.
fn keep_outline(candidates: &mut Vec<Candidate>, normal: Vec3, merge: f32) {
    if candidates.len() < 3 {
        return;
    }
    let [u, v] = tangents(normal);
    let flat = |at: Vec3| Vec2::new(u.dot(at), v.dot(at));
    let order = |a: &Candidate, b: &Candidate| {
        let (a, b) = (flat(a.at), flat(b.at));
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y))
    };
    candidates.sort_by(order);
    let mut outline: SmallVec<[usize; 16]> = SmallVec::new();
    let count = candidates.len();
    // Andrew's monotone chain: there along one side, and back along the other.
    let way = (0..count).chain((0..count - 1).rev());
    let mut base = 1;
    for (step, at) in way.enumerate() {
        if step == count {
            base = outline.len();
        }
        let place = flat(candidates[at].at);
        while outline.len() > base {
            let [from, to] =
                [outline.len() - 2, outline.len() - 1].map(|k| flat(candidates[outline[k]].at));
            let along = place - from;
            if along.perp_dot(to - from) < -merge * along.length() {
                break;
            }
            outline.pop();
        }
        outline.push(at);
    }
    let corners: SmallVec<[(Vec2, f32); 16]> = (outline.iter())
        .map(|&at| (flat(candidates[at].at), candidates[at].separation))
        .collect();
    let mut at = 0;
    candidates.retain(|candidate| {
        at += 1;
        let lower = || {
            let gap = gap_between(&corners, flat(candidate.at));
            candidate.separation < gap - merge
        };
        outline.contains(&(at - 1)) || lower()
    });
}

/// The gap at a place between corners of an outline, m: on the planes through the lowest corner and each edge, so that of a flat face it is the
/// face's own, and of what stands on several tips it is above a tip between others.
fn gap_between(corners: &[(Vec2, f32)], place: Vec2) -> f32 {
    let order = |a: &&(Vec2, f32), b: &&(Vec2, f32)| a.1.total_cmp(&b.1);
    let Some(&(lowest, least)) = corners.iter().min_by(order) else {
        return f32::INFINITY;
    };
    let arm = place - lowest;
    let mut best = (f32::NEG_INFINITY, least);
    for edge in corners.windows(2) {
        let [(from, from_gap), (to, to_gap)] =
            [edge[0], edge[1]].map(|(at, gap)| (at - lowest, gap));
        let area = from.perp_dot(to);
        if area == 0.0 {
            continue;
        }
        let (to_share, from_share) = (from.perp_dot(arm) / area, arm.perp_dot(to) / area);
        let inside = to_share.min(from_share).min(1.0 - to_share - from_share);
        if inside > best.0 {
            let gap = least + from_share * (from_gap - least) + to_share * (to_gap - least);
            best = (inside, gap);
        }
    }
    best.1
}
