//! The moments of the parts, from those of the hull.
//!
//! The sums over a closed surface are about a point. About the hull's point, the faces that the plane leaves alone add to
//! the sums of their part exactly what they added to those of the hull. So the part with fewer corners is summed up, and
//! the other one has what is left of the hull's sums, with its cut faces exchanged for their pieces and the cap. That is
//! no approximation: it is the same sum over the part's own faces, in another order.
//!
//! Where the plane cuts most of the faces, as it does in a box, summing up both parts is less work.

use crate::geometry::ConvexHull;
use crate::geometry::moments::{Fans, Moments};
use crate::simd::lanes::LaneWidth;
use crate::slice::convex::classes::Classes;
use crate::slice::convex::numbers::Renumbering;
use crate::slice::convex::{HullHalves, IrregularCut};
use glam::Vec3;
use std::ops::Range;

/// All that the moments of the parts follow from.
pub(super) struct HalfSum<'a> {
    pub(super) hull: &'a ConvexHull,
    pub(super) classes: &'a Classes,
    pub(super) numbers: &'a Renumbering,
    pub(super) fans: &'a mut Fans,
    pub(super) width: LaneWidth,
}

/// Share of what a part's box could hold below which its volume may be nothing but rounding: a part that is a plane's
/// tolerance thick and wide still holds 1.6e-13, and sums of `f64` are off by some 1e-16.
const MIN_SHARE: f64 = 1e-14;

/// Whether a part has a volume.
fn is_body(part: &ConvexHull) -> bool {
    let extents = part.aabb.extents().as_dvec3();
    let [x, y, z] = extents.to_array();
    part.moments.volume() > MIN_SHARE * extents.length() * (x * y + y * z + z * x)
}

impl HalfSum<'_> {
    /// Finds the moments of both parts, and checks that each has a volume.
    pub(super) fn find_moments(mut self, halves: &mut HullHalves) -> Result<(), IrregularCut> {
        let few = usize::from(halves.above.loops.len() < halves.below.loops.len());
        let cut = self.classes.cut_faces.len();
        if self.numbers.parts[1 - few].whole_faces.len() > cut {
            self.inherit(few, halves);
        } else {
            for part in [&mut halves.below, &mut halves.above] {
                part.moments = part.sum_moments_with(self.fans, self.width);
            }
        }
        if is_body(&halves.below) && is_body(&halves.above) {
            Ok(())
        } else {
            Err(IrregularCut)
        }
    }

    /// Moments of the parts, of which `few` has fewer corners, by addition and subtraction.
    fn inherit(&mut self, few: usize, halves: &mut HullHalves) {
        let [below, above] = [&mut halves.below, &mut halves.above];
        let [small, large] = if few == 0 {
            [below, above]
        } else {
            [above, below]
        };
        let [in_small, in_large] = [few, 1 - few].map(|part| self.numbers.parts[part].pieces());
        // The cap is the same triangles in both parts, with the other side out: what it adds to one, the other loses.
        let kept = self.sum_whole_faces_and_cap(small, in_small.start);
        let left = self.hull.moments.sums - (kept + self.sum_cut_faces());
        let sums = kept + self.sum_polygons(small, in_small);
        self.finish(small, sums);
        let sums = left + self.sum_polygons(large, in_large);
        self.finish(large, sums);
    }

    /// Gives a part its moments, from sums about the hull's point.
    fn finish(&mut self, part: &mut ConvexHull, sums: Moments) {
        let moments = self.hull.moments.with_sums(sums);
        part.moments = moments.unwrap_or_else(|| part.sum_moments_with(self.fans, self.width));
    }

    /// Sums over the faces that a part has whole, which are its first ones, and its cap, which is its last.
    fn sum_whole_faces_and_cap(&mut self, part: &ConvexHull, whole: usize) -> Moments {
        let (first, rest) = part.faces.split_at(whole);
        let cap = rest.iter().rev().take(1);
        self.fans.clear();
        self.fans.add(cap.map(|face| face.polygon(&part.loops)));
        let triangles = match self.hull.only_triangles() {
            Some(_) => &part.loops[..3 * whole],
            None => {
                let polygons = first.iter().map(|face| face.polygon(&part.loops));
                self.fans.add(polygons);
                &[]
            }
        };
        self.sum(triangles.as_chunks().0, &part.vertices)
    }

    /// Sums over the cut faces.
    fn sum_cut_faces(&mut self) -> Moments {
        let (hull, cut) = (self.hull, self.classes.cut_faces.indices());
        self.fans.clear();
        match hull.only_triangles() {
            Some(triangles) => self.fans.add_some(triangles, cut),
            None => {
                let faces = cut.iter().map(|&index| &hull.faces[index as usize]);
                self.fans.add(faces.map(|face| face.polygon(&hull.loops)));
            }
        }
        self.sum(&[], &hull.vertices)
    }

    /// Sums over some faces of a part.
    fn sum_polygons(&mut self, part: &ConvexHull, faces: Range<usize>) -> Moments {
        let faces = part.faces[faces].iter();
        self.fans.clear();
        self.fans.add(faces.map(|face| face.polygon(&part.loops)));
        self.sum(&[], &part.vertices)
    }

    /// Sums over triangles and those of the fans, about the point of the hull.
    fn sum(&mut self, triangles: &[[u32; 3]], vertices: &[Vec3]) -> Moments {
        let apex = self.hull.moments.apex;
        self.fans.sum(triangles, apex, vertices, self.width)
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
