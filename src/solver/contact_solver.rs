//! From manifolds and bodies to new velocities, motions and impulses, batch of islands by batch.

use super::Method;
use super::blocks::{Block, Blow, Place, Point, derive};
use super::bodies::{Bodies, Motion, SolverBody};
use super::islands::{Island, Islands};
use super::rows::{PointRows, Side};
use super::schedule::Schedule;
use super::substeps::{
    BatchProblem, BatchScratch, Demand, Effort, Member, MovingManifold, SubstepSettings,
    TurningBody,
};
use crate::contact::manifold::Manifold;
use crate::math::rotate_by;
use glam::{Mat3, Vec3};
use std::ops::Range;

/// Turn within a step (rad) from which the rows of a body's contacts follow it.
const TURN: f32 = 0.01;

/// Travel of two bodies against each other within a step, as a share of the smaller one's least extent, from which the
/// rows of their contact follow it.
const TRAVEL: f32 = 0.02;

/// Calm islands are solved together until they have this many manifolds: enough to fill the lanes of their blocks.
const BATCH: usize = 64;

/// The rows of a step and the working copies of the bodies they join; buffers are reused.
///
/// Bodies, blocks and points lie batch by batch, so that the sub-steps of a batch run in a few contiguous slices.
#[derive(Debug, Default)]
pub struct ContactSolver {
    islands: Islands,
    /// By island.
    demands: Vec<Demand>,
    members: Vec<Member>,
    parts: Vec<Part>,
    /// By manifold, in the order of the islands: its index and its place in its batch.
    places: Vec<(u32, Place)>,
    blocks: Vec<Block>,
    points: Vec<Point>,
    blows: Vec<Blow>,
    /// Bodies of each batch, and one that nothing happens to for the lanes that are not used.
    bodies: Vec<SolverBody>,
    displacements: Vec<SolverBody>,
    inverse_inertia: Vec<Mat3>,
    turning: Vec<TurningBody>,
    moving: Vec<MovingManifold>,
    schedule: Schedule,
    /// By block of the batch being prepared: points of its largest manifold.
    block_points: Vec<u32>,
    /// By number within the island being prepared: place among the bodies of the batch that turn.
    turning_place: Vec<Option<u32>>,
    /// By slot: whether a batch moves the body.
    is_solved: Vec<bool>,
    scratch: BatchScratch,
}

/// A batch: islands that are solved together.
#[derive(Clone, Debug)]
struct Part {
    islands: Range<usize>,
    manifolds: Range<usize>,
    blocks: Range<usize>,
    points: Range<usize>,
    blows: Range<usize>,
    bodies: Range<usize>,
    turning: Range<usize>,
    moving: Range<usize>,
    has_restitution: bool,
    settings: SubstepSettings,
    effort: Effort,
}

/// An island after the solve.
#[derive(Clone, Copy, Debug)]
pub struct SolvedIsland<'a> {
    places: &'a [(u32, Place)],
    manifolds: &'a [Manifold],
    blocks: &'a [Block],
    points: &'a [Point],
    blows: &'a [Blow],
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
    /// Rows of its points, in the order of its manifolds.
    pub fn rows(&self) -> Vec<PointRows> {
        let of_manifold = |&(manifold, place): &(u32, Place)| {
            let block = &self.blocks[place.block as usize];
            let count = self.manifolds[manifold as usize].count as usize;
            block.points.clone().take(count).map(move |i| {
                let lane = place.lane as usize;
                let rebound = self.blows.get(i).map_or(0.0, |blow| blow.rebound.0[lane]);
                let mut rows = self.points[i].rows(lane, block, rebound);
                rows.bodies = rows.bodies.map(|body| body - self.first_body);
                rows
            })
        };
        self.places.iter().flat_map(of_manifold).collect()
    }
}

impl ContactSolver {
    /// The islands of the last step, whose `manifolds` these are.
    pub fn islands<'a>(
        &'a self,
        manifolds: &'a [Manifold],
    ) -> impl Iterator<Item = SolvedIsland<'a>> {
        self.parts.iter().flat_map(move |part| {
            part.islands.clone().map(move |i| {
                let (island, member) = (&self.islands.list[i], &self.members[i]);
                SolvedIsland {
                    places: &self.places[island.manifolds.clone()],
                    manifolds,
                    blocks: &self.blocks[part.blocks.clone()],
                    points: &self.points[part.points.clone()],
                    blows: &self.blows[part.blows.clone()],
                    first_body: member.bodies.start as u32,
                    contacts: island.points.len(),
                    bodies: &self.bodies[part.bodies.clone()][member.bodies.clone()],
                    slots: &self.islands.slots[island.bodies.clone()],
                    effort: part.effort,
                }
            })
        })
    }

    /// Solves the contacts of `manifolds` and leaves in `bodies` the new velocities and how to move, in `manifolds` the
    /// impulses. `settings.h` is the length of a sub-step, s.
    pub fn solve(
        &mut self,
        manifolds: &mut [Manifold],
        bodies: &mut Bodies,
        settings: &SubstepSettings,
    ) {
        self.prepare(manifolds, bodies, settings);
        for part in &mut self.parts {
            let mut problem = BatchProblem {
                members: &self.members[part.islands.clone()],
                places: &self.places[part.manifolds.clone()],
                blocks: &mut self.blocks[part.blocks.clone()],
                points: &mut self.points[part.points.clone()],
                blows: &mut self.blows[part.blows.clone()],
                bodies: &mut self.bodies[part.bodies.clone()],
                displacements: &mut self.displacements[part.bodies.clone()],
                inverse_inertia: &mut self.inverse_inertia[part.bodies.clone()],
                turning: &mut self.turning[part.turning.clone()],
                moving: &self.moving[part.moving.clone()],
                manifolds,
                has_restitution: part.has_restitution,
                scratch: &mut self.scratch,
            };
            problem.solve(&part.settings, &mut part.effort);
        }
        self.write_back(bodies);
        self.move_free_bodies(bodies, settings);
        self.store_impulses(manifolds);
    }

    /// Finds the islands, copies their bodies and builds their rows.
    pub fn prepare(&mut self, manifolds: &[Manifold], bodies: &Bodies, settings: &SubstepSettings) {
        self.islands.find(manifolds, bodies);
        self.clear();
        for i in 0..self.islands.list.len() {
            let demand = self.demand(i, manifolds, bodies, settings);
            self.demands.push(demand);
        }
        let mut first = 0;
        while first < self.demands.len() {
            let end = self.end_of_batch(first);
            self.load_batch(first..end, manifolds, bodies, settings);
            first = end;
        }
    }

    fn clear(&mut self) {
        self.demands.clear();
        self.members.clear();
        self.parts.clear();
        self.places.clear();
        self.blocks.clear();
        self.points.clear();
        self.blows.clear();
        self.bodies.clear();
        self.displacements.clear();
        self.inverse_inertia.clear();
        self.turning.clear();
        self.moving.clear();
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
            let manifold = &manifolds[self.islands.manifolds[at] as usize];
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
                    let row = super::rows::Row::new(manifold.normal, anchors, sides);
                    load = load.max(point.normal_impulse * row.diagonal);
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

    fn load_batch(
        &mut self,
        islands: Range<usize>,
        manifolds: &[Manifold],
        bodies: &Bodies,
        settings: &SubstepSettings,
    ) {
        let settings = settings.for_demand(&self.demands[islands.start]);
        let can_hit = self.demands[islands.start].can_hit;
        let list = &self.islands.list;
        let of_manifolds = list[islands.start].manifolds.start..list[islands.end - 1].manifolds.end;
        let most_points = list[islands.clone()].iter().map(|i| i.points.len()).max();
        let (first_body, first_turning) = (self.bodies.len(), self.turning.len());
        let (first_moving, first_blow) = (self.moving.len(), self.blows.len());
        self.load_bodies(islands.clone(), first_body, bodies);
        let [blocks, points] = self.place_manifolds(islands.clone(), manifolds, first_body);
        for i in islands.clone() {
            self.fill_lanes(i, [first_turning, blocks.start, points.start], manifolds, bodies, &settings);
        }
        derive(&self.blocks[blocks.clone()], &mut self.points[points.clone()], settings.config.lane_width);
        if can_hit || settings.config.method == Method::Exact {
            self.blows.resize(first_blow + points.len(), Blow::default());
        }
        let has_restitution = self.blocks[blocks.clone()]
            .iter()
            .any(|block| block.restitution.0.iter().any(|&e| e > 0.0));
        self.parts.push(Part {
            islands,
            manifolds: of_manifolds,
            blocks,
            points,
            blows: first_blow..self.blows.len(),
            bodies: first_body..self.bodies.len(),
            turning: first_turning..self.turning.len(),
            moving: first_moving..self.moving.len(),
            has_restitution,
            settings,
            effort: Effort::new(&settings.config, most_points.unwrap_or(0)),
        });
    }

    /// Copies the bodies of a batch, and adds the idle one.
    fn load_bodies(&mut self, islands: Range<usize>, first_body: usize, bodies: &Bodies) {
        for i in islands {
            let first = self.bodies.len() - first_body;
            for &slot in &self.islands.slots[self.islands.list[i].bodies.clone()] {
                self.bodies.push(bodies.velocity[slot as usize]);
                self.inverse_inertia
                    .push(bodies.inverse_inertia[slot as usize]);
            }
            self.members.push(Member {
                bodies: first..self.bodies.len() - first_body,
                speed_scale: f32::INFINITY,
            });
        }
        self.bodies.push(SolverBody::default());
        self.inverse_inertia.push(Mat3::ZERO);
        self.displacements
            .resize(self.bodies.len(), SolverBody::default());
    }

    /// Gives each manifold of a batch a lane; returns its blocks and points.
    fn place_manifolds(
        &mut self,
        islands: Range<usize>,
        manifolds: &[Manifold],
        first_body: usize,
    ) -> [Range<usize>; 2] {
        let idle = self.bodies.len() - first_body - 1;
        self.schedule.begin(idle);
        self.block_points.clear();
        for i in islands {
            let offset = self.members[i].bodies.start as u32;
            for at in self.islands.list[i].manifolds.clone() {
                let movable = self.islands.pairs[at].map(|number| {
                    let number = number + offset;
                    let body = &self.bodies[first_body + number as usize];
                    (body.inverse_mass > 0.0).then_some(number)
                });
                let place = self.schedule.place(movable);
                self.block_points.resize(self.schedule.blocks(), 0);
                let index = self.islands.manifolds[at];
                let most = &mut self.block_points[place.block as usize];
                *most = (*most).max(manifolds[index as usize].count);
                self.places.push((index, place));
            }
        }
        let (first_block, first_point) = (self.blocks.len(), self.points.len());
        let mut points = 0;
        for &count in &self.block_points {
            let mut block = Block::empty(idle as u32, points);
            points += count as usize;
            block.points.end = points;
            self.blocks.push(block);
        }
        self.points.resize(first_point + points, Point::default());
        [
            first_block..self.blocks.len(),
            first_point..self.points.len(),
        ]
    }

    /// Fills the lanes of an island's manifolds, with the impulses of the last step, and lists bodies and manifolds that move.
    fn fill_lanes(
        &mut self,
        island: usize,
        [first_turning, first_block, first_point]: [usize; 3],
        manifolds: &[Manifold],
        bodies: &Bodies,
        settings: &SubstepSettings,
    ) {
        let range = self.islands.list[island].clone();
        let offset = self.members[island].bodies.start as u32;
        self.load_turning(&range, offset, first_turning, bodies, settings);
        let share = 1.0 / settings.config.substeps as f32;
        for at in range.manifolds {
            let (index, place) = self.places[at];
            let (manifold, lane) = (&manifolds[index as usize], place.lane as usize);
            let slots = [manifold.a as usize, manifold.b as usize];
            let extents = slots.map(|i| bodies.least_extent[i]);
            let extent = extents[0].min(extents[1]);
            let pair = self.islands.pairs[at];
            let block = &mut self.blocks[first_block + place.block as usize];
            let sides = slots.map(|i| side(bodies, i));
            block.set_manifold(lane, manifold, &sides, extent, settings.config.slop);
            block.manifolds[lane] = index;
            block.used += 1;
            for (side, number) in block.bodies.iter_mut().zip(pair) {
                side[lane] = number + offset;
            }
            let points = &mut self.points[first_point..][block.points.clone()];
            for (to, point) in points.iter_mut().zip(manifold.points()) {
                to.set(lane, block, point, share);
            }
            let least = &mut self.members[island].speed_scale;
            *least = least.min(block.speed_scale.0[lane]);
            let motion = Travel::of(slots.map(|i| &bodies.velocity[i]), extents, settings.step());
            if motion.is_noticeable {
                let carrier = carrier(slots, bodies);
                self.moving.push(MovingManifold {
                    manifold: index,
                    place,
                    bodies: pair.map(|number| number + offset),
                    turning: pair.map(|number| self.turning_place[number as usize]),
                    carrier,
                    clearance: motion.is_fast.then_some(0.5 * extents[carrier]),
                });
            }
        }
    }

    /// Lists the bodies of an island that turn.
    fn load_turning(
        &mut self,
        island: &Island,
        offset: u32,
        first_turning: usize,
        bodies: &Bodies,
        settings: &SubstepSettings,
    ) {
        self.turning_place.clear();
        for (number, &slot) in self.islands.slots[island.bodies.clone()].iter().enumerate() {
            let spin = bodies.spin(slot, settings.step());
            self.turning_place
                .push(spin.map(|_| (self.turning.len() - first_turning) as u32));
            if let Some(spin) = spin {
                self.turning.push(TurningBody {
                    body: offset + number as u32,
                    start: spin.rotation,
                    spin,
                    inverse_inertia: bodies.mass(slot).inverse_inertia(),
                });
            }
        }
    }

    /// Takes velocities and motions of the bodies that contacts move back to their slots.
    fn write_back(&mut self, bodies: &mut Bodies) {
        self.is_solved.clear();
        self.is_solved.resize(bodies.slots(), false);
        for part in &self.parts {
            let first_slot = self.islands.list[part.islands.start].bodies.start;
            let last_slot = self.islands.list[part.islands.end - 1].bodies.end;
            let slots = &self.islands.slots[first_slot..last_slot];
            for (number, &slot) in (part.bodies.start..).zip(slots) {
                let (i, body) = (slot as usize, &self.bodies[number]);
                if body.inverse_mass > 0.0 {
                    let moved = &self.displacements[number];
                    self.is_solved[i] = true;
                    bodies.velocity[i] = *body;
                    bodies.motion[i] = Motion {
                        shift: moved.linear,
                        rotation: rotate_by(bodies.rotation[i], moved.angular, 1.0),
                    };
                }
            }
            for turning in &self.turning[part.turning.clone()] {
                let slot = slots[turning.body as usize] as usize;
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

    fn store_impulses(&self, manifolds: &mut [Manifold]) {
        for part in &self.parts {
            let (blocks, points) = (&self.blocks[part.blocks.clone()], &self.points[part.points.clone()]);
            for &(index, place) in &self.places[part.manifolds.clone()] {
                let block = &blocks[place.block as usize];
                let to = manifolds[index as usize].points_mut();
                for (to, point) in to.iter_mut().zip(&points[block.points.clone()]) {
                    point.store(place.lane as usize, block, to, part.settings.config.substeps);
                }
            }
        }
    }
}

/// What rows need to know of the body in a slot.
fn side(bodies: &Bodies, slot: usize) -> Side {
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

/// How two bodies move against each other in a step.
#[derive(Clone, Copy, Debug)]
struct Travel {
    /// So far that the rows between them must follow.
    is_noticeable: bool,
    /// Farther than both are thick: they may pass through each other.
    is_fast: bool,
}

impl Travel {
    /// `extents`: least extents of the bodies, m; `step`, s.
    fn of([a, b]: [&SolverBody; 2], extents: [f32; 2], step: f32) -> Self {
        let turn = step * a.angular.length().max(b.angular.length());
        let way = step * (b.linear - a.linear).length();
        Self {
            is_noticeable: turn > TURN || way > TRAVEL * extents[0].min(extents[1]),
            is_fast: way > extents[0] + extents[1],
        }
    }
}
