//! From bodies to manifolds: feeds the contact layer with the bodies' boxes, shapes and materials.
//!
//! Pairs are independent, so they are split into parts that run on the compute task pool if there is one. The split
//! depends on the number of pairs only, and the parts are joined in order: any number of threads gives the same bits.

use crate::contact::BodyId;
use crate::contact::broadphase::{Broadphase, Pair, Proxy, ProxyKind, ProxyShape};
use crate::contact::half_space::examine_half_space;
use crate::contact::manifold::{BodyPlace, BoundPatch, Manifold, Patch};
use crate::contact::pair::{PairBody, PairState, Verdict, reach_of_test};
use crate::contact::sat::{Found, NarrowScratch, distance_along, examine_hulls};
use crate::math::{Aabb, Plane, Pose, rotate};
use crate::solver::bodies::{Bodies, RigidBody, Shape};
use bevy_tasks::ComputeTaskPool;
use glam::{Mat3, Vec3};

/// How far ahead contacts are found besides the bodies' motion, as a share of the body's least extent: far enough that a
/// body at rest keeps its contacts while it settles.
const CONTACT_MARGIN: f32 = 0.02;

/// How far the boxes kept by the broad phase reach beyond the bodies, m (it limits this for small bodies itself).
const BOX_MARGIN: f32 = 0.1;

/// Pairs that are worth a task of their own: 10 us of work while all are at rest, some 100 us while they land.
const PAIRS_PER_PART: usize = 256;

/// Most parts, so that few buffers serve any number of pairs.
const MAX_PARTS: usize = 32;

/// How far ahead in time the step looks, so that contacts exist before bodies overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lookahead {
    h: f32,
    /// How far gravity moves a body in one step, m.
    fall: f32,
}

impl Lookahead {
    /// Looks ahead over a step of `h` seconds under `gravity` (m/s2).
    pub fn new(h: f32, gravity: Vec3) -> Self {
        Self {
            h,
            fall: h * h * gravity.length(),
        }
    }

    /// How far a point of the body in `slot` may turn about the centre of mass within the step, m.
    fn turn(&self, bodies: &Bodies, slot: u32) -> f32 {
        self.h * bodies.velocity[slot as usize].angular.length() * bodies.radius(slot)
    }

    /// The body's box with all places it may reach within the step.
    fn swept_box(&self, bodies: &Bodies, slot: u32) -> Aabb {
        let i = slot as usize;
        let tight = bodies.aabb[i]
            .fattened(margin_at_rest(bodies, slot) + self.fall + self.turn(bodies, slot));
        let travel = bodies.velocity[i].linear * self.h;
        Aabb {
            min: tight.min + travel.min(Vec3::ZERO),
            max: tight.max + travel.max(Vec3::ZERO),
        }
    }
}

/// What is known of the pairs from step to step, and buffers.
#[derive(Debug, Default)]
pub struct NarrowPhase {
    proxies: Vec<Option<Proxy>>,
    /// Bodies by slot.
    bodies: Vec<PairBody>,
    /// Pairs by name, and what is known of them; in boxes, so that the order changes without copies.
    names: Vec<(BodyId, BodyId)>,
    states: Vec<Box<PairState>>,
    /// Of the pair list that `names` and `states` follow.
    revision: Option<u64>,
    new_names: Vec<(BodyId, BodyId)>,
    new_states: Vec<Box<PairState>>,
    /// States of pairs that are gone.
    spare: Vec<Box<PairState>>,
    parts: Vec<Part>,
}

#[derive(Debug, Default)]
struct Part {
    scratch: NarrowScratch,
    /// Number of its pairs that touch.
    touching: usize,
}

/// Brings the pairs of `broadphase` up to date with the bodies.
pub fn update_pairs(
    broadphase: &mut Broadphase,
    narrow: &mut NarrowPhase,
    bodies: &Bodies,
    ahead: Lookahead,
) {
    narrow.proxies.clear();
    narrow
        .proxies
        .extend((0..bodies.slots() as u32).map(|slot| proxy(bodies, slot, ahead)));
    broadphase.update(&narrow.proxies, BOX_MARGIN);
}

fn proxy(bodies: &Bodies, slot: u32, ahead: Lookahead) -> Option<Proxy> {
    if !bodies.is_active(slot) {
        return None;
    }
    let info = bodies.info(slot);
    let kind = if info.kind == RigidBody::Dynamic {
        ProxyKind::Moving
    } else {
        ProxyKind::Fixed
    };
    let shape = match &info.shape {
        Shape::Convex(_) => ProxyShape::Box(ahead.swept_box(bodies, slot)),
        Shape::HalfSpace(_) => ProxyShape::HalfSpace(half_space_plane(bodies, slot)),
    };
    Some(Proxy {
        id: bodies.id(slot),
        kind,
        layers: info.layers,
        shape,
    })
}

fn margin_at_rest(bodies: &Bodies, slot: u32) -> f32 {
    CONTACT_MARGIN * bodies.least_extent[slot as usize]
}

/// Surface of the half-space in `slot`, world frame.
fn half_space_plane(bodies: &Bodies, slot: u32) -> Plane {
    let Shape::HalfSpace(half_space) = &bodies.info(slot).shape else {
        unreachable!("asked for half-spaces only")
    };
    let pose = bodies.pose(slot);
    Plane::through(pose.position, rotate(pose.rotation, half_space.normal))
}

impl NarrowPhase {
    /// Fills `manifolds` with the contacts of all pairs, in their order. Impulses are zero.
    pub fn collide(
        &mut self,
        bodies: &Bodies,
        broadphase: &Broadphase,
        ahead: Lookahead,
        manifolds: &mut Vec<Manifold>,
    ) {
        self.carry_states(bodies, broadphase);
        self.load_bodies(bodies, ahead);
        let pairs = broadphase.pairs();
        let part_count = pairs.len().div_ceil(PAIRS_PER_PART).clamp(1, MAX_PARTS);
        let part_size = pairs.len().div_ceil(part_count).max(1);
        self.parts
            .resize_with(self.parts.len().max(part_count), Part::default);
        let scene = &Scene {
            bodies,
            seen: &self.bodies,
            fall: ahead.fall,
        };
        let parts = self.parts.iter_mut().zip(pairs.chunks(part_size));
        let parts = parts.zip(self.states.chunks_mut(part_size));
        run_parts(parts, |((part, pairs), states)| {
            part.test(scene, pairs, states)
        });
        let parts = &self.parts[..pairs.len().div_ceil(part_size)];
        let total = parts.iter().map(|part| part.touching).sum();
        manifolds.resize(total, Manifold::default());
        let mut rest = manifolds.as_mut_slice();
        let pieces = parts.iter().map(|part| {
            let (piece, after) = std::mem::take(&mut rest).split_at_mut(part.touching);
            rest = after;
            piece
        });
        let pairs = pairs.chunks(part_size).zip(self.states.chunks(part_size));
        run_parts(pieces.zip(pairs), |(piece, (pairs, states))| {
            write_manifolds(scene, pairs, states, piece)
        });
    }

    /// Brings `states` into the order of the pairs; new pairs get a blank one.
    fn carry_states(&mut self, bodies: &Bodies, broadphase: &Broadphase) {
        if self.revision == Some(broadphase.revision()) {
            return;
        }
        self.revision = Some(broadphase.revision());
        let pairs = broadphase.pairs();
        self.new_names.clear();
        self.new_names
            .extend(pairs.iter().map(|p| (bodies.id(p.a), bodies.id(p.b))));
        let mut old = self.names.iter().zip(self.states.drain(..)).peekable();
        for name in &self.new_names {
            while let Some((_, state)) = old.next_if(|(old, _)| *old < name) {
                self.spare.push(state);
            }
            let state = match old.next_if(|(old, _)| *old == name) {
                Some((_, state)) => state,
                None => {
                    let mut state = self.spare.pop().unwrap_or_default();
                    *state = PairState::default();
                    state
                }
            };
            self.new_states.push(state);
        }
        self.spare.extend(old.map(|(_, state)| state));
        std::mem::swap(&mut self.names, &mut self.new_names);
        std::mem::swap(&mut self.states, &mut self.new_states);
    }

    /// Collects what pairs read of the bodies.
    fn load_bodies(&mut self, bodies: &Bodies, ahead: Lookahead) {
        self.bodies.clear();
        self.bodies.extend((0..bodies.slots()).map(|i| {
            let is_half_space = bodies.least_extent[i] == f32::INFINITY;
            let radius = bodies.radius(i as u32);
            PairBody {
                place: BodyPlace {
                    centre: bodies.centre[i],
                    turn: Mat3::from_quat(bodies.rotation[i]),
                },
                rotation: bodies.rotation[i],
                radius: if is_half_space { f32::INFINITY } else { radius },
                least_extent: bodies.least_extent[i],
                version: bodies.version[i],
                travel: ahead.h * bodies.velocity[i].linear,
                turning: ahead.turn(bodies, i as u32),
            }
        }));
    }
}

/// Runs `work` on each part, on the compute task pool if there is one and more than one part.
fn run_parts<P: Send>(parts: impl ExactSizeIterator<Item = P>, work: impl Fn(P) + Send + Sync) {
    match ComputeTaskPool::try_get().filter(|_| parts.len() > 1) {
        Some(pool) => {
            let work = &work;
            pool.scope(|scope| {
                parts.for_each(|part| scope.spawn(async move { work(part) }));
            });
        }
        None => parts.for_each(work),
    }
}

/// What all parts read.
struct Scene<'s> {
    bodies: &'s Bodies,
    seen: &'s [PairBody],
    fall: f32,
}

impl Scene<'_> {
    fn pair(&self, pair: Pair) -> [&PairBody; 2] {
        [pair.a, pair.b].map(|slot| &self.seen[slot as usize])
    }

    /// Bodies farther apart than this, m, cannot touch within the step.
    fn margin(&self, a: &PairBody, b: &PairBody) -> f32 {
        let at_rest = CONTACT_MARGIN * a.least_extent.min(b.least_extent);
        at_rest + self.fall + (b.travel - a.travel).length() + a.turning + b.turning
    }
}

impl Part {
    /// Tests the pairs that must be, and counts those that touch.
    fn test(&mut self, scene: &Scene, pairs: &[Pair], states: &mut [Box<PairState>]) {
        self.touching = 0;
        for (&pair, state) in pairs.iter().zip(states) {
            let [a, b] = scene.pair(pair);
            let margin = scene.margin(a, b);
            if let Verdict::Unknown(axis) = state.verdict(a, b, margin) {
                self.test_pair(scene, pair, margin, axis, state);
            }
            self.touching += usize::from(state.touches());
        }
    }

    /// Finds out how a pair is now.
    fn test_pair(
        &mut self,
        scene: &Scene,
        pair: Pair,
        margin: f32,
        axis: Option<Vec3>,
        state: &mut PairState,
    ) {
        let [a, b] = scene.pair(pair);
        let bodies = scene.bodies;
        let reach = reach_of_test(a, b, margin);
        let b_in_a = relative_pose(bodies, pair.a, pair.b);
        if let Some(axis) = axis
            && let Some(distance) = distance_of(bodies, pair, &b_in_a, axis)
            && distance > margin
        {
            state.set_apart(a, b, axis, distance);
            return;
        }
        match examine_pair(bodies, pair, b_in_a, reach, &mut self.scratch) {
            Found::Apart { axis, distance } => state.set_apart(a, b, axis, distance),
            Found::Near(patch) => {
                let slots = [pair.a as usize, pair.b as usize];
                let centres = slots.map(|i| bodies.mass[i].centre);
                let boxes = slots.map(|i| bodies.kd_box[i]);
                state.set_near(a, b, BoundPatch::new(&patch, centres, boxes), reach);
                let [a, b] = [pair.a, pair.b].map(|slot| bodies.info(slot));
                state.friction = a.friction.combined(&b.friction);
                state.restitution = a.restitution.combined(&b.restitution);
            }
        }
    }
}

/// Writes the manifolds of the pairs that touch.
fn write_manifolds(
    scene: &Scene,
    pairs: &[Pair],
    states: &[Box<PairState>],
    manifolds: &mut [Manifold],
) {
    let touching = pairs.iter().zip(states).filter(|(_, s)| s.touches());
    for ((pair, state), manifold) in touching.zip(manifolds) {
        let [a, b] = scene.pair(*pair);
        (manifold.a, manifold.b) = (pair.a, pair.b);
        (manifold.friction, manifold.restitution) = (state.friction, state.restitution);
        state.patch.write(&a.place, &b.place, manifold);
    }
}

/// Distance of two hulls along a unit vector from A to B (A's frame), m; `None` if one is a half-space, which is tested
/// as fast.
fn distance_of(bodies: &Bodies, pair: Pair, b_in_a: &Pose, axis: Vec3) -> Option<f32> {
    let [a, b] = [pair.a, pair.b].map(|slot| bodies.convex(slot));
    Some(distance_along(a?.hull(), b?.hull(), b_in_a, axis))
}

/// Contact of one pair in A's frame, normal from A to B.
fn examine_pair(
    bodies: &Bodies,
    pair: Pair,
    b_in_a: Pose,
    reach: f32,
    scratch: &mut NarrowScratch,
) -> Found {
    match (&bodies.info(pair.a).shape, &bodies.info(pair.b).shape) {
        (Shape::Convex(a), Shape::Convex(b)) => {
            examine_hulls(a.hull(), b.hull(), b_in_a, reach, scratch)
        }
        (Shape::Convex(a), Shape::HalfSpace(b)) => {
            let plane = Plane::through(b_in_a.position, rotate(b_in_a.rotation, b.normal));
            examine_half_space(a.hull(), plane, b_in_a, reach, scratch)
        }
        (Shape::HalfSpace(a), Shape::Convex(b)) => {
            let a_in_b = relative_pose(bodies, pair.b, pair.a);
            let plane = Plane::through(a_in_b.position, rotate(a_in_b.rotation, a.normal));
            match examine_half_space(b.hull(), plane, a_in_b, reach, scratch) {
                Found::Near(patch) => Found::Near(patch.swapped(&a_in_b)),
                Found::Apart { distance, .. } => Found::Apart {
                    axis: a.normal,
                    distance,
                },
            }
        }
        (Shape::HalfSpace(_), Shape::HalfSpace(_)) => Found::Near(Patch::default()),
    }
}

/// `a_from_b`, from the difference of the centres of mass, which is exact far from the origin too.
fn relative_pose(bodies: &Bodies, a: u32, b: u32) -> Pose {
    let (i, j) = (a as usize, b as usize);
    let a_from_world = bodies.rotation[i].inverse();
    let rotation = a_from_world * bodies.rotation[j];
    let centres = rotate(a_from_world, bodies.centre[j] - bodies.centre[i]);
    Pose::new(
        centres + bodies.mass[i].centre - rotate(rotation, bodies.mass[j].centre),
        rotation,
    )
}
