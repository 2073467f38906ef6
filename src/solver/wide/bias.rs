//! What comes before the sweeps of a sub-step: targets and warm start. Targets may also be set on the way, by the first
//! sweep, which has all that they follow from at hand.

use crate::bodies::solver_body::SolverBody;
use crate::simd::lanes::{Kernel, Lanes};
use crate::simd::prefetch::prefetch;
use crate::simd::vec3::V3;
use crate::solver::rows::soft_step::Bias;
use crate::solver::wide::block::{Block, Point, load_anchors};
use crate::solver::wide::body_pair::{BodyPair, Frame, Masses, load_three};
use crate::solver::wide::bond::BondConstraint;
use crate::solver::wide::contacts::ContactBlocks;
use crate::tuning::FAR_BODIES;
use std::cell::Cell;

/// Sets the target velocities; see [`Pass::UpdateBias`](crate::solver::wide::pass::Pass::UpdateBias).
pub(crate) struct UpdateBias<'a, 'c, const BONDED: bool> {
    pub(crate) contacts: &'a mut ContactBlocks<'c>,
    pub(crate) bond_constraints: &'a mut [BondConstraint],
    pub(crate) bias: Bias,
    pub(crate) is_first: bool,
}

impl<const BONDED: bool> Kernel for UpdateBias<'_, '_, BONDED> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let ContactBlocks {
            blocks,
            points,
            first_point,
            displacements,
            ..
        } = self.contacts;
        let aim = BiasTargets::<L>::new(displacements, &self.bias, self.is_first);
        for block in blocks.iter() {
            let start = block.points.start - *first_point;
            let range = start..start + block.points.len();
            let points = &mut points[range.clone()];
            let of_block = aim.of_block(block);
            for point in points.iter_mut() {
                aim.at(&of_block, &load_anchors(point), point);
            }
            if BONDED {
                let bond_constraints = &mut self.bond_constraints[range];
                bond_targets::<L>(block, points, bond_constraints, displacements, &self.bias);
            }
        }
        0.0
    }
}

/// What the target velocities follow from, besides the contacts.
pub(crate) struct BiasTargets<'a, L> {
    displacements: &'a [Cell<SolverBody>],
    rate: L,
    most: L,
    /// -1 / length of the sub-step, 1/s.
    closing: L,
    is_first: bool,
    is_far: bool,
}

/// What of it is the same for all points of a block.
pub(crate) struct BlockAim<L> {
    moved: BodyPair<L>,
    normal: V3<L>,
    slop: L,
}

impl<'a, L: Lanes> BiasTargets<'a, L> {
    #[inline(always)]
    pub(crate) fn new(displacements: &'a [Cell<SolverBody>], bias: &Bias, is_first: bool) -> Self {
        Self {
            displacements,
            rate: L::splat(bias.bias_rate),
            most: L::splat(bias.max_bias_velocity),
            closing: L::splat(-1.0 / bias.substep_dt),
            is_first,
            is_far: displacements.len() >= FAR_BODIES,
        }
    }

    /// Asks for the displacements that a block needs, if they may be far.
    #[inline(always)]
    pub(crate) fn prefetch(&self, block: &Block) {
        if self.is_far {
            for &body in block.bodies.as_flattened() {
                prefetch(&self.displacements[body as usize]);
            }
        }
    }

    #[inline(always)]
    pub(crate) fn of_block(&self, block: &Block) -> BlockAim<L> {
        BlockAim {
            moved: BodyPair::gather(self.displacements, block),
            normal: V3::load(&block.normal),
            slop: L::load(&block.slop),
        }
    }

    /// Sets the target velocity of a point; of a sub-step that is not the first, the impulse of the one before goes to the total.
    #[inline(always)]
    pub(crate) fn at(&self, of_block: &BlockAim<L>, anchors: &[V3<L>; 2], point: &mut Point) {
        let zero = L::splat(0.0);
        let shift = of_block.moved.relative(anchors);
        let gap = L::load(&point.separation) + of_block.normal.dot(shift);
        let overlap = zero - gap - of_block.slop;
        let push = (self.rate * overlap.max(zero)).min(self.most);
        gap.if_above(zero, gap * self.closing, push)
            .store(&mut point.target_velocity);
        if !self.is_first {
            let total_normal_impulse =
                L::load(&point.total_normal_impulse) + L::load(&point.impulse[0]);
            total_normal_impulse.store(&mut point.total_normal_impulse);
        }
    }
}

/// Targets of bonded lanes: what has opened, been pressed in or slid goes back.
#[inline(always)]
fn bond_targets<L: Lanes>(
    block: &Block,
    points: &mut [Point],
    bond_constraints: &mut [BondConstraint],
    displacements: &[Cell<SolverBody>],
    bias: &Bias,
) {
    let moved = BodyPair::<L>::gather(displacements, block);
    let frame = Frame::<L>::load(block);
    let (zero, rate) = (L::splat(0.0), L::splat(bias.bond_rate));
    let (most, least) = (
        L::splat(bias.max_bias_velocity),
        L::splat(-bias.max_bias_velocity),
    );
    let back = |way: L| (zero - rate * way).min(most).max(least);
    for (point, constraint) in points.iter_mut().zip(bond_constraints) {
        let adhesion = L::load(&constraint.adhesion);
        let shift = moved.relative(&load_anchors(point));
        let gap = L::load(&point.separation) + frame.normal.dot(shift);
        adhesion
            .if_above(zero, back(gap), L::load(&point.target_velocity))
            .store(&mut point.target_velocity);
        for k in 0..2 {
            let slide = L::load(&constraint.slide[k]) + frame.tangents[k].dot(shift);
            let target = L::load(&constraint.target_velocity[k]);
            adhesion
                .if_above(zero, back(slide), target)
                .store(&mut constraint.target_velocity[k]);
        }
    }
}

/// Gives bodies what the impulses of points are worth, `share` times; see [`Pass::Warm`](crate::solver::wide::pass::Pass::Warm).
pub(crate) struct Warm<'a, B> {
    pub(crate) blocks: B,
    /// Points of the blocks, and what the blocks call the first of them.
    pub(crate) points: &'a [Point],
    pub(crate) first_point: usize,
    pub(crate) bodies: &'a [Cell<SolverBody>],
    pub(crate) share: f32,
}

impl<'a> Warm<'a, std::slice::Iter<'a, Block>> {
    /// All impulses of all contacts.
    pub(crate) fn all(contacts: &'a ContactBlocks<'_>) -> Self {
        Self {
            blocks: contacts.blocks.iter(),
            points: contacts.points,
            first_point: contacts.first_point,
            bodies: contacts.bodies,
            share: 1.0,
        }
    }
}

impl<'a, B: Iterator<Item = &'a Block>> Kernel for Warm<'_, B> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let share = L::splat(self.share);
        for block in self.blocks {
            let start = block.points.start - self.first_point;
            let points = &self.points[start..start + block.points.len()];
            warm_start(block, points, self.bodies, share);
        }
        0.0
    }
}

#[inline(always)]
fn warm_start<L: Lanes>(block: &Block, points: &[Point], bodies: &[Cell<SolverBody>], share: L) {
    let frame = Frame::<L>::load(block);
    let zero = V3([L::splat(0.0); 3]);
    let (mut linear, mut angular) = (zero, [zero; 2]);
    for point in points {
        let impulse = frame.impulse(load_three(&point.impulse));
        let anchors = load_anchors(point);
        linear = linear.plus(impulse);
        angular = [
            angular[0].plus(anchors[0].cross(impulse)),
            angular[1].plus(anchors[1].cross(impulse)),
        ];
    }
    let mut pair = BodyPair::<L>::gather(bodies, block);
    let [of_a, of_b] = angular;
    let angular = [of_a.times(share), of_b.times(share)];
    pair.apply(&Masses::load(block), linear.times(share), angular);
    pair.scatter(bodies, block);
}
