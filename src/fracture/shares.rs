//! What acts of an impact before something breaks: shares of its impulses, as far as they take energy.
//!
//! The impulses are those of a solve that was given up, along the normals, of all its sub-steps, at the anchors of the step's start. Shares
//! of them, which differ from contact to contact, mostly slow bodies down. Where a light body is squeezed by a heavy one, it may be kicked
//! off by them instead: its far side, which the friction and the turn of the sub-steps had held, is not held now. Such impulses are
//! found anew as those between nothing and the shares that take the most energy, a problem with bounds of a few rows.

use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use crate::contact::manifolds::Manifolds;
use crate::disjoint_sets::DisjointSets;
use crate::solver::rows::contact_rows::{Row, RowBody};
use glam::Vec3;

/// Sweeps over impulses that are found anew; each takes energy, so that few of them only leave more for the pieces.
const SWEEPS: usize = 16;

/// Part of the energies turned over that rounding may add.
const ROUNDING: f32 = 1e-5;

/// An impulse that acts at one point of a contact.
#[derive(Clone, Copy, Debug)]
struct SharedImpulse {
    manifold: u32,
    slots: [u32; 2],
    /// Those with the same number hang together; none if nothing moves by it.
    group: Option<u32>,
    anchors: [Vec3; 2],
    normal: Vec3,
    /// All that may act, N s.
    share: f32,
    /// What acts of it, N s.
    acted: f32,
    /// Separation speed of the two bodies there before anything acts, m/s.
    speed: f32,
}

/// Lets shares of the impulses of manifolds (indices, perhaps some several times) act on what breaks and on what touches it.
///
/// Equal and opposite at one point, so momentum and angular momentum stay what they are, and energy does not rise. Two bodies that break
/// at one contact share what the stronger of them bears. The result is the impulse that acted by manifold, N s, sorted by index.
pub(super) fn apply_shares(
    mut shares: Vec<(u32, f32)>,
    bodies: &mut Bodies,
    manifolds: &Manifolds,
) -> Vec<(u32, f32)> {
    shares.sort_unstable_by(|(a, share_a), (b, share_b)| a.cmp(b).then(share_b.total_cmp(share_a)));
    shares.dedup_by_key(|&mut (index, _)| index);
    let mut impulses = shared_impulses(&shares, bodies, manifolds);
    group(&mut impulses, bodies);
    for group in impulses.chunk_by_mut(|a, b| a.group == b.group) {
        for it in &mut *group {
            it.act(bodies, it.share);
        }
        if gains_energy(group, bodies) {
            for it in &mut *group {
                it.act(bodies, 0.0);
            }
            take_energy(group, bodies);
        }
    }
    for (index, acted) in &mut shares {
        let of_manifold = impulses.iter().filter(|it| it.manifold == *index);
        *acted = of_manifold.map(|it| it.acted).sum();
    }
    shares
}

/// The impulses of the points of manifolds (indices and shares).
fn shared_impulses(
    shares: &[(u32, f32)],
    bodies: &Bodies,
    manifolds: &Manifolds,
) -> Vec<SharedImpulse> {
    let mut impulses = Vec::new();
    for &(index, share) in shares {
        let manifold = manifolds.at(index as usize);
        let slots = [manifold.a, manifold.b];
        impulses.extend(manifold.points().iter().map(|point| {
            let anchors = [point.anchor_a, point.anchor_b];
            SharedImpulse {
                manifold: index,
                slots,
                group: None,
                anchors,
                normal: manifold.normal,
                share: share * point.total_impulse,
                acted: 0.0,
                speed: separation_speed(bodies, slots, anchors, manifold.normal),
            }
        }));
    }
    impulses
}

/// Sorts impulses into groups that share no body that moves.
fn group(impulses: &mut [SharedImpulse], bodies: &Bodies) {
    let is_moved = |slot: &u32| bodies.kind(*slot) == RigidBody::Dynamic;
    let mut moved: Vec<u32> = impulses.iter().flat_map(|it| it.slots).collect();
    moved.retain(is_moved);
    moved.sort_unstable();
    moved.dedup();
    let number = |slot: u32| moved.binary_search(&slot).ok().map(|i| i as u32);
    let mut sets = DisjointSets::new(moved.len());
    for it in &*impulses {
        if let [Some(a), Some(b)] = it.slots.map(number) {
            sets.join(a, b);
        }
    }
    for it in &mut *impulses {
        let first = it.slots.into_iter().find_map(number);
        it.group = first.map(|body| sets.root(body));
    }
    impulses.sort_by_key(|it| it.group);
}

/// Whether what acted has raised the energy: each impulse does the work of the mean speed before and after all of them.
fn gains_energy(group: &[SharedImpulse], bodies: &Bodies) -> bool {
    let [mut work, mut turnover] = [0.0, 0.0];
    for it in group {
        let half = 0.5 * it.acted;
        let after = separation_speed(bodies, it.slots, it.anchors, it.normal);
        work += half * (it.speed + after);
        turnover += (half * it.speed).abs() + (half * after).abs();
    }
    work > ROUNDING * turnover
}

/// Lets as much of a group's impulses act as takes energy: `w = A lambda - b` with `b` the approach, `0 <= lambda <= share`.
fn take_energy(group: &mut [SharedImpulse], bodies: &mut Bodies) {
    let mass = |it: &SharedImpulse| {
        let sides = it.slots.map(|slot| RowBody::of(bodies, slot as usize));
        Row::new(it.normal, it.anchors, sides).effective_mass
    };
    let masses: Vec<f32> = group.iter().map(mass).collect();
    for _ in 0..SWEEPS {
        for (it, mass) in group.iter_mut().zip(&masses) {
            let speed = separation_speed(bodies, it.slots, it.anchors, it.normal);
            let wanted = it.acted - mass * speed;
            it.act(bodies, wanted.clamp(it.share.min(0.0), it.share.max(0.0)));
        }
    }
}

impl SharedImpulse {
    /// Makes what acts of it `impulse`, N s.
    fn act(&mut self, bodies: &mut Bodies, impulse: f32) {
        let change = (impulse - self.acted) * self.normal;
        self.acted = impulse;
        push(bodies, self.slots[0], self.anchors[0], -change);
        push(bodies, self.slots[1], self.anchors[1], change);
    }
}

/// Speed at which the second of two bodies leaves the first along a normal at a contact point, m/s.
fn separation_speed(bodies: &Bodies, slots: [u32; 2], anchors: [Vec3; 2], normal: Vec3) -> f32 {
    let [a, b] = [0, 1].map(|side| {
        let body = &bodies.velocity[slots[side] as usize];
        body.linear + body.angular.cross(anchors[side])
    });
    normal.dot(b - a)
}

/// Changes the velocity of a body by an impulse (N s) at `anchor` from its center of mass (m), world axes.
fn push(bodies: &mut Bodies, slot: u32, anchor: Vec3, impulse: Vec3) {
    let i = slot as usize;
    if bodies.kind(slot) == RigidBody::Dynamic {
        let body = &mut bodies.velocity[i];
        body.linear += body.inverse_mass * impulse;
        body.angular += bodies.inverse_inertia[i] * anchor.cross(impulse);
    }
}
