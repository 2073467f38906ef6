//! From manifolds and bodies to new velocities, motions and impulses, batch of islands by batch.

use crate::bodies::store::Bodies;
use crate::cluster::blow::FOLLOWED_PER_STEP;
use crate::contact::manifolds::Manifolds;
use crate::joints::store::JointRecord;
use crate::solver::adaptivity::{IslandRequirements, LoneKind};
use crate::solver::batch::layout::{Group, SolvedMember};
use crate::solver::batch::{Batch, Step};
use crate::solver::breakage_probe::{BreakageProbe, is_large};
use crate::solver::graph::islands::{Island, Islands};
use crate::solver::graph::relative_motion::RelativeMotion;
use crate::solver::settings::SubstepSettings;
use crate::solver::wide::bond::BondedManifold;
use crate::threads::team::Team;
use crate::tuning::{
    BATCH_MANIFOLDS, JOINT_WEIGHT, LONE_ISLANDS, MANIFOLDS_WORTH_A_TEAM, MANIFOLDS_WORTH_HELP,
    MANIFOLDS_WORTH_THOSE_PRESENT, MIN_MANIFOLDS_OF_PART,
};
use std::ops::Range;

/// The rows of a step and the working copies of the bodies they join; buffers are reused.
#[derive(Debug, Default)]
pub struct ContactSolver {
    pub(crate) islands: Islands,
    /// By manifold.
    pub(crate) estimates: Vec<ContactEstimate>,
    /// By island.
    pub(crate) requirements: Vec<IslandRequirements>,
    /// Islands, batch by batch, and those of each batch among them.
    pub(crate) order: Vec<u32>,
    pub(crate) ranges: Vec<Range<usize>>,
    /// Those of `ranges` of lone islands.
    lone_ranges: Range<usize>,
    /// Lone islands, behind their sub-steps, kinds and numbers of manifolds.
    lone: Vec<(u32, LoneKind, usize, u32)>,
    /// Those of earlier rounds of the step, then as many as there are `ranges`, and perhaps some from other steps.
    pub(crate) batches: Vec<Batch>,
    /// Those of the manifolds that are bonded, ascending.
    pub(crate) bonded: Vec<BondedManifold>,
    /// Joints of the step, ascending by name.
    pub(crate) joints: Vec<JointRecord>,
    /// What the batches have solved: round by round, of each the islands in their order.
    pub(crate) solved: Vec<SolvedMember>,
    /// Number of batches from earlier rounds.
    pub(crate) earlier: usize,
    /// By slot: how far the bodies are in this step.
    pub(crate) progress: Vec<Progress>,
    /// By island: whether its probe broke a body, so that it is not solved in this round.
    pub(crate) is_deferred: Vec<bool>,
    pub(crate) probe: BreakageProbe,
    /// Islands that take local steps.
    pub(crate) put_off: Vec<PutOff>,
    /// Slots of their dynamic bodies.
    pub(crate) put_off_slots: Vec<u32>,
    /// Number of batches of the step itself, if there were local steps after it.
    pub(crate) whole_batches: Option<usize>,
    /// What may still be followed in the step of blows to clusters, see [`FOLLOWED_PER_STEP`].
    pub(crate) follow_left: usize,
    /// Slots of bodies that move by themselves, and no contact moves.
    pub(crate) carriers: Vec<u32>,
}

/// An island that takes local steps.
#[derive(Clone, Debug)]
pub(crate) struct PutOff {
    /// Its dynamic bodies, within [`ContactSolver::put_off_slots`].
    pub(crate) bodies: Range<usize>,
    /// See [`IslandRequirements::local_steps`].
    pub(crate) local_steps: u32,
    /// See [`IslandRequirements::max_local_steps`].
    pub(crate) max_local_steps: u32,
}

/// What a manifold asks for.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ContactEstimate {
    pub(crate) relative_motion: RelativeMotion,
    /// See [`load_of`](crate::solver::estimates); 0 if nothing depends on it.
    pub(crate) load: f32,
    /// Least extent of those of its bodies that contacts move, m.
    pub(crate) extent: f32,
    /// Farthest turn within the step of those of them that have corners, rad.
    pub(crate) turn: f32,
}

/// How far a body is within a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Progress {
    /// As it was before the step.
    #[default]
    Pending,
    /// As before the step, because something in its island breaks.
    Deferred,
    /// As before the step, because its island takes local steps.
    PutOff,
    /// A dynamic body that has got its velocity and motion.
    Solved,
}

/// What a round may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Round {
    /// Whether it is the first one of a step.
    pub is_first: bool,
    /// Whether islands in which a body breaks are left for the next round. Not in the last one.
    pub may_break: bool,
}

impl ContactSolver {
    /// Solves the contacts of `manifolds` and leaves in `bodies` the new velocities and how to move, in `manifolds` the
    /// impulses. `settings.h` is the length of a sub-step, s.
    ///
    /// Returns whether there are islands in which a body breaks. Their bodies stay as they were, their manifolds hold the
    /// impulses until then, and the next round solves what has become of them.
    pub fn solve(
        &mut self,
        manifolds: &mut Manifolds,
        bodies: &mut Bodies,
        settings: &SubstepSettings,
        round: Round,
    ) -> bool {
        if round.is_first {
            self.earlier = 0;
            self.progress.clear();
            self.put_off.clear();
            self.put_off_slots.clear();
            self.whole_batches = None;
            self.follow_left = FOLLOWED_PER_STEP;
        } else {
            self.earlier += self.ranges.len();
            let waiting = self
                .progress
                .iter_mut()
                .filter(|p| **p == Progress::Deferred);
            waiting.for_each(|progress| *progress = Progress::Pending);
        }
        self.progress.resize(bodies.slots(), Progress::Pending);
        // A large scene is worth a team from the start.
        Team::lead_if(manifolds.len() >= MANIFOLDS_WORTH_A_TEAM, |team| {
            let is_many = team.is_none() && manifolds.len() >= MANIFOLDS_WORTH_THOSE_PRESENT;
            Team::lead_present_if(is_many, |present| {
                self.find_islands(manifolds, bodies, settings, team.or(present));
            });
            self.is_deferred.clear();
            let is_deferred = round.may_break && self.probe_breakage(manifolds, bodies, settings);
            self.put_off_islands(bodies);
            self.make_batches();
            // Now it is known whether a smaller scene has work for several threads.
            Team::lead_if(team.is_none() && self.is_worth_help(), |late| {
                let team = team.or(late);
                let problem = (&*manifolds, &*bodies);
                self.solve_batches(problem, settings, round.may_break, team);
                self.write_back(bodies);
                self.move_free_bodies(bodies, settings);
                self.store_impulses(manifolds, team);
            });
            let batches = &self.batches[self.earlier..][..self.ranges.len()];
            is_deferred || batches.iter().any(|batch| batch.impacts.is_broken)
        })
    }

    /// Begins the local steps of a group of islands: what is solved until now stays.
    pub(crate) fn begin_group(&mut self) {
        self.earlier += self.ranges.len();
        self.ranges.clear();
        self.whole_batches.get_or_insert(self.earlier);
    }

    /// Begins one of their local steps, whose batches are those from this number on: those of the one before are over.
    pub(crate) fn begin_local_step(&mut self, bodies: &Bodies, first_batch: usize) {
        self.earlier = first_batch;
        self.ranges.clear();
        self.forget_solved();
        self.progress.resize(bodies.slots(), Progress::Pending);
        for &slot in &bodies.local.slots {
            self.progress[slot as usize] = Progress::Pending;
        }
    }

    /// Takes back what contacts and bonds have borne.
    fn store_impulses(&mut self, manifolds: &mut Manifolds, team: Option<&Team>) {
        let batches = &self.batches[self.earlier..][..self.ranges.len()];
        let size = Team::part_size(team, manifolds.len(), MIN_MANIFOLDS_OF_PART);
        let runs = manifolds.chunks_mut(size).enumerate();
        Team::each_of_many(team, runs, |(part, mut run)| {
            for batch in batches {
                batch.store_impulses(&mut run, part * size);
            }
        });
        for batch in batches.iter().filter(|batch| !batch.impacts.is_broken) {
            batch.update_bond_damage(&mut self.bonded);
            batch.store_joints(&mut self.joints);
        }
    }

    /// Finds the islands, what they ask for, and which are solved together.
    pub fn find_batches(
        &mut self,
        manifolds: &Manifolds,
        bodies: &Bodies,
        settings: &SubstepSettings,
    ) {
        self.find_islands(manifolds, bodies, settings, None);
        self.is_deferred.clear();
        self.make_batches();
    }

    /// Whether there is work for several threads.
    fn is_worth_help(&self) -> bool {
        let (islands, order) = (&self.islands, &self.order);
        let is_for_team = |range: &Range<usize>| {
            islands.manifolds_of(&order[range.clone()]) >= MANIFOLDS_WORTH_A_TEAM
        };
        // A single small batch is solved where its data are.
        islands.manifolds.len() + JOINT_WEIGHT * islands.joints.len() >= MANIFOLDS_WORTH_HELP
            && (self.ranges.len() > 1 || self.ranges.iter().any(is_for_team))
    }

    /// Decides which of the islands that are not set aside are solved together.
    fn make_batches(&mut self) {
        self.is_deferred.resize(self.requirements.len(), false);
        self.ranges.clear();
        self.order.clear();
        let mut first = 0;
        while first < self.requirements.len() {
            if self.is_deferred[first] {
                first += 1;
                continue;
            }
            let end = self.end_of_batch(first);
            let IslandRequirements { substeps, lone, .. } = self.requirements[first];
            match lone.filter(|_| end == first + 1) {
                Some(kind) => {
                    let manifolds = self.islands.list[first].manifolds.len();
                    self.lone.push((substeps, kind, manifolds, first as u32));
                }
                None => self.add_batch(first as u32..end as u32),
            }
            first = end;
        }
        self.make_lone_batches();
    }

    /// Puts lone islands of a kind that take as many sub-steps together.
    fn make_lone_batches(&mut self) {
        let first = self.ranges.len();
        let mut lone = std::mem::take(&mut self.lone);
        lone.sort_unstable();
        for alike in lone.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            for batch in alike.chunks(LONE_ISLANDS) {
                self.add_batch(batch.iter().map(|&(.., island)| island));
            }
        }
        lone.clear();
        self.lone = lone;
        self.lone_ranges = first..self.ranges.len();
    }

    fn add_batch(&mut self, islands: impl Iterator<Item = u32>) {
        let first = self.order.len();
        self.order.extend(islands);
        self.ranges.push(first..self.order.len());
    }

    /// Loads and solves the batches.
    fn solve_batches(
        &mut self,
        problem: (&Manifolds, &Bodies),
        settings: &SubstepSettings,
        may_break: bool,
        team: Option<&Team>,
    ) {
        let follow_left = self.follow_left;
        self.solve_batches_from(0, problem, settings, may_break, team);
        let first = self.ranges.len();
        self.find_left_islands();
        self.solve_batches_from(first, problem, settings, may_break, team);
        self.list_solved();
        // Side by side, each as if it were the only one: the same by any number of threads.
        let solved = self.batches[self.earlier..][..self.ranges.len()].iter();
        let followed = solved.map(|batch| follow_left - batch.impacts.follow_left);
        self.follow_left = follow_left.saturating_sub(followed.sum());
    }

    /// Gives lone islands that turned out to need it batches of their own.
    fn find_left_islands(&mut self) {
        let end = self.order.len();
        for number in self.lone_ranges.clone() {
            let batch = &mut self.batches[self.earlier + number];
            let first = self.ranges[number].start;
            let order = &mut self.order;
            batch.leave_out(|member| order.push(order[first + member]));
        }
        for island in end..self.order.len() {
            self.ranges.push(island..island + 1);
        }
    }

    /// Loads and solves batches from a number on, on several threads if there is enough to do: large ones one after the other by
    /// all threads together, the others side by side.
    fn solve_batches_from(
        &mut self,
        first: usize,
        (manifolds, bodies): (&Manifolds, &Bodies),
        settings: &SubstepSettings,
        may_break: bool,
        team: Option<&Team>,
    ) {
        let count = self.earlier + self.ranges.len();
        self.batches
            .resize_with(count.max(self.batches.len()), Batch::default);
        let new_batches = &mut self.batches[self.earlier + first..count];
        let (ranges, lone_ranges) = (&self.ranges[first..], &self.lone_ranges);
        let of_lone = &self.ranges[lone_ranges.clone()];
        let lone = of_lone.first().map_or(0, |r| r.start)..of_lone.last().map_or(0, |r| r.end);
        let (islands, requirements, bonded) = (&self.islands, &self.requirements, &self.bonded);
        let (joints, follow_left, order) = (&self.joints, self.follow_left, &self.order);
        let solve = |batch: &mut Batch, range: &Range<usize>, team: Option<&Team>| {
            let group = &order[range.clone()];
            let requirement = &requirements[group[0] as usize];
            let step = Step {
                islands,
                manifolds,
                bodies,
                settings,
                team,
                may_break: may_break && !is_large(&islands.list[group[0] as usize]),
            };
            let group = Group {
                islands: group,
                is_lone: lone.contains(&range.start) && group.len() > 1,
            };
            batch.load(&step, group, requirement);
            batch.load_bonds(bonded, manifolds);
            batch.load_joints(joints, bodies);
            batch.impacts.follow_left = follow_left;
            batch.solve((manifolds, bodies), team);
        };
        let is_for_team = |range: &Range<usize>| {
            islands.manifolds_of(&order[range.clone()]) >= MANIFOLDS_WORTH_A_TEAM
        };
        let batches_and_ranges = new_batches.iter_mut().zip(ranges);
        for (batch, range) in batches_and_ranges.filter(|(_, range)| is_for_team(range)) {
            solve(batch, range, team);
        }
        let small = new_batches.iter_mut().zip(ranges);
        Team::each_of_many(team, small, |(batch, range)| {
            if !is_for_team(range) {
                solve(batch, range, None);
            }
        });
    }

    /// Whether an island does not share sweeps even if it is calm: a body that touches one other at several places, as one lies on a level
    /// of triangles, takes many sweeps or few.
    fn is_for_itself(&self, island: usize) -> bool {
        let Island {
            bodies, manifolds, ..
        } = &self.islands.list[island];
        bodies.len() == 2 && manifolds.len() > 1 && self.requirements[island].lone.is_some()
    }

    /// The first island that is not solved with the one at `first`: calm ones with the same sub-steps share a batch.
    fn end_of_batch(&self, first: usize) -> usize {
        let requirement = &self.requirements[first];
        let size = |i: usize| {
            let island = &self.islands.list[i];
            island.manifolds.len() + JOINT_WEIGHT * island.joints.len()
        };
        let (mut end, mut total) = (first + 1, size(first));
        while !requirement.can_hit
            && !self.is_for_itself(first)
            && end < self.requirements.len()
            && !self.is_deferred[end]
            && !self.is_for_itself(end)
            && self.requirements[end].is_solved_like(requirement)
            && total + size(end) <= BATCH_MANIFOLDS
        {
            total += size(end);
            end += 1;
        }
        end
    }
}
