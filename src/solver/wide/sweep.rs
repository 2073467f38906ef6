//! The inner loops: passes over blocks of eight manifolds, and the sweeps among them.
//!
//! Projected Gauss-Seidel on velocities, as [`pgs`](crate::solver::rows::pgs) states it row by row: a point gets the impulses that make
//! its own velocity right while all others rest, clipped to their bounds.
//!
//! Kernels come twice: for points that only push, and with `BONDED` for blocks some of whose lanes are [bonded](crate::solver::wide::bond).

use crate::simd::lanes::{F8, Kernel, Lanes};
use crate::simd::prefetch::prefetch;
use crate::solver::config::FrictionModel;
use crate::solver::rows::soft_step::Bias;
use crate::solver::rows::soft_step::{RowSoftness, Softness};
use crate::solver::wide::bias::BiasTargets;
use crate::solver::wide::block::{Point, PointImpact, load_anchors};
use crate::solver::wide::body_pair::{BodyPair, Frame, Masses, load_three, project, store_three};
use crate::solver::wide::bond::{BondConstraint, ImpulseBounds};
use crate::solver::wide::contacts::ContactBlocks;
use crate::tuning::{BLOCKS_AHEAD, BODIES_AHEAD, POINTS_AHEAD};

/// What the two sweeps have in common.
pub(crate) struct Sweep<'a, 'c, const BONDED: bool> {
    pub(crate) contacts: &'a mut ContactBlocks<'c>,
    pub(crate) bond_constraints: &'a mut [BondConstraint],
    pub(crate) measure: bool,
}

impl<'a, 'c, const BONDED: bool> Sweep<'a, 'c, BONDED> {
    pub(crate) fn new(
        contacts: &'a mut ContactBlocks<'c>,
        bond_constraints: &'a mut [BondConstraint],
        measure: bool,
    ) -> Self {
        Self {
            contacts,
            bond_constraints,
            measure,
        }
    }

    /// Solves each point of each block by a rule, after its target velocity has been set if there is an `aim`.
    #[inline(always)]
    fn each_point<L: Lanes, R: PointUpdate<L>>(
        self,
        rule: &R,
        aim: Option<&BiasTargets<'_, L>>,
    ) -> f32 {
        let ContactBlocks {
            blocks,
            points,
            first_point,
            impacts,
            lane_changes,
            bodies,
            friction: model,
            is_far,
            ..
        } = self.contacts;
        let zero = L::splat(0.0);
        let mut largest = zero;
        for (at, block) in blocks.iter().enumerate() {
            prefetch_if(*is_far, blocks, at + BLOCKS_AHEAD);
            if let (Some(aim), Some(next)) = (aim, blocks.get(at + BODIES_AHEAD)) {
                aim.prefetch(next);
            }
            let (frame, masses) = (Frame::<L>::load(block), Masses::load(block));
            let friction = L::load(&block.friction);
            let mut pair = BodyPair::<L>::gather(bodies, block);
            let aim = aim.map(|aim| (aim, aim.of_block(block)));
            let mut change = zero;
            let start = block.points.start - *first_point;
            for i in start..start + block.points.len() {
                prefetch_if(*is_far, points, i + POINTS_AHEAD);
                let point = &mut points[i];
                let anchors = load_anchors(point);
                if let Some((aim, of_block)) = &aim {
                    aim.at(of_block, &anchors, point);
                }
                let mut state = State::<L, BONDED> {
                    velocity: frame.components(pair.relative(&anchors)),
                    impulse: load_three(&point.impulse),
                    rebound: impacts.get(i).map_or(zero, load_rebound),
                    bounds: ImpulseBounds::load(friction, self.bond_constraints.get(i)),
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
                let change = change * L::load(&block.speed_scale);
                largest = largest.max(change);
                store_if(change, lane_changes.get_mut(at));
            }
        }
        largest_lane(largest)
    }
}

/// No closure: those are not always put in line, and lanes are wide only in line.
#[inline(always)]
fn load_rebound<L: Lanes>(impact: &PointImpact) -> L {
    L::load(&impact.rebound)
}

#[inline(always)]
fn store_if<L: Lanes>(numbers: L, to: Option<&mut F8>) {
    if let Some(to) = to {
        numbers.store(to);
    }
}

/// Asks for what a list has at `index`, if it is far away.
#[inline(always)]
fn prefetch_if<T>(is_far: bool, list: &[T], index: usize) {
    if is_far && let Some(next) = list.get(index) {
        prefetch(next);
    }
}

/// The largest number of all lanes, at least 0.
#[inline(always)]
fn largest_lane<L: Lanes>(numbers: L) -> f32 {
    let mut lanes = F8::default();
    numbers.store(&mut lanes);
    lanes.0.into_iter().fold(0.0, f32::max)
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
struct State<'p, L, const BONDED: bool> {
    /// Along normal and tangents, m/s.
    velocity: [L; 3],
    /// Along normal and tangents, N s.
    impulse: [L; 3],
    rebound: L,
    bounds: ImpulseBounds<L, BONDED>,
    model: FrictionModel,
    point: &'p Point,
}

impl<L: Lanes, const BONDED: bool> State<'_, L, BONDED> {
    /// Moves the normal impulse to `unbounded`, or to its bound; returns the change.
    #[inline(always)]
    fn move_normal(&mut self, unbounded: L) -> L {
        let new = self.bounds.normal(unbounded);
        let delta = new - self.impulse[0];
        self.impulse[0] = new;
        delta
    }

    /// The velocities along the tangents, above those that the point should have.
    #[inline(always)]
    fn slip(&self) -> [L; 2] {
        let [_, v1, v2] = self.velocity;
        if !BONDED {
            return [v1, v2];
        }
        let [to_t1, to_t2] = self.bounds.target_velocity;
        [v1 - to_t1, v2 - to_t2]
    }

    /// The same once bodies have moved, when what is bonded is to hold still.
    #[inline(always)]
    fn relaxed_slip(&self) -> [L; 2] {
        let [_, v1, v2] = self.velocity;
        let [slip1, slip2] = self.slip();
        [
            self.bounds.if_bonded(v1, slip1),
            self.bounds.if_bonded(v2, slip2),
        ]
    }

    /// The friction that takes a slip away, or a `share` of it.
    #[inline(always)]
    fn stopping_friction(&self, slip: [L; 2], share: L) -> [L; 2] {
        let mass = share * L::load(&self.point.tangent_mass);
        let [_, t1, t2] = self.impulse;
        [t1 - slip[0] * mass, t2 - slip[1] * mass]
    }

    /// Moves friction to `unbounded`, within the bound of the present normal impulse; returns the changes.
    #[inline(always)]
    fn move_tangents(&mut self, unbounded: [L; 2]) -> [L; 2] {
        let [normal, t1, t2] = self.impulse;
        let new = project(self.model, unbounded, self.bounds.radius(normal));
        [self.impulse[1], self.impulse[2]] = new;
        [new[0] - t1, new[1] - t2]
    }
}

/// By how much an impulse along one of normal and tangents changes what is asked for along the other, `mass` of which a change
/// of velocity asks for.
///
/// This is multiplied while the first impulse is still waited for: the second one then follows from it by two operations.
#[inline(always)]
fn load_coupling<L: Lanes>(point: &Point, mass: L) -> [L; 2] {
    let [t1, t2] = &point.coupling;
    [L::load(t1) * mass, L::load(t2) * mass]
}

/// What a sweep does to a point.
trait PointUpdate<L> {
    /// Changes the impulses of a point; returns by how much.
    fn solve<const BONDED: bool>(&self, state: &mut State<'_, L, BONDED>) -> [L; 3];
}

/// With position bias, friction before the normal.
struct SolveWithBias<L> {
    contacts: SoftRow<L>,
    /// Share of the friction that stops a point.
    friction: L,
    bonds: SoftRow<L>,
}

/// What a soft row makes of its impulse.
struct SoftRow<L> {
    mass_scale: L,
    keep: L,
}

impl<L: Lanes> SoftRow<L> {
    #[inline(always)]
    fn new(softness: Softness) -> Self {
        Self {
            mass_scale: L::splat(softness.mass_scale),
            keep: L::splat(1.0 - softness.impulse_scale),
        }
    }
}

impl<L: Lanes> SolveWithBias<L> {
    #[inline(always)]
    fn new(softness: RowSoftness) -> Self {
        Self {
            contacts: SoftRow::new(softness.contacts),
            friction: L::splat(softness.friction),
            bonds: SoftRow::new(softness.bonds),
        }
    }

    /// Friction that goes its share of the way to stopping the point or, where it is bonded, takes it back as softly as the normal does.
    #[inline(always)]
    fn friction<const BONDED: bool>(&self, state: &State<'_, L, BONDED>) -> [L; 2] {
        let slip = state.slip();
        let stopping = state.stopping_friction(slip, self.friction);
        if !BONDED {
            return stopping;
        }
        let mass = L::load(&state.point.tangent_mass);
        let back = |k: usize| {
            let correction = slip[k] * mass;
            self.bonds.keep * state.impulse[k + 1] - self.bonds.mass_scale * correction
        };
        [
            state.bounds.if_bonded(back(0), stopping[0]),
            state.bounds.if_bonded(back(1), stopping[1]),
        ]
    }
}

impl<L: Lanes> PointUpdate<L> for SolveWithBias<L> {
    #[inline(always)]
    fn solve<const BONDED: bool>(&self, state: &mut State<'_, L, BONDED>) -> [L; 3] {
        let (one, below_zero) = (L::splat(1.0), L::splat(-f32::MIN_POSITIVE));
        let friction = self.friction(state);
        let target_velocity = L::load(&state.point.target_velocity);
        let mass = L::load(&state.point.normal_mass);
        // A gap is to be closed at a negative velocity; only what overlaps gives way, or what is bonded.
        let overlaps = state.bounds.if_bonded(one, target_velocity);
        let of_row = |contacts, bonds| state.bounds.if_bonded(bonds, contacts);
        let mass_scale = of_row(self.contacts.mass_scale, self.bonds.mass_scale);
        let keep = of_row(self.contacts.keep, self.bonds.keep);
        let scale = overlaps.if_above(below_zero, mass_scale, one);
        let keep = overlaps.if_above(below_zero, keep, one);
        let per_speed = scale * mass;
        let alone = keep * state.impulse[0] - (state.velocity[0] - target_velocity) * per_speed;
        let [from_t1, from_t2] = load_coupling(state.point, per_speed);
        let [t1, t2] = state.move_tangents(friction);
        let unbounded = alone - (from_t1 * t1 + from_t2 * t2);
        [state.move_normal(unbounded), t1, t2]
    }
}

/// Without position bias. The normal impulse falls by what pushed overlap out; friction must not keep the bound that
/// came with it, so it comes second.
struct RelaxPoint;

impl<L: Lanes> PointUpdate<L> for RelaxPoint {
    #[inline(always)]
    fn solve<const BONDED: bool>(&self, state: &mut State<'_, L, BONDED>) -> [L; 3] {
        let zero = L::splat(0.0);
        let closing = L::load(&state.point.target_velocity).min(zero);
        let may_close = state.impulse[0].if_above(zero, zero, closing);
        let at_rest = state.bounds.if_bonded(zero, may_close);
        let target = state
            .rebound
            .if_above(zero, state.rebound, at_rest + state.rebound);
        let mass = L::load(&state.point.normal_mass);
        let unbounded = state.impulse[0] - (state.velocity[0] - target) * mass;
        let [t1, t2] = state.stopping_friction(state.relaxed_slip(), L::splat(1.0));
        let [to_t1, to_t2] = load_coupling(state.point, L::load(&state.point.tangent_mass));
        let normal = state.move_normal(unbounded);
        let [t1, t2] = state.move_tangents([t1 - to_t1 * normal, t2 - to_t2 * normal]);
        [normal, t1, t2]
    }
}

pub(crate) struct SolveKernel<'a, 'c, const BONDED: bool>(
    pub(crate) Sweep<'a, 'c, BONDED>,
    pub(crate) RowSoftness,
);

impl<const BONDED: bool> Kernel for SolveKernel<'_, '_, BONDED> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        self.0.each_point::<L, _>(&SolveWithBias::new(self.1), None)
    }
}

pub(crate) struct SolveFirstKernel<'a, 'c> {
    pub(crate) sweep: Sweep<'a, 'c, false>,
    pub(crate) softness: RowSoftness,
    pub(crate) bias: Bias,
    pub(crate) is_first: bool,
}

impl Kernel for SolveFirstKernel<'_, '_> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        let displacements = self.sweep.contacts.displacements;
        let aim = BiasTargets::<L>::new(displacements, &self.bias, self.is_first);
        let rule = SolveWithBias::new(self.softness);
        self.sweep.each_point::<L, _>(&rule, Some(&aim))
    }
}

pub(crate) struct RelaxKernel<'a, 'c, const BONDED: bool>(pub(crate) Sweep<'a, 'c, BONDED>);

impl<const BONDED: bool> Kernel for RelaxKernel<'_, '_, BONDED> {
    type Output = f32;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f32 {
        self.0.each_point::<L, _>(&RelaxPoint, None)
    }
}
