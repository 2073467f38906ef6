//! Which bodies touch face to face.

use crate::bodies::body::RigidBody;
use crate::bodies::body::Shape;
use crate::bodies::store::Bodies;
use crate::collide::narrow_phase::relative_pose;
use crate::geometry::shared_area;
use crate::math::{Plane, Pose, rotate};
use glam::{Mat3, Vec3};

/// Largest gap between faces that count as touching, as a share of the smaller body's least extent.
const TOUCHING_SHARE: f32 = 0.01;

/// Least area that is worth a bond, as a share of the square of the smaller body's least extent: more than rounding makes
/// of two edges that touch.
const MIN_AREA: f32 = 1e-3;

/// Pairs of the bodies that may touch, in no particular order: a sweep along x over their boxes.
pub(super) fn close_pairs(bodies: &Bodies, slots: &[u32]) -> Vec<[u32; 2]> {
    let reach = |slot: u32| {
        let pose = bodies.pose(slot);
        let margin = TOUCHING_SHARE * bodies.min_extent[slot as usize];
        if let Some(compound) = bodies.compound(slot) {
            let turn = Mat3::from_quat(pose.rotation);
            let around = compound.bounds(&turn, pose.position).fattened(margin);
            return [around.min, around.max];
        }
        let Some(mesh) = bodies.convex(slot) else {
            return [Vec3::NEG_INFINITY, Vec3::INFINITY];
        };
        let corners = mesh.hull().vertices().iter();
        let corners = corners.map(|v| pose.transform_point(*v));
        corners.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[min, max], v| {
            [min.min(v - margin), max.max(v + margin)]
        })
    };
    let mut boxes: Vec<_> = slots.iter().map(|&slot| (slot, reach(slot))).collect();
    boxes.sort_by(|(a, [l, _]), (b, [r, _])| l.x.total_cmp(&r.x).then(a.cmp(b)));
    boxes.dedup_by_key(|(slot, _)| *slot);
    let mut pairs = Vec::new();
    for (i, (a, [min, max])) in boxes.iter().enumerate() {
        let next = boxes[i + 1..].iter();
        for (b, [other_min, other_max]) in next.take_while(|(_, [other, _])| other.x <= max.x) {
            if other_min.cmple(*max).all() && min.cmple(*other_max).all() {
                pairs.push([*a, *b]);
            }
        }
    }
    pairs
}

/// Area over which two bodies touch face to face as they lie; `None` if it is too small for a bond or nothing of the two can
/// move.
pub(super) fn touching_area(bodies: &Bodies, a: u32, b: u32) -> Option<f32> {
    area_in_pose(bodies, a, b, &relative_pose(bodies, a, b))
}

/// The same, if the pose of B in A's frame were `b_in_a`.
pub(super) fn area_in_pose(bodies: &Bodies, a: u32, b: u32, b_in_a: &Pose) -> Option<f32> {
    if !can_move(bodies, a, b) {
        return None;
    }
    let extent = smaller_extent(bodies, [a, b]);
    let gap = TOUCHING_SHARE * extent;
    let shapes = [a, b].map(|slot| &bodies.info(slot).shape);
    let area = area_of_shapes(shapes, b_in_a, gap);
    (area > MIN_AREA * extent * extent).then_some(area)
}

/// Area over which two shapes lie on each other with a gap or overlap of at most `gap` (m), m2.
fn area_of_shapes([a, b]: [&Shape; 2], b_in_a: &Pose, gap: f32) -> f32 {
    match (a, b) {
        (Shape::Compound(compound), _) => {
            let parts = compound.parts().iter();
            let areas = parts.map(|part| {
                let shape = Shape::Convex(part.shape.clone());
                area_of_shapes([&shape, b], &(part.pose.inverse() * *b_in_a), gap)
            });
            areas.sum()
        }
        (_, Shape::Compound(_)) => area_of_shapes([b, a], &b_in_a.inverse(), gap),
        (Shape::Convex(first), Shape::Convex(second)) => {
            shared_area::of_hulls(first.hull(), second.hull(), b_in_a, gap)
        }
        (Shape::Convex(mesh), Shape::HalfSpace(half_space)) => {
            let normal = rotate(b_in_a.rotation, half_space.normal);
            let plane = Plane::through(b_in_a.position, normal);
            shared_area::on_half_space(mesh.hull(), &plane, gap)
        }
        (Shape::HalfSpace(_), Shape::Convex(_)) => area_of_shapes([b, a], &b_in_a.inverse(), gap),
        (Shape::HalfSpace(_), Shape::HalfSpace(_))
        | (Shape::Level(_), _)
        | (_, Shape::Level(_)) => 0.0,
    }
}

pub(super) fn can_move(bodies: &Bodies, a: u32, b: u32) -> bool {
    [a, b]
        .into_iter()
        .any(|slot| bodies.kind(slot) == RigidBody::Dynamic)
}

/// Lesser of the least extents of two bodies, m.
pub(super) fn smaller_extent(bodies: &Bodies, slots: [u32; 2]) -> f32 {
    let [a, b] = slots.map(|slot| bodies.min_extent[slot as usize]);
    a.min(b)
}
