//! A pass over all contacts of a batch, by one thread or by a team subdomain by subdomain.

use crate::solver::batch::Batch;
use crate::solver::batch::parallel_pass::ParallelPass;
use crate::solver::graph::partition;
use crate::solver::wide::contacts::{ContactBlocks, cells};
use crate::solver::wide::pass::Pass;
use crate::threads::team::{Shared, Team};
use crate::tuning::NEAR_CACHE;
use std::sync::atomic::{AtomicU32, Ordering};

impl Batch {
    /// Does a pass over all contacts, several subdomains at a time if there is a team; returns the largest velocity change if it
    /// measures.
    pub fn pass(&mut self, pass: Pass, team: Option<&Team>) -> f32 {
        let is_far = self.is_far();
        let Some(team) = team else {
            let mut contacts = ContactBlocks {
                blocks: &self.contacts.blocks,
                points: &mut self.contacts.points,
                first_point: 0,
                impacts: &self.impacts.points,
                lane_changes: &mut self.lone.changes,
                bodies: cells(&mut self.bodies.velocities),
                displacements: cells(&mut self.bodies.displacements),
                friction: self.settings.friction,
                width: self.settings.lane_width,
                is_far,
            };
            let last = &mut self.scratch.last_impulses;
            return if self.bonds.constraints.is_empty() {
                contacts.pass(pass, last)
            } else {
                contacts.pass_bonded(pass, last, &mut self.bonds.constraints)
            };
        };
        self.pass_with(pass, team, is_far)
    }

    /// Whether blocks and points are more than a near cache keeps from one pass to the next.
    fn is_far(&self) -> bool {
        size_of_val(&self.contacts.blocks[..]) + size_of_val(&self.contacts.points[..]) > NEAR_CACHE
    }

    fn pass_with(&mut self, pass: Pass, team: &Team, is_far: bool) -> f32 {
        let settings = &self.settings;
        let work = ParallelPass {
            pass,
            blocks: &self.contacts.blocks,
            points: Shared::new(&mut self.contacts.points),
            has_bonds: !self.bonds.constraints.is_empty(),
            bond_constraints: Shared::new(&mut self.bonds.constraints),
            impacts: &self.impacts.points,
            bodies: Shared::new(&mut self.bodies.velocities),
            displacements: Shared::new(&mut self.bodies.displacements),
            last: Shared::new(&mut self.scratch.last_impulses),
            friction: settings.friction,
            width: settings.lane_width,
            is_far,
            change: AtomicU32::new(0),
        };
        let mut first = 0;
        for count in partition::stages(self.layout.subdomains.len()) {
            let stage = &self.layout.subdomains[first..first + count];
            team.run(count, &|subdomain| {
                let blocks = stage[subdomain].clone();
                // Half of what a separator joins was written by another thread.
                if first > 0 {
                    work.prefetch_bodies(blocks.clone());
                }
                work.run(blocks);
            });
            first += count;
        }
        f32::from_bits(work.change.load(Ordering::Relaxed))
    }
}
