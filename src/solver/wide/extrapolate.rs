//! Momentum of the impulses, in lanes.

use crate::simd::lanes::{F8, Kernel, Lanes};
use crate::solver::wide::block::load_anchors;
use crate::solver::wide::body_pair::{BodyPair, Frame, Masses, load_three, project, store_three};
use crate::solver::wide::bond::{BondConstraint, ImpulseBounds};
use crate::solver::wide::contacts::ContactBlocks;

/// Moves the impulses on; see [`Pass::Extrapolate`](crate::solver::wide::pass::Pass::Extrapolate).
pub(crate) struct Extrapolate<'a, 'c, const BONDED: bool> {
    pub(crate) contacts: &'a mut ContactBlocks<'c>,
    pub(crate) bond_constraints: &'a [BondConstraint],
    pub(crate) last: &'a mut [[F8; 3]],
    pub(crate) weight: F8,
}

impl<const BONDED: bool> Kernel for Extrapolate<'_, '_, BONDED> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let ContactBlocks {
            blocks,
            points,
            first_point,
            bodies,
            friction: model,
            ..
        } = self.contacts;
        let weight = L::load(&self.weight);
        for block in blocks.iter() {
            let (frame, masses) = (Frame::<L>::load(block), Masses::load(block));
            let friction = L::load(&block.friction);
            let mut pair = BodyPair::<L>::gather(bodies, block);
            let start = block.points.start - *first_point;
            for i in start..start + block.points.len() {
                let (point, last) = (&mut points[i], &mut self.last[i]);
                let now: [L; 3] = load_three(&point.impulse);
                let before: [L; 3] = load_three(last);
                let unbounded = [
                    now[0] + weight * (now[0] - before[0]),
                    now[1] + weight * (now[1] - before[1]),
                    now[2] + weight * (now[2] - before[2]),
                ];
                let bounds =
                    ImpulseBounds::<L, BONDED>::load(friction, self.bond_constraints.get(i));
                let normal = bounds.normal(unbounded[0]);
                let [t1, t2] = project(*model, [unbounded[1], unbounded[2]], bounds.radius(normal));
                let new = [normal, t1, t2];
                store_three(now, last);
                store_three(new, &mut point.impulse);
                let taken = [normal - unbounded[0], t1 - unbounded[1], t2 - unbounded[2]];
                pair.push(&masses, &load_anchors(point), frame.impulse(taken));
            }
            pair.scatter(bodies, block);
        }
        0.0
    }
}
