//! What moves far within a step does not get behind a level.
//!
//! Contacts are found where a step begins, along the way that a body goes if nothing turns it aside. What strikes a bump at a hundred meters
//! a second spins off within the step, and its middle may be below the ground at the end of it, where triangles do not touch it any more. So
//! the way of its middle is looked at once more before it is made: where it would go through a triangle from the front, it ends, and with it
//! the speed into the triangle.

use crate::bodies::store::Bodies;
use crate::geometry::StaticMesh;
use crate::math::{Pose, rotate};
use crate::query::level::cast_ray;
use crate::query::local::LocalRay;
use glam::Vec3;
use smallvec::SmallVec;

/// Share of its least extent that a body goes in a step from which on it is looked at: what is slower is held by contacts.
const FAR: f32 = 0.25;

/// How far before the triangle the middle is left, as a share of the body's least extent.
const BEFORE: f32 = 1e-3;

/// Cuts the ways that the solver has found short where they would get behind a level. Nothing without levels and for what is slow.
pub(super) fn hold_before_levels(bodies: &mut Bodies) {
    if !bodies.any_level {
        return;
    }
    let local = bodies.local.is_on;
    let count = if local {
        bodies.local.slots.len()
    } else {
        bodies.slots()
    };
    let mut levels = None;
    for at in 0..count {
        let slot = if local {
            bodies.local.slots[at]
        } else {
            at as u32
        };
        if !is_fast(bodies, slot) {
            continue;
        }
        for &level in levels.get_or_insert_with(|| levels_of(bodies)).iter() {
            let [info, below] = [slot, level].map(|slot| bodies.info(slot));
            if info.is_sensor || !info.layers.interact(&below.layers) {
                continue;
            }
            if let Some(mesh) = below.shape.level().cloned() {
                hold(bodies, slot, (level, &mesh));
            }
        }
    }
}

/// Whether contacts move a body so far in the step that it is looked at.
fn is_fast(bodies: &Bodies, slot: u32) -> bool {
    let i = slot as usize;
    // A local step is a part of the way, and few take them.
    let way = if bodies.local.is_on {
        0.0
    } else {
        FAR * bodies.min_extent[i]
    };
    bodies.velocity[i].inverse_mass > 0.0
        && bodies.is_moving(slot)
        && bodies.motion[i].shift.length_squared() > way * way
}

/// The slots of the levels that bodies stand on.
fn levels_of(bodies: &Bodies) -> SmallVec<[u32; 16]> {
    let is_level = |slot: &u32| {
        bodies.is_active(*slot) && {
            let info = bodies.info(*slot);
            !info.is_sensor && info.shape.level().is_some()
        }
    };
    (0..bodies.slots() as u32).filter(is_level).collect()
}

/// The pose of a body at the end of the step, as it will be.
fn end_of(bodies: &Bodies, slot: u32) -> Pose {
    let i = slot as usize;
    if !bodies.is_moving(slot) {
        return bodies.pose(slot);
    }
    let (center, rotation) = (
        bodies.center[i] + bodies.motion[i].shift,
        bodies.motion[i].rotation,
    );
    Pose::new(center - rotate(rotation, bodies.mass[i].center), rotation)
}

/// The middles of a body's convex parts, own frame.
fn middles(bodies: &Bodies, slot: u32) -> SmallVec<[Vec3; 4]> {
    let shape = &bodies.info(slot).shape;
    match (shape.convex(), shape.compound()) {
        (Some(mesh), _) => SmallVec::from_slice(&[mesh.hull().centroid()]),
        (None, Some(compound)) => {
            let parts = compound.parts().iter();
            let middle = parts.map(|part| part.pose.transform_point(part.shape.hull().centroid()));
            middle.collect()
        }
        (None, None) => SmallVec::new(),
    }
}

/// Cuts the way of one body short before one level.
fn hold(bodies: &mut Bodies, slot: u32, (level, mesh): (u32, &StaticMesh)) {
    let i = slot as usize;
    let (start, ground) = (bodies.pose(slot), bodies.pose(level));
    let ground_at_end = end_of(bodies, level);
    for middle in middles(bodies, slot) {
        let from = ground.inverse_transform_point(start.transform_point(middle));
        let to = end_of(bodies, slot).transform_point(middle);
        let way = ground_at_end.inverse_transform_point(to) - from;
        let length = way.length();
        let Some(direction) = way.try_normalize().filter(|_| length.is_finite()) else {
            continue;
        };
        let ray = LocalRay {
            origin: from,
            direction,
            end: length,
            is_solid: true,
        };
        let Some(hit) = cast_ray(mesh, &ray) else {
            continue;
        };
        let last = hit.point + BEFORE * bodies.min_extent[i] * hit.normal;
        bodies.motion[i].shift += ground_at_end.transform_point(last) - to;
        let normal = rotate(ground_at_end.rotation, hit.normal);
        let against = bodies.velocity[i].linear - velocity_at(bodies, level, to);
        bodies.velocity[i].linear -= against.dot(normal).min(0.0) * normal;
    }
}

/// How fast a point of a level moves, m/s.
fn velocity_at(bodies: &Bodies, level: u32, at: Vec3) -> Vec3 {
    let (linear, angular) = bodies.velocity(level);
    linear + angular.cross(at - bodies.center_of_mass(level))
}
