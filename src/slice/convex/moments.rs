//! The moments of the parts, from those of the hull.
//!
//! The sums over a closed surface are about a point. About the hull's point, the faces that the plane leaves alone add to
//! the sums of their part exactly what they added to those of the hull. So the part with fewer corners is summed up, and
//! the other one has what is left of the hull's sums, with its cut faces exchanged for their pieces and the cap. That is
//! no approximation: it is the same sum over the part's own faces, in another order.
//!
//! Where the plane cuts most of the faces, as it does in a box, summing up both parts is less work.

use super::classes::{BOTH, Classes};
use super::emit::Numbers;
use super::{HullHalves, Irregular};
use crate::geometry::ConvexHull;
use crate::geometry::moments::{MomentSum, Moments};

/// Finds the moments of both parts, and checks that each has a volume.
pub(super) fn find_moments(
    hull: &ConvexHull,
    classes: &Classes,
    numbers: &Numbers,
    halves: &mut HullHalves,
) -> Result<(), Irregular> {
    let few = usize::from(halves.above.loops.len() < halves.below.loops.len());
    let (cut, most) = (classes.cut_faces.len(), numbers.old_faces(1 - few).len());
    if most > 2 * cut {
        from_hull(hull, classes, numbers, few, halves);
    } else {
        halves.below.moments = halves.below.sum_moments();
        halves.above.moments = halves.above.sum_moments();
    }
    if is_body(&halves.below) && is_body(&halves.above) {
        Ok(())
    } else {
        Err(Irregular)
    }
}

/// Share of what a part's box could hold below which its volume may be nothing but rounding: a part that is a plane's
/// tolerance thick and wide still holds 1.6e-13, and sums of `f64` are off by some 1e-16.
const LEAST_SHARE: f64 = 1e-14;

/// Whether a part has a volume.
fn is_body(part: &ConvexHull) -> bool {
    let extents = part.aabb.extents().as_dvec3();
    let [x, y, z] = extents.to_array();
    part.moments.volume() > LEAST_SHARE * extents.length() * (x * y + y * z + z * x)
}

/// Moments of the parts, of which `few` has fewer corners, by addition and subtraction.
fn from_hull(
    hull: &ConvexHull,
    classes: &Classes,
    numbers: &Numbers,
    few: usize,
    halves: &mut HullHalves,
) {
    let old = numbers.old_faces(few).iter().copied();
    let whole = sum_faces(
        hull,
        hull,
        old.filter(|&f| classes.faces[f as usize] != BOTH),
    );
    let cut = sum_faces(hull, hull, classes.cut_faces.iter().copied());
    let others = hull.moments.sums - (whole + cut);
    // The cap is the same triangles in both parts, with the other side out.
    let last = halves.below.faces.len() as u32 - 1;
    let cap = sum_faces(hull, &halves.below, [last].into_iter());
    let parts = [&mut halves.below, &mut halves.above];
    for (part, out) in parts.into_iter().enumerate() {
        let pieces = sum_faces(hull, out, numbers.cut_faces(classes, part));
        let new = pieces + if part == 0 { cap } else { -cap };
        let sums = new + if part == few { whole } else { others };
        let moments = hull.moments.with_sums(sums);
        out.moments = moments.unwrap_or_else(|| out.sum_moments());
    }
}

/// Sums over some faces of a part, about the point of `hull`.
fn sum_faces(hull: &ConvexHull, part: &ConvexHull, faces: impl Iterator<Item = u32>) -> Moments {
    let mut sum = MomentSum::about(hull.moments.apex, &part.vertices);
    for face in faces {
        sum.add_face(part.face_loop(&part.faces[face as usize]));
    }
    sum.finish()
}

#[cfg(test)]
mod tests {
    use crate::geometry::primitives::{icosphere, regular_prism};
    use crate::mass::{VolumeIntegrals, volume_integrals};
    use crate::math::Plane;
    use crate::slice::convex::slice_hull;
    use glam::Vec3;

    #[test]
    fn moments_of_parts_are_those_of_their_faces() {
        let mut cuts = 0;
        for hull in [icosphere(0.5, 2), regular_prism(32, 1.0, 0.3)] {
            let hull = hull.expect("valid sizes");
            for step in 0..40_u8 {
                let height = 0.02 * f32::from(step) - 0.4;
                let plane = Plane::through(Vec3::splat(height), Vec3::new(0.3, 0.2, 1.0));
                let halves = slice_hull(&hull, plane).expect("a usable plane").halves();
                let Some(halves) = halves else { continue };
                cuts += 1;
                for part in [&halves.below, &halves.above] {
                    let kept = VolumeIntegrals::of_hull(part);
                    let fresh = volume_integrals(&part.vertices, part.triangles());
                    assert!((kept.volume / fresh.volume - 1.0).abs() < 1e-12);
                    assert!((kept.centroid - fresh.centroid).length() < 1e-12);
                    let largest = fresh
                        .inertia
                        .to_cols_array()
                        .into_iter()
                        .fold(0.0, f64::max);
                    let error = (kept.inertia - fresh.inertia).to_cols_array();
                    assert!(error.iter().all(|e| e.abs() < 1e-11 * largest), "{error:?}");
                }
            }
        }
        assert!(cuts > 60);
    }
}
