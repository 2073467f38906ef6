//! A pass over the contacts of a large batch, in parts that several threads do at a time.
#![allow(
    unsafe_code,
    reason = "parts of one list are written by different threads"
)]

use super::FrictionModel;
use super::blocks::{Block, Blow, Point};
use super::bodies::SolverBody;
use super::lanes::{F8, LaneWidth};
use super::sweep::{Contacts, Pass};
use super::ties::Tie;
use crate::prefetch::prefetch;
use crate::team::Shared;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

/// What all parts of a pass read and write.
///
/// [Domains](super::domains) of one stage share no body: movable ones are in one leaf, and touched by the separators on the way
/// up from it, one a stage; fixed ones have a copy in each domain (see [`Batch`](super::batch::Batch)). Each has its own
/// blocks, and these their own points.
pub(super) struct Shift<'a> {
    pub(super) pass: Pass,
    pub(super) blocks: &'a [Block],
    pub(super) points: Shared<'a, Point>,
    /// Of the points; empty where nothing is bonded.
    pub(super) ties: Shared<'a, Tie>,
    pub(super) has_ties: bool,
    pub(super) blows: &'a [Blow],
    pub(super) bodies: Shared<'a, SolverBody>,
    pub(super) displacements: Shared<'a, SolverBody>,
    pub(super) last: Shared<'a, [F8; 3]>,
    pub(super) friction: FrictionModel,
    pub(super) width: LaneWidth,
    pub(super) is_far: bool,
    /// The largest velocity change so far, as bits: those of positive numbers are in the order of the numbers.
    pub(super) change: AtomicU32,
}

impl Shift<'_> {
    /// Asks for the velocities of the bodies of some blocks.
    pub(super) fn prefetch_bodies(&self, blocks: Range<usize>) {
        // SAFETY: nothing is read or written.
        let bodies = unsafe { self.bodies.cells() };
        let blocks = &self.blocks[blocks];
        for body in blocks.iter().flat_map(|block| block.bodies.as_flattened()) {
            prefetch(&bodies[*body as usize]);
        }
    }

    /// Does the pass for the blocks of a domain. Different threads must be given different domains of the same stage.
    pub(super) fn run(&self, blocks: Range<usize>) {
        let blocks = &self.blocks[blocks];
        let [Some(first), Some(last)] = [blocks.first(), blocks.last()] else {
            return;
        };
        let range = first.points.start..last.points.end;
        let has_last = matches!(self.pass, Pass::Extrapolate { .. });
        let last_range = if has_last { range.clone() } else { 0..0 };
        let blows = if self.blows.is_empty() {
            self.blows
        } else {
            &self.blows[range.clone()]
        };
        // SAFETY: points and their ties follow their blocks, and no other thread has these blocks; of the bodies, domains of
        // one stage write different ones, see above. Displacements are not written.
        let change = unsafe {
            let mut contacts = Contacts {
                blocks,
                first_point: range.start,
                points: self.points.part(range.clone()),
                blows,
                bodies: self.bodies.cells(),
                displacements: self.displacements.cells(),
                friction: self.friction,
                width: self.width,
                is_far: self.is_far,
            };
            let last = self.last.part(last_range);
            if self.has_ties {
                contacts.pass_tied(self.pass, last, self.ties.part(range))
            } else {
                contacts.pass(self.pass, last)
            }
        };
        self.change.fetch_max(change.to_bits(), Ordering::Relaxed);
    }
}
