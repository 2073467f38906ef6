//! What joints have done at the end of a sub-step and of a step: their part of the energy, what they bore, how far they are from solved.

use crate::joints::store::JointRecord;
use crate::solver::batch::Batch;
use crate::solver::batch::joints::velocity_of;
use crate::solver::batch::layout::Member;
use crate::solver::graph::indices::BodyNumber;
use crate::solver::joint::system::JointEndpoint;
use crate::solver::joint::vector6::Vector6;
use crate::solver::rows::residual::SolvedRow;
use glam::Vec3;

impl Batch {
    /// After the last sweep of a sub-step: what joints have given is none of what contacts have.
    pub(crate) fn set_joints_apart(&mut self) {
        let begin = &mut self.bodies.contact_velocity_changes;
        if begin.is_empty() || !self.joints.any() {
            return;
        }
        for (number, given) in self.joints.numbers.iter().zip(&self.joints.given) {
            let begin = &mut begin[number.body.index()];
            begin.linear += given.linear;
            begin.angular += given.angular;
        }
    }

    /// Ends a sub-step; `is_last`: of the step.
    pub(crate) fn end_joints(&mut self, is_last: bool) {
        if !self.joints.any() {
            return;
        }
        if std::mem::take(&mut self.joints.is_disturbed) {
            self.solve_joints();
        }
        self.give_back_spin();
        self.calm_open_islands();
        let are_alone = self.joints.are_alone();
        self.joints.system.end_substep(are_alone);
        if is_last {
            self.joints.system.spread_impulses();
        }
    }

    /// What joints have given to the bodies of an island in the sub-step, m/s and rad/s.
    pub(crate) fn given_by_joints(
        &self,
        member: &Member,
    ) -> impl Iterator<Item = (BodyNumber, [Vec3; 2])> + use<'_> {
        let bodies = member.bodies.clone();
        let given = self.joints.numbers.iter().zip(&self.joints.given);
        let own = given.filter(move |(number, _)| bodies.contains(&number.body.index()));
        own.map(|(number, given)| (number.body, [given.linear, given.angular]))
    }

    /// The rows of an island's joints as they are solved.
    pub(crate) fn solved_joint_rows(
        &self,
        member: &Member,
    ) -> impl Iterator<Item = SolvedRow> + Clone + use<'_> {
        let system = &self.joints.system;
        let joints = system.joints.get(member.joints.clone()).unwrap_or(&[]);
        joints.iter().flat_map(move |joint| {
            let velocities = joint.ends.map(|end| self.velocity_of_end(end));
            let rows = system.rows[joint.rows.clone()].iter();
            rows.filter_map(move |row| {
                let error = row.velocity_error(velocities.each_ref().map(Option::as_ref))?;
                Some(SolvedRow {
                    impulse: row.impulse,
                    velocity_error: error,
                    diagonal: row.mobility,
                    bounds: row.bounds,
                })
            })
        })
    }

    /// Velocity of an end of a joint that joints move, as it is in the batch.
    fn velocity_of_end(&self, end: JointEndpoint) -> Option<Vector6> {
        match end {
            JointEndpoint::Jointed(body) => {
                let number = self.joints.numbers[body as usize].body;
                Some(velocity_of(&self.bodies.velocities[number.index()]))
            }
            JointEndpoint::Fixed(_) => None,
        }
    }

    /// Takes back what the joints bore; `joints`: those of the step.
    pub(crate) fn store_joints(&self, joints: &mut [JointRecord]) {
        let system = &self.joints.system;
        let step_dt = self.settings.step_dt();
        for ((index, _), joint) in self.layout.joints.iter().zip(&system.joints) {
            let record = &mut joints[*index as usize];
            let [force, torque] = joint.impulse.map(|impulse| impulse.as_vec3() / step_dt);
            record.load.force = force;
            record.load.torque = torque;
            record.load.error = joint.error.map(|error| error as f32);
            record.load.angle = system.angle(joint) as f32;
            let translation = joint.now.as_ref().map(|now| now.translation().as_vec3());
            record.load.translation = translation.unwrap_or_default();
            record.tension = joint.tension;
            record.stored_energy = 0.0;
            for row in &system.rows[joint.rows.clone()] {
                record.stored_energy += row.stored_energy() as f32;
            }
        }
    }
}
