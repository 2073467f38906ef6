//! What moves far within a step does not get behind what it strikes.
//!
//! Contacts are found where a step begins, along the way that a body goes if nothing turns it aside. What strikes a bump at a hundred meters
//! a second spins off within the step, and its middle may be below the ground at the end of it, where triangles do not touch it any more, or
//! on the other side of a thin plate, which it touches from there. So the way of its middle is looked at once more before it is made: where it
//! would go through a triangle from the front or into a convex body, it ends.
//!
//! What contacts do not move takes the speed towards it away. A body that they move does not: the next step finds the two where they touch.
//! But what it finds may be another side that they leave each other on, so the way goes on along the surface there. Otherwise what strikes an edge
//! of a body that hangs would be held at that place in the air, step by step, while gravity makes it faster.

use crate::bodies::body::Shape;
use crate::bodies::store::Bodies;
use crate::contact::pairs::broad_phase::Broadphase;
use crate::math::{Aabb, rotate};
use crate::query::local::{LocalHit, LocalRay};
use crate::query::{compound, convex, level};
use glam::Vec3;
use smallvec::SmallVec;

/// Share of its least extent that a body goes in a step from which on it is looked at: what is slower is held by contacts.
const FAR: f32 = 0.25;

/// How far before the surface the middle is left, as a share of the body's least extent.
const BEFORE: f32 = 1e-3;

/// How far the way of a middle between bodies that turn may be from straight for it to be followed, as a share of the body's least extent.
const BEND: f32 = 0.1;

/// Cuts the ways that the solver has found short where they would get behind a level or into a convex body. Nothing for what is slow.
pub(super) fn hold_before_walls(bodies: &mut Bodies, broadphase: &Broadphase, near: &mut Vec<u32>) {
    let is_local = bodies.local.is_on;
    let count = match is_local {
        true => bodies.local.slots.len(),
        false => bodies.slots(),
    };
    let mut levels = None;
    for at in 0..count {
        let slot = match is_local {
            true => bodies.local.slots[at],
            false => at as u32,
        };
        let is_far = goes_far(bodies, slot);
        // A local step is a part of the way, and few take them.
        if bodies.any_level && (is_far || is_local && bodies.is_carried(slot)) {
            for &level in levels.get_or_insert_with(|| levels_of(bodies)).iter() {
                hold(bodies, slot, level);
            }
        }
        // What hangs on joints is led by them: impulses go on through them where it is held.
        if is_far && !bodies.is_jointed(slot) {
            hold_before_convex(bodies, slot, broadphase, near);
        }
    }
}

/// Whether they move it so far that it is looked at.
fn goes_far(bodies: &Bodies, slot: u32) -> bool {
    let (extent, motion) = (
        bodies.min_extent[slot as usize],
        &bodies.motion[slot as usize],
    );
    let far = FAR * extent;
    motion.shift.length_squared() > far * far && bodies.is_carried(slot)
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

/// The middles of a body's convex parts, own frame.
fn middles(bodies: &Bodies, slot: u32) -> SmallVec<[Vec3; 4]> {
    match &bodies.info(slot).shape {
        Shape::Convex(mesh) => SmallVec::from_slice(&[mesh.hull().centroid()]),
        Shape::Compound(compound) => {
            let parts = compound.parts().iter();
            let middle = parts.map(|part| part.pose.transform_point(part.shape.hull().centroid()));
            middle.collect()
        }
        Shape::HalfSpace(_) | Shape::Level(_) => SmallVec::new(),
    }
}

/// Cuts the way of a body short before the convex bodies and compounds that are on it.
fn hold_before_convex(
    bodies: &mut Bodies,
    slot: u32,
    broadphase: &Broadphase,
    near: &mut Vec<u32>,
) {
    let poses = [bodies.pose(slot), bodies.pose_after_step(slot)];
    let middles = middles(bodies, slot);
    let ends = middles.iter();
    let ends = ends.flat_map(|&middle| poses.map(|pose| pose.transform_point(middle)));
    let way = Aabb::of_points(ends);
    near.clear();
    broadphase.search_box(&way, near);
    // Found in no order.
    near.sort_unstable();
    for &other in near.iter().filter(|&&other| other != slot) {
        let shape = &bodies.info(other).shape;
        if bodies.is_active(other) && (shape.convex().is_some() || shape.compound().is_some()) {
            hold(bodies, slot, other);
        }
    }
}

/// Cuts the way of one body short before another one, if they touch each other where they meet.
fn hold(bodies: &mut Bodies, slot: u32, wall: u32) {
    if !bodies.may_touch(slot, wall) {
        return;
    }
    for middle in middles(bodies, slot) {
        hold_middle(bodies, (slot, middle), wall);
    }
}

/// How far a point is from the chord of its way on a body that turns, at most, m.
fn bend(bodies: &Bodies, slot: u32, point: Vec3) -> f32 {
    let turn = bodies.pose_after_step(slot).rotation * bodies.pose(slot).rotation.inverse();
    let squared = 4.0 * turn.xyz().length_squared();
    0.125 * squared * point.distance(bodies.center_of_mass(slot))
}

/// Cuts the way of a body short where its middle (own frame) would get into a wall.
fn hold_middle(bodies: &mut Bodies, (slot, middle): (u32, Vec3), wall: u32) {
    let i = slot as usize;
    let (start, at_start) = (bodies.pose(slot), bodies.pose(wall));
    let at_end = bodies.pose_after_step(wall);
    let place = start.transform_point(middle);
    let is_bent = || {
        let bend = bend(bodies, slot, place) + bend(bodies, wall, place);
        bend > BEND * bodies.min_extent[i]
    };
    if bodies.info(wall).shape.level().is_none() && is_bent() {
        return;
    }
    let from = at_start.inverse_transform_point(place);
    let to = bodies.pose_after_step(slot).transform_point(middle);
    let way = at_end.inverse_transform_point(to) - from;
    let shape = &bodies.info(wall).shape;
    let Some(hit) = first_hit(shape, from, way) else {
        return;
    };
    let before = BEFORE * bodies.min_extent[i];
    let first = hit.point + before * hit.normal;
    let is_moved = bodies.velocity[wall as usize].inverse_mass != 0.0;
    let last = if is_moved {
        slide(shape, (first, from + way), hit.normal, before)
    } else {
        first
    };
    bodies.motion[i].shift += at_end.transform_point(last) - to;
    if !is_moved {
        let normal = rotate(at_end.rotation, hit.normal);
        let against = bodies.velocity[i].linear - bodies.velocity_at(wall, to);
        bodies.velocity[i].linear -= against.dot(normal).min(0.0) * normal;
    }
}

/// Where a way ends that goes on along a surface with this normal from where it struck it (the shape's frame); at most `before` from what is
/// on it, m.
fn slide(shape: &Shape, (from, to): (Vec3, Vec3), normal: Vec3, before: f32) -> Vec3 {
    let way = (to - from).reject_from_normalized(normal);
    match first_hit(shape, from, way) {
        Some(hit) => hit.point + before * hit.normal,
        None => from + way,
    }
}

/// Where a way gets to a shape from outside (the shape's frame).
fn first_hit(shape: &Shape, from: Vec3, way: Vec3) -> Option<LocalHit> {
    let length = way.length();
    let direction = way.try_normalize().filter(|_| length.is_finite())?;
    let ray = &LocalRay {
        origin: from,
        direction,
        end: length,
        is_solid: true,
    };
    let from_outside = |hit: &LocalHit| hit.distance > 0.0;
    match shape {
        Shape::Level(mesh) => level::cast_ray(mesh, ray),
        Shape::Convex(mesh) => convex::cast_ray(mesh, ray).filter(from_outside),
        Shape::Compound(parts) => compound::cast_ray(parts, ray).filter(from_outside),
        Shape::HalfSpace(_) => None,
    }
}
