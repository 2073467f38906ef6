//! What contacts do to the parts of clusters.

use crate::bodies::cluster_state::{LoadSource, PartLoad};
use crate::bodies::store::Bodies;
use crate::cluster::elastic::Wrench;
use crate::contact::manifolds::ManifoldRef;
use crate::contact::point::ContactPoint;
use crate::fracture::grip::Grip;
use crate::math::rotate;
use glam::Vec3;

/// Adds what a contact does to a cluster, part by part; with friction by the grip of the cluster, if it has one.
pub(super) fn add_contact(
    bodies: &Bodies,
    manifold: &ManifoldRef,
    side: usize,
    (step_dt, grip): (f32, Option<Grip>),
    found: &mut Vec<(u32, PartLoad)>,
) {
    let slots = [manifold.a, manifold.b];
    let (slot, other) = (slots[side], slots[1 - side]);
    let (Some(compound), Some(state)) = (bodies.compound(slot), bodies.cluster(slot)) else {
        return;
    };
    let to_body = bodies.pose(slot).rotation.inverse();
    let per_time = [-1.0, 1.0][side] / step_dt;
    let in_body = |v: Vec3| rotate(to_body, v * per_time).as_dvec3();
    let friction = SharedFriction::of(manifold, side, bodies.are_bonded(manifold.a, manifold.b));
    for point in manifold.points() {
        let anchor = [point.anchor_a, point.anchor_b][side];
        let share = friction.share_of(point);
        let (sideways, twist) = match &grip {
            Some(grip) => (grip.friction(manifold.normal, point, anchor), Vec3::ZERO),
            None => ((share * friction.sum).as_dvec3(), share * friction.twist),
        };
        let impulse = point.normal_impulse * manifold.normal + sideways.as_vec3();
        if impulse == Vec3::ZERO {
            continue;
        }
        let place = rotate(to_body, anchor) + bodies.mass(slot).center;
        let part = compound.part_at(place);
        let force = in_body(impulse);
        let arm = place.as_dvec3() - state.network.nodes[part as usize].center;
        let wrench = Wrench {
            force,
            torque: arm.cross(force) + in_body(twist),
        };
        let from = (LoadSource::Contact(bodies.id(other), other), part);
        let last = found.iter_mut().rev().take(4);
        let mut known = last.filter(|(of, load)| *of == slot && load.from == from);
        match known.next() {
            Some((_, load)) => load.wrench.add(wrench),
            None => found.push((slot, PartLoad { from, wrench })),
        }
    }
}

/// Friction of a contact, shared by its points as they bear the normal force; that of a bond, whose points may pull, evenly.
///
/// What it is together follows from the motion of what lies there; how points pull against each other does not, and is left from how it came to rest.
/// As a load it would strain bonds that nothing strains: by a fourth of what they bear under 20 t, another one for each rate of steps.
struct SharedFriction {
    /// Of all points, N s.
    sum: Vec3,
    /// About the middle of the shares, N m s.
    twist: Vec3,
    /// How points share it.
    is_even: bool,
    /// Of all shares.
    whole: f32,
}

impl SharedFriction {
    fn of(manifold: &ManifoldRef, side: usize, is_bonded: bool) -> Self {
        let anchor = |point: &ContactPoint| [point.anchor_a, point.anchor_b][side];
        let points = manifold.points();
        let mut shared = Self {
            sum: points.iter().map(|point| point.friction_impulse).sum(),
            twist: Vec3::ZERO,
            is_even: is_bonded,
            whole: 0.0,
        };
        shared.whole = points.iter().map(|point| shared.weight_of(point)).sum();
        let weighed = points.iter().map(|it| shared.weight_of(it) * anchor(it));
        let middle = weighed.sum::<Vec3>() / shared.whole.max(f32::MIN_POSITIVE);
        let turning = points.iter();
        let turning = turning.map(|it| (anchor(it) - middle).cross(it.friction_impulse));
        shared.twist = turning.sum();
        shared
    }

    fn weight_of(&self, point: &ContactPoint) -> f32 {
        match self.is_even {
            true => 1.0,
            false => point.normal_impulse,
        }
    }

    /// Share of a point.
    fn share_of(&self, point: &ContactPoint) -> f32 {
        if self.whole > 0.0 {
            self.weight_of(point) / self.whole
        } else {
            0.0
        }
    }
}
