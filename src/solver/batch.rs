//! Islands that are solved together: their bodies, blocks of contacts and buffers, in one piece of memory each.
//!
//! A batch shares nothing that is written with any other, so batches are loaded and solved side by side. Large islands and
//! those in which bodies may hit each other have a batch of their own; calm small ones share one, which fills its lanes.

use super::Method;
use super::arrangement::{Arrangement, Joint, Rule};
use super::blocks::{Block, Blow, Place, Point, Solid, Source, derive, derive_stale, fill};
use super::bodies::{Bodies, SolverBody};
use super::demand::{Demand, Effort, SubstepSettings};
use super::domains::{self, Domains};
use super::exact::ExactScratch;
use super::follow::{Following, Start, Turn};
use super::islands::{Islands, MovingPair};
use super::lanes::F8;
use super::limit::{BodyBlow, Limit};
use super::momentum::Pace;
use super::rows::{PointRows, Side};
use super::schedule::ContactOrder;
use super::shares::{Parts, parts_of_blocks};
use super::spin::Spin;
use super::ties::Tie;
use crate::contact::manifold::Manifold;
use crate::parts::{front, front_mut};
use crate::team::Team;
use glam::{Mat3, Quat};
use std::ops::Range;

/// A body that turns, and its number within the batch.
#[derive(Clone, Copy, Debug)]
pub struct TurningBody {
    /// Number within the batch.
    pub body: u32,
    /// `world_from_body` at the start of the step.
    pub start: Quat,
    /// Its rotation.
    pub spin: Spin,
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
    pub place: Place,
    /// Numbers of its bodies within the batch.
    pub bodies: [u32; 2],
    /// Which of the two bodies the contact points move with: 0 for A, 1 for B.
    pub carrier: usize,
    /// If the two may pass through each other in the step: half the least extent of the carrier, m.
    pub clearance: Option<f32>,
}

/// An island of a batch.
#[derive(Clone, Debug, Default)]
pub struct Member {
    /// Its bodies within the batch.
    pub bodies: Range<usize>,
    /// Its manifolds within [`Batch::places`].
    pub places: Range<usize>,
    /// Number of its points.
    pub contacts: usize,
    /// The largest extent that a contact of its is measured by: the lesser of the least extents of two bodies, m.
    pub extent: f32,
}

/// What batches are loaded from.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// All islands.
    pub islands: &'a Islands,
    /// All manifolds.
    pub manifolds: &'a [Manifold],
    /// All bodies.
    pub bodies: &'a Bodies,
    /// The sub-steps of an island that asks for nothing.
    pub settings: &'a SubstepSettings,
    /// Who solves the domains of the batch together, if it is not for one thread.
    pub team: Option<&'a Team>,
    /// Whether the solve is to be given up when a body is overloaded.
    pub may_break: bool,
}

/// What the numbers of a batch's bodies and the places of its manifolds follow from, besides the cuts.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Origin {
    /// See [`Islands::revision`].
    islands: u64,
    range: Range<usize>,
    order: ContactOrder,
    method: Method,
    has_team: bool,
}

/// Islands with all that their sub-steps read and write; buffers are reused from step to step.
#[derive(Debug, Default)]
pub struct Batch {
    /// Its islands.
    pub members: Vec<Member>,
    /// Its manifolds in the order of the islands: index and place.
    pub places: Vec<(u32, Place)>,
    /// Blocks of its manifolds.
    pub blocks: Vec<Block>,
    /// Blocks of its [`domains`], in their order.
    pub domains: Vec<Range<usize>>,
    /// Points of its blocks.
    pub points: Vec<Point>,
    /// Blows of its points; none if nothing can hit.
    pub blows: Vec<Blow>,
    /// Bonds of its points; none if nothing is bonded.
    pub ties: Vec<Tie>,
    /// Slots of its bodies.
    pub slots: Vec<u32>,
    /// Numbers of the two bodies of each of its manifolds.
    pub(super) pairs: Vec<[u32; 2]>,
    /// Velocities of its bodies, and of one that nothing happens to, for the lanes that are not used.
    pub bodies: Vec<SolverBody>,
    /// Displacements of its bodies since the start of the step: centre (m) and rotation vector (rad).
    pub displacements: Vec<SolverBody>,
    /// Masses and inertias of its bodies.
    pub solids: Vec<Solid>,
    /// Of bodies that are copies, behind all others: which ones they copy.
    originals: Vec<u32>,
    /// Those of its bodies that turn.
    pub turning: Vec<TurningBody>,
    /// Those of its manifolds whose rows follow the motion.
    pub moving: Vec<MovingManifold>,
    /// Where its points were at the start of the step, if any of its manifolds moves.
    pub(super) starts: Vec<Start>,
    /// By block: which of its lanes follow the motion, likewise.
    pub(super) following: Vec<Following>,
    /// By body: how it has turned since the start of the step, likewise.
    pub(super) turns: Vec<Turn>,
    /// Those of its bodies that break under too large an impulse.
    pub limits: Vec<Limit>,
    /// Those of its bodies (by slot) that are overloaded, and what they were hit with.
    pub overloaded: Vec<(u32, BodyBlow)>,
    /// Whether the solve is to be given up when a body is overloaded.
    pub may_break: bool,
    /// Whether the solve was given up because a body breaks; velocities and motions mean nothing then.
    pub is_broken: bool,
    /// Whether any of its points rebounds.
    pub has_restitution: bool,
    /// How it is solved.
    pub settings: SubstepSettings,
    /// What it took.
    pub effort: Effort,
    pub(super) scratch: BatchScratch,
    pub(super) cuts: Domains,
    arrangement: Arrangement,
    origin: Option<Origin>,
}

/// Buffers of the sub-steps.
#[derive(Debug, Default)]
pub(super) struct BatchScratch {
    /// By body: the number of its copy.
    copies: Vec<Option<u32>>,
    /// By body: whether its turn within the step matters to the rows.
    pub(super) is_followed: Vec<bool>,
    pub(super) exact: ExactScratch,
    pub(super) pace: Pace<f32>,
    /// Impulses and velocities of the sweep before.
    pub(super) last_impulses: Vec<[F8; 3]>,
    pub(super) last_bodies: Vec<SolverBody>,
    /// By body: whether a contact pushes it.
    pub(super) is_pushed: Vec<bool>,
    /// By body: whether it was hit in this sub-step.
    pub(super) is_hit: Vec<bool>,
    /// Points of a batch as rows, for the exact method.
    pub(super) rows: Vec<PointRows>,
    /// Inverse inertia tensors of a batch, for the exact method.
    pub(super) inertia: Vec<Mat3>,
    /// Velocities without contact impulses.
    pub(super) free: Vec<SolverBody>,
    /// Velocities at the start of the step, if a body may break.
    pub(super) start: Vec<SolverBody>,
    /// By body: what it was hit with.
    pub(super) blows: Vec<BodyBlow>,
}

impl Batch {
    /// Takes over the bodies and contacts of the islands in `range`, which ask for the same.
    pub fn load(&mut self, step: &Step, range: Range<usize>, demand: &Demand) {
        let Step {
            islands,
            manifolds,
            bodies,
            settings,
            team,
            may_break,
        } = *step;
        self.clear();
        self.settings = settings.for_demand(demand);
        let is_kept = self.keep_layout(range.clone(), step);
        if !is_kept {
            self.load_islands(range.clone(), islands);
        }
        self.load_bodies(bodies);
        self.may_break = may_break;
        self.add_idle_body();
        if !is_kept {
            self.place_manifolds(range.clone(), islands);
            self.make_blocks();
            self.fill_lanes();
            self.originals.clear();
            if team.is_some() {
                self.name_copies();
            }
        }
        self.load_copies();
        for member in 0..self.members.len() {
            self.measure(member);
            self.load_turning(member, bodies);
        }
        let first = islands.list[range.start].manifolds.start;
        for island in &islands.list[range.clone()] {
            self.load_moving(&islands.moving[island.moving.clone()], first, bodies);
        }
        self.load_limits(bodies);
        self.fill_blocks(manifolds, team);
        let restitution = self.blocks.iter().flat_map(|block| block.restitution.0);
        self.has_restitution = restitution.fold(0.0, f32::max) > 0.0;
        self.mark_following();
        if demand.can_hit || self.settings.config.method == Method::Exact {
            self.blows.resize(self.points.len(), Blow::default());
        }
        let most_points = islands.list[range].iter().map(|i| i.points.len()).max();
        self.effort = Effort::new(&self.settings.config, most_points.unwrap_or(0));
    }

    /// Gives each domain its own copies of the fixed bodies and of the idle one, so that domains of a stage, which different
    /// threads solve, write to different bodies.
    fn name_copies(&mut self) {
        let count = self.bodies.len();
        let copies = &mut self.scratch.copies;
        for domain in &self.domains[1..] {
            copies.clear();
            copies.resize(count, None);
            for block in &mut self.blocks[domain.clone()] {
                for number in block.bodies.as_flattened_mut() {
                    if self.bodies[*number as usize].inverse_mass > 0.0 {
                        continue;
                    }
                    let original = *number;
                    *number = *copies[original as usize].get_or_insert_with(|| {
                        self.originals.push(original);
                        (count + self.originals.len()) as u32 - 1
                    });
                }
            }
        }
    }

    /// Makes the copies.
    fn load_copies(&mut self) {
        for &original in &self.originals {
            self.bodies.push(self.bodies[original as usize]);
            self.solids.push(self.solids[original as usize]);
        }
        let count = self.bodies.len();
        self.displacements.resize(count, SolverBody::default());
    }

    fn fill_blocks(&mut self, manifolds: &[Manifold], team: Option<&Team>) {
        let config = &self.settings.config;
        let source = Source {
            manifolds,
            solids: &self.solids,
            share: 1.0 / config.substeps as f32,
            slop: config.slop,
        };
        let width = config.lane_width;
        let follows = !self.moving.is_empty();
        self.starts
            .resize(self.points.len() * usize::from(follows), Start::default());
        let mut starts = &mut self.starts[..];
        let (blocks, points) = (&mut self.blocks, &mut self.points);
        let parts = parts_of_blocks(blocks, points, &self.domains, team);
        let parts = parts.into_iter().map(|(blocks, points)| {
            let count = points.len() * usize::from(follows);
            (blocks, points, front_mut(&mut starts, count))
        });
        let mut parts: Parts<_> = parts.collect();
        Team::each(team, &mut parts, |(blocks, points, starts)| {
            fill(blocks, points, source, width);
            derive(blocks, points, source.solids, width);
            for (start, point) in starts.iter_mut().zip(points.iter()) {
                *start = Start::of(point);
            }
        });
    }

    /// Computes masses and couplings anew where anchors and inertias have changed.
    pub(super) fn derive_masses(&mut self, team: Option<&Team>) {
        let (solids, width) = (&self.solids, self.settings.config.lane_width);
        let (blocks, points) = (&mut self.blocks, &mut self.points);
        let mut following = &self.following[..];
        let parts = parts_of_blocks(blocks, points, &self.domains, team);
        let parts = parts.into_iter().map(|(blocks, points)| {
            let following = front(&mut following, blocks.len());
            (blocks, points, following)
        });
        let mut parts: Parts<_> = parts.collect();
        Team::each(team, &mut parts, |(blocks, points, following)| {
            let is_stale = following.iter().map(|following| following.any);
            derive_stale(blocks, points, solids, is_stale, width);
        });
    }

    /// Marks the lanes and the bodies of moving manifolds.
    fn mark_following(&mut self) {
        if self.moving.is_empty() {
            return;
        }
        self.following.clear();
        self.following
            .resize(self.blocks.len(), Following::default());
        for moving in &self.moving {
            let (place, lane) = (moving.place, moving.place.lane as usize);
            let following = &mut self.following[place.block as usize];
            following.any = true;
            following.moves.0[lane] = 1.0;
            following.on_b.0[lane] = f32::from(moving.carrier == 1);
        }
        let is_followed = &mut self.scratch.is_followed;
        is_followed.clear();
        // Rows may name copies of fixed bodies.
        is_followed.extend(self.bodies.iter().map(|body| body.inverse_mass == 0.0));
        for body in self.moving.iter().flat_map(|moving| moving.bodies) {
            is_followed[body as usize] = true;
        }
    }

    /// Forgets the step before, but not who is where.
    fn clear(&mut self) {
        self.blows.clear();
        self.ties.clear();
        self.bodies.clear();
        self.displacements.clear();
        self.solids.clear();
        self.turning.clear();
        self.moving.clear();
        self.limits.clear();
        self.overloaded.clear();
        self.is_broken = false;
    }

    /// Whether the numbers of bodies and the places of manifolds are still those that the islands in `range` would get.
    fn keep_layout(&mut self, range: Range<usize>, step: &Step) -> bool {
        let SubstepSettings { config, .. } = &self.settings;
        let origin = Some(Origin {
            islands: step.islands.revision,
            range: range.clone(),
            order: config.order,
            method: config.method,
            has_team: step.team.is_some(),
        });
        let is_cut_as_before = self.cut_domains(range, step);
        let is_kept = is_cut_as_before && self.origin == origin;
        self.origin = origin;
        is_kept
    }

    /// Numbers the bodies of the islands.
    fn load_islands(&mut self, range: Range<usize>, islands: &Islands) {
        self.members.clear();
        self.slots.clear();
        self.pairs.clear();
        let first = islands.list[range.start].manifolds.start;
        for island in &islands.list[range] {
            let offset = self.slots.len() as u32;
            self.slots
                .extend_from_slice(&islands.slots[island.bodies.clone()]);
            let pairs = islands.pairs[island.manifolds.clone()].iter();
            self.pairs
                .extend(pairs.map(|pair| pair.map(|number| number + offset)));
            let Range { start, end } = island.manifolds;
            self.members.push(Member {
                bodies: offset as usize..self.slots.len(),
                places: start - first..end - first,
                contacts: island.points.len(),
                ..Member::default()
            });
        }
        self.cuts.sort(&mut self.slots, &mut self.pairs);
    }

    /// Cuts a large island into domains; whether that gave the same ones as before.
    fn cut_domains(&mut self, range: Range<usize>, step: &Step) -> bool {
        let Step {
            islands, bodies, ..
        } = step;
        let SubstepSettings {
            config, gravity, ..
        } = &self.settings;
        let [island] = &islands.list[range] else {
            return self.cuts.keep_whole();
        };
        let leaves = domains::leaves(island.manifolds.len());
        if leaves == 1 || config.method == Method::Exact {
            return self.cuts.keep_whole();
        }
        let slots = &islands.slots[island.bodies.clone()];
        let centres = slots.iter().map(|&slot| {
            let is_movable = bodies.velocity[slot as usize].inverse_mass > 0.0;
            is_movable.then(|| bodies.centre[slot as usize])
        });
        self.cuts.cut(centres, *gravity, leaves)
    }

    /// Copies the bodies.
    fn load_bodies(&mut self, bodies: &Bodies) {
        let slots = || self.slots.iter().map(|&slot| slot as usize);
        self.bodies.extend(slots().map(|i| bodies.velocity[i]));
        self.solids.extend(slots().map(|i| {
            let inverse_mass = bodies.velocity[i].inverse_mass;
            Solid::new(
                inverse_mass,
                &bodies.inverse_inertia[i],
                bodies.least_extent[i],
            )
        }));
    }

    fn add_idle_body(&mut self) {
        self.bodies.push(SolverBody::default());
        self.solids.push(Solid::new(0.0, &Mat3::ZERO, 1.0));
        let count = self.bodies.len();
        self.displacements.resize(count, SolverBody::default());
    }

    /// Gives each manifold a lane.
    fn place_manifolds(&mut self, range: Range<usize>, islands: &Islands) {
        let rule = Rule {
            order: self.settings.config.order,
            bodies: self.bodies.len(),
            domains: self.cuts.count(),
        };
        let of_batch = islands.list[range]
            .iter()
            .flat_map(|island| island.manifolds.clone());
        let (bodies, cuts) = (&self.bodies, &self.cuts);
        let joints = self.pairs.iter().zip(of_batch.clone()).map(|(pair, at)| {
            let is_movable = |body: u32| bodies[body as usize].inverse_mass > 0.0;
            let bodies = pair.map(|body| is_movable(body).then_some(body));
            Joint {
                bodies,
                points: islands.counts[at],
                domain: cuts.of(bodies),
            }
        });
        self.arrangement.arrange(joints, rule);
        let names = of_batch.map(|at| islands.manifolds[at]);
        let places = self.arrangement.places().iter().copied();
        self.places.clear();
        self.places.extend(names.zip(places));
        self.domains.clear();
        self.domains.extend(self.arrangement.domains());
    }

    /// Makes blocks with empty lanes. What they hold from another step is overwritten when they are filled.
    fn make_blocks(&mut self) {
        let idle = self.slots.len() as u32;
        self.blocks
            .resize_with(self.arrangement.points_of_blocks().len(), Block::default);
        let mut points = 0;
        let counts = self.arrangement.points_of_blocks();
        for (block, count) in self.blocks.iter_mut().zip(counts) {
            block.clear(idle, points..points + count);
            points += count;
        }
        self.points.resize(points, Point::default());
    }

    /// Names the bodies and manifolds of the lanes.
    fn fill_lanes(&mut self) {
        for (pair, &(index, place)) in self.pairs.iter().zip(&self.places) {
            let block = &mut self.blocks[place.block as usize];
            block.put(place.lane as usize, index, *pair);
        }
    }

    /// Finds the largest extent that a contact of an island is measured by.
    fn measure(&mut self, member: usize) {
        let member = &mut self.members[member];
        let pairs = self.pairs[member.places.clone()].iter();
        let extents = pairs.map(|pair| {
            let [a, b] = pair.map(|number| self.solids[number as usize].extent());
            a.min(b)
        });
        member.extent = extents.fold(0.0, f32::max);
    }

    /// Lists the manifolds of an island whose rows follow the motion.
    fn load_moving(&mut self, moving: &[MovingPair], first: usize, bodies: &Bodies) {
        for pair in moving {
            let (manifold, place) = self.places[pair.at - first];
            let numbers = self.pairs[pair.at - first];
            let slots = numbers.map(|number| self.slots[number as usize] as usize);
            let carrier = carrier(slots, bodies);
            let extent = bodies.least_extent[slots[carrier]];
            self.moving.push(MovingManifold {
                manifold,
                place,
                bodies: numbers,
                carrier,
                clearance: pair.is_fast.then_some(0.5 * extent),
            });
        }
    }

    /// Lists the bodies of an island that turn.
    fn load_turning(&mut self, member: usize, bodies: &Bodies) {
        for number in self.members[member].bodies.clone() {
            let slot = self.slots[number];
            let spin = bodies.spin(slot, self.settings.step());
            if let Some(spin) = spin {
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
        for &(_, place) in &self.places[places] {
            let (block, lane) = (&self.blocks[place.block as usize], place.lane as usize);
            for i in block.points.clone().take(place.count as usize) {
                let rebound = self.blows.get(i).map_or(0.0, |blow| blow.rebound.0[lane]);
                let mut point = self.points[i].rows(lane, block, self.ties.get(i), rebound);
                point.bodies = point.bodies.map(|body| self.original(body) - first_body);
                rows.push(point);
            }
        }
    }

    /// The body itself, or the one that it is a copy of.
    fn original(&self, body: u32) -> u32 {
        let first_copy = self.bodies.len() - self.originals.len();
        let copy = (body as usize).checked_sub(first_copy);
        copy.map_or(body, |copy| self.originals[copy])
    }

    /// Writes the impulses into the contact points of `manifolds`, of which the first has the index `first`, and leaves out what
    /// is not among them.
    pub fn store_impulses(&self, manifolds: &mut [Manifold], first: usize) {
        let end = first + manifolds.len();
        for member in &self.members {
            // Those of one island come in their order.
            let places = &self.places[member.places.clone()];
            let [from, to] =
                [first, end].map(|past| places.partition_point(|place| (place.0 as usize) < past));
            self.store_places(&places[from..to], first, manifolds);
        }
    }

    /// `first`: index of the first one of `manifolds`.
    fn store_places(&self, places: &[(u32, Place)], first: usize, manifolds: &mut [Manifold]) {
        let substeps = self.settings.config.substeps;
        for &(index, place) in places {
            let block = &self.blocks[place.block as usize];
            let to = manifolds[index as usize - first].points_mut();
            for (to, point) in to.iter_mut().zip(&self.points[block.points.clone()]) {
                point.store(place.lane as usize, block, to, substeps);
            }
        }
    }
}

/// What rows need to know of the body in a slot.
pub(super) fn side(bodies: &Bodies, slot: usize) -> Side {
    Side {
        inverse_mass: bodies.velocity[slot].inverse_mass,
        inverse_inertia: bodies.inverse_inertia[slot],
    }
}

/// Which of two bodies carries their contact points: the smaller one, whose corners they mostly are, if it can move.
fn carrier(slots: [usize; 2], bodies: &Bodies) -> usize {
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
