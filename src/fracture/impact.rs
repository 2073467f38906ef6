//! Contact impulses of one step, summed by body: what they break, and what of them acts before that.

use super::Breaking;
use crate::contact::manifold::Manifold;
use crate::math::rotate;
use crate::slice::pattern::{Impact, Planes};
use crate::solver::bodies::{Bodies, RigidBody};
use crate::solver::limit::{BodyBlow, Limit};
use glam::Vec3;

/// Contact impulses on one body in one step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ImpulseSum {
    /// Impulse and energy of the blow, all contact points together.
    blow: BodyBlow,
    /// Sum of the impulses times where they act, from the centre of mass, world axes, N s m.
    ///
    /// Divided by the impulse, the centre of the blow. A single point would do for corners only: a box that lands flat
    /// touches with four, and a plane through one of them is the plane of a face.
    moment: Vec3,
    /// Sum of the impulses with their directions on the body, world axes, N s.
    direction: Vec3,
}

impl ImpulseSum {
    /// Sum of the normal impulses, N s.
    pub(super) fn impulse(&self) -> f32 {
        self.blow.impulse
    }

    /// The share of the impulses that a body with the limit bears before it breaks; `None` if it bears them all.
    ///
    /// The first share `s` of a plastic blow with impulse `P` and energy `E` takes `E (1 - (1 - s)^2)`: the approach is
    /// fastest at the start.
    pub(super) fn borne(&self, limit: &Limit) -> Option<f32> {
        let BodyBlow { impulse, energy } = self.blow;
        if !(impulse > limit.impulse || energy > limit.energy) {
            return None;
        }
        let by_impulse = limit.impulse / impulse;
        let by_energy = 1.0 - (1.0 - limit.energy / energy).max(0.0).sqrt();
        // Below one of the limits the share is over 1, or not a number.
        Some(by_impulse.min(by_energy).clamp(0.0, 1.0))
    }

    /// The planes (body's frame) that the blow breaks the body in `slot` by.
    pub(super) fn planes(&self, bodies: &Bodies, slot: u32) -> Planes {
        let (Some(fracturable), Some(mesh)) = (bodies.fracturable(slot), bodies.convex(slot))
        else {
            return Planes::new();
        };
        let to_body = bodies.pose(slot).rotation.inverse();
        // Squeezed from opposite sides, the impulses cancel; any direction across the body is as good as another then.
        let direction = rotate(to_body, self.direction).normalize_or(Vec3::Y);
        let impact = Impact {
            point: rotate(to_body, self.moment / self.impulse()) + bodies.mass(slot).centre,
            normal: direction,
            impulse: self.impulse(),
        };
        fracturable
            .pattern
            .planes(&impact, mesh.hull(), fracturable.seed)
    }
}

/// Fills `sums`, by slot. The velocities of `bodies` are those before the blow.
pub(super) fn sum_impulses(sums: &mut Vec<ImpulseSum>, bodies: &Bodies, manifolds: &[Manifold]) {
    sums.clear();
    sums.resize(bodies.slots(), ImpulseSum::default());
    for manifold in manifolds {
        let [a, b] = [manifold.a, manifold.b].map(|slot| &bodies.velocity[slot as usize]);
        for point in manifold.points() {
            let impulse = point.total_impulse;
            let on_a = a.linear + a.angular.cross(point.anchor_a);
            let on_b = b.linear + b.angular.cross(point.anchor_b);
            let speed = manifold.normal.dot(on_a - on_b);
            let sides = [
                (manifold.a, point.anchor_a, -manifold.normal),
                (manifold.b, point.anchor_b, manifold.normal),
            ];
            for (slot, anchor, direction) in sides {
                let sum = &mut sums[slot as usize];
                sum.blow.add(impulse, speed);
                sum.moment += anchor * impulse;
                sum.direction += direction * impulse;
            }
        }
    }
}

/// Lets the borne share of the impulses on bodies that break act on them and on what touches them.
///
/// Equal and opposite at one point, so momentum and angular momentum stay what they are.
pub(super) fn apply_borne(breaking: &[Breaking], bodies: &mut Bodies, manifolds: &[Manifold]) {
    let share = |slot: u32| {
        let found = breaking.iter().find(|entry| entry.slot == slot);
        found.map_or(0.0, |entry| entry.borne)
    };
    for manifold in manifolds {
        let borne = share(manifold.a).max(share(manifold.b));
        if borne == 0.0 {
            continue;
        }
        for point in manifold.points() {
            let impulse = borne * point.total_impulse * manifold.normal;
            push(bodies, manifold.a, point.anchor_a, -impulse);
            push(bodies, manifold.b, point.anchor_b, impulse);
        }
    }
}

/// Changes the velocity of a body by an impulse (N s) at `anchor` from its centre of mass (m), world axes.
fn push(bodies: &mut Bodies, slot: u32, anchor: Vec3, impulse: Vec3) {
    let i = slot as usize;
    if bodies.kind(slot) == RigidBody::Dynamic {
        let body = &mut bodies.velocity[i];
        body.linear += body.inverse_mass * impulse;
        body.angular += bodies.inverse_inertia[i] * anchor.cross(impulse);
    }
}
