//! The contacts of the parts of two bodies, of which those in one plane become one.

use crate::contact::local_manifold::{LocalManifold, LocalPoint};
use crate::contact::narrow::scratch::MERGE;
use crate::contact::reduce::{Candidate, CornerKind, reduce};
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
            if self.planes[at + 1..].contains(&at) {
                self.join(at, b_in_a);
            }
            self.found[kept] = self.found[at];
            kept += 1;
        }
        self.found.truncate(kept);
    }

    /// Adds the points of all contacts in the plane of one to it, and keeps at most four of them: none that is between others, as the
    /// points at seams are.
    fn join(&mut self, first: usize, b_in_a: &Pose) {
        let Self {
            found,
            planes,
            points,
            candidates,
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
        reduce(candidates, normal, MERGE * size);
        let patch = &mut found[first].patch;
        patch.count = 0;
        for candidate in candidates.iter() {
            if let Some(at) = places.iter().position(|&at| at == candidate.at) {
                patch.push(points[at]);
            }
        }
        patch.off_surface = off_surface;
    }
}

/// Leaves out points that are between others, or within `merge` (m) of a line between two, seen along a normal; but not those that are
/// deeper than all of the outline.
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
    let deepest = outline
        .iter()
        .map(|&at| candidates[at].separation)
        .fold(f32::INFINITY, f32::min);
    let mut at = 0;
    candidates.retain(|candidate| {
        at += 1;
        outline.contains(&(at - 1)) || candidate.separation < deepest - merge
    });
}
