//! Swings of light links under heavy loads, which sub-steps do not follow: where joints are alone, and the user has not fixed the number of sub-steps.

use crate::joints::store::JointRecord;
use crate::solver::batch::Batch;
use glam::Vec3;
use smallvec::SmallVec;

impl Batch {
    fn holds_swings_back(&self) -> bool {
        self.joints.are_alone() && self.settings.depends_on_load()
    }

    /// Has joints know what they bore; `joints`: those of the step.
    pub(super) fn load_tensions(&mut self, joints: &[JointRecord]) {
        let is_asked = self.holds_swings_back();
        let own = self.joints.system.joints.iter_mut();
        for (joint, &(index, _)) in own.zip(&self.layout.joints) {
            let known = joints[index as usize].tension;
            joint.tension = if is_asked { known } else { Vec3::ZERO };
        }
    }

    /// Takes note of what they bear, before the rows are written anew.
    pub(super) fn note_tensions(&mut self) {
        if self.holds_swings_back() {
            let h = self.settings.substep_dt.into();
            self.joints.system.note_tensions(h);
        }
    }

    /// Gives components that nothing holds the angular momentum back that joints took from it by inertia that bodies do not have.
    pub(super) fn give_back_spin(&mut self) {
        if !self.joints.system.has_borrowed_spin() {
            return;
        }
        self.fetch_velocities();
        self.joints.system.note_borrowed_spin(1.0);
        let turns: SmallVec<[_; 4]> = self.joints.system.borrowed_turns().collect();
        for (component, turn) in &turns {
            self.add_motion(*component, turn, 1.0);
        }
        self.fetch_velocities();
    }
}
