//! From manifolds and bodies to new velocities, motions and impulses, batch of islands by batch.

use super::batch::{Batch, Step, side};
use super::bodies::{Bodies, Motion, SolverBody};
use super::demand::{Demand, Effort, SubstepSettings, Travel};
use super::islands::Islands;
use super::rows::{PointRows, Row};
use super::team::Team;
use super::ties::{BondedManifold, is_new_bond};
use crate::contact::manifold::Manifold;
use crate::math::rotate_by;
use bevy_tasks::ComputeTaskPool;
use glam::Vec3;
use std::ops::Range;

/// Calm islands are solved together until they have this many manifolds: enough to fill the lanes of their blocks.
const BATCH: usize = 192;

/// Manifolds from which it pays to ask other threads for help: about 100 us of work, ten times what they take to come.
const WORTH_HELP: usize = 256;

/// Manifolds of a batch from which all threads solve it together.
const WORTH_A_TEAM: usize = 1500;

/// Tasks for each thread, so that none waits long for the last one.
const TASKS_PER_THREAD: usize = 4;

/// The rows of a step and the working copies of the bodies they join; buffers are reused.
#[derive(Debug, Default)]
pub struct ContactSolver {
    islands: Islands,
    /// By island.
    demands: Vec<Demand>,
    /// Islands of each batch.
    ranges: Vec<Range<usize>>,
    /// As many as there are `ranges`, and perhaps some from other steps.
    batches: Vec<Batch>,
    /// By slot: whether a batch moves the body.
    is_solved: Vec<bool>,
    /// Those of the manifolds that are bonded, ascending.
    pub(crate) bonded: Vec<BondedManifold>,
}

/// An island after the solve.
#[derive(Clone, Debug)]
pub struct SolvedIsland<'a> {
    batch: &'a Batch,
    places: Range<usize>,
    first_body: u32,
    /// Number of its points.
    pub contacts: usize,
    /// Velocities of its bodies.
    pub bodies: &'a [SolverBody],
    /// Slots of its bodies.
    pub slots: &'a [u32],
    /// What it took, together with the others of its batch.
    pub effort: Effort,
}

impl SolvedIsland<'_> {
    /// Puts the rows of its points into `rows`, in the order of its manifolds.
    pub fn rows(&self, rows: &mut Vec<PointRows>) {
        rows.clear();
        let places = self.places.clone();
        self.batch.collect_rows(places, self.first_body, rows);
    }
}

impl ContactSolver {
    /// The islands of the last step.
    pub fn islands(&self) -> impl Iterator<Item = SolvedIsland<'_>> {
        self.solved().flat_map(move |batch| {
            let islands = &self.islands.list[batch.islands.clone()];
            let first = islands.first().map_or(0, |island| island.manifolds.start);
            islands
                .iter()
                .zip(&batch.members)
                .map(move |(island, member)| SolvedIsland {
                    batch,
                    places: island.manifolds.start - first..island.manifolds.end - first,
                    first_body: member.bodies.start as u32,
                    contacts: island.points.len(),
                    bodies: &batch.bodies[member.bodies.clone()],
                    slots: &batch.slots[member.bodies.clone()],
                    effort: batch.effort,
                })
        })
    }

    /// The batches of the last step.
    fn solved(&self) -> impl Iterator<Item = &Batch> {
        self.batches[..self.ranges.len()].iter()
    }

    /// Solves the contacts of `manifolds` and leaves in `bodies` the new velocities and how to move, in `manifolds` the
    /// impulses. `settings.h` is the length of a sub-step, s.
    pub fn solve(
        &mut self,
        manifolds: &mut [Manifold],
        bodies: &mut Bodies,
        settings: &SubstepSettings,
    ) {
        self.find_batches(manifolds, bodies, settings);
        self.solve_batches(manifolds, bodies, settings);
        self.write_back(bodies);
        self.move_free_bodies(bodies, settings);
        for batch in &self.batches[..self.ranges.len()] {
            batch.store_impulses(manifolds);
            batch.judge_bonds(&mut self.bonded);
        }
    }

    /// Finds the islands, what they ask for, and which are solved together.
    pub fn find_batches(
        &mut self,
        manifolds: &[Manifold],
        bodies: &Bodies,
        settings: &SubstepSettings,
    ) {
        self.islands.find(manifolds, bodies);
        self.demands.clear();
        for i in 0..self.islands.list.len() {
            let demand = self.demand(i, manifolds, bodies, settings);
            self.demands.push(demand);
        }
        self.ranges.clear();
        let mut first = 0;
        while first < self.demands.len() {
            let end = self.end_of_batch(first);
            self.ranges.push(first..end);
            first = end;
        }
        let count = self.ranges.len().max(self.batches.len());
        self.batches.resize_with(count, Batch::default);
    }

    /// Loads and solves the batches, on several threads if there is enough to do: large ones one after the other by all
    /// threads together, the others side by side.
    fn solve_batches(
        &mut self,
        manifolds: &[Manifold],
        bodies: &Bodies,
        settings: &SubstepSettings,
    ) {
        let (islands, demands, bonded) = (&self.islands, &self.demands, &self.bonded);
        let solve = |batch: &mut Batch, range: &Range<usize>, team: Option<&Team>| {
            let demand = &demands[range.start];
            let step = Step {
                islands,
                manifolds,
                bodies,
                settings,
                has_team: team.is_some(),
            };
            batch.load(&step, range.clone(), demand);
            batch.tie(bonded, manifolds);
            batch.solve(manifolds, team);
        };
        let batches = self.batches.iter_mut().zip(&self.ranges);
        let pool = ComputeTaskPool::try_get();
        let Some(pool) = pool.filter(|_| islands.manifolds.len() >= WORTH_HELP) else {
            return batches.for_each(|(batch, range)| solve(batch, range, None));
        };
        let size = |range: &Range<usize>| {
            let list = &islands.list[range.clone()];
            list.iter()
                .map(|island| island.manifolds.len())
                .sum::<usize>()
        };
        // Where bodies move, most of the work is done body by body, and helpers would only look on.
        let is_for_team =
            |range: &Range<usize>| size(range) >= WORTH_A_TEAM && !demands[range.start].can_hit;
        if self.ranges.iter().any(is_for_team) {
            let large = batches.filter(|(_, range)| is_for_team(range));
            Team::lead(pool, |team| {
                large.for_each(|(batch, range)| solve(batch, range, Some(team)));
            });
        }
        let small = self.batches.iter_mut().zip(&self.ranges);
        let mut small = small.filter(|(_, range)| !is_for_team(range));
        let tasks = TASKS_PER_THREAD * (pool.thread_num() + 1);
        let share = islands.manifolds.len().div_ceil(tasks);
        pool.scope(|scope| {
            while let Some(first) = small.next() {
                let mut part = vec![first];
                let mut total = size(part[0].1);
                while total < share
                    && let Some(next) = small.next()
                {
                    total += size(next.1);
                    part.push(next);
                }
                scope.spawn(async move {
                    for (batch, range) in part {
                        solve(batch, range, None);
                    }
                });
            }
        });
    }

    /// What an island asks for.
    fn demand(
        &self,
        island: usize,
        manifolds: &[Manifold],
        bodies: &Bodies,
        settings: &SubstepSettings,
    ) -> Demand {
        let mut demand = Demand::default();
        let has_load = settings.depends_on_load();
        for at in self.islands.list[island].manifolds.clone() {
            let index = self.islands.manifolds[at];
            let manifold = &manifolds[index as usize];
            let slots = [manifold.a as usize, manifold.b as usize];
            let extents = slots.map(|i| bodies.least_extent[i]);
            let extent = extents[0].min(extents[1]);
            let motion = Travel::of(slots.map(|i| &bodies.velocity[i]), extents, settings.step());
            demand.is_fast |= motion.is_fast;
            demand.can_hit |= motion.is_noticeable || manifold.restitution > 0.0;
            if has_load {
                // What has just landed bears at least its own weight.
                let mut load = settings.gravity.length() * settings.step();
                let sides = slots.map(|i| side(bodies, i));
                for point in manifold.points() {
                    let anchors = [point.anchor_a, point.anchor_b];
                    let row = Row::new(manifold.normal, anchors, sides);
                    load = load.max((point.normal_impulse * row.diagonal).abs());
                }
                if is_new_bond(&self.bonded, index) {
                    load = f32::INFINITY;
                }
                demand.load = demand.load.max(load / extent);
            }
        }
        demand.substeps = settings.substeps_for(&demand);
        demand
    }

    /// The first island that is not solved with the one at `first`: calm ones with the same sub-steps share a batch.
    fn end_of_batch(&self, first: usize) -> usize {
        let demand = &self.demands[first];
        let size = |i: usize| self.islands.list[i].manifolds.len();
        let (mut end, mut total) = (first + 1, size(first));
        while !demand.can_hit
            && end < self.demands.len()
            && self.demands[end].is_solved_like(demand)
            && total + size(end) <= BATCH
        {
            total += size(end);
            end += 1;
        }
        end
    }

    /// Takes velocities and motions of the bodies that contacts move back to their slots.
    fn write_back(&mut self, bodies: &mut Bodies) {
        self.is_solved.clear();
        self.is_solved.resize(bodies.slots(), false);
        for batch in &self.batches[..self.ranges.len()] {
            for (number, &slot) in batch.slots.iter().enumerate() {
                let (i, body) = (slot as usize, &batch.bodies[number]);
                if body.inverse_mass > 0.0 {
                    let moved = &batch.displacements[number];
                    self.is_solved[i] = true;
                    bodies.velocity[i] = *body;
                    bodies.motion[i] = Motion {
                        shift: moved.linear,
                        rotation: rotate_by(bodies.rotation[i], moved.angular, 1.0),
                    };
                }
            }
            for turning in &batch.turning {
                let slot = batch.slots[turning.body as usize] as usize;
                bodies.motion[slot].rotation = turning.spin.rotation;
            }
        }
    }

    /// Moves the bodies that touch nothing, exactly under constant acceleration: `x += h v + h^2 g / 2`.
    fn move_free_bodies(&mut self, bodies: &mut Bodies, settings: &SubstepSettings) {
        let step = settings.step();
        for slot in 0..bodies.slots() as u32 {
            let i = slot as usize;
            if self.is_solved[i] || !bodies.is_moving(slot) {
                continue;
            }
            let spin = bodies.spin(slot, step);
            let body = &mut bodies.velocity[i];
            let fall = if body.inverse_mass > 0.0 {
                settings.gravity * step
            } else {
                Vec3::ZERO
            };
            let shift = step * (body.linear + 0.5 * fall);
            body.linear += fall;
            let rotation = match spin {
                Some(mut spin) => {
                    for _ in 0..settings.config.substeps {
                        body.angular = spin.advance(body.angular, settings.h);
                    }
                    spin.rotation
                }
                None => rotate_by(bodies.rotation[i], body.angular, step),
            };
            bodies.motion[i] = Motion { shift, rotation };
        }
    }
}
