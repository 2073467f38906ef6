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
use crate::geometry::{Compound, ConvexMesh};
use crate::math::{Pose, rotate};
use glam::{Quat, Vec3};

/// How deep parts may overlap along an open face that stands in for one that is none, as a share of the smaller part's least extent.
const DEEP: f32 = 0.25;

/// Cosine of the angle up to which a contact may as well lie on a face of the other shape: 3e-3 rad, which is more than the faces
/// that are preferred to each other may differ by.
const EQUAL: f32 = 1.0 - 5e-6;

/// How many times as large a body must be for contacts to lie on its faces if they may.
const LARGER: f32 = 1.02;

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

/// A contact, and what bears besides if four points are not enough.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bearing {
    pub(crate) patch: LocalManifold,
    pub(crate) beside: Option<LocalManifold>,
}

impl Bearing {
    /// The manifolds that have points.
    pub(crate) fn patches(&self) -> impl Iterator<Item = &LocalManifold> {
        let all = std::iter::once(&self.patch).chain(&self.beside);
        all.filter(|patch| patch.count > 0)
    }

    /// How deep bodies overlap at the deepest point, m; zero if they do not.
    pub(crate) fn depth(&self) -> f32 {
        self.patches().map(LocalManifold::depth).fold(0.0, f32::max)
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
        found: Bearing,
        pose: &Pose,
        reach: f32,
        scratch: &mut NarrowScratch,
    ) -> Bearing {
        if !self.sides.iter().any(Side::has_neighbors) {
            return found;
        }
        let on_larger = self.on_larger_body(&found.patch, pose, reach, scratch);
        let found = on_larger.unwrap_or(found);
        let admitted = |found: Bearing| {
            let (patch, refused) = self.admitted(&found.patch, pose);
            let beside = found.beside.map(|beside| self.admitted(&beside, pose).0);
            (Bearing { patch, beside }, refused)
        };
        let is_empty = found.patch.count == 0;
        let (kept, refused) = admitted(found);
        if kept.patch.count > 0 || is_empty || self.is_round() {
            return kept;
        }
        let instead = self.along_open_face(refused, pose, reach, scratch);
        admitted(instead).0
    }

    /// The same contact on a face of the larger body, if it lies on one of the smaller body that is parallel: parts are smaller than
    /// the whole, and what stands on a floor of them tilts a little, which would be the floor's tilt.
    fn on_larger_body(
        &self,
        patch: &LocalManifold,
        pose: &Pose,
        reach: f32,
        scratch: &mut NarrowScratch,
    ) -> Option<Bearing> {
        let [a, b] = self.sides.map(|side| side.body_size());
        let is_second = b > LARGER * a;
        let is_edge = patch.points().iter().any(|point| point.share_b == 0.5);
        if !(is_second || a > LARGER * b)
            || self.sides[usize::from(is_second)].of.is_none()
            || patch.count == 0
            || is_edge
            || self.is_round()
        {
            return None;
        }
        let outward = if is_second {
            -rotate(pose.rotation.inverse(), patch.normal)
        } else {
            patch.normal
        };
        let hull = self.sides[usize::from(is_second)].shape.hull();
        let mut faces = hull.faces().iter();
        let face = faces.position(|face| face.plane.normal.dot(outward) > EQUAL)?;
        if hull.faces()[face].plane.normal == outward {
            return None;
        }
        let [a, b] = self.sides.map(|side| side.shape.hull());
        scratch.load(a, b, pose);
        let others = [&scratch.b_in_a, &scratch.a_in_b][usize::from(is_second)];
        let axis = FaceAxis::new(hull, face, others);
        let instead = self.clip(&axis, is_second, pose, reach, scratch);
        (instead.patch.count > 0).then_some(instead)
    }

    /// The contact along a face.
    fn clip(
        &self,
        axis: &FaceAxis,
        b_refers: bool,
        pose: &Pose,
        reach: f32,
        scratch: &mut NarrowScratch,
    ) -> Bearing {
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
        let patch = clipping.face_patch(axis, b_refers, scratch);
        Bearing {
            patch,
            beside: scratch.beside,
        }
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
    ) -> Bearing {
        let hulls = self.sides.map(|side| side.shape.hull());
        let [a, b] = hulls;
        scratch.load(a, b, pose);
        let towards_b = pose.transform_point(b.centroid()) - a.centroid();
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
            return Bearing::default();
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
        slot: patch.slot,
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
