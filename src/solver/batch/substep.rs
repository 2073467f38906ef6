//! One step of one island: forces, rows, motion, as many times as there are sub-steps.
//!
//! Contact geometry is found once per step. Within it, a point's gap follows the motion of the two bodies along the
//! frozen normal, `s = s_0 + J q` with the displacements `q`; where bodies move fast against each other, or turn, the rows
//! are pointed anew at each sub-step. [`Batch::substep`] is the sub-step; each of its lines is a file of this room.

use crate::bodies::store::Bodies;
use crate::contact::manifolds::Manifolds;
use crate::solver::batch::Batch;
use crate::solver::batch::sweeps::SweepKind;
use crate::solver::batch::targets::Targets;
use crate::threads::team::Team;

impl Batch {
    /// Advances the batch by a step, or gives up when a body of it breaks.
    pub fn solve(&mut self, (manifolds, bodies): (&Manifolds, &Bodies), team: Option<&Team>) {
        self.forget_contact_velocity_changes();
        let substeps = self.settings.substeps;
        for substep in 0..substeps {
            if substep > 0 {
                self.reanchor_with_contact_velocity_changes(team);
            }
            self.budget.begin(substeps - substep);
            self.lone.begin_substep(substeps - substep);
            let is_last = substep + 1 == substeps;
            self.substep([substep == 0, is_last], manifolds, team);
            let is_looked_at = is_last || self.impacts.may_break && self.impacts.can_hit();
            if is_looked_at && self.find_overloaded(manifolds, bodies) {
                self.impacts.is_broken = self.impacts.may_break;
            }
            if self.impacts.is_broken {
                return;
            }
        }
        self.note_strains(manifolds, bodies);
    }

    /// One sub-step of `h` seconds; whether it is the first and the last of the step. One for which no motion is found at whose end joints
    /// hold is taken back and made in halves.
    ///
    /// ```text
    /// v += h (g + a)     gravity, and what drives some bodies
    /// targets            gaps and overlaps -> velocities that the rows should have; what hits; rebounds
    /// warm start, solve  the impulses of the sub-step before; sweeps with soft contacts, exact solutions for joints
    /// q += h v           with what it takes for the joints to hold then
    /// reanchor           the rows of what hits act where the bodies are now
    /// relax              takes the velocity that pushed overlap out from the bodies again; impacts rebound
    /// guard energy       contacts leave no more energy than there was; joints hold again where that took something
    /// warm start         goes back to what contacts bore before an impact
    /// free rotation
    /// ```
    fn substep(
        &mut self,
        [is_first, is_last]: [bool; 2],
        manifolds: &Manifolds,
        team: Option<&Team>,
    ) {
        self.remember_start();
        self.apply_drives();
        self.apply_gravity(team);
        let targets = self.set_targets(is_first, team);
        self.solve_with_bias(is_first, &targets, team);
        self.keep_joints_together();
        if self.loses_joints() {
            self.begin_halves();
            for is_second in [false, true] {
                self.substep([false, is_last && is_second], manifolds, team);
            }
            return self.end_halves();
        }
        self.restrain_driven();
        self.move_bodies(manifolds, team);
        self.turn_jointed_bodies(is_last);
        self.reanchor_hits(&targets, team);
        self.relax(&targets, team);
        self.set_joints_apart();
        self.restrain_driven();
        self.note_contact_velocity_changes(team);
        self.end_joints(is_last);
        self.restore_hits(&targets);
        self.turn_bodies(&targets, team);
    }

    /// Finds impulses with which the rows have their target velocities.
    fn solve_with_bias(&mut self, is_first: bool, targets: &Targets, team: Option<&Team>) {
        if self.joints.are_alone() {
            self.begin_joints(is_first);
            return self.solve_joints();
        }
        #[cfg(feature = "exact")]
        if self.settings.is_exact() {
            self.begin_joints(is_first);
            self.solve_exactly();
            return self.solve_joints();
        }
        self.warm_start(team);
        self.begin_joints(is_first);
        // Contacts see bodies that joints hold.
        self.solve_joints();
        let sweeps = self.settings.sweeps;
        self.sweep(sweeps, targets.solve, targets.tolerance, team);
    }

    /// Finds impulses that leave no velocity of what pushed overlap out.
    fn relax(&mut self, targets: &Targets, team: Option<&Team>) {
        let sweeps = self.settings.relax_sweeps;
        if sweeps == 0 || self.joints.are_alone() {
            return self.solve_joints();
        }
        #[cfg(feature = "exact")]
        if self.settings.is_exact() {
            self.relax_exactly();
            return self.solve_joints();
        }
        self.sweep(sweeps, SweepKind::Relax, targets.tolerance, team);
    }
}
