//! From bodies to manifolds: feeds the contact layer with the bodies' boxes, shapes and materials.
//!
//! Pairs are independent, so they are split into parts that run on the compute task pool if there is one. The split
//! depends on the number of pairs only, and the parts are joined in order: any number of threads gives the same bits.

use crate::contact::broadphase::{Broadphase, Pair, Proxy, ProxyKind, ProxyShape};
use crate::contact::manifold::{Manifold, ManifoldBody, Patch};
use crate::contact::sat::{NarrowScratch, collide_half_space, collide_hulls};
use crate::math::{Aabb, Plane, Pose, rotate};
use crate::solver::bodies::{Bodies, RigidBody, Shape};
use bevy_tasks::ComputeTaskPool;
use glam::Vec3;

/// How far ahead contacts are found besides the bodies' motion, as a share of the body's least extent: far enough that a
/// body at rest keeps its contacts while it settles.
const CONTACT_MARGIN: f32 = 0.02;

/// How far the boxes kept by the broad phase reach beyond the bodies, m (it limits this for small bodies itself).
const BOX_MARGIN: f32 = 0.1;

/// Pairs that are worth a task of their own: about 50 us of work, ten times the cost of a task.
const PAIRS_PER_PART: usize = 64;

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

    /// Bodies farther apart than this, m, cannot touch within the step.
    fn margin(&self, bodies: &Bodies, pair: Pair) -> f32 {
        let (a, b) = (pair.a as usize, pair.b as usize);
        let at_rest = margin_at_rest(bodies, pair.a).min(margin_at_rest(bodies, pair.b));
        let approach = self.h * (bodies.velocity[b].linear - bodies.velocity[a].linear).length();
        at_rest + self.fall + approach + self.turn(bodies, pair.a) + self.turn(bodies, pair.b)
    }
}

/// Buffers of the narrow phase.
#[derive(Debug, Default)]
pub struct NarrowPhase {
    proxies: Vec<Option<Proxy>>,
    parts: Vec<Part>,
}

#[derive(Debug, Default)]
struct Part {
    scratch: NarrowScratch,
    manifolds: Vec<Manifold>,
}

/// Brings the pairs of `broadphase` up to date with the bodies.
pub fn update_pairs(
    broadphase: &mut Broadphase,
    narrow: &mut NarrowPhase,
    bodies: &Bodies,
    ahead: Lookahead,
) {
    narrow.proxies.resize(bodies.slots(), None);
    for (slot, kept) in (0..).zip(&mut narrow.proxies) {
        if !bodies.is_asleep(slot) {
            *kept = proxy(bodies, slot, ahead);
        }
    }
    let may_change = |slot: usize| !bodies.is_asleep(slot as u32);
    broadphase.update_some(&narrow.proxies, BOX_MARGIN, may_change);
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
    /// Fills `manifolds` with the contacts of all `pairs`, in their order. Impulses are zero.
    pub fn collide(
        &mut self,
        bodies: &Bodies,
        pairs: &[Pair],
        ahead: Lookahead,
        manifolds: &mut Vec<Manifold>,
    ) {
        let part_count = pairs.len().div_ceil(PAIRS_PER_PART).clamp(1, MAX_PARTS);
        let part_size = pairs.len().div_ceil(part_count).max(1);
        self.parts
            .resize_with(self.parts.len().max(part_count), Part::default);
        let parts = self.parts.iter_mut().zip(pairs.chunks(part_size));
        match ComputeTaskPool::try_get().filter(|_| part_count > 1) {
            Some(pool) => {
                pool.scope(|scope| {
                    parts.for_each(|(part, pairs)| {
                        scope.spawn(async move { part.collide(bodies, pairs, ahead) })
                    });
                });
            }
            None => parts.for_each(|(part, pairs)| part.collide(bodies, pairs, ahead)),
        }
        manifolds.clear();
        for part in &mut self.parts {
            manifolds.append(&mut part.manifolds);
        }
    }
}

impl Part {
    fn collide(&mut self, bodies: &Bodies, pairs: &[Pair], ahead: Lookahead) {
        self.manifolds.clear();
        for &pair in pairs {
            let Some(patch) = collide_pair(bodies, pair, ahead, &mut self.scratch) else {
                continue;
            };
            let [a, b] = [pair.a, pair.b].map(|slot| bodies.info(slot));
            let friction = a.friction.combined(&b.friction);
            let restitution = a.restitution.combined(&b.restitution);
            let [a, b] = [pair.a, pair.b].map(|slot| manifold_body(bodies, slot));
            self.manifolds
                .push(Manifold::from_patch(&a, &b, &patch, friction, restitution));
        }
    }
}

fn manifold_body(bodies: &Bodies, slot: u32) -> ManifoldBody {
    let i = slot as usize;
    ManifoldBody {
        slot,
        pose: bodies.pose(slot),
        centre: bodies.mass[i].centre,
        code_box: bodies.kd_box[i],
    }
}

/// Contact of one pair in A's frame, normal from A to B.
fn collide_pair(
    bodies: &Bodies,
    pair: Pair,
    ahead: Lookahead,
    scratch: &mut NarrowScratch,
) -> Option<Patch> {
    let margin = ahead.margin(bodies, pair);
    let b_in_a = relative_pose(bodies, pair.a, pair.b);
    match (&bodies.info(pair.a).shape, &bodies.info(pair.b).shape) {
        (Shape::Convex(a), Shape::Convex(b)) => {
            collide_hulls(a.hull(), b.hull(), b_in_a, margin, scratch)
        }
        (Shape::Convex(a), Shape::HalfSpace(b)) => {
            let plane = Plane::through(b_in_a.position, rotate(b_in_a.rotation, b.normal));
            collide_half_space(a.hull(), plane, b_in_a, margin, scratch)
        }
        (Shape::HalfSpace(a), Shape::Convex(b)) => {
            let a_in_b = relative_pose(bodies, pair.b, pair.a);
            let plane = Plane::through(a_in_b.position, rotate(a_in_b.rotation, a.normal));
            let patch = collide_half_space(b.hull(), plane, a_in_b, margin, scratch)?;
            Some(patch.swapped(&a_in_b))
        }
        (Shape::HalfSpace(_), Shape::HalfSpace(_)) => None,
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
