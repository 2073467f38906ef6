//! At which faces of clusters other bodies bear them, load them or are bonded to them.

use crate::bodies::body::RigidBody;
use crate::bodies::cluster_state::{ClusterState, LoadSource};
use crate::bodies::store::Bodies;
use crate::cluster::bearing::{Bearing, Borne, Spread};
use crate::contact::manifolds::{ManifoldRef, Manifolds};
use crate::contact::point::ContactPoint;
use crate::math::rotate;
use glam::Vec3;
use smallvec::SmallVec;

/// Gap of points that bear, as a share of the least extent of a part.
const GAP: f32 = 0.01;

/// Cosine of the angle between faces that are one.
const ONE_FACE: f64 = 0.9995;

/// Finds out at which faces others touch clusters (slots, ascending). Contacts of what sleeps are not looked at: it lies as it did.
pub(super) fn find_bearings(
    bodies: &mut Bodies,
    manifolds: &Manifolds,
    gravity: Vec3,
    slots: &[u32],
) {
    let is_looked_at =
        |bodies: &Bodies, slot: u32| slots.binary_search(&slot).is_ok() && !bodies.is_asleep(slot);
    for &slot in slots {
        if !is_looked_at(bodies, slot) {
            continue;
        }
        let Some(mut kept) = (bodies.cluster_mut(slot)).map(|it| std::mem::take(&mut it.bearings))
        else {
            continue;
        };
        kept.retain(|(source, _)| is_held_back(bodies, source));
        if let Some(state) = bodies.cluster_mut(slot) {
            state.bearings = kept;
        }
    }
    for manifold in manifolds.iter() {
        for (side, slot) in [manifold.a, manifold.b].into_iter().enumerate() {
            if !is_looked_at(bodies, slot) {
                continue;
            }
            let bearing = bearing_of(bodies, &manifold, side, gravity);
            if let (Some(bearing), Some(state)) = (bearing, bodies.cluster_mut(slot)) {
                state.bearings.push(bearing);
            }
        }
    }
    for &slot in slots {
        if let Some(state) = bodies.cluster_mut(slot) {
            state.bearings.sort_by_key(|(source, _)| *source);
        }
    }
}

/// Whether a source of loads is a body that sleeps.
pub(super) fn is_held_back(bodies: &Bodies, source: &LoadSource) -> bool {
    match *source {
        LoadSource::Contact(id, other) => bodies.is_current(other, id) && bodies.is_asleep(other),
        LoadSource::Joint(_) | LoadSource::Push => false,
    }
}

/// The face of a cluster at which the other body of a contact touches it; none if that is none.
fn bearing_of(
    bodies: &Bodies,
    manifold: &ManifoldRef,
    side: usize,
    gravity: Vec3,
) -> Option<(LoadSource, Bearing)> {
    let slots = [manifold.a, manifold.b];
    let (slot, other) = (slots[side], slots[1 - side]);
    let compound = bodies.compound(slot)?;
    let normal = [-1.0, 1.0][side] * manifold.normal;
    let weight = bodies.drive(slot).gravity_scale * gravity;
    let lies =
        bodies.kind(slot) == RigidBody::Dynamic && 2.0 * normal.dot(weight) < -weight.length();
    let spread = match lies {
        _ if bodies.are_bonded(manifold.a, manifold.b) => Spread::Bonded,
        true => Spread::ByWeight,
        false => Spread::ByArea,
    };
    if manifold.points().len() < 3 {
        return None;
    }
    let to_body = bodies.pose(slot).rotation.inverse();
    let gap = GAP * compound.min_extent();
    let bears = |point: &&ContactPoint| {
        spread == Spread::Bonded || point.normal_impulse > 0.0 || point.separation < gap
    };
    let rim = manifold.points().iter().filter(bears).map(|point| {
        let anchor = [point.anchor_a, point.anchor_b][side];
        (rotate(to_body, anchor) + bodies.mass(slot).center).as_dvec3()
    });
    let bearing = Bearing {
        spread,
        normal: rotate(to_body, normal).as_dvec3().normalize(),
        rim: rim.collect(),
    };
    let source = LoadSource::Contact(bodies.id(other), other);
    (bearing.rim.len() >= 3).then_some((source, bearing))
}

/// Who touches the cluster at faces, and what by each part is still to be told. Those whose faces are not one do it as points do.
pub(super) fn borne_by(state: &ClusterState) -> Vec<(LoadSource, Borne<'_>)> {
    let groups = state.bearings.chunk_by(|a, b| a.0 == b.0);
    let borne = groups.map(|group| {
        let first = &group[0].1;
        let is_one = |it: &Bearing| {
            let off = it.normal.dot(it.rim[0] - first.rim[0]).abs();
            let size = it.rim[0]
                .distance(it.rim[1])
                .max(it.rim[0].distance(it.rim[2]));
            it.normal.dot(first.normal) > ONE_FACE && off < f64::from(GAP) * size
        };
        let faces = group.iter().map(|(_, face)| face);
        let faces: SmallVec<[&Bearing; 2]> = faces.collect();
        let is_one = faces.iter().all(|face| is_one(face));
        let faces = if is_one { faces } else { SmallVec::new() };
        let parts = Vec::new();
        (group[0].0, Borne { faces, parts })
    });
    borne.collect()
}
