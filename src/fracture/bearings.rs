//! Which faces of clusters lie on something, and what bears them there.

use crate::bodies::body::RigidBody;
use crate::bodies::cluster_state::{ClusterState, LoadSource};
use crate::bodies::store::Bodies;
use crate::cluster::bearing::{Bearing, Borne};
use crate::contact::manifolds::ManifoldRef;
use crate::contact::point::ContactPoint;
use crate::math::rotate;
use glam::Vec3;
use smallvec::SmallVec;

/// Gap of points that bear, as a share of the least extent of a part.
const GAP: f32 = 0.01;

/// Cosine of the angle between faces that are one.
const ONE_FACE: f64 = 0.9995;

/// The face of a dynamic cluster that lies on the other body of a contact; none if it does not lie there, or on no face.
pub(super) fn bearing_of(
    bodies: &Bodies,
    manifold: &ManifoldRef,
    side: usize,
    gravity: Vec3,
) -> Option<(u32, LoadSource, Bearing)> {
    let slots = [manifold.a, manifold.b];
    let (slot, other) = (slots[side], slots[1 - side]);
    let compound = bodies.compound(slot)?;
    let normal = [-1.0, 1.0][side] * manifold.normal;
    let lies = 2.0 * normal.dot(gravity) < -gravity.length();
    if bodies.kind(slot) != RigidBody::Dynamic || !lies || manifold.points().len() < 3 {
        return None;
    }
    let to_body = bodies.pose(slot).rotation.inverse();
    let gap = GAP * compound.min_extent();
    let bears = |point: &&ContactPoint| point.normal_impulse > 0.0 || point.separation < gap;
    let rim = manifold.points().iter().filter(bears).map(|point| {
        let anchor = [point.anchor_a, point.anchor_b][side];
        (rotate(to_body, anchor) + bodies.mass(slot).center).as_dvec3()
    });
    let bearing = Bearing {
        normal: rotate(to_body, normal).as_dvec3().normalize(),
        rim: rim.collect(),
    };
    let source = LoadSource::Contact(bodies.id(other), other);
    (bearing.rim.len() >= 3).then_some((slot, source, bearing))
}

/// Who bears the cluster at faces, and what by each part is still to be told. Those whose faces are not one bear it as points do.
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
