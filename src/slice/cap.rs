//! Closed loops to caps: fans where they will do, ear clipping otherwise.
//!
//! The cap is made once, for the part below; the part above has the same triangles reversed. Whatever the geometry, each
//! rim edge is used exactly once and no edge is made twice, so closed stays closed; that the triangles also tile the cut
//! without overlap holds when the loops are those of a surface without self-intersection.
//!
//! # References
//! - G. H. Meisters, "Polygons Have Ears", American Mathematical Monthly 82(6), 1975.
//! - D. Eberly, *Triangulation by Ear Clipping*, 2002 (joining holes to the outer loop by bridges).

use super::attributes::push_mean;
use super::clip::Clip;
use super::edge_table::EdgeTable;
use crate::math::{Plane, tangents};
use glam::{DVec2, Vec3};

const NONE: u32 = u32::MAX;

/// Thickness, relative to the cap's size, below which three points count as being on a line.
///
/// Cut points are rounded to `f32`, which moves them by up to `u = 6e-8` of the coordinate in each direction; four times
/// that covers the three points of a turn.
const COLLINEAR_RELATIVE: f64 = 2.4e-7;

/// How many corners are tried as the apex of a fan before ears are clipped.
const FAN_APEXES: usize = 8;

/// The triangles that close both parts.
#[derive(Debug, Default)]
pub(super) struct CapFill {
    /// For each corner of the cap a vertex number of [`Clip::vertices`] at its place.
    pub(super) corners: Vec<u32>,
    /// Triangles over `corners`, counter-clockwise seen from above the plane.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Area, m2.
    pub(super) area: f64,
}

/// Fills `loops` with triangles; appends vertices to `clip` where a loop needs one inside.
pub(super) fn fill(clip: &mut Clip, plane: &Plane, loops: &[Vec<u32>]) -> CapFill {
    let mut filler = Filler::new(clip, plane);
    let rings = filler.number_corners(loops);
    filler.fill_all(rings);
    let area = filler
        .triangles
        .iter()
        .map(|&t| 0.5 * filler.twice_area(t))
        .sum();
    CapFill {
        corners: filler.corners,
        triangles: filler.triangles,
        area,
    }
}

/// A loop over cap corners with its signed area, positive if counter-clockwise.
#[derive(Debug)]
struct Ring {
    corners: Vec<u32>,
    area: f64,
}

struct Filler<'a> {
    clip: &'a mut Clip,
    axes: [Vec3; 2],
    corners: Vec<u32>,
    /// Corners in the plane's frame, m.
    points: Vec<DVec2>,
    /// Corners that more than one loop, or another edge of the part, may join: their edges are looked up before a new
    /// one is made.
    shared: Vec<bool>,
    /// Edges between shared corners, other than those of the input.
    made: EdgeTable,
    triangles: Vec<[u32; 3]>,
    /// Length below which a point is on a line, m.
    collinear: f64,
}

impl<'a> Filler<'a> {
    fn new(clip: &'a mut Clip, plane: &Plane) -> Self {
        Self {
            clip,
            axes: tangents(plane.normal),
            corners: Vec::new(),
            points: Vec::new(),
            shared: Vec::new(),
            made: EdgeTable::default(),
            triangles: Vec::new(),
            collinear: 0.0,
        }
    }

    /// Numbers the points of the loops: one corner for each topology number.
    fn number_corners(&mut self, loops: &[Vec<u32>]) -> Vec<Ring> {
        let mut corner_of = vec![NONE; self.clip.topology_count as usize];
        let mut rings: Vec<Ring> = Vec::with_capacity(loops.len());
        for vertices in loops {
            let corners = vertices
                .iter()
                .map(|&vertex| {
                    let number = self.clip.vertices.topology[vertex as usize];
                    let corner = &mut corner_of[number as usize];
                    if *corner == NONE {
                        *corner = self.corners.len() as u32;
                        self.add_corner(vertex, number);
                    }
                    corner_of[number as usize]
                })
                .collect();
            rings.push(Ring { corners, area: 0.0 });
        }
        let (low, high) = self
            .points
            .iter()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
                (low.min(*p), high.max(*p))
            });
        let farthest = low.abs().max(high.abs()).max_element();
        self.collinear = COLLINEAR_RELATIVE * farthest.max((high - low).length());
        self.made.reset(self.corners.len());
        for ring in &mut rings {
            ring.area = self.ring_area(&ring.corners);
        }
        rings
    }

    fn add_corner(&mut self, vertex: u32, number: u32) {
        let position = self.clip.vertices.positions[vertex as usize].as_dvec3();
        let [u, v] = self.axes.map(|axis| axis.as_dvec3().dot(position));
        self.corners.push(vertex);
        self.points.push(DVec2::new(u, v));
        self.shared.push(number < self.clip.old_topology_count);
    }

    fn point(&self, corner: u32) -> DVec2 {
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
    fn turn(&self, triangle: [u32; 3], orientation: f64) -> i32 {
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

    /// Whether an edge between two corners exists already.
    fn is_taken(&self, a: u32, b: u32) -> bool {
        if !(self.shared[a as usize] && self.shared[b as usize]) {
            return false;
        }
        let number =
            |corner: u32| self.clip.vertices.topology[self.corners[corner as usize] as usize];
        let (from, to) = (number(a), number(b));
        let old = self.clip.old_topology_count;
        let in_input = from < old && to < old && self.clip.on_edges.get(from, to).is_some();
        in_input || self.made.get(a, b).is_some()
    }

    fn take(&mut self, a: u32, b: u32) {
        if self.shared[a as usize] && self.shared[b as usize] && self.made.get(a, b).is_none() {
            self.made.insert(a, b, 0);
        }
    }

    /// Each hole goes to the smallest loop around it; the rest are filled one by one.
    fn fill_all(&mut self, rings: Vec<Ring>) {
        let (mut outers, holes): (Vec<Ring>, Vec<Ring>) =
            rings.into_iter().partition(|ring| ring.area >= 0.0);
        outers.sort_by(|a, b| a.area.total_cmp(&b.area));
        let mut holes_of: Vec<Vec<Vec<u32>>> = vec![Vec::new(); outers.len()];
        for hole in holes {
            match outers
                .iter()
                .position(|outer| outer.area > -hole.area && self.encloses(outer, &hole))
            {
                Some(outer) => holes_of[outer].push(hole.corners),
                None => self.fill_ring(hole.corners, -1.0),
            }
        }
        for (outer, holes) in outers.into_iter().zip(holes_of) {
            if holes.is_empty() {
                self.fill_ring(outer.corners, 1.0);
            } else {
                self.fill_with_holes(outer.corners, holes);
            }
        }
    }

    /// Whether a corner of `hole` that `outer` does not have lies inside `outer` (crossing number of a ray along +u).
    fn encloses(&self, outer: &Ring, hole: &Ring) -> bool {
        let Some(&probe) = hole.corners.iter().find(|c| !outer.corners.contains(c)) else {
            return false;
        };
        let p = self.point(probe);
        let mut inside = false;
        for (a, b) in edges(&outer.corners) {
            let (a, b) = (self.point(a), self.point(b));
            if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
                inside = !inside;
            }
        }
        inside
    }

    /// Fills one loop without holes. `orientation` is -1 for a clockwise loop.
    fn fill_ring(&mut self, ring: Vec<u32>, orientation: f64) {
        if let [a, b, c] = ring[..] {
            if self.is_triangle_of_input([a, b, c]) {
                self.fan_about_centre(&ring);
            } else {
                self.triangles.push([a, b, c]);
            }
        } else if !self.fan(&ring, orientation) {
            self.clip_ears(ring, orientation);
        }
    }

    /// Whether the input has a triangle with these corners. The cap of one of the parts would then be its reverse, and
    /// the two would be a solid of two triangles, whose edges a later cut could not tell apart.
    fn is_triangle_of_input(&self, triangle: [u32; 3]) -> bool {
        if self.clip.on_triangles.is_empty() {
            return false;
        }
        let mut key =
            triangle.map(|c| self.clip.vertices.topology[self.corners[c as usize] as usize]);
        key.sort_unstable();
        self.clip.on_triangles.contains(&key)
    }

    /// A fan from one corner, if one of the first few sees the whole loop and its diagonals are free.
    fn fan(&mut self, ring: &[u32], orientation: f64) -> bool {
        let n = ring.len();
        let apex = (0..n.min(FAN_APEXES)).find(|&apex| {
            let at = |i: usize| ring[(apex + i) % n];
            (1..n - 1).all(|i| self.turn([at(0), at(i), at(i + 1)], orientation) >= 0)
                && (2..n - 1).all(|i| !self.is_taken(at(0), at(i)))
        });
        let Some(apex) = apex else { return false };
        let at = |i: usize| ring[(apex + i) % n];
        for i in 2..n - 1 {
            self.take(at(0), at(i));
        }
        self.triangles
            .extend((1..n - 1).map(|i| [at(0), at(i), at(i + 1)]));
        true
    }

    /// Joins each hole to the outer loop, then clips ears of what has become one polygon.
    fn fill_with_holes(&mut self, outer: Vec<u32>, mut holes: Vec<Vec<u32>>) {
        for ring in holes.iter().chain(std::iter::once(&outer)) {
            for &corner in ring {
                self.shared[corner as usize] = true;
            }
        }
        for ring in holes.iter().chain(std::iter::once(&outer)) {
            for (a, b) in edges(ring) {
                self.take(a, b);
            }
        }
        let mut polygon = outer;
        for hole in &mut holes {
            self.start_at_rightmost(hole);
        }
        holes.sort_by(|a, b| self.point(b[0]).x.total_cmp(&self.point(a[0]).x));
        for index in 0..holes.len() {
            let (hole, rest) = (&holes[index], &holes[index + 1..]);
            if let Some((place, from)) = common_corner(&polygon, hole) {
                splice(&mut polygon, place, hole, from, false);
            } else if let Some(place) = self.bridge(&polygon, hole, rest) {
                self.take(polygon[place], hole[0]);
                splice(&mut polygon, place, hole, 0, true);
            } else {
                self.fill_ring(hole.clone(), -1.0);
            }
        }
        self.clip_ears(polygon, 1.0);
    }

    fn start_at_rightmost(&self, hole: &mut [u32]) {
        let rightmost = (0..hole.len())
            .max_by(|&a, &b| self.point(hole[a]).x.total_cmp(&self.point(hole[b]).x))
            .unwrap_or(0);
        hole.rotate_left(rightmost);
    }

    /// The place in `polygon` of the nearest corner that sees the first corner of `hole`; without one, the nearest to
    /// which an edge is free.
    fn bridge(&self, polygon: &[u32], hole: &[u32], rest: &[Vec<u32>]) -> Option<usize> {
        let target = hole[0];
        let free = |&place: &usize| !self.is_taken(polygon[place], target);
        let mut places: Vec<usize> = (0..polygon.len()).filter(free).collect();
        let distance = |place: usize| {
            self.point(polygon[place])
                .distance_squared(self.point(target))
        };
        places.sort_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        places
            .iter()
            .copied()
            .find(|&place| {
                self.opens_towards(polygon, place, target)
                    && [polygon, hole]
                        .into_iter()
                        .chain(rest.iter().map(Vec::as_slice))
                        .all(|ring| self.sees(polygon[place], target, ring))
            })
            .or(places.first().copied())
    }

    /// Whether the direction to `target` lies inside the polygon's angle at `place`.
    fn opens_towards(&self, polygon: &[u32], place: usize, target: u32) -> bool {
        let n = polygon.len();
        let (before, at, after) = (
            polygon[(place + n - 1) % n],
            polygon[place],
            polygon[(place + 1) % n],
        );
        let left_of_out = self.twice_area([at, after, target]) > 0.0;
        let left_of_in = self.twice_area([before, at, target]) > 0.0;
        if self.twice_area([before, at, after]) >= 0.0 {
            left_of_in && left_of_out
        } else {
            left_of_in || left_of_out
        }
    }

    /// Whether no edge of `ring` meets the segment between two corners, apart from edges at those corners.
    fn sees(&self, from: u32, to: u32, ring: &[u32]) -> bool {
        edges(ring)
            .filter(|&(a, b)| ![a, b].contains(&from) && ![a, b].contains(&to))
            .all(|(a, b)| {
                let across = self.twice_area([from, to, a]) * self.twice_area([from, to, b]);
                let along = self.twice_area([a, b, from]) * self.twice_area([a, b, to]);
                across > 0.0 || along > 0.0
            })
    }

    /// Cuts off one triangle after the other. Good ears first, then flat ones, then any that makes no edge twice.
    fn clip_ears(&mut self, mut polygon: Vec<u32>, orientation: f64) {
        let mut start = 0;
        while polygon.len() > 3 {
            let ear = [Ear::Good, Ear::Flat, Ear::Any]
                .into_iter()
                .find_map(|kind| self.find_ear(&polygon, start, kind, orientation));
            let Some(ear) = ear else {
                return self.fill_by_centres(polygon);
            };
            let n = polygon.len();
            let (a, b, c) = (
                polygon[(ear + n - 1) % n],
                polygon[ear],
                polygon[(ear + 1) % n],
            );
            self.triangles.push([a, b, c]);
            self.take(a, c);
            polygon.remove(ear);
            // Going on beyond the ear's neighbour spreads the ears around the loop, which keeps triangles from becoming
            // needles about one corner.
            start = (ear + 1) % polygon.len();
        }
        match polygon[..] {
            [a, b, c] if a != b && b != c && c != a => self.triangles.push([a, b, c]),
            _ => self.fill_by_centres(polygon),
        }
    }

    fn find_ear(
        &self,
        polygon: &[u32],
        start: usize,
        kind: Ear,
        orientation: f64,
    ) -> Option<usize> {
        let n = polygon.len();
        (0..n).map(|i| (start + i) % n).find(|&i| {
            let ear = [polygon[(i + n - 1) % n], polygon[i], polygon[(i + 1) % n]];
            ear[0] != ear[2]
                && self.is_ear(polygon, ear, kind, orientation)
                && !self.is_taken(ear[0], ear[2])
        })
    }

    fn is_ear(&self, polygon: &[u32], ear: [u32; 3], kind: Ear, orientation: f64) -> bool {
        let turn = self.turn(ear, orientation);
        match kind {
            Ear::Any => return true,
            Ear::Good if turn <= 0 => return false,
            Ear::Flat if turn < 0 => return false,
            Ear::Good | Ear::Flat => {}
        }
        let [a, b, c] = ear.map(|corner| self.point(corner));
        let side = |p: DVec2, q: DVec2, r: DVec2| orientation * (q - p).perp_dot(r - p);
        !polygon
            .iter()
            .filter(|corner| !ear.contains(corner))
            .any(|&corner| {
                let p = self.point(corner);
                let inner = side(a, b, p).min(side(b, c, p)).min(side(c, a, p));
                match kind {
                    Ear::Good => inner >= 0.0,
                    Ear::Flat | Ear::Any => inner > 0.0,
                }
            })
    }

    /// The last resort: a new point in the middle of each simple loop of `polygon`, which no edge can have yet.
    fn fill_by_centres(&mut self, polygon: Vec<u32>) {
        let mut path: Vec<u32> = Vec::new();
        for corner in polygon {
            if let Some(place) = path.iter().position(|&c| c == corner) {
                let closed = path.split_off(place);
                self.fan_about_centre(&closed);
            }
            path.push(corner);
        }
        self.fan_about_centre(&path);
    }

    /// Joins all edges of a loop to a new point in its middle. Two edges that are each other's reverse need nothing.
    fn fan_about_centre(&mut self, ring: &[u32]) {
        if ring.len() < 3 {
            return;
        }
        let vertices: Vec<u32> = ring
            .iter()
            .map(|&corner| self.corners[corner as usize])
            .collect();
        let number = self.clip.topology_count;
        self.clip.topology_count += 1;
        let vertex = push_mean(&mut self.clip.vertices, &vertices, number);
        let centre = self.corners.len() as u32;
        self.add_corner(vertex, number);
        self.triangles
            .extend(edges(ring).map(|(a, b)| [a, b, centre]));
    }
}

/// How good an ear must be.
#[derive(Clone, Copy, Debug)]
enum Ear {
    /// With area, and no other corner in it or on its edge.
    Good,
    /// Without negative area, and no other corner inside.
    Flat,
    /// Anything.
    Any,
}

/// The edges of a loop.
fn edges(ring: &[u32]) -> impl Iterator<Item = (u32, u32)> + '_ {
    (0..ring.len()).map(|i| (ring[i], ring[(i + 1) % ring.len()]))
}

/// Places of a corner that both loops have.
fn common_corner(polygon: &[u32], hole: &[u32]) -> Option<(usize, usize)> {
    hole.iter().enumerate().find_map(|(from, corner)| {
        let place = polygon.iter().position(|c| c == corner)?;
        Some((place, from))
    })
}

/// Inserts `hole`, starting at its place `from`, after `place` of `polygon`. With a bridge the walk goes there and back;
/// without, the two places are the same corner.
fn splice(polygon: &mut Vec<u32>, place: usize, hole: &[u32], from: usize, bridged: bool) {
    let around = (0..hole.len()).map(|i| hole[(from + i) % hole.len()]);
    let detour: Vec<u32> = if bridged {
        around.chain([hole[from], polygon[place]]).collect()
    } else {
        around.skip(1).chain([polygon[place]]).collect()
    };
    polygon.splice(place + 1..place + 1, detour);
}
