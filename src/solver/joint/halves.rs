//! The two halves of a sub-step: what the rows aim at in each.

use crate::simd::dispatch::run;
use crate::simd::lanes::{Kernel, Lanes};
use crate::solver::joint::body::JointedBody;
use crate::solver::joint::rows::HalfSettings;
use crate::solver::joint::system::{BatchJoint, JointSystem};

impl JointSystem {
    /// Begins the first half of a sub-step: rows aim at where the bodies are to be. Impulses of the sub-step before do not act: they may
    /// be any where a chain is as good as straight between fixed ends, and along rows that have turned since they would throw it.
    pub(crate) fn begin_ahead(&mut self, half: &HalfSettings) {
        self.begin_half();
        self.find_swings(half.substep_dt);
        let acts_for = [half.kick, half.substep_dt];
        if self.factored_for != acts_for && self.has_springs {
            self.outdate();
        }
        self.factored_for = acts_for;
        self.forget_swings();
        if !std::mem::replace(&mut self.is_bent, true) {
            self.bend_rows(half.substep_dt);
        }
        run(self.width, Aim::<true>(self, half));
    }

    #[inline(always)]
    fn aim_ahead(&mut self, half: &HalfSettings) {
        let Self {
            joints,
            rows,
            bodies,
            velocities,
            ..
        } = self;
        for joint in joints.iter() {
            let swing = joint.swing(bodies);
            for row in &mut rows[joint.rows.clone()] {
                if !row.always_acts() {
                    row.velocity_before = row.velocity(joint.velocities(velocities));
                }
                row.spent = 0.0;
                let tolerances = if row.is_angular {
                    [0.0, 1.0]
                } else {
                    [joint.slack, joint.levers]
                };
                row.aim_ahead(half, swing, tolerances);
                row.impulse = 0.0;
            }
        }
    }

    /// Begins the second half, where the bodies are at its end.
    pub(crate) fn begin_along(&mut self, half: &HalfSettings) {
        self.begin_half();
        self.find_swings(half.substep_dt);
        self.factored_for = [half.kick, half.substep_dt];
        run(self.width, Aim::<false>(self, half));
    }

    #[inline(always)]
    fn aim_along(&mut self, half: &HalfSettings) {
        let Self {
            joints,
            rows,
            bodies,
            ..
        } = self;
        for joint in joints.iter() {
            let swing = joint.swing(bodies);
            for row in &mut rows[joint.rows.clone()] {
                row.aim_along(half, swing, joint.arm);
            }
        }
    }

    fn find_swings(&mut self, substep_dt: f64) {
        if !self.has_springs {
            return;
        }
        for body in &mut self.bodies {
            body.swing = 0.0;
        }
        for joint in &self.joints {
            let rows = self.rows[joint.rows.clone()].iter();
            let swing: f64 = rows.map(|row| row.swing(substep_dt)).sum();
            for body in joint.jointed() {
                self.bodies[body].swing += swing;
            }
        }
    }
}

impl BatchJoint {
    fn swing(&self, bodies: &[JointedBody]) -> f64 {
        self.jointed().map(|body| bodies[body].swing).sum()
    }
}

/// Has rows aim at where the bodies are to be at the end of the sub-step, or along where they are.
struct Aim<'a, const AHEAD: bool>(&'a mut JointSystem, &'a HalfSettings);

impl<const AHEAD: bool> Kernel for Aim<'_, AHEAD> {
    type Output = ();
    const NEEDS_32_REGISTERS: bool = false;

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.0.note_borrowed_spin(-1.0);
        if AHEAD {
            self.0.aim_ahead(self.1);
        } else {
            self.0.aim_along(self.1);
        }
        self.0.guess_states();
    }
}
