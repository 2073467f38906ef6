//! Light links under heavy loads: what they bear pulls them straight, faster than sub-steps can follow.
//!
//! A force `f` on a body at an anchor `r` from its center of mass resists a turn about any axis across `r` with the torque `r . f` per radian, the
//! geometric stiffness of the joint: a link of mass `m` and length `l` that bears `T` swings about the line of the force at up to
//! `sqrt(12 T / (m l))`, 600 rad/s where 1 kg bears a ton that swings. Impulses along the rows of where bodies are, which have joints
//! hold at the end of the motion, are an explicit method for that, a leapfrog: beyond `h omega = 2` it grows, until links are bent by so
//! much that no impulses along these rows close the joints any more. So bodies that what they bear would swing faster have more inertia where joints are
//! solved, as in an implicit method: as much as leaves `h omega` at a bound. What swings slower has none, to the bit.
//!
//! Such inertia takes up energy and gives it back, at a sudden load what nothing gave it. So what a joint is taken to bear follows what it bears slowly
//! upwards; where bodies turn by much in a sub-step it fades, and the energy of the island is bounded. Angular momentum that it takes from bodies that nothing
//! holds is given back to all of them, as to one rigid body.
//!
//! # References
//! Tournier, Nesme, Gilles and Faure, "Stable Constrained Dynamics", ACM Transactions on Graphics 34, 2015: the geometric
//! stiffness of all joints, whole, as part of the mass of all bodies.

use crate::simd::dispatch::run;
use crate::simd::lanes::{Kernel, Lanes};
use crate::solver::joint::rigid::RigidMotion;
use crate::solver::joint::row::JointRow;
use crate::solver::joint::stiffening::{Swing, implicit_inertia, stiffness_of};
use crate::solver::joint::system::{BatchJoint, JointEndpoint, JointSystem};
use crate::solver::joint::vector6::split;
use glam::{DMat3, DVec3, Vec3};
use std::ops::Range;

/// Largest ratio of what a joint is taken to bear to that of the sub-step before, from this share of a force on that moves its anchor by its lever in a sub-step.
const GROWTH: f64 = 1.25;
const FIRST: f64 = 0.5;

/// Turn of a body in a sub-step at which a component has no such inertia any more, rad.
const MOST_TURN: f64 = 0.15;

impl JointSystem {
    /// Whether bodies have got angular momentum in the sub-step by inertia that is none of theirs; they may have it no more.
    pub(crate) fn has_borrowed_spin(&self) -> bool {
        let mut swings = self.stiffening.swings.iter();
        swings.any(|swing| swing.borrowed_spin != DVec3::ZERO)
    }

    /// Whether some of these joints are among bodies that had such inertia in the motion and turned so fast that they may gain energy by it.
    pub(crate) fn swing_fast(&self, joints: Range<usize>) -> bool {
        let swings = &self.stiffening.swings;
        let mut joints = self.joints[joints].iter();
        joints.any(|joint| swings[joint.component as usize].is_fast())
    }

    /// Takes note of what joints bear as their rows say, in half of a sub-step of `h` seconds. Where no motion was found it
    /// is nothing that comes again, and in loops rows may bear anything against each other.
    pub(crate) fn note_tensions(&mut self, h: f64) {
        run(self.width, NoteTensions { system: self, h });
    }

    #[inline(always)]
    fn note_tensions_and_turns(&mut self, h: f64) {
        self.find_turns(h);
        for joint in &mut self.joints {
            let component = joint.component as usize;
            if self.borne.any && self.borne.is_loop[component] {
                joint.tension = Vec3::ZERO;
                continue;
            }
            if self.rounds.leave_open(joint.component) {
                continue;
            }
            let turn = self.stiffening.swings[component].turn;
            let left = (1.0 - turn * turn).max(0.0);
            let rows = &self.rows[joint.rows.clone()];
            let force = joint.force_on_b(rows) / (0.5 * h);
            let first = FIRST * joint.moving_force(rows, h);
            let most = first.max(GROWTH * f64::from(joint.tension.length()));
            // Between steps it is told in single precision.
            joint.tension = (left * force.clamp_length_max(most)).as_vec3();
        }
    }

    #[inline(always)]
    fn find_turns(&mut self, h: f64) {
        let bodies = self.bodies.iter().zip(&self.velocities);
        for ((body, velocity), &component) in bodies.zip(&self.sparsity.components) {
            let turn = h * split(velocity)[1].length() / MOST_TURN;
            let swing = &mut self.stiffening.swings[component as usize];
            swing.turn = swing.turn.max(turn);
            swing.is_stiffened |= body.is_stiffened();
        }
    }

    /// Has bodies have the inertia that sub-steps of `h` seconds ask for; whether any has another than before.
    pub(super) fn stiffen(&mut self, h: f64) -> bool {
        let is_pulled = self.joints.iter().any(|joint| joint.tension != Vec3::ZERO);
        let was_any = self.bodies.iter().any(|body| body.is_stiffened());
        self.stiffening.is_any = false;
        (is_pulled || was_any) && run(self.width, Stiffen { system: self, h })
    }

    #[inline(always)]
    fn stiffen_pulled(&mut self, h: f64) -> bool {
        let stiffening = &mut self.stiffening;
        let stiffness = &mut stiffening.stiffness;
        stiffness.clear();
        stiffness.resize(self.bodies.len(), DMat3::ZERO);
        for joint in &self.joints {
            let Some(now) = &joint.now else {
                continue;
            };
            let force = joint.tension.as_dvec3();
            for (side, force) in [-force, force].into_iter().enumerate() {
                if let JointEndpoint::Jointed(body) = joint.ends[side] {
                    stiffness[body as usize] += stiffness_of(now.r[side], force);
                }
            }
        }
        let mut has_changed = false;
        for (body, stiffness) in self.bodies.iter_mut().zip(stiffness) {
            let inertia = implicit_inertia(&body.inverse_inertia, stiffness, h);
            has_changed |= inertia != body.implicit_inertia;
            body.implicit_inertia = inertia;
            stiffening.is_any |= body.is_stiffened();
        }
        has_changed
    }

    /// Begins a sub-step, in which nothing is known yet.
    pub(super) fn forget_swings(&mut self) {
        let swings = &mut self.stiffening.swings;
        swings.clear();
        swings.resize(self.components.len(), Swing::default());
    }

    /// Takes note of the angular momenta that bodies get by inertia that is none of theirs, before (`sign` -1) and after (1) joints change velocities.
    #[inline(always)]
    pub(crate) fn note_borrowed_spin(&mut self, sign: f64) {
        if !self.stiffening.is_any {
            return;
        }
        let bodies = self.bodies.iter().zip(&self.velocities);
        for ((body, velocity), &component) in bodies.zip(&self.sparsity.components) {
            let spin = body.implicit_inertia * split(velocity)[1];
            self.stiffening.swings[component as usize].borrowed_spin += sign * spin;
        }
    }

    /// The turns that give them back to components that nothing holds.
    pub(crate) fn borrowed_turns(&self) -> impl Iterator<Item = (u32, RigidMotion)> + '_ {
        let swings = (0..).zip(&self.stiffening.swings);
        let borrowed = swings.filter(|(_, swing)| swing.borrowed_spin != DVec3::ZERO);
        borrowed.filter_map(|(component, swing)| {
            let turn = self.free_turn(component, swing.borrowed_spin)?;
            Some((component, turn))
        })
    }
}

impl BatchJoint {
    /// Impulse on B that these rows, its own, hold its anchor with, N s.
    #[inline(always)]
    fn force_on_b(&self, rows: &[JointRow]) -> DVec3 {
        let holding = rows.iter().filter(|row| row.is_of_anchor());
        let of_row = |row: &JointRow| row.impulse * split(&row.jacobian[1])[0];
        holding.map(of_row).sum()
    }

    /// Force that moves its anchor by its lever within `h` seconds, N.
    #[inline(always)]
    fn moving_force(&self, rows: &[JointRow], h: f64) -> f64 {
        let row = rows.iter().find(|row| row.is_of_anchor());
        row.map_or(0.0, |row| self.levers / (row.mobility * h * h))
    }
}

/// Takes note of what joints bear and how fast bodies turn.
struct NoteTensions<'a> {
    system: &'a mut JointSystem,
    h: f64,
}

impl Kernel for NoteTensions<'_> {
    type Output = ();
    const NEEDS_32_REGISTERS: bool = false;

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.system.note_tensions_and_turns(self.h);
    }
}

/// Gives bodies the inertia that sub-steps of `h` seconds ask for.
struct Stiffen<'a> {
    system: &'a mut JointSystem,
    h: f64,
}

impl Kernel for Stiffen<'_> {
    type Output = bool;
    const NEEDS_32_REGISTERS: bool = false;

    #[inline(always)]
    fn run<L: Lanes>(self) -> bool {
        self.system.stiffen_pulled(self.h)
    }
}
