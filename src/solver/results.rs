//! What the solver found: velocities and motions of bodies, islands with their rows, bodies that are overloaded.

use crate::bodies::breaking::{Blow, ImpactLoad};
use crate::bodies::solver_body::{Motion, SolverBody};
use crate::bodies::store::Bodies;
use crate::math::rotate_by;
use crate::solver::adaptivity::SweepBudget;
use crate::solver::batch::Batch;
use crate::solver::batch::cluster_blow::{Crack, Strain};
use crate::solver::batch::layout::{Member, SolvedMember};
use crate::solver::contact_solver::{ContactSolver, Progress};
use crate::solver::rows::contact_rows::PointRows;
use crate::solver::rows::residual::{ResidualSum, Solved};

/// An island after the solve.
#[derive(Clone, Debug)]
pub struct SolvedIsland<'a> {
    pub(crate) batch: &'a Batch,
    pub(crate) member: &'a Member,
    /// Number of its points.
    pub contacts: usize,
    /// Velocities of its bodies.
    pub bodies: &'a [SolverBody],
    /// Slots of its bodies.
    pub slots: &'a [u32],
    /// What it took, together with the others of its batch.
    pub budget: SweepBudget,
}

impl SolvedIsland<'_> {
    /// Puts the rows of its points into `rows`, in the order of its manifolds.
    pub fn rows(&self, rows: &mut Vec<PointRows>) {
        rows.clear();
        let Member { places, bodies, .. } = self.member;
        let first_body = bodies.start as u32;
        self.batch.collect_rows(places.clone(), first_body, rows);
    }

    /// How far its rows, which `rows` is a buffer for, and those of its joints are from being solved.
    pub(crate) fn residual_sum(&self, rows: &mut Vec<PointRows>) -> ResidualSum {
        self.rows(rows);
        let settings = &self.batch.settings;
        let solved = Solved {
            friction: settings.friction,
            is_relaxed: settings.is_relaxed(),
        };
        let mut sum = ResidualSum::of(rows, self.bodies, solved);
        sum.add_rows(self.batch.solved_joint_rows(self.member));
        sum
    }
}

impl ContactSolver {
    /// Lists the islands of this round in their order, whatever batches they are of.
    pub(crate) fn list_solved(&mut self) {
        self.forget_solved();
        let first = self.solved.len();
        let batches = (0..).zip(&self.batches);
        for (batch, of_round) in batches.skip(self.earlier).take(self.ranges.len()) {
            let members = (0..).zip(&of_round.layout.members);
            self.solved
                .extend(members.map(|(member, of_batch)| SolvedMember {
                    island: of_batch.island,
                    batch,
                    member,
                }));
        }
        self.solved[first..].sort_unstable();
    }

    /// Forgets what batches have solved that are not of earlier rounds.
    pub(crate) fn forget_solved(&mut self) {
        let is_earlier = |solved: &SolvedMember| (solved.batch as usize) < self.earlier;
        let count = self.solved.partition_point(is_earlier);
        self.solved.truncate(count);
    }

    /// The islands of the last step.
    pub fn islands(&self) -> impl Iterator<Item = SolvedIsland<'_>> {
        let solved = self.solved_before(self.batches.len());
        solved.map(|(batch, number)| {
            let member = &batch.layout.members[number];
            SolvedIsland {
                batch,
                member,
                contacts: member.contacts,
                bodies: &batch.bodies.velocities[member.bodies.clone()],
                slots: &batch.layout.slots[member.bodies.clone()],
                budget: batch.lone.budget(number).unwrap_or(batch.budget),
            }
        })
    }

    /// The islands that the batches before this one have solved, as batches and numbers in these.
    fn solved_before(&self, end: usize) -> impl Iterator<Item = (&Batch, usize)> {
        let solved = self.solved.iter().filter(move |s| (s.batch as usize) < end);
        let solved = solved.map(|s| (&self.batches[s.batch as usize], s.member as usize));
        solved.filter(|(batch, _)| !batch.impacts.is_broken)
    }

    /// Slots of the islands of the step as it began, which may have come apart in local steps: together they rest and sleep.
    pub(crate) fn whole_islands(&self) -> impl Iterator<Item = &[u32]> {
        let end = self.whole_batches.unwrap_or(self.batches.len());
        let islands = self.solved_before(end).map(|(batch, number)| {
            let member = &batch.layout.members[number];
            &batch.layout.slots[member.bodies.clone()]
        });
        let put_off = self.put_off.iter();
        islands.chain(put_off.map(|island| &self.put_off_slots[island.bodies.clone()]))
    }

    /// Blows to bodies that got through the step although these are more than they bear, of the batches from this number on.
    pub(crate) fn overloaded(&self, first: usize) -> impl Iterator<Item = &Blow> {
        let batches = self.batches[first..self.earlier + self.ranges.len()].iter();
        let solved = batches.filter(|batch| !batch.impacts.is_broken);
        solved.flat_map(|batch| &batch.impacts.overloaded)
    }

    /// What cracked in the islands that have been solved, of the batches from this number on.
    pub(crate) fn cracks(&self, first: usize) -> impl Iterator<Item = &Crack> {
        let batches = self.batches[first..self.earlier + self.ranges.len()].iter();
        let solved = batches.filter(|batch| !batch.impacts.is_broken);
        solved.flat_map(|batch| &batch.impacts.cracks)
    }

    /// What blows wear in the islands that have been solved, of the batches from this number on.
    pub(crate) fn strains(&self, first: usize) -> impl Iterator<Item = &Strain> {
        let batches = self.batches[first..self.earlier + self.ranges.len()].iter();
        let solved = batches.filter(|batch| !batch.impacts.is_broken);
        solved.flat_map(|batch| &batch.impacts.strains)
    }

    /// Blows that ended the solve of their islands in the last round.
    pub(crate) fn breaking(&self) -> impl Iterator<Item = &Blow> {
        let batches = self.batches[self.earlier..][..self.ranges.len()].iter();
        let broken = batches.filter(|batch| batch.impacts.is_broken);
        let blows = broken.flat_map(|batch| &batch.impacts.overloaded);
        blows.chain(&self.probe.overloaded)
    }

    /// What bodies that may break, by slot, were hit with in the islands that have been solved, of the batches from this number on.
    pub(crate) fn borne_loads(
        &self,
        first: usize,
    ) -> impl Iterator<Item = (u32, ImpactLoad)> + Clone {
        let batches = self.batches[first..self.earlier + self.ranges.len()].iter();
        let solved = batches.filter(|batch| !batch.impacts.is_broken);
        solved.flat_map(|batch| {
            let limits = batch.impacts.limits.iter();
            limits.map(|limit| {
                let number = limit.body as usize;
                (batch.layout.slots[number], batch.impacts.loads[number])
            })
        })
    }

    /// Whether the body in `slot` is as it was before the step, because something in its island breaks.
    pub fn is_deferred(&self, slot: u32) -> bool {
        self.progress.get(slot as usize) == Some(&Progress::Deferred)
    }

    /// Whether the body in `slot` is dynamic and has got its velocity and motion in this step.
    pub fn is_solved(&self, slot: u32) -> bool {
        self.progress.get(slot as usize) == Some(&Progress::Solved)
    }

    /// Takes velocities and motions of the bodies that contacts move back to their slots.
    pub(crate) fn write_back(&mut self, bodies: &mut Bodies) {
        let batches = &self.batches[self.earlier..][..self.ranges.len()];
        for batch in batches {
            if batch.impacts.is_broken {
                for (&slot, body) in batch.layout.slots.iter().zip(&batch.bodies.velocities) {
                    if body.inverse_mass > 0.0 {
                        self.progress[slot as usize] = Progress::Deferred;
                    }
                }
                continue;
            }
            for (number, &slot) in batch.layout.slots.iter().enumerate() {
                let (i, body) = (slot as usize, &batch.bodies.velocities[number]);
                if body.inverse_mass > 0.0 {
                    let moved = &batch.bodies.displacements[number];
                    self.progress[i] = Progress::Solved;
                    // What was squeezed was heavier for the step.
                    let inverse_mass = bodies.velocity[i].inverse_mass;
                    bodies.velocity[i] = SolverBody {
                        inverse_mass,
                        ..*body
                    };
                    bodies.motion[i] = Motion {
                        shift: moved.linear,
                        rotation: rotate_by(bodies.rotation[i], moved.angular, 1.0),
                    };
                }
            }
            for turning in &batch.bodies.turning {
                let slot = batch.layout.slots[turning.body as usize] as usize;
                bodies.motion[slot].rotation = turning.spin.rotation;
            }
        }
    }
}
