//! Islands that wait: large ones in which a body breaks for the next round, before they are solved for nothing, and those of bodies that
//! are small for the step for their local steps.

use crate::bodies::store::Bodies;
use crate::contact::manifolds::{ManifoldHead, Manifolds};
use crate::solver::batch::Step;
use crate::solver::batch::layout::Group;
use crate::solver::breakage_probe::{self, BreakageProbe, is_large};
use crate::solver::contact_solver::{ContactSolver, Progress, PutOff};
use crate::solver::settings::SubstepSettings;

impl ContactSolver {
    /// Rehearses the large islands that have been found. Bodies of those in which a body breaks wait, and `manifolds` hold the
    /// impulses of the probe; whether there are any.
    pub(crate) fn probe_breakage(
        &mut self,
        manifolds: &mut Manifolds,
        bodies: &Bodies,
        settings: &SubstepSettings,
    ) -> bool {
        self.is_deferred.clear();
        self.is_deferred.resize(self.islands.list.len(), false);
        self.probe.overloaded.clear();
        if !bodies.any_fracturable() || !self.islands.list.iter().any(is_large) {
            return false;
        }
        let mut probe = std::mem::take(&mut self.probe);
        let anybody = probe.choose(&self.islands, manifolds, bodies, settings);
        if anybody {
            let BreakageProbe {
                participants,
                islands,
                batch,
                overloaded,
                ..
            } = &mut probe;
            let takes_part = |slot: u32| participants[slot as usize] != breakage_probe::NONE;
            let moves = |slot: u32| bodies.velocity[slot as usize].inverse_mass > 0.0;
            let is_pending = |m: &ManifoldHead| {
                let counts = |slot: u32| takes_part(slot) || !moves(slot);
                counts(m.a) && counts(m.b) && (takes_part(m.a) || takes_part(m.b))
            };
            islands.find(manifolds.heads(), bodies, is_pending, None);
            islands.find_moving(|index| self.relative_motion(index));
            for part in 0..islands.list.len() {
                let slots = &islands.slots[islands.list[part].bodies.clone()];
                let Some(&slot) = slots.iter().find(|&&slot| takes_part(slot)) else {
                    continue;
                };
                let whole = participants[slot as usize] as usize;
                let step = Step {
                    islands,
                    manifolds,
                    bodies,
                    settings,
                    team: None,
                    may_break: true,
                };
                batch.load(&step, Group::one(&[part as u32]), &self.requirements[whole]);
                batch.load_bonds(&self.bonded, manifolds);
                batch.impacts.follow_left = self.follow_left;
                batch.solve((manifolds, bodies), None);
                self.follow_left = batch.impacts.follow_left;
                if batch.impacts.is_broken {
                    batch.store_impulses(&mut manifolds.whole(), 0);
                    overloaded.append(&mut batch.impacts.overloaded);
                    self.is_deferred[whole] = true;
                }
            }
        }
        self.probe = probe;
        self.defer_island_bodies(bodies);
        self.is_deferred.contains(&true)
    }

    /// Notes that the bodies of islands that are set aside wait.
    pub(crate) fn defer_island_bodies(&mut self, bodies: &Bodies) {
        for island in 0..self.is_deferred.len() {
            if self.is_deferred[island] {
                self.set_aside(bodies, island, Progress::Deferred);
            }
        }
    }

    /// Leaves the islands that take local steps, and are not set aside already, for later.
    pub(crate) fn put_off_islands(&mut self, bodies: &Bodies) {
        self.is_deferred.resize(self.islands.list.len(), false);
        for island in 0..self.islands.list.len() {
            let local_steps = self.requirements[island].local_steps;
            if local_steps > 1 && !self.is_deferred[island] {
                self.is_deferred[island] = true;
                let first = self.put_off_slots.len();
                self.set_aside(bodies, island, Progress::PutOff);
                self.put_off.push(PutOff {
                    bodies: first..self.put_off_slots.len(),
                    local_steps,
                });
            }
        }
    }

    /// Notes that the dynamic bodies of an island wait, and lists those that are put off.
    fn set_aside(&mut self, bodies: &Bodies, island: usize, progress: Progress) {
        let slots = &self.islands.slots[self.islands.list[island].bodies.clone()];
        let moves = |slot: &&u32| bodies.velocity[**slot as usize].inverse_mass > 0.0;
        for &slot in slots.iter().filter(moves) {
            self.progress[slot as usize] = progress;
            if progress == Progress::PutOff {
                self.put_off_slots.push(slot);
            }
        }
    }
}
