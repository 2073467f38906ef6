//! Plane against a convex hull: faces stay polygons, the cap is one polygon.
//!
//! A face with vertices on both sides is divided by one chord from where its loop goes up through the plane to where it
//! comes down. The chords, and the edges on the plane between a face below and a face above, form the rim, and the rim is
//! the cap's loop. Both parts use the same cut points, bit for bit, and keep the planes of the faces they come from.
//!
//! The work in proportion to the hull is a few passes without search or hashing: every vertex gets a side, every edge and
//! face a part; vertices and faces are numbered in order, and what the plane leaves alone is copied and then
//! renumbered, list by list. Only the faces and edges that the plane meets, about the square root of all, are looked at
//! closely.
//!
//! A hull whose faces are flat and convex to rounding gives exactly one rim loop. If noise near the plane makes it
//! otherwise, the parts are rebuilt as the convex hulls of their points.

mod classes;
mod cut_points;
mod emit;
mod moments;
mod numbers;
mod rebuild;
mod rim;
mod select;

use crate::geometry::ConvexHull;
use crate::geometry::moments::Fans;
use crate::geometry::predicates::check_plane;
use crate::math::Plane;
use crate::simd::lanes::LaneWidth;
use crate::slice::SliceError;
use crate::slice::cut::Cut;
use classes::Classes;
use emit::HullWriter;
use moments::HalfSum;
use numbers::Renumbering;
use rim::Rim;

/// The two parts of a hull that a plane cut.
#[derive(Clone, Debug, PartialEq)]
pub struct HullHalves {
    /// The part on the side that the plane's normal points away from; its last face is the cap.
    pub below: ConvexHull,
    /// The part on the side that the normal points to; its last face is the cap.
    pub above: ConvexHull,
}

impl HullHalves {
    /// Room for [`HullSlicer::slice_into`]: `hull` twice, until a cut puts parts in their place.
    pub fn copies_of(hull: &ConvexHull) -> Self {
        Self {
            below: hull.clone(),
            above: hull.clone(),
        }
    }
}

/// Cuts a convex hull by a plane.
///
/// `plane` is in the hull's frame (m). Vertices nearer to it than the plane tolerance belong to both parts, unmoved.
///
/// # Errors
/// [`SliceError::Plane`] if the plane has NaN or infinite numbers or no unit normal.
pub fn slice_hull(hull: &ConvexHull, plane: Plane) -> Result<Cut<Box<HullHalves>>, SliceError> {
    HullSlicer::default().slice(hull, plane)
}

/// Cuts hulls one after the other, keeping its working memory.
#[derive(Clone, Debug, Default)]
pub struct HullSlicer {
    classes: Classes,
    rim: Rim,
    numbers: Renumbering,
    fans: Fans,
    /// Which registers may be used; all give the same bits.
    width: LaneWidth,
}

/// The rim is not one simple loop, or a part is not a polyhedron.
#[derive(Clone, Copy, Debug)]
struct IrregularCut;

impl HullSlicer {
    /// As [`slice_hull`].
    ///
    /// # Errors
    /// As [`slice_hull`].
    pub fn slice(
        &mut self,
        hull: &ConvexHull,
        plane: Plane,
    ) -> Result<Cut<Box<HullHalves>>, SliceError> {
        let mut halves = HullHalves {
            below: ConvexHull::empty(),
            above: ConvexHull::empty(),
        };
        let cut = self.slice_into(hull, plane, &mut halves)?;
        Ok(cut.map(|()| Box::new(halves)))
    }

    /// As [`slice_hull`], with the parts in the memory of the hulls in `halves`.
    ///
    /// Once that and the slicer's own memory are as large as hulls of this size need, a cut allocates nothing, but for the
    /// rare one that rebuilds the parts from their points. If the hull is not cut, `halves` holds what it held before, or
    /// `hull` twice.
    ///
    /// # Errors
    /// As [`slice_hull`].
    pub fn slice_into(
        &mut self,
        hull: &ConvexHull,
        plane: Plane,
        halves: &mut HullHalves,
    ) -> Result<Cut, SliceError> {
        check_plane(&plane)?;
        let found = self.classes.find_sides(hull, &plane);
        if found & classes::ABOVE == 0 {
            return Ok(Cut::Below);
        }
        if found & classes::BELOW == 0 {
            return Ok(Cut::Above);
        }
        match self.divide(hull, &plane, halves) {
            Ok(()) => Ok(Cut::Cut(())),
            Err(IrregularCut) => {
                rebuild::rebuild(hull, &self.classes.sides, &self.rim.points, halves)
            }
        }
    }

    /// Makes the parts of a hull with vertices on both sides.
    fn divide(
        &mut self,
        hull: &ConvexHull,
        plane: &Plane,
        halves: &mut HullHalves,
    ) -> Result<(), IrregularCut> {
        let Self {
            classes,
            rim,
            numbers,
            fans,
            width,
        } = self;
        let width = *width;
        classes.find_edges(hull, width);
        classes.find_faces(hull, plane);
        rim.cut_edges(hull, plane, classes, width);
        rim.divide_faces(hull, classes)?;
        rim.find_cap(hull, classes)?;
        numbers.count(hull, classes, rim, width)?;
        let parts = [&mut halves.below, &mut halves.above];
        for (part, out) in parts.into_iter().enumerate() {
            let writer = HullWriter {
                hull,
                classes,
                rim,
                part,
                numbers: &numbers.parts[part],
                plane: [*plane, plane.flipped()][part],
                width,
            };
            writer.write(out)?;
        }
        let summing = HalfSum {
            hull,
            classes,
            numbers,
            fans,
            width,
        };
        summing.find_moments(halves)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::hull_lanes::HullLanes;
    use crate::geometry::primitives::{cuboid, icosphere, regular_prism};
    use glam::Vec3;
    use rand_core::Rng;
    use rand_pcg::Pcg32;

    /// A number between -1 and 1.
    fn signed(dice: &mut Pcg32) -> f32 {
        f32::from((dice.next_u32() >> 16) as u16) / 32768.0 - 1.0
    }

    /// A plane through a point of a hull, or through one, two or three of its vertices.
    fn plane(dice: &mut Pcg32, hull: &ConvexHull) -> Plane {
        let count = hull.vertices().len() as u32;
        let mut vertex = || hull.vertices()[(dice.next_u32() % count) as usize];
        let [a, b, c] = [vertex(), vertex(), vertex()];
        let normal = Vec3::new(signed(dice), signed(dice), signed(dice));
        match dice.next_u32() % 4 {
            0 => Plane::through(a, normal),
            1 => Plane::through(a, (b - a).cross(normal)),
            2 => Plane::through(a, (b - a).cross(c - a)),
            _ => Plane::through((a + b + c) / 3.0, normal),
        }
    }

    #[test]
    fn wide_and_narrow_registers_give_the_same_bits_and_the_lanes_of_the_faces() {
        let mut dice = Pcg32::new(1, 1);
        let mut wide = HullSlicer::default();
        let mut narrow = HullSlicer {
            width: LaneWidth::Four,
            ..HullSlicer::default()
        };
        let bodies = [
            cuboid(1.0, 0.7, 1.3),
            icosphere(0.5, 1),
            icosphere(0.5, 2),
            regular_prism(33, 1.0, 0.3),
        ];
        let mut cuts = 0;
        for body in bodies {
            let mut hulls = vec![body.expect("valid sizes")];
            for _ in 0..200 {
                let hull = hulls.swap_remove(dice.next_u32() as usize % hulls.len());
                let plane = plane(&mut dice, &hull);
                let found = [&mut wide, &mut narrow].map(|slicer| slicer.slice(&hull, plane));
                // Written out, because `0.0 == -0.0`.
                let [of_wide, of_narrow] = found.each_ref().map(|found| format!("{found:?}"));
                assert_eq!(of_wide, of_narrow);
                match found {
                    [Ok(Cut::Cut(halves)), _] => {
                        cuts += 1;
                        for part in [&halves.below, &halves.above] {
                            let lanes = HullLanes::of(&part.vertices, &part.faces);
                            assert_eq!(part.lanes, lanes);
                        }
                        hulls.extend([halves.below, halves.above]);
                    }
                    _ => hulls.push(hull),
                }
            }
        }
        assert!(cuts > 400, "{cuts}");
    }
}
