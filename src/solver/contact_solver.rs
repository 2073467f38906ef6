//! From manifolds and bodies to new velocities, motions and impulses, batch of islands by batch.

use crate::bodies::breaking::ImpactLoad;
use crate::bodies::solver_body::{Motion, SolverBody};
use crate::bodies::store::Bodies;
use crate::contact::manifolds::{ManifoldHead, ManifoldRef, Manifolds};
use crate::contact::point::ContactPoint;
use crate::math::rotate_by;
use crate::solver::adaptivity::{IslandRequirements, SweepBudget};
use crate::solver::batch::layout::Member;
use crate::solver::batch::{Batch, Step};
use crate::solver::breakage_probe;
use crate::solver::breakage_probe::{BreakageProbe, is_large};
use crate::solver::graph::islands::Islands;
use crate::solver::graph::partition::MIN_MANIFOLDS;
use crate::solver::graph::relative_motion::RelativeMotion;
use crate::solver::rows::contact_rows::{PointRows, Row, RowBody};
use crate::solver::rows::residual::{ResidualSum, Solved};
use crate::solver::settings::SubstepSettings;
use crate::solver::wide::bond::{BondedManifold, is_new_bond};
use crate::threads::parts::run_parts;
use crate::threads::team::Team;
use std::ops::Range;

/// Calm islands are solved together until they have this many manifolds: enough to fill the lanes of their blocks.
const BATCH: usize = 192;

/// Manifolds from which it pays to ask other threads for help: about 100 us of work, ten times what they take to come.
const WORTH_HELP: usize = 256;

/// Manifolds from which it pays to have helpers look at them that are here anyway.
const WORTH_THOSE_PRESENT: usize = 1024;

/// Manifolds of a batch from which all threads solve it together: there are several subdomains then.
const WORTH_A_TEAM: usize = 2 * MIN_MANIFOLDS;

/// Least manifolds of a part of a list that a team works through: each takes some 50 ns.
const MIN_OF_PART: usize = 128;

/// The rows of a step and the working copies of the bodies they join; buffers are reused.
#[derive(Debug, Default)]
pub struct ContactSolver {
    pub(crate) islands: Islands,
    /// By manifold.
    estimates: Vec<ContactEstimate>,
    /// By island.
    pub(crate) requirements: Vec<IslandRequirements>,
    /// Islands of each batch.
    ranges: Vec<Range<usize>>,
    /// Those of earlier rounds of the step, then as many as there are `ranges`, and perhaps some from other steps.
    batches: Vec<Batch>,
    /// Those of the manifolds that are bonded, ascending.
    pub(crate) bonded: Vec<BondedManifold>,
    /// Number of batches from earlier rounds.
    earlier: usize,
    /// By slot: how far the bodies are in this step.
    pub(crate) progress: Vec<Progress>,
    /// By island: whether its rehearsal broke a body, so that it is not solved in this round.
    pub(crate) is_deferred: Vec<bool>,
    pub(crate) rehearsal: BreakageProbe,
}

/// What a manifold asks for.
#[derive(Clone, Copy, Debug, Default)]
struct ContactEstimate {
    travel: RelativeMotion,
    /// See [`load_of`]; 0 if nothing depends on it.
    load: f32,
}

/// How far a body is within a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Progress {
    /// As it was before the step.
    #[default]
    Pending,
    /// As before the step, because something in its island breaks.
    Deferred,
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

/// An island after the solve.
#[derive(Clone, Debug)]
pub struct SolvedIsland<'a> {
    batch: &'a Batch,
    member: &'a Member,
    /// Number of its points.
    pub contacts: usize,
    /// Velocities of its bodies.
    pub bodies: &'a [SolverBody],
    /// Slots of its bodies.
    pub slots: &'a [u32],
    /// What it took, together with the others of its batch.
    pub budget: SweepBudget,
}

impl SolvedIsland<'_> {
    /// Puts the rows of its points into `rows`, in the order of its manifolds.
    pub fn rows(&self, rows: &mut Vec<PointRows>) {
        rows.clear();
        let Member { places, bodies, .. } = self.member;
        let first_body = bodies.start as u32;
        self.batch.collect_rows(places.clone(), first_body, rows);
    }

    /// How far its rows, which `rows` is a buffer for, are from being solved.
    pub(crate) fn residual_sum(&self, rows: &mut Vec<PointRows>) -> ResidualSum {
        self.rows(rows);
        let settings = &self.batch.settings;
        let solved = Solved {
            friction: settings.friction,
            is_relaxed: settings.is_relaxed(),
        };
        ResidualSum::of(rows, self.bodies, solved)
    }
}

impl ContactSolver {
    /// The islands of the last step.
    pub fn islands(&self) -> impl Iterator<Item = SolvedIsland<'_>> {
        let batches = self.batches[..self.earlier + self.ranges.len()].iter();
        batches
            .filter(|batch| !batch.impacts.is_broken)
            .flat_map(|batch| {
                batch.layout.members.iter().map(move |member| SolvedIsland {
                    batch,
                    member,
                    contacts: member.contacts,
                    bodies: &batch.bodies.velocities[member.bodies.clone()],
                    slots: &batch.layout.slots[member.bodies.clone()],
                    budget: batch.budget,
                })
            })
    }

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
        Team::lead_if(manifolds.len() >= WORTH_A_TEAM, |team| {
            let is_many = team.is_none() && manifolds.len() >= WORTH_THOSE_PRESENT;
            Team::lead_present_if(is_many, |present| {
                self.find_islands(manifolds, bodies, settings, team.or(present));
            });
            self.is_deferred.clear();
            let is_deferred = round.may_break && self.rehearse(manifolds, bodies, settings);
            self.make_batches();
            // Now it is known whether a smaller scene has work for several threads.
            Team::lead_if(team.is_none() && self.is_worth_help(), |late| {
                let team = team.or(late);
                self.solve_batches(manifolds, bodies, settings, round.may_break, team);
                self.write_back(bodies);
                self.move_free_bodies(bodies, settings);
                self.store_impulses(manifolds, team);
            });
            let batches = &self.batches[self.earlier..][..self.ranges.len()];
            is_deferred || batches.iter().any(|batch| batch.impacts.is_broken)
        })
    }

    /// Takes back what contacts and bonds have borne.
    fn store_impulses(&mut self, manifolds: &mut Manifolds, team: Option<&Team>) {
        let batches = &self.batches[self.earlier..][..self.ranges.len()];
        let size = Team::part_size(team, manifolds.len(), MIN_OF_PART);
        let runs = manifolds.chunks_mut(size).enumerate();
        run_parts(team, runs, |(part, mut run)| {
            for batch in batches {
                batch.store_impulses(&mut run, part * size);
            }
        });
        for batch in batches.iter().filter(|batch| !batch.impacts.is_broken) {
            batch.update_bond_damage(&mut self.bonded);
        }
    }

    /// Bodies (by slot) that got through the step although they were hit with more than they bear, and with what.
    pub fn overloaded(&self) -> impl Iterator<Item = (u32, ImpactLoad)> {
        let batches = self.batches[..self.earlier + self.ranges.len()].iter();
        let solved = batches.filter(|batch| !batch.impacts.is_broken);
        solved.flat_map(|batch| batch.impacts.overloaded.iter().copied())
    }

    /// Whether the body in `slot` is as it was before the step, because something in its island breaks.
    pub fn is_deferred(&self, slot: u32) -> bool {
        self.progress.get(slot as usize) == Some(&Progress::Deferred)
    }

    /// Whether the body in `slot` is dynamic and has got its velocity and motion in this step.
    pub fn is_solved(&self, slot: u32) -> bool {
        self.progress.get(slot as usize) == Some(&Progress::Solved)
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

    /// Finds the islands and what they ask for.
    fn find_islands(
        &mut self,
        manifolds: &Manifolds,
        bodies: &Bodies,
        settings: &SubstepSettings,
        team: Option<&Team>,
    ) {
        let progress = &self.progress;
        let is_pending = |slot: u32| progress.get(slot as usize) != Some(&Progress::Solved);
        let is_pending = |m: &ManifoldHead| is_pending(m.a) && is_pending(m.b);
        self.islands
            .find(manifolds.heads(), bodies, is_pending, team);
        self.estimate_contacts(manifolds, bodies, settings, team);
        let estimates = &self.estimates;
        let travel = |manifold: u32| estimates[manifold as usize].travel;
        self.islands.find_moving(travel);
        self.requirements.clear();
        for i in 0..self.islands.list.len() {
            let requirement = self.requirement(i, settings);
            self.requirements.push(requirement);
        }
    }

    /// Looks what each manifold asks for.
    fn estimate_contacts(
        &mut self,
        manifolds: &Manifolds,
        bodies: &Bodies,
        settings: &SubstepSettings,
        team: Option<&Team>,
    ) {
        let (step, depends_on_load) = (settings.step_dt(), settings.depends_on_load());
        self.estimates
            .resize(manifolds.len(), ContactEstimate::default());
        let size = Team::part_size(team, manifolds.len(), MIN_OF_PART);
        let parts = self.estimates.chunks_mut(size).enumerate();
        run_parts(team, parts, |(part, estimates)| {
            for (index, wish) in (part * size..).zip(estimates) {
                let head = &manifolds.heads()[index];
                let slots = [head.a as usize, head.b as usize];
                wish.travel = RelativeMotion::of(bodies, slots, step);
                wish.load = if depends_on_load {
                    load_of(manifolds.at(index), bodies, settings)
                } else {
                    0.0
                };
            }
        });
    }

    /// How the bodies of a manifold move against each other.
    pub(crate) fn travel(&self, manifold: u32) -> RelativeMotion {
        self.estimates[manifold as usize].travel
    }

    /// Whether there is work for several threads.
    fn is_worth_help(&self) -> bool {
        let islands = &self.islands;
        let is_for_team = |range: &Range<usize>| islands.manifolds_of(range) >= WORTH_A_TEAM;
        // A single small batch is solved where its data are.
        islands.manifolds.len() >= WORTH_HELP
            && (self.ranges.len() > 1 || self.ranges.iter().any(is_for_team))
    }

    /// Decides which of the islands that are not set aside are solved together.
    fn make_batches(&mut self) {
        self.is_deferred.resize(self.requirements.len(), false);
        self.ranges.clear();
        let mut first = 0;
        while first < self.requirements.len() {
            if self.is_deferred[first] {
                first += 1;
                continue;
            }
            let end = self.end_of_batch(first);
            self.ranges.push(first..end);
            first = end;
        }
        let count = self.earlier + self.ranges.len();
        self.batches
            .resize_with(count.max(self.batches.len()), Batch::default);
    }

    /// Loads and solves the batches, on several threads if there is enough to do: large ones one after the other by all
    /// threads together, the others side by side.
    fn solve_batches(
        &mut self,
        manifolds: &Manifolds,
        bodies: &Bodies,
        settings: &SubstepSettings,
        may_break: bool,
        team: Option<&Team>,
    ) {
        let new_batches = &mut self.batches[self.earlier..][..self.ranges.len()];
        let (islands, requirements, bonded) = (&self.islands, &self.requirements, &self.bonded);
        let solve = |batch: &mut Batch, range: &Range<usize>, team: Option<&Team>| {
            let requirement = &requirements[range.start];
            let step = Step {
                islands,
                manifolds,
                bodies,
                settings,
                team,
                may_break: may_break && !is_large(&islands.list[range.start]),
            };
            batch.load(&step, range.clone(), requirement);
            batch.tie(bonded, manifolds);
            batch.solve(manifolds, team);
        };
        let is_for_team = |range: &Range<usize>| islands.manifolds_of(range) >= WORTH_A_TEAM;
        let batches_and_ranges = new_batches.iter_mut().zip(&self.ranges);
        for (batch, range) in batches_and_ranges.filter(|(_, range)| is_for_team(range)) {
            solve(batch, range, team);
        }
        let small = new_batches.iter_mut().zip(&self.ranges);
        run_parts(team, small, |(batch, range)| {
            if !is_for_team(range) {
                solve(batch, range, None);
            }
        });
    }

    /// What an island asks for.
    fn requirement(&self, island: usize, settings: &SubstepSettings) -> IslandRequirements {
        let island = &self.islands.list[island];
        let mut requirement = IslandRequirements {
            load: 0.0,
            can_hit: island.bounces || !island.moving.is_empty(),
            substeps: 0,
        };
        if settings.depends_on_load() {
            for &index in &self.islands.manifolds[island.manifolds.clone()] {
                let load = if is_new_bond(&self.bonded, index) {
                    f32::INFINITY
                } else {
                    self.estimates[index as usize].load
                };
                requirement.load = requirement.load.max(load);
            }
        }
        requirement.substeps = settings.substeps_for(&requirement);
        requirement
    }

    /// The first island that is not solved with the one at `first`: calm ones with the same sub-steps share a batch.
    fn end_of_batch(&self, first: usize) -> usize {
        let requirement = &self.requirements[first];
        let size = |i: usize| self.islands.list[i].manifolds.len();
        let (mut end, mut total) = (first + 1, size(first));
        while !requirement.can_hit
            && end < self.requirements.len()
            && !self.is_deferred[end]
            && self.requirements[end].is_solved_like(requirement)
            && total + size(end) <= BATCH
        {
            total += size(end);
            end += 1;
        }
        end
    }

    /// Takes velocities and motions of the bodies that contacts move back to their slots.
    fn write_back(&mut self, bodies: &mut Bodies) {
        let batches = &self.batches[self.earlier..][..self.ranges.len()];
        for batch in batches {
            if batch.impacts.is_broken {
                for (&slot, body) in batch.layout.slots.iter().zip(&batch.bodies.velocities) {
                    if body.inverse_mass > 0.0 {
                        self.progress[slot as usize] = Progress::Deferred;
                    }
                }
                continue;
            }
            for (number, &slot) in batch.layout.slots.iter().enumerate() {
                let (i, body) = (slot as usize, &batch.bodies.velocities[number]);
                if body.inverse_mass > 0.0 {
                    let moved = &batch.bodies.displacements[number];
                    self.progress[i] = Progress::Solved;
                    bodies.velocity[i] = *body;
                    bodies.motion[i] = Motion {
                        shift: moved.linear,
                        rotation: rotate_by(bodies.rotation[i], moved.angular, 1.0),
                    };
                }
            }
            for turning in &batch.bodies.turning {
                let slot = batch.layout.slots[turning.body as usize] as usize;
                bodies.motion[slot].rotation = turning.spin.rotation;
            }
        }
    }
}

/// Largest velocity that a contact of the manifold gave its effective mass in the last step, over the smaller body's least
/// extent, 1/s. What has just landed bears at least its own weight.
fn load_of(manifold: ManifoldRef, bodies: &Bodies, settings: &SubstepSettings) -> f32 {
    let slots = [manifold.a, manifold.b].map(|slot| slot as usize);
    let weight = settings.gravity.length() * settings.step_dt();
    let sides = slots.map(|i| RowBody::of(bodies, i));
    let velocity = |point: &ContactPoint| {
        let anchors = [point.anchor_a, point.anchor_b];
        let row = Row::new(manifold.normal, anchors, sides);
        (point.normal_impulse * row.diagonal).abs()
    };
    let velocities = manifold.points().iter().map(velocity);
    let [a, b] = slots.map(|i| bodies.min_extent[i]);
    velocities.fold(weight, f32::max) / a.min(b)
}

impl ContactSolver {
    /// Rehearses the large islands that have been found. Bodies of those in which a body breaks wait, and `manifolds` hold the
    /// impulses of the rehearsal; whether there are any.
    pub(crate) fn rehearse(
        &mut self,
        manifolds: &mut Manifolds,
        bodies: &Bodies,
        settings: &SubstepSettings,
    ) -> bool {
        self.is_deferred.clear();
        self.is_deferred.resize(self.islands.list.len(), false);
        if !bodies.any_fracturable() || !self.islands.list.iter().any(is_large) {
            return false;
        }
        let mut rehearsal = std::mem::take(&mut self.rehearsal);
        let anybody = rehearsal.choose(&self.islands, manifolds, bodies, settings);
        if anybody {
            let BreakageProbe {
                cast,
                islands,
                batch,
                ..
            } = &mut rehearsal;
            let takes_part = |slot: u32| cast[slot as usize] != breakage_probe::NONE;
            let moves = |slot: u32| bodies.velocity[slot as usize].inverse_mass > 0.0;
            let is_pending = |m: &ManifoldHead| {
                let counts = |slot: u32| takes_part(slot) || !moves(slot);
                counts(m.a) && counts(m.b) && (takes_part(m.a) || takes_part(m.b))
            };
            islands.find(manifolds.heads(), bodies, is_pending, None);
            islands.find_moving(|index| self.travel(index));
            for part in 0..islands.list.len() {
                let slots = &islands.slots[islands.list[part].bodies.clone()];
                let Some(&slot) = slots.iter().find(|&&slot| takes_part(slot)) else {
                    continue;
                };
                let whole = cast[slot as usize] as usize;
                let step = Step {
                    islands,
                    manifolds,
                    bodies,
                    settings,
                    team: None,
                    may_break: true,
                };
                batch.load(&step, part..part + 1, &self.requirements[whole]);
                batch.tie(&self.bonded, manifolds);
                batch.solve(manifolds, None);
                if batch.impacts.is_broken {
                    batch.store_impulses(&mut manifolds.whole(), 0);
                    self.is_deferred[whole] = true;
                }
            }
        }
        self.rehearsal = rehearsal;
        self.defer_island_bodies(bodies);
        self.is_deferred.contains(&true)
    }

    /// Notes that the bodies of islands that are set aside wait.
    fn defer_island_bodies(&mut self, bodies: &Bodies) {
        let islands = self.islands.list.iter().zip(&self.is_deferred);
        for (island, _) in islands.filter(|(_, is_deferred)| **is_deferred) {
            for &slot in &self.islands.slots[island.bodies.clone()] {
                if bodies.velocity[slot as usize].inverse_mass > 0.0 {
                    self.progress[slot as usize] = Progress::Deferred;
                }
            }
        }
    }
}
