//! What joints of trees bear in a half of a sub-step whose motion was found along the rows of its end, or whose energy may have been bounded.
//!
//! There the impulse of a row acted partly along the row as it was and partly along what it became, or not all of it was left. But what bodies have got is
//! known, and in a tree that says it all: what a body got and what those that hang on it took, it got by the one joint on which it hangs
//! itself. Told by their rows, joints of trees that whip bore up to 20 times less or more than their bodies got.

use crate::solver::joint::body::JointedBody;
use crate::solver::joint::row::JointRow;
use crate::solver::joint::system::{BatchJoint, JointEndpoint, JointSystem};
use crate::solver::joint::vector6::{Vector6, add_scaled, join, split};
use glam::DVec3;

impl JointSystem {
    /// Whether what a joint bears is told by bodies.
    #[inline(always)]
    pub(super) fn is_passed(&self, joint: &BatchJoint) -> bool {
        self.borne.is_passed[joint.component as usize]
    }

    /// Finds the components whose joints are told by bodies; whether there are any.
    fn find_passed(&mut self) -> bool {
        let is_passed = &mut self.borne.is_passed;
        let is_calmed = |number| self.rounds.is_along_end(number) || self.rounds.leave_open(number);
        is_passed.clear();
        is_passed.extend((0..self.components.len() as u32).map(is_calmed));
        if self.has_bounds {
            for joint in &self.joints {
                let comes_back = self.rows[joint.rows.clone()]
                    .iter()
                    .any(JointRow::comes_back);
                is_passed[joint.component as usize] |= comes_back;
            }
        }
        // Inertia that bodies do not have bears something of what rows bear.
        if self.stiffening.is_any {
            for (body, &component) in self.bodies.iter().zip(&self.sparsity.components) {
                is_passed[component as usize] |= body.is_stiffened();
            }
        }
        // Of loops bodies do not say it.
        if self.borne.any {
            for (is_passed, is_loop) in is_passed.iter_mut().zip(&self.borne.is_loop) {
                *is_passed &= !is_loop;
            }
        }
        is_passed.contains(&true)
    }

    /// Has joints bear what their bodies got, where rows do not say it; whether there are such joints.
    #[inline(always)]
    pub(super) fn note_passed(&mut self) -> bool {
        let is_asked = self.find_passed();
        // What holds a body along its locked axes is no joint.
        let is_locked = |body: &JointedBody| body.locks != [DVec3::ZERO; 2];
        if !is_asked || self.bodies.iter().any(is_locked) {
            return false;
        }
        let mut passed = std::mem::take(&mut self.borne.passed);
        passed.clear();
        let velocities = self.velocities.iter().zip(&self.borne.before);
        passed.extend(
            self.bodies
                .iter()
                .zip(velocities)
                .map(|(body, (now, before))| {
                    let change = std::array::from_fn(|i| now[i] - before[i]);
                    body.momentum(&change)
                }),
        );
        for at in 0..self.sparsity.order.len() {
            let body = self.sparsity.order[at] as usize;
            let links = self.link_starts[at] as usize..self.link_starts[at + 1] as usize;
            for link in links {
                let number = self.link_joints[link] as usize;
                if self.is_passed(&self.joints[number]) {
                    let got = passed[body];
                    self.joints[number].pass_on(&got, &mut passed);
                }
            }
        }
        self.borne.passed = passed;
        true
    }
}

impl BatchJoint {
    /// Bears what the body that hangs on it got by it, which is what the other one took.
    #[inline(always)]
    fn pass_on(&mut self, got: &Vector6, passed: &mut [Vector6]) {
        let (Some(now), Some(side)) = (&self.now, self.link) else {
            return;
        };
        let [linear, angular] = split(got);
        let sign = [-1.0, 1.0][side];
        // From the center of mass of the body to B's anchor, and from that of the other one to the body.
        let b_from_a = now.r[0] + now.d - now.r[1];
        let to_anchor = [now.r[0] + now.d, now.r[1]][side];
        if let JointEndpoint::Jointed(other) = self.ends[1 - side] {
            let taken = join(linear, angular + (sign * b_from_a).cross(linear));
            add_scaled(&mut passed[other as usize], 1.0, &taken);
        }
        self.impulse[0] += sign * linear;
        self.impulse[1] += sign * (angular - to_anchor.cross(linear));
    }
}
