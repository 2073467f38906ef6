//! A sub-step by the exact method.

use crate::bodies::solver_body::BodyMass;
use crate::bodies::solver_body::SolverBody;
use crate::solver::batch::Batch;
use crate::solver::exact;
use crate::solver::exact::ExactScratch;
use crate::solver::rows::contact_rows::PointRows;
use crate::solver::rows::soft_step;
use crate::solver::rows::soft_step::RowSoftness;
use crate::solver::wide::pass::Pass;
use glam::Mat3;

/// Sweeps where the exact method has no answer.
const UNCERTIFIED_SWEEPS: u32 = 200;

/// Velocity of position bias, m/s, that is not worth taking out again.
const NEGLIGIBLE_SPEED: f32 = 1e-4;

/// Buffers of the exact method.
#[derive(Debug, Default)]
pub(crate) struct ExactBuffers {
    solver: ExactScratch,
    /// Points of the batch as rows.
    rows: Vec<PointRows>,
    /// Inverse inertia tensors of the bodies, world axes, 1/(kg m2).
    inertia: Vec<Mat3>,
    /// Velocities without contact impulses.
    pub(crate) free: Vec<SolverBody>,
}

impl Batch {
    /// Solves to rounding from the velocities that the bodies have without contacts.
    pub(crate) fn solve_exactly(&mut self) {
        self.scratch.exact.free.clear();
        self.scratch
            .exact
            .free
            .extend_from_slice(&self.bodies.velocities);
        self.solve_from_free();
    }

    /// Solves to rounding from the free velocities. What cannot be certified (there may be no solution with friction) is not
    /// used: sweeps, which never gain energy, have the word then.
    fn solve_from_free(&mut self) {
        let mut rows = std::mem::take(&mut self.scratch.exact.rows);
        rows.clear();
        self.collect_rows(0..self.layout.places.len(), 0, &mut rows);
        let scratch = &mut self.scratch.exact;
        scratch.rows = rows;
        scratch.inertia.clear();
        let inertia = self.bodies.masses.iter().map(BodyMass::inverse_inertia);
        scratch.inertia.extend(inertia);
        let certificate = exact::solve(
            &mut scratch.rows,
            &mut self.bodies.velocities,
            &scratch.inertia,
            self.settings.friction,
            &mut scratch.solver,
        );
        self.budget.sweeps += certificate.iterations;
        if certificate.converged {
            return self.take_impulses_of_rows();
        }
        self.bodies
            .velocities
            .copy_from_slice(&self.scratch.exact.free);
        self.pass(Pass::Warm, None);
        let softness = RowSoftness::HARD;
        for _ in 0..UNCERTIFIED_SWEEPS {
            let measure = false;
            self.pass(Pass::Solve { softness, measure }, None);
        }
        self.budget.sweeps += UNCERTIFIED_SWEEPS;
        self.budget.is_unconverged = true;
    }

    fn take_impulses_of_rows(&mut self) {
        let mut rows = self.scratch.exact.rows.iter();
        for &(_, place) in &self.layout.places {
            let (block, lane) = (
                &self.contacts.blocks[place.block as usize],
                place.lane as usize,
            );
            let count = place.count as usize;
            let points = &mut self.contacts.points[block.points.clone()][..count];
            for (point, rows) in points.iter_mut().zip(&mut rows) {
                for (lanes, impulse) in point.impulse.iter_mut().zip(rows.impulses()) {
                    lanes.0[lane] = impulse;
                }
            }
        }
    }

    /// Solves the rows once more from the free velocities, with what they should have after the motion.
    pub(crate) fn relax_exactly(&mut self) {
        let mut difference = 0.0_f32;
        for (i, point) in self.contacts.points.iter_mut().enumerate() {
            for (lane, target_velocity) in point.target_velocity.0.iter_mut().enumerate() {
                let constraint = self.bonds.constraints.get_mut(i);
                if let Some(constraint) =
                    constraint.filter(|constraint| constraint.adhesion.0[lane] > 0.0)
                {
                    difference = difference.max(constraint.relax(lane, target_velocity));
                    continue;
                }
                let rebound = self
                    .impacts
                    .points
                    .get(i)
                    .map_or(0.0, |impact| impact.rebound.0[lane]);
                let relaxed = soft_step::relaxed_velocity(
                    rebound,
                    point.impulse[0].0[lane],
                    *target_velocity,
                );
                difference = difference.max((*target_velocity - relaxed).abs());
                *target_velocity = relaxed;
            }
        }
        if difference > NEGLIGIBLE_SPEED {
            self.bodies
                .velocities
                .copy_from_slice(&self.scratch.exact.free);
            self.solve_from_free();
        }
    }
}
