//! Whether bodies of which one has several parts overlap, for sensors.

use crate::bodies::body::Shape;
use crate::bodies::store::Bodies;
use crate::collide::narrow_phase::compound_near::{PartScratch, examine_on_plane, part_pair};
use crate::contact::narrow::compound::{Side, lifted};
use crate::contact::narrow::scratch::SatResult;
use crate::contact::pairs::broad_phase::Pair;
use crate::math::{Pose, rotate};
use glam::Vec3;

/// Contact of one pair in A's frame, normal from A to B; if they are apart, of the parts that touch first where B comes along `way`
/// (A's frame, m). None if none of the two has several parts.
pub(in crate::collide) fn examine_compound_pair(
    bodies: &Bodies,
    pair: Pair,
    b_in_a: Pose,
    way: Vec3,
    others: &mut PartScratch,
) -> Option<SatResult> {
    let shapes = [pair.a, pair.b].map(|slot| &bodies.info(slot).shape);
    if shapes.iter().all(|shape| shape.compound().is_none()) {
        return None;
    }
    // What does not come nearer never touches.
    let mut soonest = SatResult::Separated {
        axis: way.try_normalize().unwrap_or(Vec3::Y),
        distance: f32::INFINITY,
    };
    let mut first = f32::INFINITY;
    let [a, b] = shapes.map(|shape| shape.compound().map_or(1, |it| it.len() as u32));
    for near in (0..a).flat_map(|a| (0..b).map(move |b| [a, b])) {
        match examine_parts(shapes, near, b_in_a, others)? {
            SatResult::Touching(patch) => return Some(SatResult::Touching(patch)),
            SatResult::Separated { axis, distance } => {
                let share = distance / -axis.dot(way);
                if share >= 0.0 && share < first {
                    first = share;
                    soonest = SatResult::Separated { axis, distance };
                }
            }
        }
    }
    Some(soonest)
}

/// The same of two parts; none of a level.
fn examine_parts(
    shapes: [&Shape; 2],
    near: [u32; 2],
    b_in_a: Pose,
    others: &mut PartScratch,
) -> Option<SatResult> {
    let found = match shapes {
        [Shape::Compound(compound), Shape::HalfSpace(below)] => {
            let side = Side::part(compound, near[0]);
            let seen = side.pose.inverse() * b_in_a;
            match examine_on_plane(&side, below.normal, seen, 0.0, others) {
                SatResult::Touching(patch) => {
                    SatResult::Touching(lifted(&patch, &side.pose, &Pose::IDENTITY))
                }
                SatResult::Separated { axis, distance } => SatResult::Separated {
                    axis: rotate(side.pose.rotation, axis),
                    distance,
                },
            }
        }
        [Shape::HalfSpace(below), Shape::Compound(compound)] => {
            let side = Side::part(compound, near[1]);
            let seen = (b_in_a * side.pose).inverse();
            match examine_on_plane(&side, below.normal, seen, 0.0, others) {
                SatResult::Touching(patch) => {
                    let patch = lifted(&patch, &side.pose, &Pose::IDENTITY);
                    SatResult::Touching(patch.swapped(&b_in_a.inverse()))
                }
                SatResult::Separated { distance, .. } => SatResult::Separated {
                    axis: below.normal,
                    distance,
                },
            }
        }
        _ => {
            let parts = part_pair(shapes, near)?;
            let pose = parts.own_pose(b_in_a);
            match parts.examine(pose, 0.0, (&mut *others.hulls, &mut *others.round)) {
                SatResult::Touching(patch) => SatResult::Touching(parts.lift(&patch)),
                SatResult::Separated { axis, distance } => SatResult::Separated {
                    axis: rotate(parts.sides[0].pose.rotation, axis),
                    distance,
                },
            }
        }
    };
    Some(found)
}
