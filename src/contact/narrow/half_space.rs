//! Where a hull touches a half-space.

use crate::contact::local_manifold::{LocalManifold, LocalPoint};
use crate::contact::narrow::scratch::{MERGE, NarrowScratch, SatResult};
use crate::contact::reduce::{Candidate, CornerKind, SAG, reduce_uneven};
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

/// As [`collide_half_space`], which it does the work of, and says how far apart hull and half-space are; `scratch.beside` as that of hulls.
pub(crate) fn examine_half_space(
    hull: &ConvexHull,
    plane: Plane,
    b_in_a: Pose,
    margin: f32,
    scratch: &mut NarrowScratch,
) -> SatResult {
    let patch = LocalManifold {
        normal: -plane.normal,
        normal_in_b: Some(-rotate(b_in_a.rotation.inverse(), plane.normal)),
        recycle_distance: f32::INFINITY,
        slide: f32::INFINITY,
        ..LocalManifold::default()
    };
    scratch.beside = None;
    if !b_in_a.is_finite() || !margin.is_finite() {
        return SatResult::Touching(patch);
    }
    let (support, deepest) = lowest(hull.lanes.points.iter(), plane.normal);
    let distance = deepest - plane.offset;
    if !distance.is_finite() {
        return SatResult::Touching(patch);
    }
    if distance > margin {
        let axis = -plane.normal;
        return SatResult::Separated { axis, distance };
    }
    load_lowest_face(hull, support, &plane, margin, scratch);
    let NarrowScratch {
        polygon,
        lower,
        beside,
        ..
    } = scratch;
    let merge = MERGE * hull.aabb().diagonal();
    let sag = SAG * hull.aabb().extents().min_element();
    reduce_uneven(polygon, lower, plane.normal, merge, sag);
    let with = |vertices: &[Candidate]| {
        let mut patch = patch;
        for vertex in vertices {
            let below = vertex.at - vertex.separation * plane.normal;
            patch.push(LocalPoint {
                on_a: vertex.at,
                on_b: b_in_a.inverse_transform_point(below),
                separation: vertex.separation,
                ..LocalPoint::default()
            });
        }
        patch
    };
    *beside = (!lower.is_empty()).then(|| with(lower));
    SatResult::Touching(with(polygon))
}

/// Puts the corners of the face that a falling hull lands on into `scratch.polygon`, as far as they are within the margin. Vertices off it do
/// not count, however large the margin, or four points would be spread over the whole height of a flat hull.
fn load_lowest_face(
    hull: &ConvexHull,
    support: usize,
    plane: &Plane,
    margin: f32,
    scratch: &mut NarrowScratch,
) {
    let face = hull.incident_face(support, plane.normal);
    let outline = face.map_or(&[][..], |face| hull.face_loop(face));
    let corners = outline.iter().map(|&v| hull.vertices()[v as usize]);
    let corners = corners.map(|at| Candidate {
        at,
        separation: plane.distance(at),
        kind: CornerKind::Incident,
        leaves_on_cut: false,
    });
    scratch.polygon.clear();
    scratch
        .polygon
        .extend(corners.filter(|corner| corner.separation <= margin));
}
