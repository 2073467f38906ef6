//! As many sweeps as a sub-step needs: the least number, then on until a sweep changes no velocity by more than the tolerance.

use crate::bodies::solver_body::SolverBody;
use crate::solver::batch::layout::Layout;
use crate::solver::batch::subdomain_slices::{each_part, parts_of_blocks};
use crate::solver::batch::{Batch, BatchScratch};
use crate::solver::rows::soft_step::{Bias, RowSoftness};
use crate::solver::wide::pass::Pass;
use crate::threads::parts::front_mut;
use crate::threads::team::Team;

/// What one sweep does.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SweepKind {
    /// With position bias.
    Solve(RowSoftness),
    /// The same, where target velocities are to be set on the way.
    SolveFrom {
        bias: Bias,
        is_first: bool,
        softness: RowSoftness,
    },
    /// Without.
    Relax,
}

impl SweepKind {
    /// The pass of a sweep by its number, from 1 on.
    pub(crate) fn pass(self, number: u32, measure: bool) -> Pass {
        match self {
            Self::SolveFrom {
                bias,
                is_first,
                softness,
            } if number == 1 => Pass::SolveFirst {
                bias,
                is_first,
                softness,
                measure,
            },
            Self::Solve(softness) | Self::SolveFrom { softness, .. } => {
                Pass::Solve { softness, measure }
            }
            Self::Relax => Pass::Relax { measure },
        }
    }
}

impl Batch {
    /// Sweeps `least` times, then with [`momentum`](crate::solver::rows::acceleration) until a sweep changes no velocity by more than
    /// `tolerance`, but not more often than the configuration allows, nor than is left for the step.
    pub(crate) fn sweep(
        &mut self,
        least: u32,
        kind: SweepKind,
        tolerance: Option<f32>,
        team: Option<&Team>,
    ) {
        if self.lone.any() {
            return self.sweep_lone(least, kind);
        }
        let most = self.settings.max_sweeps.min(least + self.budget.share());
        let (mut change, mut done) = (0.0, 0);
        self.scratch.acceleration.restart();
        while done < least || tolerance.is_some_and(|t| change > t) && done < most {
            let is_extra = done >= least;
            if is_extra {
                self.accelerate(team);
            }
            done += 1;
            let measure = tolerance.is_some() && done >= least;
            change = self.pass(kind.pass(done, measure), team);
            self.solve_joints();
            if is_extra {
                self.scratch.acceleration.note(change);
            }
        }
        let is_unconverged = tolerance.is_some_and(|t| change > t);
        self.budget.note(done, done - least, is_unconverged);
    }

    /// Moves impulses and velocities on in the direction of their last change, or remembers them for the next time.
    fn accelerate(&mut self, team: Option<&Team>) {
        let BatchScratch {
            acceleration,
            last_impulses,
            last_velocities,
            ..
        } = &mut self.scratch;
        let Layout {
            cuts, subdomains, ..
        } = &self.layout;
        last_velocities.resize(self.bodies.velocities.len(), SolverBody::default());
        let bodies = (&mut self.bodies.velocities[..], &mut last_velocities[..]);
        let Some(weight) = acceleration.weight() else {
            each_part(cuts, team, bodies, |now, last| last.copy_from_slice(now));
            self.joints.remember();
            last_impulses.resize(self.contacts.points.len(), Default::default());
            let mut last = &mut last_impulses[..];
            let parts = parts_of_blocks(
                &mut self.contacts.blocks,
                &mut self.contacts.points,
                subdomains,
                team,
            );
            let parts = parts.map(|(_, points)| (front_mut(&mut last, points.len()), points));
            Team::each(team, parts, |(last, now)| {
                for (last, now) in last.iter_mut().zip(now) {
                    *last = now.impulse;
                }
            });
            return;
        };
        each_part(cuts, team, bodies, |now, last| {
            for (body, last) in now.iter_mut().zip(last) {
                let now = *body;
                body.linear = now.linear + weight * (now.linear - last.linear);
                body.angular = now.angular + weight * (now.angular - last.angular);
                *last = now;
            }
        });
        self.joints.extrapolate(weight);
        self.pass(Pass::Extrapolate { weight }, team);
    }
}
