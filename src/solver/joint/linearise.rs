//! The rows of all joints where the bodies are now, and which bodies are eliminated by them.

use crate::simd::dispatch::run;
use crate::simd::lanes::{Kernel, Lanes};
use crate::solver::joint::measure::Frames;
use crate::solver::joint::rows::add_rows;
use crate::solver::joint::sparsity::Elimination;
use crate::solver::joint::system::{BatchJoint, JointEndpoint, JointSystem};
use crate::solver::joint::vector6::{Vector6, split};
use glam::{DMat3, DVec3};

impl JointSystem {
    /// Finds by the rows of which joints each body is eliminated: those with what comes later, and with what joints do not move.
    pub(super) fn find_links(&mut self) {
        let Self {
            sparsity,
            joints,
            link_starts,
            link_joints,
            ..
        } = self;
        let place = |end| match end {
            JointEndpoint::Jointed(body) => sparsity.position[body as usize],
            JointEndpoint::Fixed(_) => u32::MAX,
        };
        let place_of = |joint: &BatchJoint| joint.link.map(|side| place(joint.ends[side]) as usize);
        link_starts.clear();
        link_starts.resize(sparsity.order.len() + 1, 0);
        for joint in joints.iter_mut() {
            let [a, b] = joint.ends.map(place);
            let (side, first) = if a < b { (0, a) } else { (1, b) };
            let elimination = sparsity.eliminations.get(first as usize);
            let is_link = matches!(elimination, Some(Elimination::Rows(_)));
            joint.link = is_link.then_some(side);
            if is_link {
                link_starts[first as usize] += 1;
            }
        }
        let mut end = 0;
        for start in link_starts.iter_mut() {
            end += *start;
            *start = end;
        }
        link_joints.clear();
        link_joints.resize(end as usize, 0);
        for (number, joint) in joints.iter().enumerate().rev() {
            if let Some(at) = place_of(joint) {
                link_starts[at] -= 1;
                link_joints[link_starts[at] as usize] = number as u32;
            }
        }
    }

    /// Writes the rows anew for where the bodies are now; those that were there keep their impulses.
    pub(crate) fn linearise(&mut self) {
        run(self.width, Linearise(self));
    }

    #[inline(always)]
    fn write_rows(&mut self) {
        self.is_factored = false;
        for body in &mut self.bodies {
            body.rotation = body.spin.rotation.as_dquat().normalize();
            let axes = DMat3::from_quat(body.rotation * body.frame);
            let across = axes.transpose();
            let tensor = |moments: DVec3| {
                let [x, y, z] = [0, 1, 2].map(|i| axes.col(i) * moments[i]);
                DMat3::from_cols(x, y, z) * across
            };
            body.inertia = tensor(body.principal);
            body.inverse_inertia = tensor(body.principal.recip());
        }
        std::mem::swap(&mut self.rows, &mut self.old_rows);
        self.rows.clear();
        for at in 0..self.joints.len() {
            let joint = &self.joints[at];
            let (a, b) = (self.place(joint.ends[0]), self.place(joint.ends[1]));
            let frames = Frames::of([&a, &b], joint.anchors, joint.frames, joint.has_angles);
            let (first, old) = (self.rows.len(), joint.rows.clone());
            for measure in &frames.measure(&joint.joint, joint.angle) {
                let mobility = self.mobility(joint, &measure.jacobian);
                add_rows(&mut self.rows, &joint.joint, measure, mobility);
            }
            let old = &self.old_rows[old];
            let rows = &mut self.rows[first..];
            for row in rows.iter_mut() {
                let before = old.iter().find(|old| old.slot == row.slot);
                if let Some(before) = before {
                    row.state = before.state;
                    row.impulse = before.impulse;
                    row.spent = before.spent;
                    row.curve = before.curve;
                    row.bounds = before.bounds;
                    row.velocity_before = before.velocity_before;
                }
            }
            if joint.pair().is_none() {
                let fixed = joint.ends.map(|end| self.fixed_velocity(end));
                for row in &mut self.rows[first..] {
                    let still = [fixed[0].as_ref(), fixed[1].as_ref()];
                    row.fixed_velocity = row.velocity(still);
                }
            }
            let joint = &mut self.joints[at];
            joint.rows = first..self.rows.len();
            if joint.has_angles {
                joint.angle = frames.twist(joint.angle);
            }
            joint.now = Some(frames);
        }
        self.has_springs = self.rows.iter().any(|row| !row.is_rigid());
    }

    fn fixed_velocity(&self, end: JointEndpoint) -> Option<Vector6> {
        match end {
            JointEndpoint::Jointed(_) => None,
            JointEndpoint::Fixed(body) => Some(self.fixed[body as usize].velocity),
        }
    }

    /// `J M^-1 J^T`, 1/kg.
    #[inline(always)]
    fn mobility(&self, joint: &BatchJoint, jacobian: &[Vector6; 2]) -> f64 {
        let of = |side: usize| {
            let JointEndpoint::Jointed(body) = joint.ends[side] else {
                return 0.0;
            };
            let body = &self.bodies[body as usize];
            let [linear, angular] = split(&jacobian[side]);
            linear.length_squared() / body.mass + angular.dot(body.inverse_inertia * angular)
        };
        of(0) + of(1)
    }
}

/// Writes the rows anew.
struct Linearise<'a>(&'a mut JointSystem);

impl Kernel for Linearise<'_> {
    type Output = ();
    const NEEDS_32_REGISTERS: bool = false;

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.0.write_rows();
    }
}
