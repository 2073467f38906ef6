//! Where a contact is after a step, and how fast its bodies approached.

use crate::bodies::solver_body::SolverBody;
use crate::bodies::store::Bodies;
use crate::contact::manifolds::ManifoldRef;
use glam::Vec3;

/// The lesser of two bodies' least extents, m.
pub(super) fn smaller_extent(bodies: &Bodies, slots: [u32; 2]) -> f32 {
    let [a, b] = slots.map(|slot| bodies.min_extent[slot as usize]);
    a.min(b)
}

/// Where a contact is after the step: on the surface of the body that contacts do not move, if one is, else between the two.
pub(super) fn center_of(bodies: &Bodies, manifold: ManifoldRef) -> Vec3 {
    let [a, b] = [manifold.a, manifold.b].map(|slot| bodies.center[slot as usize]);
    let [fixed_a, fixed_b] =
        [manifold.a, manifold.b].map(|slot| bodies.velocity[slot as usize].inverse_mass == 0.0);
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    for point in manifold.points() {
        // Anchors are halfway between the surfaces.
        let half_gap = 0.5 * point.separation * manifold.normal;
        let [on_a, on_b] = [a + point.anchor_a - half_gap, b + point.anchor_b + half_gap];
        let place = match (fixed_a, fixed_b) {
            (true, false) => on_a,
            (false, true) => on_b,
            _ => 0.5 * (on_a + on_b),
        };
        let weight = point.total_impulse.abs() + f32::MIN_POSITIVE;
        sum += weight * place;
        weights += weight;
    }
    sum / weights
}

/// Largest speed of approach at a point before the step, m/s.
pub(super) fn approach_speed(before: &[SolverBody], manifold: ManifoldRef) -> f32 {
    let velocity = |slot: u32| before.get(slot as usize).copied().unwrap_or_default();
    let [a, b] = [velocity(manifold.a), velocity(manifold.b)];
    let speeds = manifold.points().iter().map(|point| {
        let on_a = a.linear + a.angular.cross(point.anchor_a);
        let on_b = b.linear + b.angular.cross(point.anchor_b);
        manifold.normal.dot(on_a - on_b)
    });
    speeds.fold(0.0, f32::max)
}
