//! Where a hull touches a half-space.

use crate::contact::local_manifold::{LocalManifold, LocalPoint};
use crate::contact::narrow::scratch::{MERGE, NarrowScratch, SatResult};
use crate::contact::reduce::{Candidate, CornerKind, reduce};
use crate::geometry::ConvexHull;
use crate::geometry::hull_lanes::lowest;
use crate::math::{Plane, Pose, rotate};

/// Contact of a hull (A) with a half-space (B) whose surface is `plane`, given in the hull's frame.
///
/// The half-space is what lies below the plane; the patch's normal, from A to B, is minus the plane's. `on_b` is in the
/// half-space's frame, whose pose in the hull's frame is `b_in_a`. `None` if the hull is higher than `margin` (m) above
/// the plane, or if an argument is not finite.
pub fn collide_half_space(
    hull: &ConvexHull,
    plane: Plane,
    b_in_a: Pose,
    margin: f32,
    scratch: &mut NarrowScratch,
) -> Option<LocalManifold> {
    match examine_half_space(hull, plane, b_in_a, margin, scratch) {
        SatResult::Touching(patch) if patch.count > 0 => Some(patch),
        _ => None,
    }
}

/// As [`collide_half_space`], which it does the work of, and says how far apart hull and half-space are.
pub(crate) fn examine_half_space(
    hull: &ConvexHull,
    plane: Plane,
    b_in_a: Pose,
    margin: f32,
    scratch: &mut NarrowScratch,
) -> SatResult {
    let mut patch = LocalManifold {
        normal: -plane.normal,
        normal_in_b: Some(-rotate(b_in_a.rotation.inverse(), plane.normal)),
        recycle_distance: f32::INFINITY,
        slide: f32::INFINITY,
        ..LocalManifold::default()
    };
    if !b_in_a.is_finite() || !margin.is_finite() {
        return SatResult::Touching(patch);
    }
    let (support, deepest) = lowest(hull.lanes.points.iter(), plane.normal);
    let distance = deepest - plane.offset;
    if !distance.is_finite() {
        return SatResult::Touching(patch);
    }
    if distance > margin {
        return SatResult::Separated {
            axis: -plane.normal,
            distance,
        };
    }
    let size = hull.aabb().diagonal();
    // The face that a falling hull lands on. Vertices off it do not count, however large the margin, or four points would be
    // spread over the whole height of a flat hull.
    let face = hull.most_opposed_face(support, plane.normal);
    let outline = face.map_or(&[][..], |face| hull.face_loop(face));
    let candidates = &mut scratch.polygon;
    candidates.clear();
    candidates.extend(
        outline
            .iter()
            .map(|&v| hull.vertices()[v as usize])
            .map(|at| Candidate {
                at,
                separation: plane.distance(at),
                kind: CornerKind::Incident,
                leaves_on_cut: false,
            })
            .filter(|vertex| vertex.separation <= margin),
    );
    reduce(candidates, plane.normal, MERGE * size);
    for vertex in candidates {
        patch.push(LocalPoint {
            on_a: vertex.at,
            on_b: b_in_a.inverse_transform_point(vertex.at - vertex.separation * plane.normal),
            separation: vertex.separation,
            ..LocalPoint::default()
        });
    }
    SatResult::Touching(patch)
}
