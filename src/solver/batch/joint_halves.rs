//! Sub-steps that joints cannot follow are made in halves.

use crate::solver::batch::Batch;

/// How often a sub-step in which no motion is found for the joints is halved.
const MOST_HALVINGS: u32 = 5;

impl Batch {
    /// Remembers the velocities before a sub-step of joints alone.
    pub(crate) fn remember_start(&mut self) {
        if self.joints.are_alone() {
            self.joints.start.clone_from(&self.bodies.velocities);
        }
    }

    /// Whether the sub-step is to be made in halves: joints are alone, and no motion was found at whose end they hold. Where the shortest ones
    /// do not help either there is none, and nothing more is halved in the step.
    pub(crate) fn loses_joints(&mut self) -> bool {
        let joints = &mut self.joints;
        let is_lost = joints.are_alone() && joints.system.is_lost();
        joints.halving_fails |= is_lost && joints.halvings == MOST_HALVINGS;
        is_lost && !joints.halving_fails
    }

    /// Takes back a sub-step whose bodies have not moved yet; what follows until [`end_halves`](Self::end_halves) is half as long.
    pub(crate) fn begin_halves(&mut self) {
        self.bodies.velocities.clone_from(&self.joints.start);
        self.joints.halvings += 1;
        self.settings.substep_dt *= 0.5;
        self.settings.substeps *= 2;
        self.joints
            .system
            .take_back(self.settings.substep_dt.into());
    }

    /// Goes on with sub-steps as they were.
    pub(crate) fn end_halves(&mut self) {
        self.joints.halvings -= 1;
        self.settings.substep_dt *= 2.0;
        self.settings.substeps /= 2;
    }
}
