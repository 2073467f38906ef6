//! The moments of the parts, from those of the hull.
//!
//! The sums over a closed surface are about a point. About the hull's point, the faces that the plane leaves alone add to
//! the sums of their part exactly what they added to those of the hull. So the part with fewer corners is summed up, and
//! the other one has what is left of the hull's sums, with its cut faces exchanged for their pieces and the cap. That is
//! no approximation: it is the same sum over the part's own faces, in another order.
//!
//! Where the plane cuts most of the faces, as it does in a box, summing up both parts is less work.

use super::classes::Classes;
use super::numbers::Numbers;
use super::{HullHalves, Irregular};
use crate::geometry::ConvexHull;
use crate::geometry::lanes::wide::Avx2;
use crate::geometry::moments::{MomentSum, Moments};
use glam::Vec3;

/// Finds the moments of both parts, and checks that each has a volume.
pub(super) fn find_moments(
    hull: &ConvexHull,
    classes: &Classes,
    numbers: &Numbers,
    halves: &mut HullHalves,
    wide: Option<Avx2>,
) -> Result<(), Irregular> {
    let few = usize::from(halves.above.loops.len() < halves.below.loops.len());
    let (cut, most) = (classes.cut_faces.len(), numbers.parts[1 - few].faces.len());
    if most > 2 * cut {
        let summing = Summing {
            hull,
            classes,
            numbers,
            wide,
        };
        summing.inherit(few, halves);
    } else {
        halves.below.moments = halves.below.sum_moments_with(wide);
        halves.above.moments = halves.above.sum_moments_with(wide);
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

/// All that summing up needs.
struct Summing<'a> {
    hull: &'a ConvexHull,
    classes: &'a Classes,
    numbers: &'a Numbers,
    wide: Option<Avx2>,
}

impl Summing<'_> {
    /// Moments of the parts, of which `few` has fewer corners, by addition and subtraction.
    fn inherit(&self, few: usize, halves: &mut HullHalves) {
        let (hull, cut_faces) = (self.hull, self.classes.cut_faces.indices());
        let whole = match few {
            0 => self.sum_whole_faces(few, &halves.below),
            _ => self.sum_whole_faces(few, &halves.above),
        };
        let cut = self.sum_faces(hull, cut_faces.iter().copied());
        let others = hull.moments.sums - (whole + cut);
        // The cap is the same triangles in both parts, with the other side out.
        let last = halves.below.faces.len() as u32 - 1;
        let cap = self.sum_faces(&halves.below, [last].into_iter());
        let parts = [&mut halves.below, &mut halves.above];
        for (part, out) in parts.into_iter().enumerate() {
            let (_, faces) = self.numbers.parts[part].tables();
            let pieces = cut_faces.iter().map(|&face| faces[face as usize]);
            let pieces = self.sum_faces(out, pieces);
            let new = pieces + if part == 0 { cap } else { -cap };
            let sums = new + if part == few { whole } else { others };
            let moments = hull.moments.with_sums(sums);
            out.moments = moments.unwrap_or_else(|| out.sum_moments_with(self.wide));
        }
    }

    /// Sums over the faces that a part has whole, which stand between its pieces of cut faces.
    fn sum_whole_faces(&self, part: usize, out: &ConvexHull) -> Moments {
        let mut sum = self.about_apex(&out.vertices);
        let (_, numbers) = self.numbers.parts[part].tables();
        let mut next = 0;
        for &face in self.classes.cut_faces.indices() {
            let place = numbers[face as usize] as usize;
            sum.add_faces(&out.faces[next..place], &out.loops);
            next = place + 1;
        }
        let cap = out.faces.len() - 1;
        sum.add_faces(&out.faces[next..cap], &out.loops);
        sum.finish()
    }

    /// Sums over some faces of the hull or of a part.
    fn sum_faces(&self, part: &ConvexHull, faces: impl Iterator<Item = u32>) -> Moments {
        let mut sum = self.about_apex(&part.vertices);
        for face in faces {
            sum.add_face(&part.faces[face as usize], &part.loops);
        }
        sum.finish()
    }

    /// Of nothing, about the point of the hull.
    fn about_apex<'v>(&self, vertices: &'v [Vec3]) -> MomentSum<'v> {
        MomentSum::about(self.hull.moments.apex, vertices, self.wide)
    }
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
