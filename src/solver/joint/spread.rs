//! What joints in loops bear.
//!
//! Where bodies are held by more rows than they can move along, impulses of any size balance each other, and rounding of places makes some: a door
//! on two hinges was told to bear a thousand times its weight, and broke by it. Where they are held by as many, in a loop, what is eliminated first
//! hands on the stiffness of its rows, and impulses come out with half of their digits. Motion is the same either way. So what is told is not what
//! rows have got, but what bodies have: the impulses of joints on each body in the step, by its velocities, spread over the rows that hold it such
//! that they are least, each measured by its stiffness:
//!
//! ```text
//! p = sum M (v - v_before) - J_o^T mu_o,    (M + J^T K J) x = -p,    mu = -K J x
//! ```
//!
//! with the other rows `o`, springs and what is at its bounds, whose impulses are known. `K` is 1e6 times `M` here, so that `J^T mu` is `p` to 1e-6. With the
//! 1e8 of the rows themselves it would be more exact, and what is none of the joints' would come in: balls in a line hold a torque about it by
//! the rounding that keeps them from a line, 1e-7 of their distance, and what bodies have got about it by rounding made 60 times a weight of that.

use crate::simd::dispatch::run;
use crate::simd::lanes::{Kernel, Lanes};
use crate::solver::joint::row::{JointRow, RowState};
use crate::solver::joint::system::{BatchJoint, JointEndpoint, JointSystem};
use crate::solver::joint::vector6::{Vector6, add_scaled, product, split};

/// How much less stiff rows are than when they are solved; a power of two, so that nothing is left of it.
const STIFFNESS: f64 = 1.0 / 128.0;

impl JointSystem {
    /// Finds the components whose joints are no tree: there are more than hang each body on another one, or on what does not move.
    pub(super) fn find_loops(&mut self) {
        let count = self.sparsity.component_count;
        let spread = &mut self.borne;
        spread.spare.clear();
        spread.spare.resize(count, 0);
        spread.is_held.clear();
        spread.is_held.resize(count, false);
        for &component in &self.sparsity.components {
            spread.spare[component as usize] += 1;
        }
        for joint in &self.joints {
            let component = joint.component as usize;
            spread.spare[component] -= 1;
            spread.is_held[component] |= joint.pair().is_none();
        }
        let spare = spread.spare.iter().zip(&spread.is_held);
        spread.is_loop.clear();
        spread
            .is_loop
            .extend(spare.map(|(&spare, &is_held)| spare < i64::from(!is_held)));
        spread.any = spread.is_loop.contains(&true);
    }

    /// Begins a step: nothing is borne yet.
    pub(super) fn begin_spread(&mut self) {
        if self.borne.any {
            self.borne.impulses.clear();
            self.borne.impulses.resize(self.bodies.len(), [0.0; 6]);
        }
    }

    /// Begins a half of a sub-step, before joints act.
    pub(super) fn begin_half(&mut self) {
        self.borne.before.clone_from(&self.velocities);
    }

    #[inline(always)]
    fn is_in_loop(&self, joint: &BatchJoint) -> bool {
        self.borne.any && self.borne.is_loop[joint.component as usize]
    }

    /// Takes note of what the joints bear in a half of a sub-step, where the bodies are in it. `are_alone`: nothing else has changed velocities.
    pub(crate) fn note_impulses(&mut self, are_alone: bool) {
        run(
            self.width,
            NoteImpulses {
                system: self,
                are_alone,
            },
        );
    }

    #[inline(always)]
    fn add_impulses(&mut self, are_alone: bool) {
        let any_passed = are_alone && self.note_passed();
        for at in 0..self.joints.len() {
            let is_spread = self.is_in_loop(&self.joints[at]);
            if any_passed && self.is_passed(&self.joints[at]) {
                continue;
            }
            let (rows, joint) = (&self.rows, &mut self.joints[at]);
            let rows = rows[joint.rows.clone()].iter();
            let known = rows.filter(|row| !(is_spread && row.is_spread()));
            joint.add_impulses(known.map(|row| (row, row.impulse)));
        }
        if self.borne.any {
            self.note_borne(are_alone);
        }
    }

    /// The same of bodies in loops.
    fn note_borne(&mut self, are_alone: bool) {
        let mut borne = std::mem::take(&mut self.borne.impulses);
        if are_alone {
            let velocities = self.velocities.iter().zip(&self.borne.before);
            for ((borne, body), (now, before)) in borne.iter_mut().zip(&self.bodies).zip(velocities)
            {
                let change: Vector6 = std::array::from_fn(|i| now[i] - before[i]);
                add_scaled(borne, 1.0, &product(&body.spatial_inertia(), &change));
            }
        }
        for joint in self.joints.iter().filter(|joint| self.is_in_loop(joint)) {
            let rows = self.rows[joint.rows.clone()].iter();
            for row in rows.filter(|row| row.is_spread() != are_alone) {
                let sign = if are_alone { -1.0 } else { 1.0 };
                for (end, jacobian) in joint.ends.into_iter().zip(&row.jacobian) {
                    if let JointEndpoint::Jointed(body) = end {
                        add_scaled(&mut borne[body as usize], sign * row.impulse, jacobian);
                    }
                }
            }
        }
        self.borne.impulses = borne;
    }

    /// At the end of a step: spreads what bodies in loops have got over the rows that hold them.
    pub(crate) fn spread_impulses(&mut self) {
        if !self.borne.any {
            return;
        }
        self.scale_spread_rows(STIFFNESS);
        self.renew_factor();
        self.missing.clear();
        self.missing.resize(self.rows.len(), 0.0);
        self.changes.clear();
        self.changes.resize(self.bodies.len(), [0.0; 6]);
        for (borne, &at) in self.borne.impulses.iter().zip(&self.sparsity.position) {
            add_scaled(&mut self.changes[at as usize], -1.0, borne);
        }
        self.solve_for_changes();
        self.find_given();
        for at in 0..self.joints.len() {
            if !self.is_in_loop(&self.joints[at]) {
                continue;
            }
            let (rows, joint) = (&self.rows, &mut self.joints[at]);
            let rows = joint
                .rows
                .clone()
                .map(|number| (&rows[number], self.missing[number]));
            joint.add_impulses(rows.filter(|(row, _)| row.is_spread()));
        }
        self.scale_spread_rows(STIFFNESS.recip());
    }

    /// Has rows that are spread be stiffer; their components are asked and have no factor then.
    fn scale_spread_rows(&mut self, share: f64) {
        let is_loop = self.borne.is_loop.iter();
        for (component, &is_loop) in self.components.iter_mut().zip(is_loop) {
            component.is_asked = is_loop;
            component.is_stale |= is_loop;
        }
        for at in 0..self.joints.len() {
            if self.is_in_loop(&self.joints[at]) {
                let rows = &mut self.rows[self.joints[at].rows.clone()];
                let spread = rows.iter_mut().filter(|row| row.is_spread());
                spread.for_each(|row| row.stiffness *= share);
            }
        }
    }
}

impl JointRow {
    /// Whether its impulse is what others leave to it.
    fn is_spread(&self) -> bool {
        self.state == RowState::Free && self.is_rigid() && self.stiffness > 0.0
    }
}

impl BatchJoint {
    /// Adds impulses of its rows to what it bears.
    #[inline(always)]
    fn add_impulses<'r>(&mut self, impulses: impl Iterator<Item = (&'r JointRow, f64)>) {
        let Some(now) = &self.now else {
            return;
        };
        let mut sum = [0.0; 6];
        for (row, impulse) in impulses {
            add_scaled(&mut sum, impulse, &row.jacobian[1]);
        }
        let [linear, angular] = split(&sum);
        self.impulse[0] += linear;
        self.impulse[1] += angular - now.r[1].cross(linear);
    }
}

/// Takes note of what the joints bear.
struct NoteImpulses<'a> {
    system: &'a mut JointSystem,
    are_alone: bool,
}

impl Kernel for NoteImpulses<'_> {
    type Output = ();
    const NEEDS_32_REGISTERS: bool = false;

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.system.add_impulses(self.are_alone);
    }
}
