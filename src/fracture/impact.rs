//! Contact impulses of one step, summed by body: what they break, and what of them acts before that.

use crate::bodies::body::RigidBody;
use crate::bodies::breaking::ImpactLoad;
use crate::bodies::store::Bodies;
use crate::contact::manifolds::Manifolds;
use crate::fracture::BreakingImpact;
use crate::fracture::pieces::PieceSet;
use crate::math::rotate;
use crate::slice::{Cutting, Impact};
use glam::Vec3;

/// Contact impulses on one body in one step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ImpulseSum {
    /// Impulse and energy of the blow, all contact points together.
    blow: ImpactLoad,
    /// Sum of the impulses times where they act, from the center of mass, world axes, N s m.
    ///
    /// Divided by the impulse, the center of the blow. A single point would do for corners only: a box that lands flat
    /// touches with four, and a plane through one of them is the plane of a face.
    moment: Vec3,
    /// Sum of the impulses with their directions on the body, world axes, N s.
    direction: Vec3,
    /// Slot of the body that gave most of it, and how much that was, N s.
    strongest: Option<(u32, f32)>,
}

impl ImpulseSum {
    /// Sum of the normal impulses, N s.
    pub(super) fn impulse(&self) -> f32 {
        self.blow.impulse
    }

    /// The same with another energy, J: that of a blow is not known any more once the velocities are those after it.
    pub(super) fn with_energy(mut self, energy: f32) -> Self {
        self.blow.energy = energy;
        self
    }

    /// Whether the body in `slot` does not bear it.
    pub(super) fn is_too_much(&self, bodies: &Bodies, slot: u32) -> bool {
        let limit = bodies.limit(slot);
        limit.is_some_and(|limit| limit.is_exceeded_by(&self.blow))
    }

    /// What the fracture is reported with.
    pub(super) fn blow(&self, bodies: &Bodies, slot: u32, withstood: f32) -> BreakingImpact {
        let ImpactLoad { impulse, energy } = self.blow;
        let center = bodies.center_of_mass(slot);
        BreakingImpact {
            impulse,
            energy,
            withstood,
            by: self.strongest.map(|(by, _)| (by, bodies.id(by))),
            point: center + self.moment / impulse,
            direction: self.direction.normalize_or(Vec3::Y),
        }
    }

    /// Takes note of what the body in `by` gave.
    fn note_giver(&mut self, by: u32, impulse: f32) {
        if self.strongest.is_none_or(|(_, most)| impulse > most) {
            self.strongest = Some((by, impulse));
        }
    }

    /// The share of the impulses that acts before the body in `slot` breaks: what it bears, and what the cracks take.
    ///
    /// The first share `s` of a plastic blow with energy `E` takes `E (1 - (1 - s)^2)`: the approach is fastest at the
    /// start.
    pub(super) fn withstood(&self, bodies: &Bodies, slot: u32, division: &PieceSet) -> f32 {
        let (Some(fracturable), Some(mesh)) = (bodies.fracturable(slot), bodies.convex(slot))
        else {
            return 0.0;
        };
        let ImpactLoad { impulse, energy } = self.blow;
        let cracks = fracturable.toughness * division.crack_area(mesh.hull()) as f32;
        let taken = fracturable.min_energy.max(cracks) / energy;
        let by_energy = if taken > 0.0 {
            1.0 - (1.0 - taken).max(0.0).sqrt()
        } else {
            0.0
        };
        (fracturable.strength / impulse).max(by_energy).min(1.0)
    }

    /// The blow as the body in `slot` feels it, body's frame.
    pub(super) fn impact(&self, bodies: &Bodies, slot: u32) -> Impact {
        let to_body = bodies.pose(slot).rotation.inverse();
        // Squeezed from opposite sides, the impulses cancel; any direction across the body is as good as another then.
        let direction = rotate(to_body, self.direction).normalize_or(Vec3::Y);
        Impact {
            point: rotate(to_body, self.moment / self.impulse()) + bodies.mass(slot).center,
            normal: direction,
            impulse: self.impulse(),
            energy: self.blow.energy,
        }
    }
}

/// How a blow divides the body in `slot`, into at most `most` pieces; nothing if it does not pay for a crack.
///
/// Who has fewer pieces to give asks again: a pattern of cells that is cut short does not fill the body.
pub(super) fn cutting(bodies: &Bodies, slot: u32, impact: &Impact, most: usize) -> Option<Cutting> {
    let (fracturable, mesh) = (bodies.fracturable(slot)?, bodies.convex(slot)?);
    let most = u32::try_from(most).unwrap_or(u32::MAX);
    fracturable.cutting(impact, mesh.hull(), most)
}

/// Fills `sums`, by slot. The velocities of `bodies` are those before the blow.
pub(super) fn sum_impulses(sums: &mut Vec<ImpulseSum>, bodies: &Bodies, manifolds: &Manifolds) {
    sums.clear();
    sums.resize(bodies.slots(), ImpulseSum::default());
    for manifold in manifolds.iter() {
        let [a, b] = [manifold.a, manifold.b].map(|slot| &bodies.velocity[slot as usize]);
        let mut total = 0.0;
        for point in manifold.points() {
            // Bonds pull too, but only a push is a blow.
            let impulse = point.total_impulse.max(0.0);
            total += impulse;
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
        sums[manifold.a as usize].note_giver(manifold.b, total);
        sums[manifold.b as usize].note_giver(manifold.a, total);
    }
}

/// Lets the shares (by slot) of the impulses on bodies that break act on them and on what touches them.
///
/// Equal and opposite at one point, so momentum and angular momentum stay what they are.
pub(super) fn apply_shares(shares: &[f32], bodies: &mut Bodies, manifolds: &Manifolds) {
    for manifold in manifolds.iter() {
        let share = shares[manifold.a as usize].max(shares[manifold.b as usize]);
        if share == 0.0 {
            continue;
        }
        for point in manifold.points() {
            let impulse = share * point.total_impulse * manifold.normal;
            push(bodies, manifold.a, point.anchor_a, -impulse);
            push(bodies, manifold.b, point.anchor_b, impulse);
        }
    }
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

impl BreakingImpact {
    /// Impulse that acted on the body before it broke, N s.
    pub fn borne_impulse(&self) -> f32 {
        self.withstood * self.impulse
    }

    /// Kinetic energy that it took to break the body, J: what the withstood share of a plastic blow takes.
    pub fn borne_energy(&self) -> f32 {
        self.energy * self.withstood * (2.0 - self.withstood)
    }
}
