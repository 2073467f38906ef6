//! Passes over blocks of eight manifolds: what is done to all contacts, and which kernel does it.

use crate::simd::lanes::{F8, run};
use crate::solver::rows::soft_step::{Feedback, Softness};
use crate::solver::wide::bias::{Targets, Warm};
use crate::solver::wide::bond::Tie;
use crate::solver::wide::contacts::Contacts;
use crate::solver::wide::extrapolate::Extrapolate;
use crate::solver::wide::sweep::{Relax, Solve, SolveFirst, Sweep};

/// What is done to all contacts.
#[derive(Clone, Copy, Debug)]
pub enum Pass {
    /// Sets the wanted velocities from the displacements of the bodies since the start of the step. Of a sub-step that is not
    /// the `first`, the impulses of the one before are added to the total.
    Targets {
        /// How overlap is pushed out.
        feedback: Feedback,
        /// Whether the step begins.
        first: bool,
    },
    /// Adds `M^-1 J^T lambda` of the impulses found in the points to the velocities: the warm start.
    Warm,
    /// One sweep with position feedback, friction before the normal. With `measure`, tells the largest velocity change of a row
    /// in units of its [speed scale](crate::solver::rows::contact_rows::PointRows::speed_scale), else 0.
    Solve {
        /// Compliance.
        softness: Softness,
        /// Whether to measure.
        measure: bool,
    },
    /// [`Targets`](Self::Targets) and the first [`Solve`](Self::Solve) in one go through the contacts, with the same outcome;
    /// not where there are bonds.
    SolveFirst {
        /// How overlap is pushed out.
        feedback: Feedback,
        /// Whether the step begins.
        first: bool,
        /// Compliance.
        softness: Softness,
        /// Whether to measure.
        measure: bool,
    },
    /// One sweep without position feedback, the normal before friction. Points that are pushed stop, others may close their
    /// gap, impacts rebound.
    Relax {
        /// As in [`Solve`](Self::Solve).
        measure: bool,
    },
    /// Moves the impulses on from where they were to where they were going, by `weight` times their last change, and projects
    /// them on what they may be. The velocities are moved by the caller; only what the projection takes away is taken out of
    /// them here.
    Extrapolate {
        /// Weight of the momentum.
        weight: f32,
    },
}

impl Contacts<'_> {
    /// Does a pass; returns the largest velocity change if it is measured, else 0. `last`: where the impulses were before an
    /// extrapolation, and then where they are; of no use to other passes.
    pub fn pass(&mut self, pass: Pass, last: &mut [[F8; 3]]) -> f32 {
        self.run::<false>(pass, last, &mut [])
    }

    /// Does a pass with bonds: `ties` are those of the points.
    pub fn pass_tied(&mut self, pass: Pass, last: &mut [[F8; 3]], ties: &mut [Tie]) -> f32 {
        self.run::<true>(pass, last, ties)
    }

    fn run<const TIED: bool>(&mut self, pass: Pass, last: &mut [[F8; 3]], ties: &mut [Tie]) -> f32 {
        let width = self.width;
        let contacts = self;
        match pass {
            Pass::Targets { feedback, first } => {
                let targets = Targets::<TIED> {
                    contacts,
                    ties,
                    feedback,
                    first,
                };
                run(width, targets)
            }
            Pass::Warm => {
                let warm = Warm {
                    blocks: contacts.blocks.iter(),
                    points: contacts.points,
                    first_point: contacts.first_point,
                    bodies: contacts.bodies,
                    share: 1.0,
                };
                run(width, warm)
            }
            Pass::SolveFirst {
                feedback,
                first,
                softness,
                measure,
            } => {
                debug_assert!(!TIED, "bonds have targets of their own");
                let sweep = Sweep::<false> {
                    contacts,
                    ties: &mut [],
                    measure,
                };
                let solve = SolveFirst {
                    sweep,
                    softness,
                    feedback,
                    first,
                };
                run(width, solve)
            }
            Pass::Solve { softness, measure } => {
                let sweep = Sweep::<TIED> {
                    contacts,
                    ties,
                    measure,
                };
                run(width, Solve(sweep, softness))
            }
            Pass::Relax { measure } => {
                let sweep = Sweep::<TIED> {
                    contacts,
                    ties,
                    measure,
                };
                run(width, Relax(sweep))
            }
            Pass::Extrapolate { weight } => {
                let extrapolate = Extrapolate::<TIED> {
                    contacts,
                    ties,
                    last,
                    weight,
                };
                run(width, extrapolate)
            }
        }
    }
}
