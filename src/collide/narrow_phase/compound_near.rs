//! Which parts of two bodies are near each other, and what is asked of one part.

use crate::bodies::body::Shape;
use crate::contact::local_manifold::LocalManifold;
use crate::contact::narrow::compound::{PartPair, Side};
use crate::contact::narrow::half_space::examine_half_space;
use crate::contact::narrow::level_scratch::LevelScratch;
use crate::contact::narrow::round::pair::examine_round_half_space;
use crate::contact::narrow::round::patch::RoundScratch;
use crate::contact::narrow::scratch::{NarrowScratch, SatResult};
use crate::math::{Aabb, Plane, Pose, rotate};
use glam::{Mat3, Vec3};

/// Buffers of the tests.
pub(in crate::collide) struct PartScratch<'r> {
    pub(in crate::collide) hulls: &'r mut NarrowScratch,
    pub(in crate::collide) round: &'r mut RoundScratch,
    pub(in crate::collide) level: &'r mut LevelScratch,
}

impl PartScratch<'_> {
    /// What bears beside the last contact that was looked for, which nothing is said of if a shape was round.
    pub(super) fn beside(&self, is_round: bool) -> Option<LocalManifold> {
        self.hulls.beside.filter(|_| !is_round)
    }
}

/// Contact of a part with everything below a plane, whose body has this pose in the part's frame.
pub(super) fn examine_on_plane(
    side: &Side,
    normal: Vec3,
    below_in_part: Pose,
    reach: f32,
    others: &mut PartScratch,
) -> SatResult {
    let normal = rotate(below_in_part.rotation, normal);
    let plane = Plane::through(below_in_part.position, normal);
    let shape = side.shape;
    if shape.is_round() {
        examine_round_half_space(shape, plane, below_in_part, reach, others.round)
    } else {
        examine_half_space(shape.hull(), plane, below_in_part, reach, others.hulls)
    }
}

/// The parts with these numbers.
pub(super) fn part_pair<'s>(shapes: [&'s Shape; 2], near: [u32; 2]) -> Option<PartPair<'s>> {
    let side = |side: usize| match shapes[side] {
        Shape::Convex(mesh) => Some(Side::whole(mesh)),
        Shape::Compound(compound) => Some(Side::part(compound, near[side])),
        Shape::HalfSpace(_) | Shape::Level(_) => None,
    };
    Some(PartPair {
        sides: [side(0)?, side(1)?],
    })
}

/// Fills `near` with the parts of two bodies whose boxes are within `reach` (m) of each other, in order.
pub(super) fn find_near([a, b]: [&Shape; 2], b_in_a: &Pose, reach: f32, near: &mut Vec<[u32; 2]>) {
    near.clear();
    let bounds_of = |shape: &Shape, pose: &Pose| {
        let turn = Mat3::from_quat(pose.rotation);
        match shape {
            Shape::Convex(mesh) => mesh.bounds(&turn, pose.position),
            _ => Aabb::EMPTY,
        }
    };
    match (a.compound(), b.compound()) {
        (Some(a), None) => {
            let around = bounds_of(b, b_in_a).fattened(reach);
            a.within(&around, |part| near.push([part, 0]));
        }
        (None, Some(b)) => {
            let around = bounds_of(a, &b_in_a.inverse()).fattened(reach);
            b.within(&around, |part| near.push([0, part]));
        }
        (Some(a), Some(b)) => {
            let is_first_larger = a.len() >= b.len();
            let (large, small) = if is_first_larger { (a, b) } else { (b, a) };
            let seen = if is_first_larger {
                *b_in_a
            } else {
                b_in_a.inverse()
            };
            for (index, part) in (0..).zip(small.parts()) {
                let pose = seen * part.pose;
                let turn = Mat3::from_quat(pose.rotation);
                let around = part.shape.bounds(&turn, pose.position).fattened(reach);
                large.within(&around, |other| {
                    let pair = [other, index];
                    near.push(if is_first_larger {
                        pair
                    } else {
                        [index, other]
                    });
                });
            }
        }
        (None, None) => {}
    }
    near.sort_unstable();
}

/// How far the boxes of two shapes are apart in the frame of the first, m; negative where they overlap.
pub(super) fn gap_of_boxes(parts: &PartPair, pose: &Pose) -> f32 {
    let [a, b] = parts.sides.map(|side| side.shape);
    let turn = Mat3::from_quat(pose.rotation);
    let (a, b) = (a.aabb(), b.bounds(&turn, pose.position));
    (b.min - a.max).max(a.min - b.max).max_element()
}
