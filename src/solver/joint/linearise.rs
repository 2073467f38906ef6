//! The rows of all joints where the bodies are now, and which bodies are eliminated by them.

use crate::simd::dispatch::run;
use crate::simd::lanes::{Kernel, Lanes};
use crate::solver::joint::measure::{Frames, Measure};
use crate::solver::joint::row::{JointRow, RowState};
use crate::solver::joint::rows::{add_rows, axis_of, has_spring, is_held};
use crate::solver::joint::sparsity::Elimination;
use crate::solver::joint::system::{BatchJoint, Component, JointEndpoint, JointSystem};
use crate::solver::joint::vector6::{Vector6, add_scaled, split};
use glam::{DMat3, DVec3};
use smallvec::SmallVec;

/// Share of a mobility that is rounding.
const NOTHING: f64 = 1e-9;

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

    /// Begins a step: with the rows that the one before ended with, if nothing was moved or changed since, else with new ones. Either way
    /// nothing is left of what these bore.
    pub(crate) fn begin_step(&mut self, h: f64) {
        self.is_bent = false;
        self.begin_spread();
        if self.is_as_it_ended() {
            self.take_over_rows();
            if self.stiffen(h) {
                self.outdate();
            }
        } else {
            self.linearise(h);
        }
    }

    /// Whether joints and bodies are as the step before left them.
    fn is_as_it_ended(&self) -> bool {
        let before = &self.before;
        let mut fixed = self.fixed.iter().zip(&before.fixed);
        let mut bodies = self.bodies.iter().zip(&before.bodies);
        let mut joints = self.joints.iter().zip(&before.joints);
        before.is_written
            && self.fixed.len() == before.fixed.len()
            && self.bodies.len() == before.bodies.len()
            && self.joints.len() == before.joints.len()
            && fixed.all(|(now, before)| now.place == before.place)
            && bodies.all(|(now, before)| now.is_as_loaded(before))
            && joints.all(|(now, before)| now.is_as_loaded(before))
    }

    fn take_over_rows(&mut self) {
        for (body, before) in self.bodies.iter_mut().zip(&self.before.bodies) {
            body.rotation = before.rotation;
            body.inertia = before.inertia;
            body.inverse_inertia = before.inverse_inertia;
            body.implicit_inertia = before.implicit_inertia;
        }
        for (joint, before) in self.joints.iter_mut().zip(&self.before.joints) {
            joint.rows = before.rows.clone();
            joint.now = before.now;
            if joint.has_angles {
                joint.angle = before.angle;
            }
        }
        for row in &mut self.rows {
            *row = JointRow {
                state: RowState::Unknown,
                impulse: 0.0,
                spent: 0.0,
                curve: 0.0,
                bounds: [0.0; 2],
                velocity_before: 0.0,
                fixed_velocity: 0.0,
                ..*row
            };
        }
        for at in 0..self.joints.len() {
            self.add_fixed_velocity(at);
        }
        self.is_written = true;
    }

    /// Writes the rows anew for where the bodies are now; those that were there keep their impulses. `h`: length of a sub-step, s.
    pub(crate) fn linearise(&mut self, h: f64) {
        run(self.width, Linearise(self));
        self.stiffen(h);
    }

    #[inline(always)]
    fn write_rows(&mut self) {
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
            if body.locks[1] != DVec3::ZERO {
                body.lock_turns();
            }
        }
        std::mem::swap(&mut self.rows, &mut self.old_rows);
        self.rows.clear();
        for at in 0..self.joints.len() {
            let joint = &self.joints[at];
            let (a, b) = (self.place(joint.ends[0]), self.place(joint.ends[1]));
            let frames = Frames::of([&a, &b], joint.anchors, joint.frames, joint.has_angles);
            let (first, old) = (self.rows.len(), joint.rows.clone());
            let measures = frames.measure(&joint.joint, joint.angle);
            for measure in &measures {
                let mobilities = self.mobilities(joint, &measures, measure);
                add_rows(&mut self.rows, &joint.joint, measure, mobilities);
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
            let joint = &mut self.joints[at];
            joint.rows = first..self.rows.len();
            if joint.has_angles {
                joint.angle = frames.twist(joint.angle);
            }
            joint.now = Some(frames);
            self.add_fixed_velocity(at);
        }
        self.has_springs = self.rows.iter().any(|row| !row.is_rigid());
        self.has_bounds = self.rows.iter().any(|row| !row.always_acts());
        self.components.clear();
        let components = self.sparsity.component_count.max(1);
        self.components.resize(components, Component::default());
        self.outdate();
        self.lay_out_factor();
        self.is_written = true;
    }

    /// Has the rows of a joint know how fast what joints do not move is along them.
    #[inline(always)]
    fn add_fixed_velocity(&mut self, at: usize) {
        let joint = &self.joints[at];
        if joint.pair().is_some() {
            return;
        }
        let fixed = joint.ends.map(|end| self.fixed_velocity(end));
        for row in &mut self.rows[joint.rows.clone()] {
            row.fixed_velocity = row.velocity([fixed[0].as_ref(), fixed[1].as_ref()]);
        }
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
        self.product(joint, jacobian, jacobian)
    }

    /// The same for the rows of a measure, and for its springs.
    #[inline(always)]
    fn mobilities(&self, joint: &BatchJoint, measures: &[Measure], of: &Measure) -> [f64; 2] {
        let mobility = self.mobility(joint, &of.jacobian);
        let of_spring = if has_spring(axis_of(&joint.joint, of.axis)) {
            self.held_mobility(joint, measures, of)
        } else {
            mobility
        };
        [mobility, of_spring]
    }

    /// The same of what is left of a motion where the joint's own rows that always act hold: the mass that swings on a spring about a hinge is
    /// that of all that turns about the hinge. What is left of each row is found by Gram's and Schmidt's method, with `M^-1` as the metric.
    #[inline(never)]
    fn held_mobility(&self, joint: &BatchJoint, measures: &[Measure], of: &Measure) -> f64 {
        let mut held: SmallVec<[([Vector6; 2], f64); 6]> = SmallVec::new();
        let left = |jacobian: &[Vector6; 2], held: &[([Vector6; 2], f64)]| {
            let mut left = *jacobian;
            for (row, square) in held {
                let share = self.product(joint, &left, row) / square;
                for (left, row) in left.iter_mut().zip(row) {
                    add_scaled(left, -share, row);
                }
            }
            left
        };
        let others = measures.iter().filter(|other| other.axis != of.axis);
        for other in
            others.filter(|other| other.has_range && is_held(axis_of(&joint.joint, other.axis)))
        {
            let row = left(&other.jacobian, &held);
            let square = self.mobility(joint, &row);
            // Rows that say the same twice leave nothing.
            if square > NOTHING * self.mobility(joint, &other.jacobian) {
                held.push((row, square));
            }
        }
        let all = self.mobility(joint, &of.jacobian);
        let free = self.mobility(joint, &left(&of.jacobian, &held));
        if free > NOTHING * all { free } else { all }
    }

    /// `J M^-1 K^T` of two rows of a joint.
    #[inline(always)]
    fn product(&self, joint: &BatchJoint, j: &[Vector6; 2], k: &[Vector6; 2]) -> f64 {
        let [a, b] = joint.ends;
        self.product_at(a, &j[0], &k[0]) + self.product_at(b, &j[1], &k[1])
    }

    #[inline(always)]
    fn product_at(&self, end: JointEndpoint, j: &Vector6, k: &Vector6) -> f64 {
        let JointEndpoint::Jointed(body) = end else {
            return 0.0;
        };
        let body = &self.bodies[body as usize];
        let ([v, omega], [w, spin]) = (split(j), split(k));
        body.free_part(v).dot(w) / body.mass + omega.dot(body.inverse_inertia * spin)
    }
}

impl BatchJoint {
    /// Whether it is, as it was loaded, what it was when a step ended: angles of a turn are told in single precision between steps.
    fn is_as_loaded(&self, ended: &Self) -> bool {
        let angle = if ended.has_angles {
            f64::from(ended.angle as f32)
        } else {
            self.angle
        };
        self.ends == ended.ends
            && self.angle == angle
            && self.anchors == ended.anchors
            && self.frames == ended.frames
            && self.joint == ended.joint
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
