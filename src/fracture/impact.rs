//! Contact impulses of one step, summed by body, and what they break.

use crate::contact::manifold::Manifold;
use crate::math::rotate;
use crate::slice::pattern::{Impact, Planes};
use crate::solver::bodies::{Bodies, RigidBody};
use glam::Vec3;

/// Contact impulses on one body in one step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ImpulseSum {
    /// Sum of the normal impulses over all contact points, N s.
    total: f32,
    /// The largest of them, N s.
    strongest: f32,
    /// Where that one acts, from the centre of mass, world axes, m.
    point: Vec3,
    /// Its direction on the body, world axes.
    direction: Vec3,
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
                sum.total += point.normal_impulse;
                if point.normal_impulse > sum.strongest {
                    sum.strongest = point.normal_impulse;
                    (sum.point, sum.direction) = (anchor, direction);
                }
            }
        }
    }
}

/// The planes (body's frame) that the impulses break the body in `slot` by; none if it bears them.
pub(super) fn planes_of_impact(bodies: &Bodies, slot: u32, sum: &ImpulseSum) -> Planes {
    let Some(fracturable) = bodies.fracturable(slot) else {
        return Planes::new();
    };
    let breaks = sum.total > fracturable.strength
        && bodies.kind(slot) == RigidBody::Dynamic
        && bodies.is_active(slot);
    let Some(mesh) = bodies.convex(slot).filter(|_| breaks) else {
        return Planes::new();
    };
    let to_body = bodies.pose(slot).rotation.inverse();
    let impact = Impact {
        point: rotate(to_body, sum.point) + bodies.mass(slot).centre,
        normal: rotate(to_body, sum.direction),
        impulse: sum.total,
    };
    let seed = fracturable.seed;
    fracturable.pattern.planes(&impact, mesh.hull(), seed)
}
