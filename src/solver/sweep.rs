//! The inner loops: passes over blocks of eight manifolds, and the sweeps among them.
//!
//! Projected Gauss-Seidel on velocities, as [`pgs`](super::pgs) states it row by row: a point gets the impulses that make
//! its own velocity right while all others rest, clipped to their bounds.
//!
//! Kernels come twice: for points that only push, and with `TIED` for blocks some of whose lanes are [bonded](super::ties).

use super::FrictionModel;
use super::blocks::{Block, Blow, Point, load_anchors};
use super::bodies::SolverBody;
use super::extrapolate::Extrapolate;
use super::lane_pair::{Frame, Masses, Pair, load_three, project, store_three};
use super::lanes::{F8, Kernel, LaneWidth, Lanes, run};
use super::prepare::{Aim, Targets, Warm};
use super::soft_step::Softness;
use super::ties::{Bounds, Tie};
use crate::prefetch::prefetch;
use std::cell::Cell;

/// How many blocks and points ahead of a sweep they are asked for: some 200 ns, in which far memory answers.
const AHEAD: [usize; 2] = [3, 6];

/// The same for what a block needs to know of bodies besides their velocities.
const BODIES_AHEAD: usize = 2;

/// What all loops run over.
#[derive(Debug)]
pub struct Contacts<'a> {
    /// Blocks of manifolds.
    pub blocks: &'a [Block],
    /// Points of the blocks.
    pub points: &'a mut [Point],
    /// What the blocks call the first of these points.
    pub first_point: usize,
    /// Blows of the points; empty where nothing hits.
    pub blows: &'a [Blow],
    /// Velocities that the numbers in the blocks refer to.
    pub bodies: &'a [Cell<SolverBody>],
    /// Displacements of the bodies since the start of the step.
    pub displacements: &'a [Cell<SolverBody>],
    /// Shape of the friction bound.
    pub friction: FrictionModel,
    /// Lanes of a register.
    pub width: LaneWidth,
    /// Whether blocks and points lie in far memory, so that sweeps ask for them ahead.
    pub is_far: bool,
}

/// How position feedback is computed; see [`soft_step`](super::soft_step).
#[derive(Clone, Copy, Debug)]
pub struct Feedback {
    /// Length of the sub-step, s.
    pub h: f32,
    /// Share of the overlap that is pushed out per second, 1/s.
    pub rate: f32,
    /// Fastest speed at which that happens, m/s.
    pub most: f32,
}

/// What is done to all contacts.
#[derive(Clone, Copy, Debug)]
pub enum Pass {
    /// Sets the wanted velocities from the displacements of the bodies since the start of the step. Of a sub-step that is not
    /// the `first`, the impulses of the one before are added to the total.
    Targets {
        /// How overlap is pushed out.
        feedback: Feedback,
        /// Whether the step begins.
        first: bool,
    },
    /// Adds `M^-1 J^T lambda` of the impulses found in the points to the velocities: the warm start.
    Warm,
    /// One sweep with position feedback, friction before the normal. With `measure`, tells the largest velocity change of a row
    /// in units of its [speed scale](super::rows::PointRows::speed_scale), else 0.
    Solve {
        /// Compliance.
        softness: Softness,
        /// Whether to measure.
        measure: bool,
    },
    /// [`Targets`](Self::Targets) and the first [`Solve`](Self::Solve) in one go through the contacts, with the same outcome;
    /// not where there are bonds.
    SolveFirst {
        /// How overlap is pushed out.
        feedback: Feedback,
        /// Whether the step begins.
        first: bool,
        /// Compliance.
        softness: Softness,
        /// Whether to measure.
        measure: bool,
    },
    /// One sweep without position feedback, the normal before friction. Points that are pushed stop, others may close their
    /// gap, impacts rebound.
    Relax {
        /// As in [`Solve`](Self::Solve).
        measure: bool,
    },
    /// Moves the impulses on from where they were to where they were going, by `weight` times their last change, and projects
    /// them on what they may be. The velocities are moved by the caller; only what the projection takes away is taken out of
    /// them here.
    Extrapolate {
        /// Weight of the momentum.
        weight: f32,
    },
}

/// The elements of a list, for passes.
pub(super) fn cells<T>(list: &mut [T]) -> &[Cell<T>] {
    Cell::from_mut(list).as_slice_of_cells()
}

impl Contacts<'_> {
    /// Does a pass; returns the largest velocity change if it is measured, else 0. `last`: where the impulses were before an
    /// extrapolation, and then where they are; of no use to other passes.
    pub fn pass(&mut self, pass: Pass, last: &mut [[F8; 3]]) -> f32 {
        self.run::<false>(pass, last, &mut [])
    }

    /// Does a pass with bonds: `ties` are those of the points.
    pub fn pass_tied(&mut self, pass: Pass, last: &mut [[F8; 3]], ties: &mut [Tie]) -> f32 {
        self.run::<true>(pass, last, ties)
    }

    fn run<const TIED: bool>(&mut self, pass: Pass, last: &mut [[F8; 3]], ties: &mut [Tie]) -> f32 {
        let width = self.width;
        let contacts = self;
        match pass {
            Pass::Targets { feedback, first } => {
                let targets = Targets::<TIED> {
                    contacts,
                    ties,
                    feedback,
                    first,
                };
                run(width, targets)
            }
            Pass::Warm => {
                let warm = Warm {
                    blocks: contacts.blocks.iter(),
                    points: contacts.points,
                    first_point: contacts.first_point,
                    bodies: contacts.bodies,
                    share: 1.0,
                };
                run(width, warm)
            }
            Pass::SolveFirst {
                feedback,
                first,
                softness,
                measure,
            } => {
                debug_assert!(!TIED, "bonds have targets of their own");
                let sweep = Sweep::<false> {
                    contacts,
                    ties: &mut [],
                    measure,
                };
                let solve = SolveFirst {
                    sweep,
                    softness,
                    feedback,
                    first,
                };
                run(width, solve)
            }
            Pass::Solve { softness, measure } => {
                let sweep = Sweep::<TIED> {
                    contacts,
                    ties,
                    measure,
                };
                run(width, Solve(sweep, softness))
            }
            Pass::Relax { measure } => {
                let sweep = Sweep::<TIED> {
                    contacts,
                    ties,
                    measure,
                };
                run(width, Relax(sweep))
            }
            Pass::Extrapolate { weight } => {
                let extrapolate = Extrapolate::<TIED> {
                    contacts,
                    ties,
                    last,
                    weight,
                };
                run(width, extrapolate)
            }
        }
    }
}

/// What the two sweeps have in common.
struct Sweep<'a, 'c, const TIED: bool> {
    contacts: &'a mut Contacts<'c>,
    ties: &'a mut [Tie],
    measure: bool,
}

impl<const TIED: bool> Sweep<'_, '_, TIED> {
    /// Solves each point of each block by a rule, after its wanted velocity has been set if there is an `aim`.
    #[inline(always)]
    fn each_point<L: Lanes, R: Rule<L>>(self, rule: &R, aim: Option<&Aim<'_, L>>) -> f32 {
        let Contacts {
            blocks,
            points,
            first_point,
            blows,
            bodies,
            friction: model,
            is_far,
            ..
        } = self.contacts;
        let zero = L::splat(0.0);
        let mut largest = zero;
        for (at, block) in blocks.iter().enumerate() {
            if *is_far && let Some(next) = blocks.get(at + AHEAD[0]) {
                prefetch(next);
            }
            if let (Some(aim), Some(next)) = (aim, blocks.get(at + BODIES_AHEAD)) {
                aim.prefetch(next);
            }
            let (frame, masses) = (Frame::<L>::load(block), Masses::load(block));
            let friction = L::load(&block.friction);
            let mut pair = Pair::<L>::gather(bodies, block);
            let aim = aim.map(|aim| (aim, aim.of_block(block)));
            let mut change = zero;
            let start = block.points.start - *first_point;
            for i in start..start + block.points.len() {
                if *is_far && let Some(next) = points.get(i + AHEAD[1]) {
                    prefetch(next);
                }
                let point = &mut points[i];
                let anchors = load_anchors(point);
                if let Some((aim, of_block)) = &aim {
                    aim.at(of_block, &anchors, point);
                }
                let velocity = pair.relative(&anchors);
                let mut state = State::<L, TIED> {
                    velocity: [
                        frame.normal.dot(velocity),
                        frame.tangents[0].dot(velocity),
                        frame.tangents[1].dot(velocity),
                    ],
                    impulse: load_three(&point.impulse),
                    rebound: match blows.get(i) {
                        Some(blow) => L::load(&blow.rebound),
                        None => zero,
                    },
                    bounds: Bounds::load(friction, self.ties.get(i)),
                    model: *model,
                    point,
                };
                let delta = rule.solve(&mut state);
                store_three(state.impulse, &mut point.impulse);
                if self.measure {
                    change = change.max(largest_change(point, delta));
                }
                pair.push(&masses, &anchors, frame.impulse(delta));
            }
            pair.scatter(bodies, block);
            if self.measure {
                largest = largest.max(change * L::load(&block.speed_scale));
            }
        }
        let mut lanes = F8::default();
        largest.store(&mut lanes);
        lanes.0.into_iter().fold(0.0, f32::max)
    }
}

/// The largest velocity change of a row of a point by impulses that have changed by `delta`.
#[inline(always)]
fn largest_change<L: Lanes>(point: &Point, delta: [L; 3]) -> L {
    let (zero, least) = (L::splat(0.0), L::splat(f32::MIN_POSITIVE));
    let normal = delta[0].max(zero - delta[0]) / L::load(&point.normal_mass).max(least);
    let [t1, t2] = [delta[1].max(zero - delta[1]), delta[2].max(zero - delta[2])];
    let tangent = t1.max(t2) / L::load(&point.tangent_mass).max(least);
    normal.max(tangent)
}

/// A point that is being solved.
struct State<'p, L, const TIED: bool> {
    /// Along normal and tangents, m/s.
    velocity: [L; 3],
    /// Along normal and tangents, N s.
    impulse: [L; 3],
    rebound: L,
    bounds: Bounds<L, TIED>,
    model: FrictionModel,
    point: &'p Point,
}

impl<L: Lanes, const TIED: bool> State<'_, L, TIED> {
    /// Moves the normal impulse to `wish`, or to its bound; returns the change.
    #[inline(always)]
    fn move_normal(&mut self, wish: L) -> L {
        let new = self.bounds.normal(wish);
        let delta = new - self.impulse[0];
        self.impulse[0] = new;
        delta
    }

    /// The friction that stops the point.
    #[inline(always)]
    fn stopping_friction(&self) -> [L; 2] {
        let mass = L::load(&self.point.tangent_mass);
        let [_, t1, t2] = self.impulse;
        let [_, v1, v2] = self.velocity;
        [t1 - v1 * mass, t2 - v2 * mass]
    }

    /// Moves friction to `wish`, within the bound of the present normal impulse; returns the changes.
    #[inline(always)]
    fn move_tangents(&mut self, wish: [L; 2]) -> [L; 2] {
        let [normal, t1, t2] = self.impulse;
        let new = project(self.model, wish, self.bounds.radius(normal));
        [self.impulse[1], self.impulse[2]] = new;
        [new[0] - t1, new[1] - t2]
    }
}

/// By how much an impulse along one of normal and tangents changes what is wanted along the other, `mass` of which a change
/// of velocity asks for.
///
/// This is multiplied while the first impulse is still waited for: the second one then follows from it by two operations.
#[inline(always)]
fn load_coupling<L: Lanes>(point: &Point, mass: L) -> [L; 2] {
    let [t1, t2] = &point.coupling;
    [L::load(t1) * mass, L::load(t2) * mass]
}

/// What a sweep does to a point.
trait Rule<L> {
    /// Changes the impulses of a point; returns by how much.
    fn solve<const TIED: bool>(&self, state: &mut State<'_, L, TIED>) -> [L; 3];
}

/// With position feedback, friction before the normal.
struct Feeding<L> {
    mass_scale: L,
    keep: L,
}

impl<L: Lanes> Feeding<L> {
    #[inline(always)]
    fn new(softness: Softness) -> Self {
        Self {
            mass_scale: L::splat(softness.mass_scale),
            keep: L::splat(1.0 - softness.release),
        }
    }

    /// Friction that stops the point or, where it is bonded, takes it back as softly as the normal does.
    #[inline(always)]
    fn friction<const TIED: bool>(&self, state: &State<'_, L, TIED>) -> [L; 2] {
        let stopping = state.stopping_friction();
        if !TIED {
            return stopping;
        }
        let mass = L::load(&state.point.tangent_mass);
        let back = |k: usize| {
            let correction = (state.velocity[k + 1] - state.bounds.wanted[k]) * mass;
            self.keep * state.impulse[k + 1] - self.mass_scale * correction
        };
        [
            state.bounds.if_bonded(back(0), stopping[0]),
            state.bounds.if_bonded(back(1), stopping[1]),
        ]
    }
}

impl<L: Lanes> Rule<L> for Feeding<L> {
    #[inline(always)]
    fn solve<const TIED: bool>(&self, state: &mut State<'_, L, TIED>) -> [L; 3] {
        let (one, below_zero) = (L::splat(1.0), L::splat(-f32::MIN_POSITIVE));
        let friction = self.friction(state);
        let wanted = L::load(&state.point.wanted);
        let mass = L::load(&state.point.normal_mass);
        // A gap is to be closed at a negative velocity; only what overlaps gives way, or what is bonded.
        let overlaps = state.bounds.if_bonded(one, wanted);
        let scale = overlaps.if_above(below_zero, self.mass_scale, one);
        let keep = overlaps.if_above(below_zero, self.keep, one);
        let per_speed = scale * mass;
        let alone = keep * state.impulse[0] - (state.velocity[0] - wanted) * per_speed;
        let [from_t1, from_t2] = load_coupling(state.point, per_speed);
        let [t1, t2] = state.move_tangents(friction);
        let wish = alone - (from_t1 * t1 + from_t2 * t2);
        [state.move_normal(wish), t1, t2]
    }
}

/// Without position feedback. The normal impulse falls by what pushed overlap out; friction must not keep the bound that
/// came with it, so it comes second.
struct Settling;

impl<L: Lanes> Rule<L> for Settling {
    #[inline(always)]
    fn solve<const TIED: bool>(&self, state: &mut State<'_, L, TIED>) -> [L; 3] {
        let zero = L::splat(0.0);
        let closing = L::load(&state.point.wanted).min(zero);
        let may_close = state.impulse[0].if_above(zero, zero, closing);
        let at_rest = state.bounds.if_bonded(zero, may_close);
        let target = state.rebound.if_above(zero, state.rebound, at_rest);
        let mass = L::load(&state.point.normal_mass);
        let wish = state.impulse[0] - (state.velocity[0] - target) * mass;
        let [t1, t2] = state.stopping_friction();
        let [to_t1, to_t2] = load_coupling(state.point, L::load(&state.point.tangent_mass));
        let normal = state.move_normal(wish);
        let [t1, t2] = state.move_tangents([t1 - to_t1 * normal, t2 - to_t2 * normal]);
        [normal, t1, t2]
    }
}

struct Solve<'a, 'c, const TIED: bool>(Sweep<'a, 'c, TIED>, Softness);

impl<const TIED: bool> Kernel for Solve<'_, '_, TIED> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        self.0.each_point::<L, _>(&Feeding::new(self.1), None)
    }
}

struct SolveFirst<'a, 'c> {
    sweep: Sweep<'a, 'c, false>,
    softness: Softness,
    feedback: Feedback,
    first: bool,
}

impl Kernel for SolveFirst<'_, '_> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let displacements = self.sweep.contacts.displacements;
        let aim = Aim::<L>::new(displacements, &self.feedback, self.first);
        let rule = Feeding::new(self.softness);
        self.sweep.each_point::<L, _>(&rule, Some(&aim))
    }
}

struct Relax<'a, 'c, const TIED: bool>(Sweep<'a, 'c, TIED>);

impl<const TIED: bool> Kernel for Relax<'_, '_, TIED> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        self.0.each_point::<L, _>(&Settling, None)
    }
}
