//! The warm start of a sub-step.
//!
//! In the first sub-step of a step the contacts are asked for it, `v += M^-1 J^T lambda`. Later their answer is known before:
//! a sub-step begins without their impulses and ends with `lambda`, so what they have done to the bodies since it began is
//!
//! ```text
//! v_end - v_begin = M^-1 J^T lambda
//! ```
//!
//! To add that again takes one look at each body instead of one at each contact. Where rows are [pointed
//! anew](crate::solver::wide::reanchor) in between, their part is taken out by the old rows and added by the new ones.

use crate::bodies::solver_body::SolverBody;
use crate::simd::dispatch::run;
use crate::solver::batch::Batch;
use crate::solver::batch::energy_guard::LinearSums;
use crate::solver::batch::subdomain_slices::{each_part, parts_by_body};
use crate::solver::wide::bias::Warm;
use crate::solver::wide::contacts::cells;
use crate::solver::wide::pass::Pass;
use crate::threads::team::Team;
use crate::tuning::{BLOCKS_PER_FOLLOWING, MAX_LEAVES};

impl Batch {
    /// Gives the bodies what the impulses of the sub-step before are worth.
    pub(crate) fn warm_start(&mut self, team: Option<&Team>) {
        if self.bodies.contact_velocity_changes.is_empty() {
            // A single sub-step whose energy is not bounded has no use for them.
            if self.settings.substeps > 1 || self.is_passive() {
                self.bodies
                    .contact_velocity_changes
                    .extend_from_slice(&self.bodies.velocities);
            }
            self.pass(Pass::Warm, team);
            return;
        }
        let lists = (
            &mut self.bodies.velocities[..],
            &mut self.bodies.contact_velocity_changes[..],
        );
        each_part(
            &self.layout.cuts,
            team,
            lists,
            |bodies, contact_velocity_changes| {
                for (body, gain) in bodies.iter_mut().zip(contact_velocity_changes.iter_mut()) {
                    let begin = *body;
                    body.linear += gain.linear;
                    body.angular += gain.angular;
                    *gain = begin;
                }
            },
        );
    }

    /// Ends a sub-step that began with a [warm start](Self::warm_start): finds what contacts have given to the bodies, which
    /// is no [energy](crate::solver::batch::energy_guard).
    pub(crate) fn note_contact_velocity_changes(&mut self, team: Option<&Team>) {
        if self.bodies.contact_velocity_changes.is_empty() {
            return;
        }
        let members = std::mem::take(&mut self.layout.members);
        if let ([member], [_, ..]) = (&members[..], self.layout.cuts.leaves()) {
            let linear = self.note_gains_of_leaves(team);
            self.guard_energy(0, member, &linear, team);
        } else {
            // Behind their bodies there is only the dummy one, which gains nothing.
            for (island, member) in members.iter().enumerate() {
                let bodies = member.bodies.clone();
                let linear = note_contact_velocity_changes(
                    &mut self.bodies.contact_velocity_changes[bodies.clone()],
                    &self.bodies.velocities[bodies],
                );
                self.guard_energy(island, member, &linear, team);
            }
        }
        self.layout.members = members;
    }

    fn note_gains_of_leaves(&mut self, team: Option<&Team>) -> LinearSums {
        let cuts = &self.layout.cuts;
        let parts = parts_by_body(&mut self.bodies.contact_velocity_changes, cuts)
            .zip(parts_by_body(&mut self.bodies.velocities, cuts));
        let mut sums = [LinearSums::default(); MAX_LEAVES];
        let sums = &mut sums[..cuts.leaves().len()];
        Team::each(
            team,
            parts.zip(&mut *sums),
            |((contact_velocity_changes, bodies), sums)| {
                *sums = note_contact_velocity_changes(contact_velocity_changes, bodies);
            },
        );
        let sums = sums.iter().copied();
        sums.reduce(|a, b| a + b).unwrap_or_default()
    }

    /// Has the contacts asked at the next warm start, because their impulses are no longer what the sub-step found.
    pub(crate) fn forget_contact_velocity_changes(&mut self) {
        self.bodies.contact_velocity_changes.clear();
    }

    /// [Points](Self::reanchor) the rows of moving manifolds anew, between two sub-steps.
    pub(crate) fn reanchor_with_contact_velocity_changes(&mut self, team: Option<&Team>) {
        if self.contacts.moving.is_empty() {
            return;
        }
        if BLOCKS_PER_FOLLOWING * self.contacts.reanchored.len() > self.contacts.blocks.len() {
            self.forget_contact_velocity_changes();
        }
        self.add_to_gains(-1.0);
        self.reanchor(0.0, team);
        self.add_to_gains(1.0);
    }

    /// Adds `share` times what the impulses of reanchored blocks are worth to the gains, if these are known.
    fn add_to_gains(&mut self, share: f32) {
        if self.bodies.contact_velocity_changes.is_empty() {
            return;
        }
        let reanchored = self.contacts.reanchored.iter();
        let warm = Warm {
            blocks: reanchored.map(|reanchored| &self.contacts.blocks[reanchored.block as usize]),
            points: &self.contacts.points,
            first_point: 0,
            bodies: cells(&mut self.bodies.contact_velocity_changes),
            share,
        };
        run(self.settings.lane_width, warm);
    }
}

/// Turns velocities at the start of a sub-step into what has been added since.
fn note_contact_velocity_changes(
    contact_velocity_changes: &mut [SolverBody],
    bodies: &[SolverBody],
) -> LinearSums {
    let mut sums = LinearSums::default();
    for (gain, body) in contact_velocity_changes.iter_mut().zip(bodies) {
        gain.linear = body.linear - gain.linear;
        gain.angular = body.angular - gain.angular;
        sums.add(body, gain);
    }
    sums
}
