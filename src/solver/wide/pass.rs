//! Passes over blocks of eight manifolds: what is done to all contacts, and which kernel does it.

use crate::simd::dispatch::run;
use crate::simd::lanes::{F8, WIDTH};
use crate::solver::rows::soft_step::{Bias, RowSoftness};
use crate::solver::wide::bias::{UpdateBias, Warm};
use crate::solver::wide::bond::BondConstraint;
use crate::solver::wide::contacts::ContactBlocks;
use crate::solver::wide::extrapolate::Extrapolate;
use crate::solver::wide::sweep::{RelaxKernel, SolveFirstKernel, SolveKernel, Sweep};

/// What is done to all contacts.
#[derive(Clone, Copy, Debug)]
pub enum Pass {
    /// Sets the target velocities from the displacements of the bodies since the start of the step. Of a sub-step that is not
    /// the `is_first`, the impulses of the one before are added to the total.
    UpdateBias {
        /// How overlap is pushed out.
        bias: Bias,
        /// Whether the step begins.
        is_first: bool,
    },
    /// Adds `M^-1 J^T lambda` of the impulses found in the points to the velocities: the warm start.
    Warm,
    /// One sweep with position bias, friction before the normal. With `measure`, tells the largest velocity change of a row
    /// in units of its [speed scale](crate::solver::rows::contact_rows::PointRows::speed_scale), else 0.
    Solve {
        /// Compliance.
        softness: RowSoftness,
        /// Whether to measure.
        measure: bool,
    },
    /// [`UpdateBias`](Self::UpdateBias) and the first [`Solve`](Self::Solve) in one go through the contacts, with the same outcome;
    /// not where there are bonds.
    SolveFirst {
        /// How overlap is pushed out.
        bias: Bias,
        /// Whether the step begins.
        is_first: bool,
        /// Compliance.
        softness: RowSoftness,
        /// Whether to measure.
        measure: bool,
    },
    /// One sweep without position bias, the normal before friction. Points that are pushed stop, others may close their
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

impl ContactBlocks<'_> {
    /// Does a pass; returns the largest velocity change if it is measured, else 0. `last`: where the impulses were before an
    /// extrapolation, and then where they are; of no use to other passes.
    pub fn pass(&mut self, pass: Pass, last: &mut [[F8; 3]]) -> f32 {
        self.run::<false>(pass, last, &mut [])
    }

    /// Does a pass with bonds: `bond_constraints` are those of the points.
    pub fn pass_bonded(
        &mut self,
        pass: Pass,
        last: &mut [[F8; 3]],
        bond_constraints: &mut [BondConstraint],
    ) -> f32 {
        self.run::<true>(pass, last, bond_constraints)
    }

    fn run<const BONDED: bool>(
        &mut self,
        pass: Pass,
        last: &mut [[F8; 3]],
        bond_constraints: &mut [BondConstraint],
    ) -> f32 {
        let width = self.width;
        let contacts = self;
        match pass {
            Pass::UpdateBias { bias, is_first } => {
                let targets = UpdateBias::<BONDED> {
                    contacts,
                    bond_constraints,
                    bias,
                    is_first,
                };
                run(width, targets)
            }
            Pass::Warm => run(width, Warm::all(contacts)),
            Pass::SolveFirst {
                bias,
                is_first,
                softness,
                measure,
            } => {
                debug_assert!(!BONDED, "bonds have targets of their own");
                let sweep = Sweep::<false>::new(contacts, &mut [], measure);
                let solve = SolveFirstKernel {
                    sweep,
                    softness,
                    bias,
                    is_first,
                };
                run(width, solve)
            }
            Pass::Solve { softness, measure } => {
                let sweep = Sweep::<BONDED>::new(contacts, bond_constraints, measure);
                run(width, SolveKernel(sweep, softness))
            }
            Pass::Relax { measure } => {
                let sweep = Sweep::<BONDED>::new(contacts, bond_constraints, measure);
                run(width, RelaxKernel(sweep))
            }
            Pass::Extrapolate { weight } => {
                let extrapolate = Extrapolate::<BONDED> {
                    contacts,
                    bond_constraints,
                    last,
                    weight: F8([weight; WIDTH]),
                };
                run(width, extrapolate)
            }
        }
    }
}
