//! Closed loops to caps: fans where they will do, ear clipping (`ears.rs`) otherwise.
//!
//! The cap is made once, for the part below; the part above has the same triangles reversed. Whatever the geometry, each
//! rim edge is used exactly once and no edge is made twice, so closed stays closed; that the triangles also tile the cut
//! without overlap holds when the loops are those of a surface without self-intersection.
//!
//! # References
//! - D. Eberly, *Triangulation by Ear Clipping*, 2002 (joining holes to the outer loop by bridges).

mod ears;
mod holes;

use crate::geometry::TriMesh;
use crate::math::{Plane, tangents};
use crate::slice::border::Border;
use crate::slice::cap::ears::CornerTurn;
use crate::slice::clip::Clip;
use crate::slice::edge_table::EdgeTable;
use glam::{DVec2, Vec3};
use std::ops::Range;

const NONE: u32 = u32::MAX;

/// Thickness, relative to the cap's size, below which three points count as being on a line.
///
/// Cut points are rounded to `f32`, which moves them by up to `u = 6e-8` of the coordinate in each direction; four times
/// that covers the three points of a turn.
const COLLINEAR_RELATIVE: f64 = 2.4e-7;

/// How many corners are tried as the apex of a fan before ears are clipped.
const FAN_APEXES: usize = 8;

/// The triangles that close both parts; keeps its working memory.
#[derive(Clone, Debug, Default)]
pub(super) struct CapFill {
    /// For each corner of the cap a vertex number (see [`Clip`]) at its place.
    pub(super) corners: Vec<u32>,
    /// Triangles over `corners`, counter-clockwise seen from above the plane.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Area, m2.
    pub(super) area: f64,
    /// Directions of the plane's frame.
    axes: [Vec3; 2],
    /// Corners in the plane's frame, m.
    points: Vec<DVec2>,
    /// Topology numbers of the corners.
    numbers: Vec<u32>,
    /// Corners that more than one loop, or another edge of the part, may join: their edges are looked up before a new
    /// one is made.
    shared: Vec<bool>,
    /// Edges between shared corners, other than those of the input.
    made: EdgeTable,
    /// Length below which a point is on a line, m.
    collinear: f64,
    /// By topology number: its corner.
    corner_of: Vec<u32>,
    rings: Vec<Ring>,
    ring_corners: Vec<u32>,
    /// An outer ring with the holes joined to it.
    joined: Vec<u32>,
    pub(super) polygon: Vec<CornerTurn>,
    places: Vec<u32>,
}

/// A loop over cap corners with its signed area, positive if counter-clockwise.
#[derive(Clone, Debug)]
struct Ring {
    corners: Range<usize>,
    area: f64,
    /// For a hole: the ring that it is a hole of.
    outer: u32,
}

impl CapFill {
    /// Fills the loops of `border` with triangles; appends vertices to `clip` where a loop needs one inside.
    pub(super) fn run(&mut self, mesh: &TriMesh, clip: &mut Clip, border: &Border, plane: &Plane) {
        self.corners.clear();
        self.triangles.clear();
        self.points.clear();
        self.numbers.clear();
        self.shared.clear();
        self.axes = tangents(plane.normal);
        let mut filler = Filler {
            mesh,
            clip,
            cap: self,
        };
        filler.number_corners(border);
        filler.fill_all();
        self.area = self
            .triangles
            .iter()
            .map(|&t| 0.5 * self.twice_area(t))
            .sum();
    }

    pub(super) fn point(&self, corner: u32) -> DVec2 {
        self.points[corner as usize]
    }

    fn twice_area(&self, [a, b, c]: [u32; 3]) -> f64 {
        let a = self.point(a);
        (self.point(b) - a).perp_dot(self.point(c) - a)
    }

    fn ring_area(&self, ring: &[u32]) -> f64 {
        ring.windows(2)
            .map(|pair| 0.5 * self.twice_area([ring[0], pair[0], pair[1]]))
            .sum()
    }

    /// Whether the path through the three corners turns left (`+1`), right (`-1`), or runs straight within the tolerance
    /// (`0`): its middle corner is then nearer than that to the line through the others.
    pub(super) fn turn(&self, triangle: [u32; 3], orientation: f64) -> i32 {
        let area = orientation * self.twice_area(triangle);
        let base = self
            .point(triangle[0])
            .distance_squared(self.point(triangle[2]));
        if area * area <= self.collinear * self.collinear * base {
            0
        } else if area > 0.0 {
            1
        } else {
            -1
        }
    }

    /// Whether no edge of `ring` meets the segment between two corners, apart from edges at those corners.
    fn sees(&self, from: u32, to: u32, ring: impl Iterator<Item = (u32, u32)>) -> bool {
        let mut blocking = ring.filter(|&(a, b)| ![a, b].contains(&from) && ![a, b].contains(&to));
        blocking.all(|(a, b)| {
            let across = self.twice_area([from, to, a]) * self.twice_area([from, to, b]);
            let along = self.twice_area([a, b, from]) * self.twice_area([a, b, to]);
            across > 0.0 || along > 0.0
        })
    }
}

pub(super) struct Filler<'a> {
    pub(super) mesh: &'a TriMesh,
    pub(super) clip: &'a mut Clip,
    pub(super) cap: &'a mut CapFill,
}

impl Filler<'_> {
    /// Numbers the points of the loops, one corner for each topology number, and makes rings of the loops.
    fn number_corners(&mut self, border: &Border) {
        let mut corner_of = std::mem::take(&mut self.cap.corner_of);
        corner_of.clear();
        corner_of.resize(self.clip.topology_count as usize, NONE);
        self.cap.rings.clear();
        self.cap.ring_corners.clear();
        for vertices in border.loops() {
            let first = self.cap.ring_corners.len();
            for &vertex in vertices {
                let number = self.clip.topology(self.mesh, vertex);
                let corner = &mut corner_of[number as usize];
                if *corner == NONE {
                    *corner = self.cap.corners.len() as u32;
                    self.add_corner(vertex, number);
                }
                self.cap.ring_corners.push(*corner);
            }
            let corners = first..self.cap.ring_corners.len();
            let area = self.cap.ring_area(&self.cap.ring_corners[corners.clone()]);
            self.cap.rings.push(Ring {
                corners,
                area,
                outer: NONE,
            });
        }
        self.cap.corner_of = corner_of;
        let (low, high) = self
            .cap
            .points
            .iter()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
                (low.min(*p), high.max(*p))
            });
        let farthest = low.abs().max(high.abs()).max_element();
        self.cap.collinear = COLLINEAR_RELATIVE * farthest.max((high - low).length());
        self.cap.made.clear();
    }

    pub(super) fn add_corner(&mut self, vertex: u32, number: u32) {
        let (source, place) = self.clip.find(self.mesh, vertex);
        let position = source.positions[place].as_dvec3();
        let [u, v] = self.cap.axes.map(|axis| axis.as_dvec3().dot(position));
        self.cap.corners.push(vertex);
        self.cap.points.push(DVec2::new(u, v));
        self.cap.numbers.push(number);
        self.cap.shared.push(number < self.clip.old_topology_count);
    }

    /// Whether an edge between two corners exists already.
    pub(super) fn is_taken(&self, a: u32, b: u32) -> bool {
        let cap = &*self.cap;
        if !(cap.shared[a as usize] && cap.shared[b as usize]) {
            return false;
        }
        let [from, to] = [a, b].map(|corner| cap.numbers[corner as usize]);
        let old = self.clip.old_topology_count;
        let in_input = from < old && to < old && self.clip.on_edges.get(from, to).is_some();
        in_input || cap.made.get(a, b).is_some()
    }

    pub(super) fn take(&mut self, a: u32, b: u32) {
        let cap = &mut *self.cap;
        if cap.shared[a as usize] && cap.shared[b as usize] && cap.made.get(a, b).is_none() {
            cap.made.insert(a, b, 0);
        }
    }

    /// Each hole goes to the smallest loop around it; the rest are filled one by one.
    fn fill_all(&mut self) {
        let mut rings = std::mem::take(&mut self.cap.rings);
        let mut corners = std::mem::take(&mut self.cap.ring_corners);
        rings.sort_by(|a, b| a.area.total_cmp(&b.area));
        // Holes have negative areas, so they come first.
        let first_outer = rings.partition_point(|ring| ring.area < 0.0);
        let (holes, outers) = rings.split_at_mut(first_outer);
        for hole in &mut *holes {
            let is_around = |outer: &Ring| {
                outer.area > -hole.area
                    && self.encloses(
                        &corners[outer.corners.clone()],
                        &corners[hole.corners.clone()],
                    )
            };
            match outers.iter().position(is_around) {
                Some(outer) => hole.outer = outer as u32,
                None => self.fill_ring(&corners[hole.corners.clone()], -1.0),
            }
        }
        holes.sort_by_key(|hole| hole.outer);
        let mut rest = &mut *holes;
        for (index, outer) in (0..).zip(outers) {
            let count = rest.partition_point(|hole| hole.outer == index);
            let (own, others) = rest.split_at_mut(count);
            rest = others;
            if own.is_empty() {
                self.fill_ring(&corners[outer.corners.clone()], 1.0);
            } else {
                self.fill_with_holes(&outer.corners, own, &mut corners);
            }
        }
        self.cap.rings = rings;
        self.cap.ring_corners = corners;
    }

    /// Whether a corner of `hole` that `outer` does not have lies inside `outer` (crossing number of a ray along +u).
    fn encloses(&self, outer: &[u32], hole: &[u32]) -> bool {
        let Some(&probe) = hole.iter().find(|c| !outer.contains(c)) else {
            return false;
        };
        let p = self.cap.point(probe);
        let mut inside = false;
        for (a, b) in edges(outer) {
            let (a, b) = (self.cap.point(a), self.cap.point(b));
            if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
                inside = !inside;
            }
        }
        inside
    }

    /// Fills one loop without holes. `orientation` is -1 for a clockwise loop.
    fn fill_ring(&mut self, ring: &[u32], orientation: f64) {
        if let [a, b, c] = *ring {
            if self.is_triangle_of_input([a, b, c]) {
                self.fan_about_center(ring);
            } else {
                self.cap.triangles.push([a, b, c]);
            }
        } else if !self.fan(ring, orientation) {
            self.clip_ears(ring.iter().copied(), orientation);
        }
    }

    /// Whether the input has a triangle with these corners. The cap of one of the parts would then be its reverse, and
    /// the two would be a solid of two triangles, whose edges a later cut could not tell apart.
    fn is_triangle_of_input(&self, triangle: [u32; 3]) -> bool {
        if self.clip.on_triangles.is_empty() {
            return false;
        }
        let mut key = triangle.map(|corner| self.cap.numbers[corner as usize]);
        key.sort_unstable();
        self.clip.on_triangles.contains(&key)
    }

    /// A fan from one corner, if one of the first few sees the whole loop and its diagonals are free.
    fn fan(&mut self, ring: &[u32], orientation: f64) -> bool {
        let n = ring.len();
        let apex = (0..n.min(FAN_APEXES)).find(|&apex| {
            let at = |i: usize| ring[(apex + i) % n];
            (1..n - 1).all(|i| self.cap.turn([at(0), at(i), at(i + 1)], orientation) >= 0)
                && (2..n - 1).all(|i| !self.is_taken(at(0), at(i)))
        });
        let Some(apex) = apex else { return false };
        let at = |i: usize| ring[(apex + i) % n];
        for i in 2..n - 1 {
            self.take(at(0), at(i));
        }
        self.cap
            .triangles
            .extend((1..n - 1).map(|i| [at(0), at(i), at(i + 1)]));
        true
    }
}

/// The edges of a loop.
pub(super) fn edges(ring: &[u32]) -> impl Iterator<Item = (u32, u32)> + Clone + '_ {
    (0..ring.len()).map(|i| (ring[i], ring[(i + 1) % ring.len()]))
}
