//! How far a hull sticks out of a solid, by branch and bound.
//!
//! What is sought is the largest distance of a point of the hull from the solid. The distance grows by at most the way that a point
//! goes, so in a cell it is at most that of one of its points and the way to the farthest corner. The cell with the largest
//! bound is halved until no cell can have more than what was found, but for a tolerance. The result is a bound, not an estimate.
//!
//! Where the surface of the solid goes along that of the hull, bounds would be found by halving cells down to the tolerance
//! everywhere. But only triangles that enter the hull can divide it into solid and air: a cell that none of them enters
//! is all of one kind, and one point tells which.

use crate::geometry::ConvexHull;
use crate::geometry::predicates::length_scale;
use crate::slice::decomposition::solid::Solid;
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A triangle that enters the hull by less than this share of its size lies on its surface: some roundings of a cut.
const ON_SURFACE: f64 = 4e-6;

/// Most cells that are looked at, after which the bound that was reached is the answer.
const MOST_CELLS: usize = 30_000;

/// What is asked.
#[derive(Clone, Copy, Debug)]
pub(super) enum Question {
    /// Whether it is no more than this, m: the answer is a bound on the right side of it.
    Within(f64),
    /// How much it is, up to this, m.
    UpTo(f64),
}

/// A part of space that is yet to be looked at.
struct Cell {
    center: DVec3,
    half: DVec3,
    /// No point of the hull in it is farther from the solid, m.
    bound: f64,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

/// A hull within a solid.
struct Search<'s> {
    hull: &'s ConvexHull,
    solid: &'s Solid,
    /// Triangles that enter the hull.
    inner: Solid,
    middle: DVec3,
    /// Nearer to the hull's surface than this, roundings decide what a point is in, m.
    skin: f64,
    /// The largest distance that was found, m.
    found: f64,
}

/// No point of `hull` is farther than this from `solid`, m; or, if it is asked about a limit, there is a point farther than that.
pub(super) fn concavity(hull: &ConvexHull, solid: &Solid, question: Question) -> f64 {
    let bounds = hull.aabb();
    let skin = ON_SURFACE * f64::from(length_scale(&bounds));
    let mut search = Search {
        hull,
        solid,
        inner: inner_triangles(hull, solid, skin),
        skin: 4.0 * skin,
        middle: middle(hull),
        found: 0.0,
    };
    let mut open = BinaryHeap::new();
    let (center, half) = (
        bounds.center().as_dvec3(),
        0.5 * bounds.extents().as_dvec3(),
    );
    open.extend(search.cell(center, half));
    let mut count = 0;
    while let Some(cell) = open.pop() {
        count += 1;
        let is_known = match question {
            Question::Within(limit) => cell.bound <= limit || search.found > limit,
            Question::UpTo(tolerance) => cell.bound <= search.found + tolerance,
        };
        if is_known || count > MOST_CELLS {
            return cell.bound.max(search.found);
        }
        for corner in 0..8 {
            let sign = |bit: usize| if corner >> bit & 1 == 0 { -0.5 } else { 0.5 };
            let half = 0.5 * cell.half;
            let away = DVec3::new(sign(0), sign(1), sign(2)) * cell.half;
            open.extend(search.cell(cell.center + away, half));
        }
    }
    search.found
}

impl Search<'_> {
    /// A cell, if what of the hull is in it can be in the air.
    fn cell(&mut self, center: DVec3, half: DVec3) -> Option<Cell> {
        let planes = self.hull.faces().iter().map(|face| face.plane);
        for plane in planes {
            let normal = plane.normal.as_dvec3();
            let away = normal.dot(center) - f64::from(plane.offset);
            if away > normal.abs().dot(half) {
                return None;
            }
        }
        let Some(point) = self.point_inside(center, half) else {
            let bound = self.solid.distance(center) + half.length();
            return Some(Cell {
                center,
                half,
                bound,
            });
        };
        let is_solid = self.solid.contains(point);
        if is_solid && !self.inner.meets_box(center, half) {
            return None;
        }
        let distance = self.solid.distance(point);
        let reach = half.length() + point.distance(center);
        let bound = if is_solid {
            // On the way to the air it passes through the surface.
            reach - distance
        } else {
            self.found = self.found.max(distance);
            distance + reach
        };
        (bound > 0.0).then_some(Cell {
            center,
            half,
            bound,
        })
    }

    /// A point of the cell that is clearly in the hull: its center, or one half way through what of the cell lies between the hull's
    /// surface and the middle of the hull.
    fn point_inside(&self, center: DVec3, half: DVec3) -> Option<DVec3> {
        let way = self.middle - center;
        let mut enters = 0.0_f64;
        let depth = |point: DVec3| {
            let away =
                self.hull.faces().iter().map(|face| {
                    face.plane.normal.as_dvec3().dot(point) - f64::from(face.plane.offset)
                });
            -away.fold(f64::NEG_INFINITY, f64::max)
        };
        if depth(center) >= self.skin {
            return Some(center);
        }
        for face in self.hull.faces() {
            let normal = face.plane.normal.as_dvec3();
            let away = normal.dot(center) - f64::from(face.plane.offset);
            if away > 0.0 {
                enters = enters.max(away / -normal.dot(way));
            }
        }
        let leaves = (half / way.abs()).min_element().min(1.0);
        let point = center + 0.5 * (enters + leaves) * way;
        (enters < leaves && depth(point) >= self.skin).then_some(point)
    }
}

/// Triangles that are not wholly beyond or on a face of the hull.
fn inner_triangles(hull: &ConvexHull, solid: &Solid, tolerance: f64) -> Solid {
    let enters = |triangle: &&[DVec3; 3]| {
        hull.faces().iter().all(|face| {
            let normal = face.plane.normal.as_dvec3();
            let away = |corner: &DVec3| normal.dot(*corner) - f64::from(face.plane.offset);
            triangle.iter().any(|corner| away(corner) < -tolerance)
        })
    };
    Solid::of_triangles(solid.triangles.iter().filter(enters).copied().collect())
}

/// The mean of the corners.
fn middle(hull: &ConvexHull) -> DVec3 {
    let sum: DVec3 = hull.vertices().iter().map(|v| v.as_dvec3()).sum();
    sum / hull.vertices().len() as f64
}
