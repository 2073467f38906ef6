//! Islands that are solved together: their bodies, blocks of contacts and buffers, in one piece of memory each.
//!
//! A batch shares nothing that is written with any other, so batches are loaded and solved side by side. Large islands and
//! those in which bodies may hit each other have a batch of their own; calm small ones share one, which fills its lanes.

mod bonds;
mod energy_guard;
mod exact_substep;
mod impacts;
pub mod layout;
mod motion;
mod overload;
mod parallel_pass;
mod reanchoring;
mod subdomain_slices;
pub mod substep;
mod warm_start;

use crate::bodies::breaking::{BreakingLimit, ImpactLoad};
use crate::bodies::free_rotation::FreeRotation;
use crate::bodies::solver_body::BodyMass;
use crate::bodies::solver_body::SolverBody;
use crate::bodies::store::Bodies;
use crate::contact::manifolds::{Manifolds, Run};
use crate::simd::lanes::F8;
use crate::solver::adaptivity::{IslandRequirements, SweepBudget};
use crate::solver::batch::layout::Layout;
use crate::solver::batch::subdomain_slices::{parts_by_body, parts_of_blocks};
use crate::solver::config::Method;
use crate::solver::exact::ExactScratch;
use crate::solver::graph::indices::LaneSlot;
use crate::solver::graph::islands::{Islands, MovingPair};
use crate::solver::rows::acceleration::AccelerationWeight;
use crate::solver::rows::contact_rows::{PointRows, RowBody};
use crate::solver::settings::SubstepSettings;
use crate::solver::wide::block::{Block, Point, PointImpact};
use crate::solver::wide::bond::BondConstraint;
use crate::solver::wide::prepare::{Source, derive_stale, fill};
use crate::solver::wide::reanchor::{AnchorStart, BodyRotation, ReanchoredBlock, ReanchoredBlocks};
use crate::threads::parts::{front, front_mut};
use crate::threads::team::{MAX_PARTS, Team};
use glam::{Mat3, Quat};
use std::ops::Range;

/// Least pairs of a part of which a team finds the largest extent: each takes some 5 ns.
const MIN_PAIRS: usize = 1024;

/// A body that turns, and its number within the batch.
#[derive(Clone, Copy, Debug)]
pub struct TurningBody {
    /// Number within the batch.
    pub body: u32,
    /// `world_from_body` at the start of the step.
    pub start: Quat,
    /// Its rotation.
    pub spin: FreeRotation,
    /// Inverse inertia tensor, body's axes, 1/(kg m2).
    pub inverse_inertia: Mat3,
}

impl TurningBody {
    /// Its rotation since the start of the step.
    pub fn turn(&self) -> Quat {
        self.spin.rotation * self.start.inverse()
    }
}

/// A manifold whose rows must follow the motion of its bodies.
#[derive(Clone, Copy, Debug)]
pub struct MovingManifold {
    /// Index of the manifold.
    pub manifold: u32,
    /// Where it is.
    pub place: LaneSlot,
    /// Numbers of its bodies within the batch.
    pub bodies: [u32; 2],
    /// Which of the two bodies the contact points move with: 0 for A, 1 for B.
    pub anchor_body: usize,
    /// If the two may pass through each other in the step: half the least extent of the anchor body, m.
    pub ccd_radius: Option<f32>,
}

/// What batches are loaded from.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// All islands.
    pub islands: &'a Islands,
    /// All manifolds.
    pub manifolds: &'a Manifolds,
    /// All bodies.
    pub bodies: &'a Bodies,
    /// The sub-steps of an island that asks for nothing.
    pub settings: &'a SubstepSettings,
    /// Who solves the subdomains of the batch together, if it is not for one thread.
    pub team: Option<&'a Team>,
    /// Whether the solve is to be given up when a body is overloaded.
    pub may_break: bool,
}

/// Islands with all that their sub-steps read and write; buffers are reused from step to step.
#[derive(Debug, Default)]
pub struct Batch {
    /// Who is where.
    pub layout: Layout,
    /// By island: the largest extent that a contact is measured by, the lesser of the least extents of two bodies, m.
    pub extents: Vec<f32>,
    /// Blocks of its manifolds.
    pub blocks: Vec<Block>,
    /// Points of its blocks.
    pub points: Vec<Point>,
    /// Blows of its points; none if nothing can hit.
    pub impacts: Vec<PointImpact>,
    /// Bonds of its points; none if nothing is bonded.
    pub bond_constraints: Vec<BondConstraint>,
    /// Velocities of its bodies, of one that nothing happens to, for the lanes that are not used, and
    /// of the copies.
    pub bodies: Vec<SolverBody>,
    /// Displacements of its bodies since the start of the step: center (m) and rotation vector (rad).
    pub displacements: Vec<SolverBody>,
    /// Masses and inertias of its bodies.
    pub solids: Vec<BodyMass>,
    /// Those of its bodies that turn.
    pub turning: Vec<TurningBody>,
    /// Those of its manifolds whose rows follow the motion.
    pub moving: Vec<MovingManifold>,
    /// Those of its blocks in which a manifold moves, ascending.
    pub(crate) reanchored: Vec<ReanchoredBlock>,
    /// Where the points of these were at the start of the step.
    pub(crate) starts: Vec<AnchorStart>,
    /// By body: how it has turned since the start of the step, if any of its manifolds moves.
    pub(crate) turns: Vec<BodyRotation>,
    /// Those of its bodies that break under too large an impulse.
    pub limits: Vec<BreakingLimit>,
    /// Those of its bodies (by slot) that are overloaded, and what they were hit with.
    pub overloaded: Vec<(u32, ImpactLoad)>,
    /// Whether the solve is to be given up when a body is overloaded.
    pub may_break: bool,
    /// Whether the solve was given up because a body breaks; velocities and motions mean nothing then.
    pub is_broken: bool,
    /// Whether any of its points rebounds.
    pub has_restitution: bool,
    /// How it is solved.
    pub settings: SubstepSettings,
    /// What it took.
    pub effort: SweepBudget,
    pub(crate) scratch: BatchScratch,
}

/// Buffers of the sub-steps.
#[derive(Debug, Default)]
pub(crate) struct BatchScratch {
    /// By block: its number among those that follow.
    pub(crate) reanchored_number: Vec<Option<u32>>,
    /// By body: whether its turn within the step matters to the rows.
    pub(crate) is_reanchored: Vec<bool>,
    pub(crate) exact: ExactScratch,
    pub(crate) acceleration: AccelerationWeight<f32>,
    /// Impulses and velocities of the sweep before.
    pub(crate) last_impulses: Vec<[F8; 3]>,
    pub(crate) last_bodies: Vec<SolverBody>,
    /// By body: whether a contact pushes it.
    pub(crate) is_pushed: Vec<bool>,
    /// By body: whether it was hit in this sub-step.
    pub(crate) is_hit: Vec<bool>,
    /// Points of a batch as rows, for the exact method.
    pub(crate) rows: Vec<PointRows>,
    /// Inverse inertia tensors of a batch, for the exact method.
    pub(crate) inertia: Vec<Mat3>,
    /// By body: its velocities at the start of the sub-step, then what contacts have added to them; empty if that is not known.
    pub(crate) contact_velocity_changes: Vec<SolverBody>,
    /// Velocities without contact impulses.
    pub(crate) free: Vec<SolverBody>,
    /// By island, if a tolerance depends on it: square of the largest speed before contacts act in the sub-step, m2/s2.
    pub(crate) fastest: Vec<f32>,
    /// Velocities at the start of the step, if a body may break.
    pub(crate) start: Vec<SolverBody>,
    /// By body: what it was hit with.
    pub(crate) impacts: Vec<ImpactLoad>,
}

impl Batch {
    /// Takes over the bodies and contacts of the islands in `range`, which ask for the same.
    pub fn load(&mut self, step: &Step, range: Range<usize>, demand: &IslandRequirements) {
        let Step {
            islands,
            manifolds,
            bodies,
            settings,
            team,
            may_break,
        } = *step;
        self.clear();
        self.settings = settings.for_requirements(demand);
        let layout = &mut self.layout;
        let is_kept = layout.number(islands, range.clone(), bodies, &self.settings, team);
        self.load_bodies(bodies, team);
        self.may_break = may_break;
        if !is_kept {
            let (blocks, points) = (&mut self.blocks, &mut self.points);
            let (layout, order) = (&mut self.layout, self.settings.config.order);
            layout.place(islands, range.clone(), &self.bodies, order, team);
            layout.name(blocks, points, team);
        }
        self.load_copies();
        for member in 0..self.layout.members.len() {
            self.measure(member, team);
            self.load_turning(member, bodies);
        }
        let first = islands.list[range.start].manifolds.start;
        for island in &islands.list[range.clone()] {
            self.load_moving(&islands.moving[island.moving.clone()], first, bodies);
        }
        self.load_limits(bodies);
        self.mark_reanchored();
        self.fill_blocks(manifolds, team);
        self.has_restitution = islands.list[range.clone()].iter().any(|i| i.bounces);
        if demand.can_hit || self.settings.config.method == Method::Exact {
            self.impacts
                .resize(self.points.len(), PointImpact::default());
        }
        let most_points = islands.list[range].iter().map(|i| i.points.len()).max();
        self.effort = SweepBudget::new(&self.settings.config, most_points.unwrap_or(0));
    }

    /// Makes the copies.
    fn load_copies(&mut self) {
        for &original in &self.layout.originals {
            self.bodies.push(self.bodies[original as usize]);
            self.solids.push(self.solids[original as usize]);
        }
        let count = self.bodies.len();
        self.displacements.resize(count, SolverBody::default());
    }

    fn fill_blocks(&mut self, manifolds: &Manifolds, team: Option<&Team>) {
        let config = &self.settings.config;
        let source = Source {
            manifolds,
            solids: &self.solids,
            share: 1.0 / config.substeps as f32,
            slop: config.slop,
        };
        let width = config.lane_width;
        let (mut reanchored, mut starts) = (
            ReanchoredBlocks::new(&self.reanchored),
            &mut self.starts[..],
        );
        let (blocks, points) = (&mut self.blocks, &mut self.points);
        let parts = parts_of_blocks(blocks, points, &self.layout.subdomains, team);
        let parts = parts.map(|(blocks, points)| {
            let reanchored = reanchored.take(blocks.len());
            let starts = front_mut(&mut starts, reanchored.points());
            (blocks, points, reanchored, starts)
        });
        Team::each(team, parts, |(blocks, points, reanchored, starts)| {
            fill(blocks, points, source, width);
            reanchored.start(blocks, points, starts);
        });
    }

    /// Computes masses and couplings anew where anchors and inertias have changed.
    pub(crate) fn derive_masses(&mut self, team: Option<&Team>) {
        let (solids, width) = (&self.solids, self.settings.config.lane_width);
        let (blocks, points) = (&mut self.blocks, &mut self.points);
        let mut reanchored = ReanchoredBlocks::new(&self.reanchored);
        let parts = parts_of_blocks(blocks, points, &self.layout.subdomains, team);
        let parts = parts.map(|(blocks, points)| {
            let reanchored = reanchored.take(blocks.len());
            (blocks, points, reanchored)
        });
        Team::each(team, parts, |(blocks, points, reanchored)| {
            derive_stale(blocks, points, solids, reanchored.blocks(), width);
        });
    }

    /// Lists the blocks, and marks the lanes and the bodies, of moving manifolds.
    fn mark_reanchored(&mut self) {
        self.reanchored.clear();
        if self.moving.is_empty() {
            return;
        }
        let number = &mut self.scratch.reanchored_number;
        number.clear();
        number.resize(self.blocks.len(), None);
        for moving in &self.moving {
            number[moving.place.block as usize] = Some(0);
        }
        let mut points = 0;
        let named = (0..).zip(number.iter_mut().zip(&self.blocks));
        for (block, (number, named)) in named.filter(|(_, (number, _))| number.is_some()) {
            *number = Some(self.reanchored.len() as u32);
            let first = points;
            points += named.points.len() as u32;
            self.reanchored.push(ReanchoredBlock {
                block,
                starts: [first, points],
                ..ReanchoredBlock::default()
            });
        }
        self.starts.resize(points as usize, AnchorStart::default());
        for moving in &self.moving {
            let (place, lane) = (moving.place, moving.place.lane as usize);
            let Some(number) = number[place.block as usize] else {
                continue;
            };
            let reanchored = &mut self.reanchored[number as usize];
            reanchored.moves.0[lane] = 1.0;
            reanchored.on_b.0[lane] = f32::from(moving.anchor_body == 1);
        }
        let is_reanchored = &mut self.scratch.is_reanchored;
        is_reanchored.clear();
        // Rows may name copies of fixed bodies.
        is_reanchored.extend(self.bodies.iter().map(|body| body.inverse_mass == 0.0));
        for body in self.moving.iter().flat_map(|moving| moving.bodies) {
            is_reanchored[body as usize] = true;
        }
    }

    /// Forgets the step before, but not who is where.
    fn clear(&mut self) {
        self.extents.clear();
        self.impacts.clear();
        self.bond_constraints.clear();
        self.bodies.clear();
        self.displacements.clear();
        self.solids.clear();
        self.turning.clear();
        self.moving.clear();
        self.limits.clear();
        self.overloaded.clear();
        self.is_broken = false;
    }

    /// Copies the bodies, and adds an dummy one.
    fn load_bodies(&mut self, bodies: &Bodies, team: Option<&Team>) {
        let (cuts, mut slots) = (&self.layout.cuts, &self.layout.slots[..]);
        self.bodies.resize(slots.len() + 1, SolverBody::default());
        self.solids
            .resize(slots.len() + 1, BodyMass::new(0.0, &Mat3::ZERO, 1.0));
        let parts = parts_by_body(&mut self.bodies, cuts);
        let parts = parts.zip(parts_by_body(&mut self.solids, cuts));
        let parts = parts.map(|part| {
            let count = part.0.len().min(slots.len());
            (front(&mut slots, count), part)
        });
        Team::each(team, parts, |(slots, part)| {
            let copies = part.0.iter_mut().zip(part.1.iter_mut());
            for (&slot, (body, solid)) in slots.iter().zip(copies) {
                let i = slot as usize;
                *body = bodies.velocity[i];
                *solid = BodyMass::new(
                    body.inverse_mass,
                    &bodies.inverse_inertia[i],
                    bodies.min_extent[i],
                );
            }
        });
    }

    /// Finds the largest extent that a contact of an island is measured by, if there is a tolerance that depends on it.
    fn measure(&mut self, member: usize, team: Option<&Team>) {
        if self.settings.config.tolerance.is_none() {
            return;
        }
        let member = &self.layout.members[member];
        let pairs = &self.layout.pairs[member.places.clone()];
        let solids = &self.solids;
        let extent = |pair: &[u32; 2]| {
            let [a, b] = pair.map(|number| solids[number as usize].extent());
            a.min(b)
        };
        let size = Team::part_size(team, pairs.len(), MIN_PAIRS);
        let mut most = [0.0; MAX_PARTS];
        let parts = pairs.chunks(size).zip(&mut most);
        Team::each(team, parts, |(pairs, most)| {
            *most = pairs.iter().map(extent).fold(0.0, f32::max);
        });
        self.extents.push(most.into_iter().fold(0.0, f32::max));
    }

    /// Lists the manifolds of an island whose rows follow the motion.
    fn load_moving(&mut self, moving: &[MovingPair], first: usize, bodies: &Bodies) {
        for pair in moving {
            let (manifold, place) = self.layout.places[pair.at - first];
            let numbers = self.layout.pairs[pair.at - first];
            let slots = numbers.map(|number| self.layout.slots[number as usize] as usize);
            let anchor_body = anchor_body(slots, bodies);
            let extent = bodies.min_extent[slots[anchor_body]];
            self.moving.push(MovingManifold {
                manifold,
                place,
                bodies: numbers,
                anchor_body,
                ccd_radius: pair.is_fast.then_some(0.5 * extent),
            });
        }
    }

    /// Lists the bodies of an island that turn.
    fn load_turning(&mut self, member: usize, bodies: &Bodies) {
        let step = self.settings.step();
        for number in self.layout.members[member].bodies.clone() {
            // Most do not, which is seen without a look at far memory.
            if !FreeRotation::is_noticeable(self.bodies[number].angular, step) {
                continue;
            }
            let slot = self.layout.slots[number];
            if let Some(spin) = bodies.spin(slot, step) {
                self.turning.push(TurningBody {
                    body: number as u32,
                    start: spin.rotation,
                    spin,
                    inverse_inertia: bodies.mass(slot).inverse_inertia(),
                });
            }
        }
    }

    /// Adds the rows of an island's points to `rows`, in the order of its manifolds, with numbers of bodies within the island.
    /// `places`: those of the island.
    pub fn collect_rows(&self, places: Range<usize>, first_body: u32, rows: &mut Vec<PointRows>) {
        for &(_, place) in &self.layout.places[places] {
            let (block, lane) = (&self.blocks[place.block as usize], place.lane as usize);
            for i in block.points.clone().take(place.count as usize) {
                let rebound = self
                    .impacts
                    .get(i)
                    .map_or(0.0, |impact| impact.rebound.0[lane]);
                let mut point =
                    self.points[i].rows(lane, block, self.bond_constraints.get(i), rebound);
                point.bodies = point
                    .bodies
                    .map(|body| self.layout.original(body) - first_body);
                rows.push(point);
            }
        }
    }

    /// Writes the impulses into the contact points of a run of manifolds, of which the first has the index `first`, and leaves
    /// out what is not among them.
    pub(crate) fn store_impulses(&self, run: &mut Run, first: usize) {
        let end = first + run.len();
        for member in &self.layout.members {
            // Those of one island come in their order.
            let places = &self.layout.places[member.places.clone()];
            let [from, to] =
                [first, end].map(|past| places.partition_point(|place| (place.0 as usize) < past));
            self.store_places(&places[from..to], first, run);
        }
    }

    /// `first`: index of the first manifold of the run.
    fn store_places(&self, places: &[(u32, LaneSlot)], first: usize, run: &mut Run) {
        let substeps = self.settings.config.substeps;
        for &(index, place) in places {
            let block = &self.blocks[place.block as usize];
            let to = run.points_of(index as usize - first);
            for (to, point) in to.iter_mut().zip(&self.points[block.points.clone()]) {
                point.store(place.lane as usize, block, to, substeps);
            }
        }
    }
}

/// What rows need to know of the body in a slot.
pub(crate) fn side(bodies: &Bodies, slot: usize) -> RowBody {
    RowBody {
        inverse_mass: bodies.velocity[slot].inverse_mass,
        inverse_inertia: bodies.inverse_inertia[slot],
    }
}

/// Which of two bodies carries their contact points: the smaller one, whose corners they mostly are, if it can move.
fn anchor_body(slots: [usize; 2], bodies: &Bodies) -> usize {
    let size = slots.map(|i| {
        let is_movable = bodies.velocity[i].inverse_mass > 0.0;
        if is_movable {
            bodies.radius(i as u32)
        } else {
            f32::INFINITY
        }
    });
    usize::from(size[1] <= size[0])
}
