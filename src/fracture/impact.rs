//! Contact impulses of one step, summed by body, and what they break.

use crate::contact::manifold::Manifold;
use crate::math::rotate;
use crate::slice::{Cutting, Impact};
use crate::solver::bodies::{Bodies, RigidBody};
use glam::Vec3;

/// Contact impulses on one body in one step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ImpulseSum {
    /// Sum of the normal impulses over all contact points, N s.
    total: f32,
    /// Sum of the impulses times where they act, from the centre of mass, world axes, N s m.
    ///
    /// Divided by the total, the centre of the blow. A single point would do for corners only: a box that lands flat
    /// touches with four, and a plane through one of them is the plane of a face.
    moment: Vec3,
    /// Sum of the impulses with their directions on the body, world axes, N s.
    impulse: Vec3,
}

/// Fills `sums`, by slot.
pub(super) fn sum_impulses(sums: &mut Vec<ImpulseSum>, slots: usize, manifolds: &[Manifold]) {
    sums.clear();
    sums.resize(slots, ImpulseSum::default());
    for manifold in manifolds {
        for point in manifold.points() {
            let sides = [
                (manifold.a, point.anchor_a, -manifold.normal),
                (manifold.b, point.anchor_b, manifold.normal),
            ];
            for (slot, anchor, direction) in sides {
                let sum = &mut sums[slot as usize];
                sum.total += point.total_impulse;
                sum.moment += anchor * point.total_impulse;
                sum.impulse += direction * point.total_impulse;
            }
        }
    }
}

/// How the impulses break the body in `slot`; nothing if it bears them.
pub(super) fn cutting_of_impact(bodies: &Bodies, slot: u32, sum: &ImpulseSum) -> Option<Cutting> {
    let fracturable = bodies.fracturable(slot)?;
    let breaks = sum.total > fracturable.strength
        && bodies.kind(slot) == RigidBody::Dynamic
        && bodies.is_active(slot);
    let mesh = bodies.convex(slot).filter(|_| breaks)?;
    let to_body = bodies.pose(slot).rotation.inverse();
    // Squeezed from opposite sides, the impulses cancel; any direction across the body is as good as another then.
    let direction = rotate(to_body, sum.impulse).normalize_or(Vec3::Y);
    let impact = Impact {
        point: rotate(to_body, sum.moment / sum.total) + bodies.mass(slot).centre,
        normal: direction,
        impulse: sum.total,
        // What an impulse through the centre of mass takes from a body that it stops: J^2 / (2 m).
        energy: 0.5 * sum.total * sum.total * bodies.mass(slot).inverse_mass(),
    };
    fracturable.cutting(&impact, mesh.hull())
}
