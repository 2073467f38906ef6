//! Corners of triangles, four at a time.
#![allow(
    unsafe_code,
    reason = "corners are looked up without asking again; the block says why it is sound"
)]

use crate::simd::float4::columns;
use glam::Vec3;

/// Triangles whose corners are all in a list of points, so that they are looked up without asking again.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TrianglesOf<'a> {
    points: &'a [Vec3],
    fours: &'a [[[u32; 3]; 4]],
}

impl<'a> TrianglesOf<'a> {
    /// Panics if there is no point for one of the corners.
    #[inline(always)]
    pub(crate) fn new(points: &'a [Vec3], fours: &'a [[[u32; 3]; 4]]) -> Self {
        let corners = fours.as_flattened().as_flattened();
        let last = corners.iter().fold(0, |last, &corner| last.max(corner));
        assert!(
            corners.is_empty() || (last as usize) < points.len(),
            "there is no point {last}"
        );
        Self { points, fours }
    }

    /// How many fours there are.
    #[inline(always)]
    pub(crate) fn len(self) -> usize {
        self.fours.len()
    }

    /// Coordinates of corner `k` of four triangles, one axis after the other.
    #[inline(always)]
    pub(crate) fn columns(self, four: usize, k: usize) -> [[f32; 4]; 3] {
        let [a, b, c, d] = self.fours[four];
        // SAFETY: `new` found that there is a point for every corner.
        unsafe {
            columns([
                self.points.get_unchecked(a[k] as usize),
                self.points.get_unchecked(b[k] as usize),
                self.points.get_unchecked(c[k] as usize),
                self.points.get_unchecked(d[k] as usize),
            ])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_triangles_are_the_points_they_name() {
        let points: Vec<Vec3> = (0..7_u8)
            .map(|k| Vec3::new(0.0, 10.0, 20.0) + f32::from(k))
            .collect();
        let fours = [[[0, 1, 2], [3, 6, 4], [5, 0, 6], [6, 2, 1]]];
        let triangles = TrianglesOf::new(&points, &fours);
        for k in 0..3 {
            let expected = fours[0].map(|triangle| points[triangle[k] as usize]);
            let [x, y, z] = triangles.columns(0, k);
            for lane in 0..4 {
                assert_eq!(Vec3::new(x[lane], y[lane], z[lane]), expected[lane]);
            }
        }
    }

    #[test]
    #[should_panic(expected = "there is no point 7")]
    fn a_corner_without_a_point_is_found() {
        let _ = TrianglesOf::new(
            &[Vec3::ZERO; 7],
            &[[[0, 1, 2], [3, 6, 4], [5, 0, 6], [6, 7, 1]]],
        );
    }
}
