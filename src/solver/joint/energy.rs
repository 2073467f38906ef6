//! Which joints may gain energy in a sub-step, and what drives have given in it.

use crate::solver::joint::row::{JointRow, RowKind, RowState};
use crate::solver::joint::system::{BatchJoint, JointSystem};
use std::ops::Range;

impl JointSystem {
    /// Whether some of these joints are among components that do not hold at the end of the motion.
    pub(crate) fn stay_open(&self, joints: Range<usize>) -> bool {
        let mut joints = self.joints[joints].iter();
        joints.any(|joint| self.rounds.leave_open(joint.component))
    }

    /// Whether some do by impulses along the rows of its end, which are not symmetric in time.
    pub(crate) fn hold_along_end(&self, joints: Range<usize>) -> bool {
        let mut joints = self.joints[joints].iter();
        joints.any(|joint| self.rounds.is_along_end(joint.component))
    }

    /// Whether some come back from the ends of their ranges, as fast as they came by the rows that they had before the motion.
    pub(crate) fn come_back(&self, joints: Range<usize>) -> bool {
        let rows = |joint: &BatchJoint| &self.rows[joint.rows.clone()];
        let mut joints = self.joints[joints].iter();
        joints.any(|joint| rows(joint).iter().any(JointRow::comes_back))
    }

    /// What motors and springs of these joints have given in the sub-step, J, those that have taken some not counted.
    pub(crate) fn given_by_drives(&self, joints: Range<usize>) -> f64 {
        let of_joint = |joint: &BatchJoint| -> f64 {
            let rows = self.rows[joint.rows.clone()].iter();
            let drives =
                rows.filter(|row| matches!(row.kind, RowKind::Velocity(_) | RowKind::Spring(_)));
            let given = drives.map(|row| {
                let now = row.velocity(joint.velocities(&self.velocities));
                0.5 * (row.spent + row.impulse) * (row.velocity_before + now)
            });
            given.map(|given| given.max(0.0)).sum()
        };
        self.joints[joints].iter().map(of_joint).sum()
    }
}

impl JointRow {
    /// Whether it gives speed away from the end of a range.
    pub(super) fn comes_back(&self) -> bool {
        let is_rebound = self.kind == RowKind::Limit && self.restitution > 0.0;
        is_rebound && self.state == RowState::Free && self.side * self.target > 0.0
    }
}
