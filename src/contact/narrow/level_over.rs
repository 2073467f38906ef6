//! What of a hull's underside lies over a triangle.
//!
//! On which sides of the triangle each vertex is out is found for four at a time; then most faces are known to be beside it, or to be
//! inside of some of its edges, from bits alone.
//!
//! # References
//! D. Cohen, I. Sutherland, in W. Newman, R. Sproull, "Principles of Interactive Computer Graphics", 1973: bits for sides.

use crate::contact::narrow::level::{Ground, LevelPair, TOUCH};
use crate::contact::narrow::level_scratch::{LevelScratch, Over};
use crate::geometry::hull_lanes::{LANES, point};
use glam::{Mat3, Vec3};

impl LevelPair<'_> {
    /// Fills `scratch.over` with the points of the hull's underside over a triangle, after a shift.
    pub(super) fn find_over(
        &self,
        ground: &Ground,
        shift: Vec3,
        turn: &Mat3,
        scratch: &mut LevelScratch,
    ) {
        scratch.over.clear();
        // What comes down to it in the rest of the step counts too.
        let rest = -ground.normal.dot(self.travel - shift);
        let reach = self.reach + rest.max(0.0);
        let borders = [0, 1, 2].map(|edge| ground.border(edge));
        if self.note_sides(ground, borders, shift, reach, scratch) {
            return;
        }
        let LevelScratch {
            points,
            polygon,
            clipped,
            sides,
            over,
            ..
        } = scratch;
        let up = turn.transpose() * ground.normal;
        let hull = self.shape.hull();
        let sides = sides.as_flattened();
        for (number, face) in (0..).zip(hull.faces()) {
            let outline = hull.face_loop(face);
            let (mut all, mut any) = (u32::MAX, 0);
            for &v in outline {
                all &= sides[v as usize];
                any |= sides[v as usize];
            }
            if all != 0 || face.plane.normal.dot(up) >= 0.0 {
                continue;
            }
            polygon.clear();
            polygon.extend(outline.iter().map(|&v| point(points, v as usize) + shift));
            for (edge, (from, outward)) in borders.into_iter().enumerate() {
                if any >> edge & 1 != 0 {
                    clip(polygon, from, outward, clipped);
                    std::mem::swap(polygon, clipped);
                }
            }
            let found = polygon.iter().map(|&at| Over {
                at,
                height: ground.height(at),
                face: number,
            });
            over.extend(found.filter(|found| found.height <= reach));
        }
    }

    /// Notes for each vertex of the hull, after a shift, beyond which edges it is, and whether it is higher than `reach`; true if all of
    /// them are out on one side.
    fn note_sides(
        &self,
        ground: &Ground,
        borders: [(Vec3, Vec3); 3],
        shift: Vec3,
        reach: f32,
        scratch: &mut LevelScratch,
    ) -> bool {
        let size = self.shape.aabb().diagonal();
        let bounds = borders.map(|(from, outward)| {
            let border = outward.dot(from - shift);
            (outward, border + TOUCH * (size + border.abs()))
        });
        let top = ground.normal.dot(ground.corners[0] - shift) + reach;
        let bounds = [bounds[0], bounds[1], bounds[2], (ground.normal, top)];
        let mut all = [u32::MAX; LANES];
        scratch.sides.clear();
        scratch.sides.extend(scratch.points.iter().map(|group| {
            let mut sides = [0; LANES];
            for (bit, (axis, most)) in (0..).zip(bounds) {
                let along = group.along(axis);
                for l in 0..LANES {
                    sides[l] |= u32::from(along[l] > most) << bit;
                }
            }
            for l in 0..LANES {
                all[l] &= sides[l];
            }
            sides
        }));
        all.into_iter().fold(u32::MAX, |a, b| a & b) != 0
    }
}

/// What of a polygon lies behind the plane through `from` with the normal `outward`.
fn clip(polygon: &[Vec3], from: Vec3, outward: Vec3, result: &mut Vec<Vec3>) {
    result.clear();
    let Some(&last) = polygon.last() else {
        return;
    };
    let height = |at: Vec3| outward.dot(at - from);
    let (mut before, mut before_height) = (last, height(last));
    for &at in polygon {
        let at_height = height(at);
        if (before_height > 0.0) != (at_height > 0.0) {
            let share = before_height / (before_height - at_height);
            result.push(before + share * (at - before));
        }
        if at_height <= 0.0 {
            result.push(at);
        }
        (before, before_height) = (at, at_height);
    }
}
