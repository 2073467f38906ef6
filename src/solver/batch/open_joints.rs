//! Islands whose joints stay open gain no energy.
//!
//! Where joints hold at the end of each motion by impulses along the rows of its start, these are symmetric in time and energy does not drift.
//! Where they do not, because there is no such motion or none was found, what is solved is not what moves, and nothing bounds what the difference adds up to: with few
//! sub-steps a bridge of light planks was thrown away at 10^4 m/s by a truck. There all velocities of the island are taken times the share
//! that leaves no more kinetic energy than there was before the impulses of the sub-step, and than drives have given. Joints that are solved
//! stay solved, contacts do not approach. What nothing holds keeps its momentum, linear and angular: there it is the velocities against the motion that
//! all of it would have as one rigid body ([`RigidMotion`](crate::solver::joint::rigid::RigidMotion)). Of 1000 free trees of joints 200 lost some, up to nine tenths of it, while all velocities were
//! taken times that share.

use crate::bodies::solver_body::SolverBody;
use crate::solver::batch::Batch;
use crate::solver::batch::energy_guard::{inertia_of, mass_of};
use crate::solver::batch::layout::Member;
use crate::solver::joint::rigid::RigidMotion;
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
            self.fetch_velocities();
            let kept = self.kept_motion(joints);
            let share = self.share_without_gain(&self.layout.members[at], kept.as_ref());
            if share < 1.0 {
                self.calm(at, kept, share);
            }
        }
    }

    /// Leaves a share of an island's velocities, but for those that it keeps. What joints bore is with that.
    fn calm(&mut self, island: usize, kept: Option<(u32, RigidMotion)>, share: f32) {
        let bodies = self.layout.members[island].bodies.clone();
        for body in &mut self.bodies.velocities[bodies] {
            if body.inverse_mass > 0.0 {
                body.linear *= share;
                body.angular *= share;
            }
        }
        if let Some((component, motion)) = kept {
            self.add_motion(component, &motion, 1.0 - share);
        }
        self.fetch_velocities();
    }

    /// The motion that an island of these joints keeps, whatever they do, and its component; none if something else holds it.
    fn kept_motion(&self, mut joints: Range<usize>) -> Option<(u32, RigidMotion)> {
        if !self.joints.are_alone() {
            return None;
        }
        let system = &self.joints.system;
        let component = system.joints[joints.next()?].component();
        let motion = system.free_motion(component)?;
        Some((component, motion))
    }

    /// Adds a share of a motion to the bodies of a component.
    pub(super) fn add_motion(&mut self, component: u32, motion: &RigidMotion, share: f32) {
        let system = &self.joints.system;
        for (at, number) in self.joints.numbers.iter().enumerate() {
            if system.is_of(at, component) {
                let [linear, angular] = motion.at(system.bodies[at].center);
                let body = &mut self.bodies.velocities[number.body.index()];
                body.linear += share * linear.as_vec3();
                body.angular += share * angular.as_vec3();
            }
        }
    }

    /// Whether joints may have gained energy by being solved: those that stay open, and where no contacts hold bodies down those that were not
    /// solved along the rows of where they were, and those that come back from the ends of their ranges: with what these rows were before bodies turned,
    /// and friction besides, a tree of 3 cm at 1 m/s came to 10^7 m/s.
    fn may_gain(&self, joints: Range<usize>) -> bool {
        let (system, are_alone) = (&self.joints.system, self.joints.are_alone());
        system.stay_open(joints.clone())
            || are_alone
                && (system.swing_fast(joints.clone())
                    || system.hold_along_end(joints.clone())
                    || system.come_back(joints))
    }

    /// The share of an island's velocities, but for those that it keeps, that leaves no more energy than the sub-step began with and drives have given, J.
    fn share_without_gain(&self, member: &Member, kept: Option<&(u32, RigidMotion)>) -> f32 {
        let given = self.joints.system.given_by_drives(member.joints.clone());
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
        let kept = kept.map_or(0.0, |(_, motion)| motion.twice_energy);
        let allowed = f64::max(before - kept, mass * f64::from(speed * speed));
        let after = after - kept;
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
