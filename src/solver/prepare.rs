//! What comes before the sweeps of a sub-step: targets and warm start.

use super::blocks::{Block, Point, load_anchors};
use super::bodies::SolverBody;
use super::lane_pair::{Frame, Masses, Pair, load_three};
use super::lanes::{Kernel, Lanes};
use super::sweep::{Contacts, Feedback};
use super::ties::{RATE, Tie};
use super::triple::V3;
use std::cell::Cell;

/// Targets, warm start, or both.
pub(super) struct Prepare<'a, 'c, const TARGETS: bool, const WARM: bool, const TIED: bool> {
    contacts: &'a mut Contacts<'c>,
    ties: &'a mut [Tie],
    feedback: Feedback,
    first: bool,
}

impl<'a, 'c, const TARGETS: bool, const WARM: bool, const TIED: bool>
    Prepare<'a, 'c, TARGETS, WARM, TIED>
{
    pub(super) fn new(
        contacts: &'a mut Contacts<'c>,
        ties: &'a mut [Tie],
        feedback: Feedback,
        first: bool,
    ) -> Self {
        Self {
            contacts,
            ties,
            feedback,
            first,
        }
    }
}

impl<const TARGETS: bool, const WARM: bool, const TIED: bool> Kernel
    for Prepare<'_, '_, TARGETS, WARM, TIED>
{
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let Contacts {
            blocks,
            points,
            first_point,
            bodies,
            displacements,
            ..
        } = self.contacts;
        for block in blocks.iter() {
            let start = block.points.start - *first_point;
            let range = start..start + block.points.len();
            let points = &mut points[range.clone()];
            if TARGETS {
                targets::<L>(block, points, displacements, &self.feedback, self.first);
            }
            if TARGETS && TIED {
                let ties = &mut self.ties[range];
                tie_targets::<L>(block, points, ties, displacements, &self.feedback);
            }
            if WARM {
                warm_start::<L>(block, points, bodies);
            }
        }
        0.0
    }
}

#[inline(always)]
fn targets<L: Lanes>(
    block: &Block,
    points: &mut [Point],
    displacements: &[Cell<SolverBody>],
    feedback: &Feedback,
    first: bool,
) {
    let moved = Pair::<L>::gather(displacements, block);
    let (zero, rate) = (L::splat(0.0), L::splat(feedback.rate));
    let (closing, most) = (L::splat(-1.0 / feedback.h), L::splat(feedback.most));
    let normal = V3::<L>::load(&block.normal);
    let slop = L::load(&block.slop);
    for point in points {
        let shift = moved.relative(&load_anchors(point));
        let gap = L::load(&point.separation) + normal.dot(shift);
        let overlap = zero - gap - slop;
        let push = (rate * overlap.max(zero)).min(most);
        gap.if_above(zero, gap * closing, push)
            .store(&mut point.wanted);
        if !first {
            let total = L::load(&point.total) + L::load(&point.impulse[0]);
            total.store(&mut point.total);
        }
    }
}

/// Targets of bonded lanes: what has opened, been pressed in or slid goes back.
#[inline(always)]
fn tie_targets<L: Lanes>(
    block: &Block,
    points: &mut [Point],
    ties: &mut [Tie],
    displacements: &[Cell<SolverBody>],
    feedback: &Feedback,
) {
    let moved = Pair::<L>::gather(displacements, block);
    let frame = Frame::<L>::load(block);
    let (zero, rate) = (L::splat(0.0), L::splat(RATE * feedback.rate));
    let (most, least) = (L::splat(feedback.most), L::splat(-feedback.most));
    let back = |way: L| (zero - rate * way).min(most).max(least);
    for (point, tie) in points.iter_mut().zip(ties) {
        let adhesion = L::load(&tie.adhesion);
        let shift = moved.relative(&load_anchors(point));
        let gap = L::load(&point.separation) + frame.normal.dot(shift);
        adhesion
            .if_above(zero, back(gap), L::load(&point.wanted))
            .store(&mut point.wanted);
        for k in 0..2 {
            let slide = L::load(&tie.slide[k]) + frame.tangents[k].dot(shift);
            adhesion
                .if_above(zero, back(slide), zero)
                .store(&mut tie.wanted[k]);
        }
    }
}

#[inline(always)]
fn warm_start<L: Lanes>(block: &Block, points: &[Point], bodies: &[Cell<SolverBody>]) {
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
    let mut pair = Pair::<L>::gather(bodies, block);
    pair.apply(&Masses::load(block), linear, angular);
    pair.scatter(bodies, block);
}
