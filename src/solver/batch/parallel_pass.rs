//! A pass over the contacts of a large batch, in parts that several threads do at a time.
#![allow(
    unsafe_code,
    reason = "parts of one list are written by different threads"
)]

use crate::bodies::solver_body::SolverBody;
use crate::simd::lanes::{F8, LaneWidth};
use crate::simd::prefetch::prefetch;
use crate::solver::config::FrictionModel;
use crate::solver::wide::block::{Block, Point, PointImpact};
use crate::solver::wide::bond::BondConstraint;
use crate::solver::wide::contacts::ContactBlocks;
use crate::solver::wide::pass::Pass;
use crate::threads::team::Shared;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

/// What all parts of a pass read and write.
///
/// [Partition](crate::solver::graph::partition) of one stage share no body: movable ones are in one leaf, and touched by the separators on the way
/// up from it, one a stage; fixed ones have a copy in each subdomain (see [`Batch`](crate::solver::batch::Batch)). Each has its own
/// blocks, and these their own points.
pub(crate) struct ParallelPass<'a> {
    pub(crate) pass: Pass,
    pub(crate) blocks: &'a [Block],
    pub(crate) points: Shared<'a, Point>,
    /// Of the points; empty where nothing is bonded.
    pub(crate) bond_constraints: Shared<'a, BondConstraint>,
    pub(crate) has_bonds: bool,
    pub(crate) impacts: &'a [PointImpact],
    pub(crate) bodies: Shared<'a, SolverBody>,
    pub(crate) displacements: Shared<'a, SolverBody>,
    pub(crate) last: Shared<'a, [F8; 3]>,
    pub(crate) friction: FrictionModel,
    pub(crate) width: LaneWidth,
    pub(crate) is_far: bool,
    /// The largest velocity change so far, as bits: those of positive numbers are in the order of the numbers.
    pub(crate) change: AtomicU32,
}

impl ParallelPass<'_> {
    /// Asks for the velocities of the bodies of some blocks.
    pub(crate) fn prefetch_bodies(&self, blocks: Range<usize>) {
        // SAFETY: nothing is read or written.
        let bodies = unsafe { self.bodies.cells() };
        let blocks = &self.blocks[blocks];
        for body in blocks.iter().flat_map(|block| block.bodies.as_flattened()) {
            prefetch(&bodies[*body as usize]);
        }
    }

    /// Does the pass for the blocks of a subdomain. Different threads must be given different subdomains of the same stage.
    pub(crate) fn run(&self, blocks: Range<usize>) {
        let blocks = &self.blocks[blocks];
        let [Some(first), Some(last)] = [blocks.first(), blocks.last()] else {
            return;
        };
        let range = first.points.start..last.points.end;
        let has_last = matches!(self.pass, Pass::Extrapolate { .. });
        let last_range = if has_last { range.clone() } else { 0..0 };
        let impacts = if self.impacts.is_empty() {
            self.impacts
        } else {
            &self.impacts[range.clone()]
        };
        // SAFETY: points and their ties follow their blocks, and no other thread has these blocks; of the bodies, subdomains of
        // one stage write different ones, see above. Displacements are not written.
        let change = unsafe {
            let mut contacts = ContactBlocks {
                blocks,
                first_point: range.start,
                points: self.points.part(range.clone()),
                impacts,
                lane_changes: &mut [],
                bodies: self.bodies.cells(),
                displacements: self.displacements.cells(),
                friction: self.friction,
                width: self.width,
                is_far: self.is_far,
            };
            let last = self.last.part(last_range);
            if self.has_bonds {
                contacts.pass_bonded(self.pass, last, self.bond_constraints.part(range))
            } else {
                contacts.pass(self.pass, last)
            }
        };
        self.change.fetch_max(change.to_bits(), Ordering::Relaxed);
    }
}
