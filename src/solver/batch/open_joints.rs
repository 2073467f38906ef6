//! Islands whose joints stay open gain no energy.
//!
//! Where joints hold at the end of each motion by impulses along the rows of its start, these are symmetric in time and energy does not drift.
//! Where they do not, because there is no such motion or none was found, what is solved is not what moves, and nothing bounds what the difference adds up to: with few
//! sub-steps a bridge of light planks was thrown away at 10^4 m/s by a truck. There all velocities of the island are taken times the share
//! that leaves no more kinetic energy than there was before the impulses of the sub-step, and than drives have given. Joints that are solved
//! stay solved, contacts do not approach; momentum is lost.

use crate::bodies::solver_body::SolverBody;
use crate::solver::batch::Batch;
use crate::solver::batch::energy_guard::{inertia_of, mass_of};
use crate::solver::batch::layout::Member;
use std::ops::Range;

impl Batch {
    /// At the end of a sub-step.
    pub(super) fn calm_open_islands(&mut self) {
        for at in 0..self.layout.members.len() {
            let member = &self.layout.members[at];
            let joints = member.joints.clone();
            if joints.is_empty() || !self.may_gain(joints.clone()) || self.is_driven(member) {
                continue;
            }
            let given = self.joints.system.given_by_drives(joints);
            let share = self.share_without_gain(member, given);
            let bodies = member.bodies.clone();
            if share < 1.0 {
                for body in &mut self.bodies.velocities[bodies] {
                    if body.inverse_mass > 0.0 {
                        body.linear *= share;
                        body.angular *= share;
                    }
                }
            }
        }
    }

    /// Whether joints may have gained energy by being solved: those that stay open, and where no contacts hold bodies down those that were not
    /// solved along the rows of where they were.
    fn may_gain(&self, joints: Range<usize>) -> bool {
        let (system, are_alone) = (&self.joints.system, self.joints.are_alone());
        system.stay_open(joints.clone()) || are_alone && system.hold_along_end(joints)
    }

    /// The share of an island's velocities that leaves no more energy than the sub-step began with and `given`, J.
    fn share_without_gain(&self, member: &Member, given: f64) -> f32 {
        let speed = self.settings.gravity.length() * self.settings.step_dt();
        let (mut before, mut after, mut mass) = (2.0 * given, 0.0, 0.0);
        let without_contacts = |i: usize| {
            let now = self.bodies.velocities[i];
            let gain = self.bodies.contact_velocity_changes.get(i);
            gain.map_or(now, |gain| SolverBody {
                linear: now.linear - gain.linear,
                angular: now.angular - gain.angular,
                ..now
            })
        };
        for i in member.bodies.clone() {
            before += self.twice_energy(i, &without_contacts(i));
            after += self.twice_energy(i, &self.bodies.velocities[i]);
            mass += f64::from(mass_of(&self.bodies.velocities[i]));
        }
        for (number, [linear, angular]) in self.given_by_joints(member) {
            let i = number.index();
            let mut body = without_contacts(i);
            before -= self.twice_energy(i, &body);
            body.linear -= linear;
            body.angular -= angular;
            before += self.twice_energy(i, &body);
        }
        let allowed = f64::max(before, mass * f64::from(speed * speed));
        if after <= allowed {
            return 1.0;
        }
        (allowed / after).sqrt() as f32
    }

    /// Twice the kinetic energy of a body at a velocity, J.
    fn twice_energy(&self, body: usize, at: &SolverBody) -> f64 {
        let linear = mass_of(at) * at.linear.length_squared();
        let inertia = inertia_of(&self.bodies.masses[body]);
        let angular = inertia.map_or(0.0, |inertia| (inertia * at.angular).dot(at.angular));
        f64::from(linear) + f64::from(angular)
    }
}
