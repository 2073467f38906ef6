//! Islands that wait: large ones in which a body breaks for the next round, before they are solved for nothing, and those of bodies that
//! are small for the step for their local steps.

use crate::bodies::solver_body::SolverBody;
use crate::bodies::store::Bodies;
use crate::contact::manifolds::{ManifoldHead, Manifolds};
use crate::solver::batch::layout::{Group, Member, SolvedMember};
use crate::solver::batch::{Batch, Step};
use crate::solver::breakage_probe::{self, BreakageProbe, is_large};
use crate::solver::contact_solver::{ContactSolver, Progress, PutOff};
use crate::solver::settings::SubstepSettings;

/// What a body is in a step whose islands have been solved or put off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum StepRole {
    /// Contacts do not move it, or it waits for something else.
    #[default]
    None,
    /// It touches nothing.
    Free,
    /// It is of an island that has been solved.
    Solved(SolvedMember),
    /// It is of this one of the islands that take local steps.
    PutOff(u32),
}

impl ContactSolver {
    /// Finds the role of each body, by slot.
    pub(crate) fn find_roles(&self, bodies: &Bodies, roles: &mut Vec<StepRole>) {
        roles.clear();
        roles.extend(
            (0..bodies.slots() as u32).map(|slot| match self.is_solved(slot) {
                true => StepRole::Free,
                false => StepRole::None,
            }),
        );
        for &solved in &self.solved {
            let (batch, member) = self.batch_of(solved);
            for &slot in &batch.layout.slots[member.bodies.clone()] {
                roles[slot as usize] = match bodies.velocity[slot as usize].inverse_mass > 0.0 {
                    true => StepRole::Solved(solved),
                    false => StepRole::None,
                };
            }
        }
        for (number, island) in (0..).zip(&self.put_off) {
            for &slot in &self.put_off_slots[island.bodies.clone()] {
                roles[slot as usize] = StepRole::PutOff(number);
            }
        }
    }

    fn batch_of(&self, solved: SolvedMember) -> (&Batch, &Member) {
        let batch = &self.batches[solved.batch as usize];
        (batch, &batch.layout.members[solved.member as usize])
    }

    /// Local steps of a body in a role, if it can take more of them without anything being solved anew.
    pub(crate) fn local_steps_of(&self, role: StepRole) -> Option<u32> {
        match role {
            StepRole::Free => Some(1),
            StepRole::PutOff(number) => Some(self.put_off[number as usize].local_steps),
            StepRole::Solved(_) | StepRole::None => None,
        }
    }

    /// Lets the island of a body, or the body alone, take so many local steps, or as many as it may. What has been solved is taken back:
    /// velocities are those of `start`, which is sorted by slot.
    pub(crate) fn put_off_too(
        &mut self,
        bodies: &mut Bodies,
        start: &[(u32, SolverBody)],
        (slot, role): (u32, StepRole),
        local_steps: u32,
    ) {
        match role {
            StepRole::None => {}
            StepRole::PutOff(number) => self.take_at_least(number as usize, local_steps),
            // Another body of its island was before it.
            _ if self.progress[slot as usize] == Progress::PutOff => {
                let has_slot = |island: &PutOff| {
                    let slots = &self.put_off_slots[island.bodies.clone()];
                    slots.contains(&slot)
                };
                if let Some(number) = self.put_off.iter().rposition(has_slot) {
                    self.take_at_least(number, local_steps);
                }
            }
            StepRole::Free => self.take_back(bodies, start, &[slot], [local_steps, u32::MAX]),
            StepRole::Solved(solved) => {
                let most = self.most_local_steps_of(solved);
                // What takes fewer than it should in one step and none in the next is shaken by each change.
                let Some(max_local_steps) = most.filter(|&most| most >= local_steps) else {
                    return;
                };
                let (batch, member) = self.batch_of(solved);
                let moves = |slot: &u32| bodies.velocity[*slot as usize].inverse_mass > 0.0;
                let slots = batch.layout.slots[member.bodies.clone()].iter().copied();
                let slots: Vec<u32> = slots.filter(moves).collect();
                self.batches[solved.batch as usize].forget_blows();
                self.take_back(bodies, start, &slots, [local_steps, max_local_steps]);
            }
        }
    }

    fn take_at_least(&mut self, number: usize, local_steps: u32) {
        let island = &mut self.put_off[number];
        let most = local_steps.min(island.max_local_steps);
        island.local_steps = island.local_steps.max(most);
    }

    /// Most local steps that an island which has been solved may take, if any. None if it has bonds or joints, or what its bodies were hit
    /// with cannot be told from what others were.
    fn most_local_steps_of(&self, solved: SolvedMember) -> Option<u32> {
        let (batch, member) = self.batch_of(solved);
        let is_alone = batch.layout.members.len() == 1;
        let is_held = batch.bonds.any() || !member.joints.is_empty();
        let most = batch
            .settings
            .affordable_local_steps(member.contacts as u32);
        let may_wait = !is_held && (is_alone || batch.impacts.limits.is_empty());
        (may_wait && most > 1).then_some(most)
    }

    /// Gives bodies the velocities back that they had, and lets them take local steps as an island.
    fn take_back(
        &mut self,
        bodies: &mut Bodies,
        start: &[(u32, SolverBody)],
        slots: &[u32],
        [local_steps, max_local_steps]: [u32; 2],
    ) {
        let first = self.put_off_slots.len();
        for &slot in slots {
            if let Ok(at) = start.binary_search_by_key(&slot, |(slot, _)| *slot) {
                bodies.velocity[slot as usize] = start[at].1;
            }
            self.progress[slot as usize] = Progress::PutOff;
        }
        self.put_off_slots.extend_from_slice(slots);
        self.put_off.push(PutOff {
            bodies: first..self.put_off_slots.len(),
            local_steps: local_steps.min(max_local_steps),
            max_local_steps,
        });
    }

    /// Forgets what batches have solved that was taken back.
    pub(crate) fn forget_put_off(&mut self) {
        let mut solved = std::mem::take(&mut self.solved);
        solved.retain(|&solved| {
            let (batch, member) = self.batch_of(solved);
            let mut slots = batch.layout.slots[member.bodies.clone()].iter();
            slots.all(|&slot| self.progress[slot as usize] != Progress::PutOff)
        });
        self.solved = solved;
    }

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
                    max_local_steps: self.requirements[island].max_local_steps,
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
