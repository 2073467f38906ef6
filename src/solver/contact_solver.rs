//! From manifolds and bodies to new velocities, motions and impulses, island by island.

use super::bodies::{Bodies, Motion, SolverBody};
use super::islands::{Island, Islands};
use super::rows::{PointRows, Side};
use super::substeps::{
    Demand, Effort, IslandProblem, IslandScratch, MovingManifold, SubstepSettings, TurningBody,
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

/// The rows of a step and the working copies of the bodies they join; buffers are reused.
///
/// Bodies lie island by island, so that an island's sub-steps run in a few contiguous slices.
#[derive(Debug, Default)]
pub struct ContactSolver {
    islands: Islands,
    rows: Vec<PointRows>,
    bodies: Vec<SolverBody>,
    displacements: Vec<SolverBody>,
    inverse_inertia: Vec<Mat3>,
    turning: Vec<TurningBody>,
    moving: Vec<MovingManifold>,
    parts: Vec<Part>,
    /// By number within the island being prepared: place among its bodies that turn.
    place: Vec<Option<u32>>,
    /// By slot: whether an island moves the body.
    is_solved: Vec<bool>,
    scratch: IslandScratch,
}

/// What an island has besides its bodies and rows.
#[derive(Clone, Debug)]
struct Part {
    turning: Range<usize>,
    moving: Range<usize>,
    has_restitution: bool,
    settings: SubstepSettings,
    effort: Effort,
}

/// An island after the solve.
#[derive(Clone, Copy, Debug)]
pub struct SolvedIsland<'a> {
    /// Rows of its points.
    pub rows: &'a [PointRows],
    /// Velocities of its bodies.
    pub bodies: &'a [SolverBody],
    /// Slots of its bodies.
    pub slots: &'a [u32],
    /// What it took.
    pub effort: Effort,
}

impl ContactSolver {
    /// The islands of the last step.
    pub fn islands(&self) -> impl Iterator<Item = SolvedIsland<'_>> {
        let parts = self.islands.list.iter().zip(&self.parts);
        parts.map(|(island, part)| SolvedIsland {
            rows: &self.rows[island.points.clone()],
            bodies: &self.bodies[island.bodies.clone()],
            slots: &self.islands.slots[island.bodies.clone()],
            effort: part.effort,
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
        for (island, part) in self.islands.list.iter().zip(&mut self.parts) {
            let mut problem = IslandProblem {
                rows: &mut self.rows[island.points.clone()],
                bodies: &mut self.bodies[island.bodies.clone()],
                displacements: &mut self.displacements[island.bodies.clone()],
                inverse_inertia: &mut self.inverse_inertia[island.bodies.clone()],
                turning: &mut self.turning[part.turning.clone()],
                moving: &self.moving[part.moving.clone()],
                manifolds,
                has_restitution: part.has_restitution,
                scratch: &mut self.scratch,
            };
            part.effort = problem.solve(&part.settings);
        }
        self.write_back(bodies);
        self.move_free_bodies(bodies, settings);
        self.store_impulses(manifolds);
    }

    /// Finds the islands, copies their bodies and builds their rows.
    pub fn prepare(&mut self, manifolds: &[Manifold], bodies: &Bodies, settings: &SubstepSettings) {
        self.islands.find(manifolds, bodies);
        self.load_bodies(bodies);
        self.rows.clear();
        self.turning.clear();
        self.moving.clear();
        self.parts.clear();
        for index in 0..self.islands.list.len() {
            let island = self.islands.list[index].clone();
            let turning = self.load_turning(&island, bodies, settings);
            let moving = self.moving.len();
            let demand = self.build_rows(&island, manifolds, bodies, settings);
            let settings = settings.for_demand(demand);
            let rows = &mut self.rows[island.points];
            let share = 1.0 / settings.config.substeps as f32;
            rows.iter_mut().for_each(|p| p.scale_impulses(share));
            self.parts.push(Part {
                turning,
                moving: moving..self.moving.len(),
                has_restitution: rows.iter().any(|p| p.restitution > 0.0),
                settings,
                effort: Effort::default(),
            });
        }
    }

    fn load_bodies(&mut self, bodies: &Bodies) {
        let slots = || self.islands.slots.iter().map(|&slot| slot as usize);
        self.bodies.clear();
        self.bodies.extend(slots().map(|i| bodies.velocity[i]));
        self.inverse_inertia.clear();
        self.inverse_inertia
            .extend(slots().map(|i| bodies.inverse_inertia[i]));
        self.displacements.clear();
        self.displacements
            .resize(self.bodies.len(), SolverBody::default());
    }

    /// Lists the bodies of an island that turn.
    fn load_turning(
        &mut self,
        island: &Island,
        bodies: &Bodies,
        settings: &SubstepSettings,
    ) -> Range<usize> {
        let first = self.turning.len();
        self.place.clear();
        for (number, &slot) in self.islands.slots[island.bodies.clone()].iter().enumerate() {
            let spin = bodies.spin(slot, settings.step());
            self.place
                .push(spin.map(|_| (self.turning.len() - first) as u32));
            if let Some(spin) = spin {
                self.turning.push(TurningBody {
                    body: number as u32,
                    start: spin.rotation,
                    spin,
                    inverse_inertia: bodies.mass(slot).inverse_inertia(),
                });
            }
        }
        first..self.turning.len()
    }

    /// Builds the rows of an island, with the impulses of the last step, and lists its manifolds that move.
    fn build_rows(
        &mut self,
        island: &Island,
        manifolds: &[Manifold],
        bodies: &Bodies,
        settings: &SubstepSettings,
    ) -> Demand {
        let first = self.rows.len();
        let mut demand = Demand::default();
        for at in island.manifolds.clone() {
            let (index, pair) = (self.islands.manifolds[at], self.islands.pairs[at]);
            let manifold = &manifolds[index as usize];
            let slots = [manifold.a as usize, manifold.b as usize];
            let [a, b] = slots.map(|i| Side {
                inverse_mass: bodies.velocity[i].inverse_mass,
                inverse_inertia: bodies.inverse_inertia[i],
            });
            let extents = slots.map(|i| bodies.least_extent[i]);
            let extent = extents[0].min(extents[1]);
            let motion = Travel::of(slots.map(|i| &bodies.velocity[i]), extents, settings.step());
            demand.is_fast |= motion.is_fast;
            if motion.is_noticeable {
                let carrier = carrier(slots, bodies);
                self.moving.push(MovingManifold {
                    manifold: index,
                    first: (self.rows.len() - first) as u32,
                    turning: pair.map(|body| self.place[body as usize]),
                    carrier,
                    clearance: motion.is_fast.then_some(0.5 * extents[carrier]),
                });
            }
            let slop = settings.config.slop;
            // What has just landed bears at least its own weight.
            let mut load = settings.gravity.length() * settings.step();
            for point in manifold.points() {
                let rows = PointRows::new(manifold, point, pair, [a, b], extent, slop);
                load = load.max(rows.normal.impulse * rows.normal.diagonal);
                self.rows.push(rows);
            }
            demand.load = demand.load.max(load / extent);
        }
        demand
    }

    /// Takes velocities and motions of the bodies that contacts move back to their slots.
    fn write_back(&mut self, bodies: &mut Bodies) {
        self.is_solved.clear();
        self.is_solved.resize(bodies.slots(), false);
        for (island, part) in self.islands.list.iter().zip(&self.parts) {
            for number in island.bodies.clone() {
                let (i, body) = (self.islands.slots[number] as usize, &self.bodies[number]);
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
                let slot = self.islands.slots[island.bodies.start + turning.body as usize];
                bodies.motion[slot as usize].rotation = turning.spin.rotation;
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
        for (island, part) in self.islands.list.iter().zip(&self.parts) {
            let mut rows = self.rows[island.points.clone()].iter();
            for &index in &self.islands.manifolds[island.manifolds.clone()] {
                let points = manifolds[index as usize].points_mut();
                for (point, rows) in points.iter_mut().zip(&mut rows) {
                    rows.store(point, part.settings.config.substeps);
                }
            }
        }
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
