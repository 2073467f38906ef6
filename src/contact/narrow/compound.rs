//! Where convex parts touch of which at least one belongs to a compound: what of a contact is on the surface of the whole.
//!
//! Parts are tested as bodies of their own are. What that finds on a face that another part covers, or along an edge where another part
//! goes on, is not there (`geometry/compound_cover.rs`): such points are left out. Where none is left, hulls touch along an open face
//! of the part, if they do; so a box that has sunk in by the sag of a contact stands on the top of the next part, and not against its
//! hidden side.

use crate::contact::local_manifold::{LocalManifold, LocalPoint};
use crate::contact::narrow::clipping::Clipping;
use crate::contact::narrow::round::pair::examine_round;
use crate::contact::narrow::round::patch::RoundScratch;
use crate::contact::narrow::sat::examine_hulls;
use crate::contact::narrow::scratch::{
    FaceAxis, HullPair, MERGE, NarrowScratch, SatCache, SatResult,
};
use crate::contact::reduce::{Candidate, CornerKind, reduce};
use crate::geometry::{Compound, ConvexMesh};
use crate::math::{Aabb, Pose, rotate, tangents};
use glam::{Quat, Vec2, Vec3};
use smallvec::SmallVec;

/// How deep parts may overlap along an open face that stands in for one that is none, as a share of the smaller part's least extent.
const DEEP: f32 = 0.25;

/// Cosine of the angle up to which a contact may as well lie on a face of the other shape: 3e-3 rad, which is more than the faces
/// that are preferred to each other may differ by.
const EQUAL: f32 = 1.0 - 5e-6;

/// How many times as large a body must be for contacts to lie on its faces if they may.
const LARGER: f32 = 1.02;

/// Cosine of the angle between normals that make one manifold.
const SAME: f32 = 0.9999;

/// A convex shape of a body: all of it, or a part of a compound.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side<'s> {
    pub(crate) shape: &'s ConvexMesh,
    /// Its frame in that of the body.
    pub(crate) pose: Pose,
    /// What it is a part of, and which.
    of: Option<(&'s Compound, usize)>,
}

impl<'s> Side<'s> {
    pub(crate) fn whole(shape: &'s ConvexMesh) -> Self {
        Self {
            shape,
            pose: Pose::IDENTITY,
            of: None,
        }
    }

    pub(crate) fn part(compound: &'s Compound, index: u32) -> Self {
        let part = &compound.parts()[index as usize];
        Self {
            shape: &part.shape,
            pose: part.pose,
            of: Some((compound, index as usize)),
        }
    }

    /// Whether the surface of the body has this outward direction at this place, own frame.
    fn admits(&self, at: Vec3, normal: Vec3, overlap: f32) -> bool {
        self.of.is_none_or(|(compound, part)| {
            let cover = compound.cover();
            cover.admits(compound.parts(), part, (at, normal), overlap)
        })
    }

    fn is_open(&self, face: usize) -> bool {
        self.of
            .is_none_or(|(compound, part)| compound.cover().is_open(part, face))
    }

    /// Whether anything of it may be covered.
    fn has_neighbors(&self) -> bool {
        self.of
            .is_some_and(|(compound, part)| !compound.neighbors(part).is_empty())
    }

    /// Size of the body, m.
    fn body_size(&self) -> f32 {
        let of = self.of.map(|(compound, _)| compound.aabb());
        of.unwrap_or_else(|| self.shape.aabb()).diagonal()
    }

    fn extent(&self) -> f32 {
        self.shape.aabb().extents().min_element()
    }
}

/// Two convex shapes of two bodies.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartPair<'s> {
    pub(crate) sides: [Side<'s>; 2],
}

impl PartPair<'_> {
    /// The pose of the second shape in the frame of the first, from that of the bodies.
    pub(crate) fn own_pose(&self, b_in_a: Pose) -> Pose {
        let [a, b] = self.sides.map(|side| side.pose);
        a.inverse() * b_in_a * b
    }

    /// How B is turned in A's frame where the shapes have this pose.
    pub(crate) fn turn_of_bodies(&self, pose: &Pose) -> Quat {
        let [a, b] = self.sides.map(|side| side.pose.rotation);
        (a * pose.rotation * b.inverse()).normalize()
    }

    pub(crate) fn is_round(&self) -> bool {
        self.sides.iter().any(|side| side.shape.is_round())
    }

    /// The contact of the shapes as if they were bodies of their own, in the frame of the first.
    pub(crate) fn examine(
        &self,
        pose: Pose,
        reach: f32,
        (scratch, round_scratch): (&mut NarrowScratch, &mut RoundScratch),
    ) -> SatResult {
        let [a, b] = self.sides.map(|side| side.shape);
        if self.is_round() {
            examine_round([a, b], pose, reach, round_scratch)
        } else {
            examine_hulls(a.hull(), b.hull(), pose, reach, SatCache::NONE, scratch)
        }
    }

    /// What of a contact that was found at a pose is on the surfaces of the bodies, or what takes its place.
    pub(crate) fn settle(
        &self,
        patch: &LocalManifold,
        pose: &Pose,
        reach: f32,
        scratch: &mut NarrowScratch,
    ) -> LocalManifold {
        if !self.sides.iter().any(Side::has_neighbors) {
            return *patch;
        }
        let patch = &self.on_larger_body(patch, pose, reach, scratch);
        let (kept, refused) = self.admitted(patch, pose);
        if kept.count > 0 || patch.count == 0 || self.is_round() {
            return kept;
        }
        let instead = self.along_open_face(refused, pose, reach, scratch);
        self.admitted(&instead, pose).0
    }

    /// The same contact on a face of the larger body, if it lies on one of the smaller body that is parallel: parts are smaller than
    /// the whole, and what stands on a floor of them tilts a little, which would be the floor's tilt.
    fn on_larger_body(
        &self,
        patch: &LocalManifold,
        pose: &Pose,
        reach: f32,
        scratch: &mut NarrowScratch,
    ) -> LocalManifold {
        let [a, b] = self.sides.map(|side| side.body_size());
        let is_second = b > LARGER * a;
        let is_edge = patch.points().iter().any(|point| point.share_b == 0.5);
        if !(is_second || a > LARGER * b)
            || self.sides[usize::from(is_second)].of.is_none()
            || patch.count == 0
            || is_edge
            || self.is_round()
        {
            return *patch;
        }
        let outward = if is_second {
            -rotate(pose.rotation.inverse(), patch.normal)
        } else {
            patch.normal
        };
        let hull = self.sides[usize::from(is_second)].shape.hull();
        let mut faces = hull.faces().iter();
        let Some(face) = faces.position(|face| face.plane.normal.dot(outward) > EQUAL) else {
            return *patch;
        };
        if hull.faces()[face].plane.normal == outward {
            return *patch;
        }
        let [a, b] = self.sides.map(|side| side.shape.hull());
        scratch.load(a, b, pose);
        let others = [&scratch.b_in_a, &scratch.a_in_b][usize::from(is_second)];
        let axis = FaceAxis::new(hull, face, others);
        let instead = self.clip(&axis, is_second, pose, reach, scratch);
        if instead.count > 0 { instead } else { *patch }
    }

    /// The contact along a face.
    fn clip(
        &self,
        axis: &FaceAxis,
        b_refers: bool,
        pose: &Pose,
        reach: f32,
        scratch: &mut NarrowScratch,
    ) -> LocalManifold {
        let [a, b] = self.sides.map(|side| side.shape.hull());
        let size = a.aabb().diagonal().min(b.aabb().diagonal());
        let clipping = Clipping {
            pair: HullPair {
                a,
                b,
                b_in_a: pose,
                margin: reach,
            },
            merge: MERGE * size,
        };
        clipping.face_patch(axis, b_refers, scratch)
    }

    /// The points that are on the surfaces of both bodies, and on which of them some are not.
    fn admitted(&self, patch: &LocalManifold, pose: &Pose) -> (LocalManifold, [bool; 2]) {
        let [a, b] = &self.sides;
        let back = -patch
            .normal_in_b
            .unwrap_or_else(|| rotate(pose.rotation.inverse(), patch.normal));
        let mut kept = LocalManifold { count: 0, ..*patch };
        let mut refused = [false; 2];
        for point in patch.points() {
            let overlap = -point.separation;
            let is_on = [
                a.admits(point.on_a, patch.normal, overlap),
                b.admits(point.on_b, back, overlap),
            ];
            if is_on == [true; 2] {
                kept.push(*point);
            }
            for (refused, is_on) in refused.iter_mut().zip(is_on) {
                *refused |= !is_on;
            }
        }
        (kept, refused)
    }

    /// The contact along the open face that separates best, of those parts whose surface is none where they touch.
    fn along_open_face(
        &self,
        refused: [bool; 2],
        pose: &Pose,
        reach: f32,
        scratch: &mut NarrowScratch,
    ) -> LocalManifold {
        let hulls = self.sides.map(|side| side.shape.hull());
        let [a, b] = hulls;
        scratch.load(a, b, pose);
        let towards_b = pose.transform_point(b.aabb().center()) - a.aabb().center();
        let towards = [towards_b, -(scratch.turn.transpose() * towards_b)];
        let mut best: Option<(FaceAxis, bool)> = None;
        for side in (0..2).filter(|&side| refused[side]) {
            let others = [&scratch.b_in_a, &scratch.a_in_b][side];
            for (face, plane) in hulls[side].faces().iter().map(|f| f.plane).enumerate() {
                if plane.normal.dot(towards[side]) <= 0.0 || !self.sides[side].is_open(face) {
                    continue;
                }
                let axis = FaceAxis::new(hulls[side], face, others);
                let separates = |(best, _): &(FaceAxis, bool)| axis.separation > best.separation;
                if best.as_ref().is_none_or(separates) {
                    best = Some((axis, side == 1));
                }
            }
        }
        let [of_a, of_b] = self.sides.map(|side| side.extent());
        let (least, most) = (-DEEP * of_a.min(of_b), reach);
        let Some((axis, b_refers)) =
            best.filter(|(axis, _)| (least..=most).contains(&axis.separation))
        else {
            return LocalManifold::default();
        };
        self.clip(&axis, b_refers, pose, reach, scratch)
    }

    /// A contact of the shapes as one of the bodies, in the frame of the first.
    pub(crate) fn lift(&self, patch: &LocalManifold) -> LocalManifold {
        let [a, b] = &self.sides;
        lifted(patch, &a.pose, &b.pose)
    }
}

/// A contact whose frames are at these poses in other ones, in those. How far it may slide is not known there.
pub(crate) fn lifted(patch: &LocalManifold, a: &Pose, b: &Pose) -> LocalManifold {
    let mut lifted = LocalManifold {
        normal: rotate(a.rotation, patch.normal),
        normal_in_b: patch.normal_in_b.map(|n| rotate(b.rotation, n)),
        off_surface: patch.off_surface,
        ..LocalManifold::default()
    };
    for point in patch.points() {
        lifted.push(LocalPoint {
            on_a: a.transform_point(point.on_a),
            on_b: b.transform_point(point.on_b),
            along: rotate(a.rotation, point.along),
            ..*point
        });
    }
    lifted
}

/// What of a contact of a part with something that has no parts is on the surface of the body; own frame, the part first.
pub(crate) fn on_surface(side: &Side, patch: &LocalManifold) -> LocalManifold {
    let mut kept = LocalManifold { count: 0, ..*patch };
    let points = patch.points().iter();
    points
        .filter(|point| side.admits(point.on_a, patch.normal, -point.separation))
        .for_each(|point| kept.push(*point));
    kept
}

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

/// The contacts of two bodies.
#[derive(Clone, Debug, Default)]
pub(crate) struct FoundParts {
    pub(crate) found: Vec<Found>,
    /// By contact: the first one in the same plane.
    planes: Vec<usize>,
    points: Vec<LocalPoint>,
    candidates: Vec<Candidate>,
}

impl FoundParts {
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
