//! From manifolds and bodies to new velocities, motions and impulses, island by island.

use super::SolverConfig;
use super::bodies::{Bodies, Motion, SolverBody};
use super::islands::{Island, Islands};
use super::rows::{PointRows, Side};
use super::substeps::{
    Effort, ExactBuffers, IslandProblem, MovingManifold, SubstepSettings, TurningBody,
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

/// Steps until a direct solution is tried again where it has failed.
const PATIENCE: u8 = 60;

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
    exact: ExactBuffers,
}

/// What an island has besides its bodies and rows.
#[derive(Clone, Debug)]
struct Part {
    turning: Range<usize>,
    moving: Range<usize>,
    has_restitution: bool,
    may_be_direct: bool,
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
                may_be_direct: part.may_be_direct,
                exact: &mut self.exact,
            };
            part.effort = problem.solve(settings);
        }
        self.write_back(bodies);
        self.move_free_bodies(bodies, settings);
        self.store_impulses(manifolds, settings.config.substeps);
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
            self.build_rows(&island, manifolds, bodies, settings);
            let rows = &self.rows[island.points.clone()];
            self.parts.push(Part {
                turning,
                moving: moving..self.moving.len(),
                has_restitution: rows.iter().any(|p| p.restitution > 0.0),
                may_be_direct: self.patience(&island, bodies) == 0,
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

    /// Builds the rows of an island and lists its manifolds that move.
    fn build_rows(
        &mut self,
        island: &Island,
        manifolds: &[Manifold],
        bodies: &Bodies,
        settings: &SubstepSettings,
    ) {
        let first = self.rows.len();
        let config = &settings.config;
        for at in island.manifolds.clone() {
            let (index, pair) = (self.islands.manifolds[at], self.islands.pairs[at]);
            let manifold = &manifolds[index as usize];
            let slots = [manifold.a as usize, manifold.b as usize];
            let sides = slots.map(|i| Side {
                inverse_mass: bodies.velocity[i].inverse_mass,
                inverse_inertia: bodies.inverse_inertia[i],
            });
            let extent = slots
                .map(|i| bodies.least_extent[i])
                .into_iter()
                .fold(f32::INFINITY, f32::min);
            if config.substeps > 1
                && moves(slots.map(|i| &bodies.velocity[i]), extent, settings.step())
            {
                self.moving.push(MovingManifold {
                    manifold: index,
                    first: (self.rows.len() - first) as u32,
                    turning: pair.map(|body| self.place[body as usize]),
                    carrier: carrier(slots, bodies),
                });
            }
            let slop = config.slop * extent;
            self.rows.extend(
                manifold.points().iter().map(|point| {
                    PointRows::new(manifold, point, pair, sides, slop, config.substeps)
                }),
            );
        }
    }

    /// Steps for which no direct solution is tried on an island, because one of its bodies was in one where it failed.
    fn patience(&self, island: &Island, bodies: &Bodies) -> u8 {
        let slots = self.islands.slots[island.bodies.clone()].iter();
        slots
            .map(|&s| bodies.patience[s as usize])
            .max()
            .unwrap_or(0)
    }

    /// Takes velocities and motions of the bodies that contacts move back to their slots.
    fn write_back(&mut self, bodies: &mut Bodies) {
        self.is_solved.clear();
        self.is_solved.resize(bodies.slots(), false);
        for (island, part) in self.islands.list.iter().zip(&self.parts) {
            for number in island.bodies.clone() {
                let (i, body) = (self.islands.slots[number] as usize, &self.bodies[number]);
                if body.inverse_mass > 0.0 {
                    let patience = &mut bodies.patience[i];
                    *patience = if part.effort.direct_failed {
                        PATIENCE
                    } else {
                        patience.saturating_sub(1)
                    };
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

    fn store_impulses(&self, manifolds: &mut [Manifold], substeps: u32) {
        let mut rows = self.rows.iter();
        for &index in &self.islands.manifolds {
            let points = manifolds[index as usize].points_mut();
            for (point, rows) in points.iter_mut().zip(&mut rows) {
                rows.store(point, substeps);
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

/// Whether two bodies move so much against each other in a step of `h` seconds that the rows between them must follow.
fn moves([a, b]: [&SolverBody; 2], extent: f32, h: f32) -> bool {
    let turn = a.angular.length_squared().max(b.angular.length_squared());
    let travel = (b.linear - a.linear).length_squared();
    turn * h * h > TURN * TURN || travel * h * h > TRAVEL * TRAVEL * extent * extent
}
