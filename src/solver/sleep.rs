//! Sleep: islands that rest are left out of the step until something disturbs them.
//!
//! A whole island sleeps or none of it. It falls asleep when all its bodies have been slow and in place for a time
//! and fixed bodies that rest bear its weight and what else pulls it, so nothing sleeps in mid-air or on what moves. A sleeping body has no
//! velocity and keeps its pose bit for bit; its pairs with sleeping and resting fixed bodies make no work.
//!
//! Two things wake an island: somebody changes one of its bodies, which [`Bodies`] notices in its setters and does at once;
//! or something happens around it, which `wake_disturbed` and `wake_touched` find in the next step: a fixed
//! body that bears it was changed or removed (*changed*), gravity changed, or a body that moves came so close that they have
//! a manifold. So no manifold that is solved ever joins a sleeping body.
//!
//! Islands are gone through in the order of their first manifolds, which is that of body ids; which islands sleep does
//! not depend on the order in which things are found.

use crate::bodies::driving::STALLED;
use crate::bodies::sleep_state::{SleepCandidate, Status};
use crate::bodies::solver_body::Motion;
use crate::bodies::store::Bodies;
use crate::contact::impulses::ContactCache;
use crate::contact::manifolds::{ManifoldHead, Manifolds};
use crate::contact::pairs::broad_phase::Pair;
use crate::joints::store::JointRecord;
use crate::solver::config::SleepConfig;
use crate::solver::contact_solver::ContactSolver;
use glam::Vec3;

/// Share of an island's weight that fixed bodies must bear: less than one, because impulses of a step are not exactly
/// those of rest.
const MIN_SUPPORTED_SHARE: f32 = 0.5;

/// Marks a slot that belongs to no island that may fall asleep.
const NONE: u32 = u32::MAX;

impl Bodies {
    /// Wakes what lost its support or its reason to rest since the last step. Before the contacts of a step are found.
    pub(crate) fn wake_disturbed(&mut self, config: &SleepConfig, gravity: Vec3) {
        if !config.enabled && !self.sleep.is_on {
            return;
        }
        if !config.enabled || self.sleep.gravity != gravity {
            self.wake_all();
        }
        self.sleep.is_on = config.enabled;
        self.sleep.gravity = gravity;
        if self.sleep.changed.is_empty() {
            return;
        }
        for index in 0..self.sleep.supports.len() {
            let [fixed, body] = self.sleep.supports[index];
            if self.sleep.is_changed(fixed) && self.is_asleep(body) {
                self.wake(body);
            }
        }
    }

    fn wake_all(&mut self) {
        for slot in 0..self.slots() as u32 {
            if self.is_asleep(slot) {
                self.wake(slot);
            }
        }
    }

    /// Whether it matters if the bodies of a pair touch: one of them is awake, and if the other one sleeps, could wake it.
    pub(crate) fn needs_look(&self, pair: Pair) -> bool {
        if self.are_apart(pair.a, pair.b) {
            return false;
        }
        if self.sleep.asleep == 0 {
            return true;
        }
        match (self.is_asleep(pair.a), self.is_asleep(pair.b)) {
            (false, false) => true,
            (true, true) => false,
            (true, false) => self.disturbs(pair.b),
            (false, true) => self.disturbs(pair.a),
        }
    }

    /// Whether a touch of this body, which is awake, wakes: it is dynamic, or fixed and moves or was changed.
    fn disturbs(&self, slot: u32) -> bool {
        let body = &self.velocity[slot as usize];
        body.inverse_mass > 0.0 || self.is_displaced(slot)
    }

    /// Takes the multipliers of the bodies that woke back into the cache, and forgets what bore them while they slept.
    pub(crate) fn resume_woken(&mut self, cache: &mut ContactCache) {
        let Self { sleep, status, .. } = self;
        if !sleep.woken.is_empty() {
            sleep.woken.sort_unstable();
            cache.resume(&sleep.woken);
            sleep.woken.clear();
            sleep
                .supports
                .retain(|&[_, body]| status[body as usize] == Status::Asleep);
        }
    }

    /// Whether a fixed body moves, or was changed since the last step.
    fn is_displaced(&self, slot: u32) -> bool {
        let body = &self.velocity[slot as usize];
        body.linear != Vec3::ZERO || body.angular != Vec3::ZERO || self.sleep.is_changed(slot)
    }

    /// Wakes the sleeping bodies of `manifolds`, which were made for pairs that [need a look](Self::needs_look); whether there were
    /// any: their own pairs need a look then.
    pub(crate) fn wake_touched(&mut self, manifolds: &[ManifoldHead]) -> bool {
        let before = self.sleep.asleep;
        if before == 0 {
            return false;
        }
        for slot in manifolds.iter().flat_map(|m| [m.a, m.b]) {
            if self.is_asleep(slot) {
                self.wake(slot);
            }
        }
        self.sleep.asleep < before
    }

    /// Ends the look for what must wake: everybody has seen what was changed.
    pub(crate) fn end_wake(&mut self) {
        let sleep = &mut self.sleep;
        for slot in sleep.changed.drain(..) {
            sleep.is_changed[slot as usize] = false;
        }
    }

    /// Puts islands to sleep that have been at rest for long enough, after a step of `step_dt` seconds; `manifolds` are those that
    /// `solver` has solved. Their ids are in `sleep.slept` then.
    pub(crate) fn fall_asleep(
        &mut self,
        config: &SleepConfig,
        solver: &ContactSolver,
        manifolds: &Manifolds,
        step_dt: f32,
    ) {
        self.sleep.slept.clear();
        if !self.sleep.is_on {
            return;
        }
        self.count_rest(config, step_dt);
        self.find_candidates(config, solver, step_dt);
        if self.sleep.candidates.is_empty() {
            return;
        }
        self.weigh_supports(manifolds);
        self.weigh_joints(&solver.joints, step_dt);
        self.find_carried(config, &solver.joints, manifolds.heads());
        let mut next = 0;
        for (number, slots) in solver.whole_islands().enumerate() {
            let Some(candidate) = self.sleep.candidates.get(next) else {
                break;
            };
            if candidate.island == number {
                next += 1;
                let is_borne = candidate.is_borne(MIN_SUPPORTED_SHARE);
                if is_borne && candidate.has_support && !candidate.is_carried {
                    self.put_to_sleep(slots);
                }
            }
        }
        self.keep_supports(manifolds.heads());
    }

    /// Lists the islands all of whose bodies have been at rest for long enough.
    fn find_candidates(&mut self, config: &SleepConfig, solver: &ContactSolver, step_dt: f32) {
        let mut candidates = std::mem::take(&mut self.sleep.candidates);
        candidates.clear();
        self.sleep.candidate_of.resize(self.slots(), NONE);
        for (number, slots) in solver.whole_islands().enumerate() {
            let dynamic = || {
                let slots = slots.iter().copied();
                slots.filter(|&slot| self.velocity[slot as usize].inverse_mass > 0.0)
            };
            if !dynamic().all(|slot| self.is_rested(slot, config)) {
                continue;
            }
            let index = candidates.len() as u32;
            let weight = |slot: u32| self.mass[slot as usize].mass * self.pull_on(slot);
            candidates.push(SleepCandidate {
                island: number,
                weight: step_dt * dynamic().map(weight).sum::<Vec3>(),
                ..SleepCandidate::default()
            });
            for &slot in slots {
                if self.velocity[slot as usize].inverse_mass > 0.0 {
                    self.sleep.candidate_of[slot as usize] = index;
                }
            }
        }
        self.sleep.candidates = candidates;
    }

    /// Adds up what fixed bodies bear of each candidate.
    fn weigh_supports(&mut self, manifolds: &Manifolds) {
        for m in manifolds.iter() {
            let Some((fixed, body, sign)) = self.support(&m) else {
                continue;
            };
            let Some(&index) = self.sleep.candidate_of.get(body as usize) else {
                continue;
            };
            if index == NONE {
                continue;
            }
            let is_displaced = self.is_displaced(fixed);
            let on_b = m.points().iter();
            let on_b = on_b.map(|p| p.normal_impulse * m.normal + p.friction_impulse);
            let candidate = &mut self.sleep.candidates[index as usize];
            candidate.support += sign * on_b.sum::<Vec3>();
            candidate.has_support = true;
            candidate.is_carried |= is_displaced;
        }
    }

    /// Adds up what joints to the world and to fixed bodies bear of each candidate.
    fn weigh_joints(&mut self, joints: &[JointRecord], step_dt: f32) {
        for record in joints {
            let slots = record.ends.map(|end| end.map(|(slot, _)| slot));
            let moves = slots
                .map(|slot| slot.filter(|&slot| self.velocity[slot as usize].inverse_mass > 0.0));
            let (body, fixed, sign) = match moves {
                [None, Some(body)] => (body, slots[0], 1.0),
                [Some(body), None] => (body, slots[1], -1.0),
                _ => continue,
            };
            let index = self.sleep.candidate_of[body as usize];
            if index == NONE {
                continue;
            }
            let is_displaced = fixed.is_some_and(|fixed| self.is_displaced(fixed));
            let candidate = &mut self.sleep.candidates[index as usize];
            candidate.support += sign * step_dt * record.load.force;
            candidate.has_support = true;
            candidate.is_carried |= is_displaced;
        }
    }

    /// Finds out which candidates motors and running surfaces move. What is held back there may sleep.
    fn find_carried(
        &mut self,
        config: &SleepConfig,
        joints: &[JointRecord],
        manifolds: &[ManifoldHead],
    ) {
        for record in joints {
            if record.is_driven(self) {
                let ends = record.ends.iter().flatten();
                ends.for_each(|&(slot, _)| self.mark_carried(slot));
            }
        }
        if !self.has_running_surfaces() {
            return;
        }
        for slots in manifolds.iter().map(|m| [m.a, m.b]) {
            let [a, b] = slots.map(|slot| self.surface_velocity(slot));
            if a == b {
                continue;
            }
            let [of_a, of_b] = slots.map(|slot| self.mean_velocity(slot, config));
            if of_a.distance(of_b) > STALLED * a.distance(b) {
                slots.into_iter().for_each(|slot| self.mark_carried(slot));
            }
        }
    }

    /// Keeps the candidate that a body belongs to, if it does, awake.
    fn mark_carried(&mut self, slot: u32) {
        let index = self.sleep.candidate_of[slot as usize];
        if index != NONE {
            self.sleep.candidates[index as usize].is_carried = true;
        }
    }

    /// Of a manifold between a fixed and a dynamic body: their slots, and the sign of its impulses on the dynamic one.
    fn support(&self, m: &ManifoldHead) -> Option<(u32, u32, f32)> {
        let moves = |slot: u32| self.velocity[slot as usize].inverse_mass > 0.0;
        match (moves(m.a), moves(m.b)) {
            (false, true) => Some((m.a, m.b, 1.0)),
            (true, false) => Some((m.b, m.a, -1.0)),
            _ => None,
        }
    }

    /// Stops the dynamic ones of an island's bodies and links them to a ring.
    fn put_to_sleep(&mut self, slots: &[u32]) {
        let count = self.slots();
        self.sleep.next.resize(count, NONE);
        let (mut first, mut last) = (NONE, NONE);
        for &slot in slots {
            let i = slot as usize;
            if self.velocity[i].inverse_mass == 0.0 {
                continue;
            }
            self.halt(slot);
            self.motion[i] = Motion {
                shift: Vec3::ZERO,
                rotation: self.rotation[i],
            };
            self.status[i] = Status::Asleep;
            self.sleep.asleep += 1;
            self.sleep.sleep_changes.push((slot, self.ids[i]));
            self.sleep.slept.push(self.ids[i]);
            match last {
                NONE => first = slot,
                last => self.sleep.next[last as usize] = slot,
            }
            last = slot;
        }
        self.sleep.next[last as usize] = first;
    }

    /// Remembers which fixed bodies bear those that fell asleep, and forgets the candidates.
    fn keep_supports(&mut self, manifolds: &[ManifoldHead]) {
        for m in manifolds {
            let Some((fixed, body, _)) = self.support(m) else {
                continue;
            };
            let was_candidate = self.sleep.candidate_of[body as usize] != NONE;
            if was_candidate && self.is_asleep(body) {
                self.sleep.supports.push([fixed, body]);
            }
        }
        self.sleep.candidate_of.fill(NONE);
        self.sleep.slept.sort_unstable();
    }
}
