//! Convex hull of a point cloud: Quickhull with exact predicates, then coplanar triangles joined to polygons.
//!
//! The only question the algorithm asks of the coordinates is on which side of a plane through three input points a
//! fourth one lies, and `robust` answers it exactly. With exact answers the set of facets that a new point sees is
//! always a disc, a new facet never has zero area (a point in line with a horizon edge lies in the planes of both facets
//! at that edge and sees neither), and coplanar or repeated points need no special case. Rounding can therefore not
//! break the topology, whatever the input; `docs/decisions/convex_hull.md` has the comparison with other implementations.
//!
//! # References
//! - C. B. Barber, D. P. Dobkin, H. Huhdanpaa, "The Quickhull Algorithm for Convex Hulls", ACM TOMS 22(4), 1996.
//! - J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997.

use crate::geometry::convex::ConvexHull;
use crate::geometry::coplanar::{compact, merge_coplanar, unmerged};
use crate::geometry::hull_error::HullError;
use crate::geometry::predicates::{FLAT_RELATIVE, SIZE_RANGE, length_scale, merge_tolerance};
use crate::math::{Aabb, Plane};
use glam::{DVec3, Vec3};
use robust::{Coord3D, orient3d};

/// No facet.
const NONE: u32 = u32::MAX;

/// Triangles (indices into `points`, counter-clockwise seen from outside) of the convex hull of `points` (m).
///
/// The surface is closed and no point lies outside any triangle's plane, exactly. Coplanar faces come as several
/// triangles, and a point in the middle of such a face or of an edge may be a corner of them.
///
/// # Errors
/// [`HullError::TooFewPoints`], [`HullError::NotFinite`], [`HullError::Size`] or [`HullError::Flat`].
pub fn convex_hull_triangles(points: &[DVec3]) -> Result<Vec<[u32; 3]>, HullError> {
    let simplex = first_simplex(points)?;
    let mut quickhull = Quickhull::new(points, simplex);
    while let Some(facet) = quickhull.pending.pop() {
        quickhull.add_farthest_point_of(facet);
    }
    let alive = quickhull.facets.iter().filter(|facet| facet.alive);
    Ok(alive.map(|facet| facet.corners).collect())
}

impl ConvexHull {
    /// The convex hull of `points` (m).
    ///
    /// Triangles in one plane, within `merge_tolerance`, become one polygon face with the plane of the largest of them;
    /// that plane supports the hull, so no point lies outside it by more than its rounding to `f32`. Points inside a face
    /// or on a straight edge are left out. Vertices keep the order they have in `points`.
    ///
    /// # Errors
    /// [`HullError`] says what is wrong with the points.
    pub fn from_points(points: &[Vec3]) -> Result<Self, HullError> {
        let exact: Vec<DVec3> = points.iter().map(|p| p.as_dvec3()).collect();
        let triangles = convex_hull_triangles(&exact)?;
        let size = length_scale(&Aabb::of_points(points.iter().copied()));
        let faces = merge_coplanar(&exact, &triangles, f64::from(merge_tolerance(size)))
            .unwrap_or_else(|| unmerged(&exact, &triangles));
        let (vertices, loops) = compact(points, &faces);
        let planes: Vec<Plane> = faces.iter().map(|face| face.plane).collect();
        Self::from_faces_and_planes(vertices, &loops, &planes)
    }
}

/// The hull of points; none if they are too few or lie in a plane, so that there is no body.
pub(crate) fn hull_unless_flat(points: &[Vec3]) -> Result<Option<ConvexHull>, HullError> {
    match ConvexHull::from_points(points) {
        Ok(hull) => Ok(Some(hull)),
        Err(HullError::Flat { .. } | HullError::TooFewPoints { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Four points that span a volume: two far apart, the one farthest from their line, the one farthest from that plane.
///
/// Returned so that the fourth lies below the first three.
fn first_simplex(points: &[DVec3]) -> Result<[u32; 4], HullError> {
    if let Some(point) = points.iter().position(|p| !p.is_finite()) {
        return Err(HullError::NotFinite { point });
    }
    if points.len() < 4 {
        return Err(HullError::TooFewPoints {
            found: points.len(),
        });
    }
    let min = points
        .iter()
        .copied()
        .reduce(DVec3::min)
        .unwrap_or_default();
    let max = points
        .iter()
        .copied()
        .reduce(DVec3::max)
        .unwrap_or_default();
    let size = (max - min)
        .length()
        .max(min.abs().max(max.abs()).max_element());
    if !SIZE_RANGE.contains(&size) {
        return Err(HullError::Size { size });
    }
    let thinnest = f64::from(FLAT_RELATIVE) * size;
    let flat = |thickness: f64| Err(HullError::Flat { thickness, size });

    let axis = (max - min).max_position();
    let a = farthest(points, |p| -p[axis]);
    let b = farthest(points, |p| p[axis]);
    let line = points[b] - points[a];
    let length = line.length();
    if length <= thinnest {
        return flat(length);
    }
    let from_line = |p: DVec3| (p - points[a]).cross(line).length() / length;
    let c = farthest(points, from_line);
    if from_line(points[c]) <= thinnest {
        return flat(from_line(points[c]));
    }
    let normal = line.cross(points[c] - points[a]).normalize();
    let above = |p: DVec3| normal.dot(p - points[a]);
    let d = farthest(points, |p| above(p).abs());
    let highest = above(points[farthest(points, above)]);
    let lowest = above(points[farthest(points, |p| -above(p))]);
    if highest - lowest <= thinnest {
        return flat(highest - lowest);
    }
    // Far above the rounding error of `above`, so the simplex is not flat in exact arithmetic either.
    let [a, b, c, d] = [a, b, c, d].map(|index| index as u32);
    Ok(if above(points[d as usize]) < 0.0 {
        [a, b, c, d]
    } else {
        [a, c, b, d]
    })
}

/// Index of the point with the largest `measure`, the first of equal ones.
fn farthest(points: &[DVec3], measure: impl Fn(DVec3) -> f64) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (index, &point) in points.iter().enumerate() {
        let value = measure(point);
        if value > best.1 {
            best = (index, value);
        }
    }
    best.0
}

/// A triangle of the growing hull.
#[derive(Debug)]
struct Facet {
    corners: [u32; 3],
    /// The facet across the edge from `corners[k]` to `corners[k + 1]`.
    neighbors: [u32; 3],
    /// Points that see this facet; each point outside the hull is in one such list.
    outside: Vec<u32>,
    alive: bool,
}

/// An edge between a facet that the new point sees, in whose direction it runs, and one that it does not see.
#[derive(Clone, Copy, Debug)]
struct HorizonEdge {
    from: u32,
    to: u32,
    hidden: u32,
}

struct Quickhull<'a> {
    points: &'a [DVec3],
    facets: Vec<Facet>,
    /// Facets whose list of outside points was not empty when they were made.
    pending: Vec<u32>,
    /// For each point the newest facet whose horizon edge starts there.
    facet_from: Vec<u32>,
    visible: Vec<u32>,
    horizon: Vec<HorizonEdge>,
}

impl<'a> Quickhull<'a> {
    fn new(points: &'a [DVec3], [a, b, c, d]: [u32; 4]) -> Self {
        let mut quickhull = Self {
            points,
            facets: Vec::new(),
            pending: Vec::new(),
            facet_from: vec![NONE; points.len()],
            visible: Vec::new(),
            horizon: Vec::new(),
        };
        for (corners, neighbors) in [
            ([a, b, c], [1, 2, 3]),
            ([b, a, d], [0, 3, 2]),
            ([c, b, d], [0, 1, 3]),
            ([a, c, d], [0, 2, 1]),
        ] {
            quickhull.push(corners, neighbors);
        }
        let all: Vec<u32> = (0..points.len() as u32).collect();
        quickhull.distribute(&all, 0);
        quickhull
    }

    fn push(&mut self, corners: [u32; 3], neighbors: [u32; 3]) {
        self.facets.push(Facet {
            corners,
            neighbors,
            outside: Vec::new(),
            alive: true,
        });
    }

    /// Whether `point` lies strictly outside the plane of `facet`; exact.
    fn sees(&self, point: u32, facet: u32) -> bool {
        let coordinates = |index: u32| {
            let DVec3 { x, y, z } = self.points[index as usize];
            Coord3D { x, y, z }
        };
        let [a, b, c] = self.facets[facet as usize].corners.map(coordinates);
        // Positive means below the plane of a counter-clockwise triangle.
        orient3d(a, b, c, coordinates(point)) < 0.0
    }

    /// Hands each of `points` to the first facet from number `first` on that it sees; points that see none are inside.
    fn distribute(&mut self, points: &[u32], first: u32) {
        for &point in points {
            if let Some(facet) =
                (first..self.facets.len() as u32).find(|&facet| self.sees(point, facet))
            {
                self.facets[facet as usize].outside.push(point);
            }
        }
        for facet in first..self.facets.len() as u32 {
            if !self.facets[facet as usize].outside.is_empty() {
                self.pending.push(facet);
            }
        }
    }

    /// The point outside `facet` that is farthest from its plane. Rounding may pick another one: that costs time only.
    fn farthest_outside(&self, facet: u32) -> Option<u32> {
        let Facet {
            corners, outside, ..
        } = &self.facets[facet as usize];
        let [a, b, c] = corners.map(|corner| self.points[corner as usize]);
        let normal = (b - a).cross(c - a);
        let candidates: Vec<DVec3> = outside
            .iter()
            .map(|&point| self.points[point as usize])
            .collect();
        outside
            .get(farthest(&candidates, |p| normal.dot(p - a)))
            .copied()
    }

    fn add_farthest_point_of(&mut self, facet: u32) {
        if !self.facets[facet as usize].alive {
            return;
        }
        let Some(apex) = self.farthest_outside(facet) else {
            return;
        };
        self.find_horizon(apex, facet);
        let first = self.facets.len() as u32;
        self.cover_horizon(apex);
        let mut orphans = Vec::new();
        for &facet in &self.visible {
            orphans.append(&mut self.facets[facet as usize].outside);
        }
        self.distribute(&orphans, first);
    }

    /// Marks all facets that `apex` sees as gone, from `start` across edges, and collects the edges around them.
    fn find_horizon(&mut self, apex: u32, start: u32) {
        self.visible.clear();
        self.horizon.clear();
        self.visible.push(start);
        self.facets[start as usize].alive = false;
        let mut next = 0;
        while next < self.visible.len() {
            let seen = self.visible[next] as usize;
            next += 1;
            for edge in 0..3 {
                let across = self.facets[seen].neighbors[edge];
                if !self.facets[across as usize].alive {
                    continue;
                }
                if self.sees(apex, across) {
                    self.facets[across as usize].alive = false;
                    self.visible.push(across);
                } else {
                    let corners = self.facets[seen].corners;
                    self.horizon.push(HorizonEdge {
                        from: corners[edge],
                        to: corners[(edge + 1) % 3],
                        hidden: across,
                    });
                }
            }
        }
    }

    /// Closes the hole inside the horizon with a fan of facets around `apex`.
    fn cover_horizon(&mut self, apex: u32) {
        let first = self.facets.len() as u32;
        for (k, edge) in self.horizon.iter().enumerate() {
            self.facet_from[edge.from as usize] = first + k as u32;
        }
        for k in 0..self.horizon.len() {
            let HorizonEdge { from, to, hidden } = self.horizon[k];
            let this = first + k as u32;
            let after = self.facet_from[to as usize];
            self.push([from, to, apex], [hidden, after, NONE]);
            let other = &mut self.facets[hidden as usize];
            let edge = other.corners.iter().position(|&corner| corner == to);
            debug_assert!(edge.is_some(), "neighbors share an edge");
            other.neighbors[edge.unwrap_or(0)] = this;
        }
        // The facet before this one in the fan lies across the edge from the apex to `from`.
        for k in 0..self.horizon.len() as u32 {
            let after = self.facets[(first + k) as usize].neighbors[1];
            self.facets[after as usize].neighbors[2] = first + k;
        }
    }
}
