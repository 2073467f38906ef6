//! Plane against a convex hull: faces stay polygons, the cap is one polygon.
//!
//! A face with vertices on both sides is divided by one chord from where its loop goes up through the plane to where it
//! comes down. The chords, and the edges on the plane between a face below and a face above, form the rim, and the rim is
//! the cap's loop. Both parts use the same cut points, bit for bit, and keep the planes of the faces they come from.
//!
//! A hull whose faces are flat and convex to rounding gives exactly one rim loop. If noise near the plane makes it
//! otherwise, the parts are rebuilt as the convex hulls of their points.

use super::SliceError;
use super::clip::crossing;
use super::edge_table::EdgeTable;
use crate::geometry::lanes::HullLanes;
use crate::geometry::predicates::{Side, check_plane, length_scale, plane_tolerance, side};
use crate::geometry::{ConvexHull, Edge, Face, HullError};
use crate::math::{Aabb, Plane};
use glam::Vec3;

const NONE: u32 = u32::MAX;

/// What a plane does to a hull.
#[derive(Clone, Debug, PartialEq)]
pub enum HullSlice {
    /// Missed: no vertex is above the plane, or what is above is too thin to be a body.
    Below,
    /// Missed: no vertex is below the plane, or what is below is too thin to be a body.
    Above,
    /// Cut in two.
    Cut(Box<HullHalves>),
}

impl HullSlice {
    /// The two parts, if the plane cut the hull.
    pub fn halves(self) -> Option<HullHalves> {
        match self {
            Self::Cut(halves) => Some(*halves),
            Self::Below | Self::Above => None,
        }
    }
}

/// The two parts of a hull that a plane cut.
#[derive(Clone, Debug, PartialEq)]
pub struct HullHalves {
    /// The part on the side that the plane's normal points away from; its last face is the cap.
    pub below: ConvexHull,
    /// The part on the side that the normal points to; its last face is the cap.
    pub above: ConvexHull,
}

/// Cuts a convex hull by a plane.
///
/// `plane` is in the hull's frame (m). Vertices nearer to it than the plane tolerance belong to both parts, unmoved.
///
/// # Errors
/// [`SliceError::Plane`] if the plane has NaN or infinite numbers or no unit normal.
pub fn slice_hull(hull: &ConvexHull, plane: Plane) -> Result<HullSlice, SliceError> {
    HullSlicer::default().slice(hull, plane)
}

/// Cuts hulls one after the other, keeping its working memory.
#[derive(Clone, Debug, Default)]
pub struct HullSlicer {
    sides: Vec<Side>,
    /// Cut points, numbered after the hull's vertices.
    cuts: Vec<Vec3>,
    /// For each face the cut points where its loop goes up and comes down through the plane.
    crossings: Vec<[u32; 2]>,
    below: Part,
    above: Part,
    rim: Vec<[u32; 2]>,
    cap: Vec<u32>,
    next: Vec<u32>,
    renumber: Vec<u32>,
    edge_table: EdgeTable,
}

/// The faces of one part, over the hull's vertices followed by the cut points.
#[derive(Clone, Debug, Default)]
struct Part {
    faces: Vec<Face>,
    loops: Vec<u32>,
}

impl Part {
    fn clear(&mut self) {
        self.faces.clear();
        self.loops.clear();
    }

    fn begin(&mut self, plane: Plane) {
        self.faces.push(Face {
            plane,
            first: self.loops.len() as u32,
            count: 0,
        });
    }

    fn push(&mut self, vertex: u32) {
        self.loops.push(vertex);
        if let Some(face) = self.faces.last_mut() {
            face.count += 1;
        }
    }

    fn push_face(&mut self, plane: Plane, corners: impl IntoIterator<Item = u32>) {
        self.begin(plane);
        for vertex in corners {
            self.push(vertex);
        }
    }
}

/// The rim is not one simple loop, or a part is not a polyhedron.
#[derive(Clone, Copy, Debug)]
struct Irregular;

impl HullSlicer {
    /// As [`slice_hull`].
    ///
    /// # Errors
    /// As [`slice_hull`].
    pub fn slice(&mut self, hull: &ConvexHull, plane: Plane) -> Result<HullSlice, SliceError> {
        check_plane(&plane)?;
        let tolerance = plane_tolerance(length_scale(&hull.aabb));
        self.sides.clear();
        self.sides
            .extend(hull.vertices.iter().map(|&p| side(&plane, p, tolerance)));
        if !self.sides.contains(&Side::Above) {
            return Ok(HullSlice::Below);
        }
        if !self.sides.contains(&Side::Below) {
            return Ok(HullSlice::Above);
        }
        self.cut_edges(hull, &plane);
        let divided = self
            .divide_faces(hull, &plane)
            .and_then(|()| self.find_cap(hull.vertices.len()))
            .and_then(|()| self.build(hull, &plane));
        match divided {
            Ok(halves) => Ok(HullSlice::Cut(Box::new(halves))),
            Err(Irregular) => self.rebuild(hull),
        }
    }

    /// One cut point for each edge with ends on both sides, from the end with the smaller number.
    fn cut_edges(&mut self, hull: &ConvexHull, plane: &Plane) {
        self.cuts.clear();
        self.crossings.clear();
        self.crossings.resize(hull.faces.len(), [NONE; 2]);
        for edge in &hull.edges {
            let [a, b] = edge.vertices;
            let goes_up = match [a, b].map(|v| self.sides[v as usize]) {
                [Side::Below, Side::Above] => true,
                [Side::Above, Side::Below] => false,
                _ => continue,
            };
            let [low, high] = [a.min(b), a.max(b)].map(|v| hull.vertices[v as usize]);
            let cut = (hull.vertices.len() + self.cuts.len()) as u32;
            self.cuts.push(crossing(plane, low, high).0);
            let [forward, backward] = edge.faces.map(|face| face as usize);
            self.crossings[forward][usize::from(!goes_up)] = cut;
            self.crossings[backward][usize::from(goes_up)] = cut;
        }
    }

    /// Hands the faces to the parts, those with vertices on both sides divided by a chord.
    fn divide_faces(&mut self, hull: &ConvexHull, plane: &Plane) -> Result<(), Irregular> {
        self.below.clear();
        self.above.clear();
        for (face, crossings) in hull.faces.iter().zip(&self.crossings) {
            let corners = hull.face_loop(face);
            let has = |wanted| corners.iter().any(|&v| self.sides[v as usize] == wanted);
            let is_below = match (has(Side::Below), has(Side::Above)) {
                (true, true) => {
                    divide_face(
                        corners,
                        face.plane,
                        &self.sides,
                        *crossings,
                        [&mut self.below, &mut self.above],
                    )?;
                    continue;
                }
                (is_below, is_above) if is_below != is_above => is_below,
                // A face on the plane bounds what is behind it.
                _ => face.plane.normal.dot(plane.normal) > 0.0,
            };
            let part = if is_below {
                &mut self.below
            } else {
                &mut self.above
            };
            part.push_face(face.plane, corners.iter().copied());
        }
        Ok(())
    }

    /// Finds the edges of the part below that have no partner, and joins them into the loop of the cap.
    fn find_cap(&mut self, old_vertices: usize) -> Result<(), Irregular> {
        let total = old_vertices + self.cuts.len();
        let on_plane = |v: u32| self.sides.get(v as usize).is_none_or(|&s| s == Side::On);
        self.rim.clear();
        for face in &self.below.faces {
            let corners = &self.below.loops[face.first as usize..][..face.count as usize];
            let pairs = (0..corners.len()).map(|i| [corners[i], corners[(i + 1) % corners.len()]]);
            self.rim
                .extend(pairs.filter(|pair| pair.iter().all(|&v| on_plane(v))));
        }
        self.rim
            .sort_unstable_by_key(|&[a, b]| (a.min(b), a.max(b), a));
        self.next.clear();
        self.next.resize(total, NONE);
        let (mut count, mut start) = (0, NONE);
        for run in self
            .rim
            .chunk_by(|a, b| a == b || (a[0], a[1]) == (b[1], b[0]))
        {
            match *run {
                [[from, to]] if self.next[to as usize] == NONE => {
                    self.next[to as usize] = from;
                    count += 1;
                    start = to;
                }
                [[a, _], [b, _]] if a != b => {}
                _ => return Err(Irregular),
            }
        }
        self.cap.clear();
        while start != NONE && self.cap.len() < count {
            self.cap.push(start);
            start = self.next[start as usize];
        }
        let is_one_loop = count >= 3 && self.cap.first() == Some(&start);
        let mut visited = self.cap.clone();
        visited.sort_unstable();
        let is_simple = visited.windows(2).all(|pair| pair[0] != pair[1]);
        if is_one_loop && is_simple {
            Ok(())
        } else {
            Err(Irregular)
        }
    }

    /// Adds the cap to both parts and makes hulls of them.
    fn build(&mut self, hull: &ConvexHull, plane: &Plane) -> Result<HullHalves, Irregular> {
        self.below.push_face(*plane, self.cap.iter().copied());
        // Reversed about the same first corner: where vertices on the plane leave the cap uneven, both parts have it as the
        // same triangle fan, and their volumes add up.
        self.cap[1..].reverse();
        self.above
            .push_face(plane.flipped(), self.cap.iter().copied());
        let mut make = |part: &Part| {
            make_hull(
                part,
                &hull.vertices,
                &self.cuts,
                &mut self.renumber,
                &mut self.edge_table,
            )
        };
        Ok(HullHalves {
            below: make(&self.below)?,
            above: make(&self.above)?,
        })
    }

    /// The parts as convex hulls of their points. A part too thin for a hull is no part.
    fn rebuild(&self, hull: &ConvexHull) -> Result<HullSlice, SliceError> {
        let hull_without = |dropped: Side| {
            let kept = hull.vertices.iter().zip(&self.sides);
            let points: Vec<Vec3> = kept
                .filter(|&(_, &side)| side != dropped)
                .map(|(&point, _)| point)
                .chain(self.cuts.iter().copied())
                .collect();
            match ConvexHull::from_points(&points) {
                Ok(hull) => Ok(Some(hull)),
                Err(HullError::Flat { .. } | HullError::TooFewPoints { .. }) => Ok(None),
                Err(error) => Err(error),
            }
        };
        let (below, above) = (hull_without(Side::Above)?, hull_without(Side::Below)?);
        Ok(match (below, above) {
            (Some(below), Some(above)) => HullSlice::Cut(Box::new(HullHalves { below, above })),
            (Some(_), None) => HullSlice::Below,
            (None, _) => HullSlice::Above,
        })
    }
}

/// Divides one face between the parts `[below, above]`.
///
/// Walks around the loop from a vertex below. A vertex on the plane is a crossing if the next vertex off the plane is on
/// the other side; otherwise it stays with its neighbours.
fn divide_face(
    corners: &[u32],
    plane: Plane,
    sides: &[Side],
    [up, down]: [u32; 2],
    parts: [&mut Part; 2],
) -> Result<(), Irregular> {
    let n = corners.len();
    let side_at = |i: usize| sides[corners[i % n] as usize];
    let start = (0..n)
        .find(|&i| side_at(i) == Side::Below)
        .ok_or(Irregular)?;
    let [below, above] = parts;
    below.begin(plane);
    above.begin(plane);
    let (mut is_above, mut crossings) = (false, 0);
    // One step beyond the loop, so that a crossing on the last edge is seen.
    for i in start..=start + n {
        let (vertex, side) = (corners[i % n], side_at(i));
        let other = if is_above { Side::Below } else { Side::Above };
        let crosses_here = side == Side::On
            && (i + 1..=start + n)
                .map(side_at)
                .find(|&next| next != Side::On)
                == Some(other);
        if side == other || crosses_here {
            let cut = match (crosses_here, is_above) {
                (true, _) => vertex,
                (false, false) => up,
                (false, true) => down,
            };
            if cut == NONE {
                return Err(Irregular);
            }
            below.push(cut);
            above.push(cut);
            is_above = !is_above;
            crossings += 1;
        }
        if !crosses_here && i < start + n {
            if is_above {
                above.push(vertex);
            } else {
                below.push(vertex);
            }
        }
    }
    if crossings == 2 {
        Ok(())
    } else {
        Err(Irregular)
    }
}

/// Renumbers the vertices of a part, pairs its edges, and checks that it is a polyhedron with volume.
fn make_hull(
    part: &Part,
    old: &[Vec3],
    cuts: &[Vec3],
    renumber: &mut Vec<u32>,
    edge_table: &mut EdgeTable,
) -> Result<ConvexHull, Irregular> {
    renumber.clear();
    renumber.resize(old.len() + cuts.len(), NONE);
    let mut vertices = Vec::new();
    let loops: Vec<u32> = part
        .loops
        .iter()
        .map(|&vertex| {
            let number = &mut renumber[vertex as usize];
            if *number == NONE {
                *number = vertices.len() as u32;
                let v = vertex as usize;
                vertices.push(if v < old.len() {
                    old[v]
                } else {
                    cuts[v - old.len()]
                });
            }
            *number
        })
        .collect();
    let edges = pair_edges(&part.faces, &loops, vertices.len(), edge_table)?;
    let mut hull = ConvexHull {
        aabb: Aabb::of_points(vertices.iter().copied()),
        vertices,
        faces: part.faces.clone(),
        loops,
        edges,
        lanes: HullLanes::default(),
    };
    let is_polyhedron = hull.vertices.len() + hull.faces.len() == hull.edges.len() + 2;
    if is_polyhedron && hull.volume() > 0.0 {
        hull.lanes = HullLanes::of(&hull.vertices, &hull.faces, &hull.loops);
        Ok(hull)
    } else {
        Err(Irregular)
    }
}

/// The undirected edges of closed face loops.
fn pair_edges(
    faces: &[Face],
    loops: &[u32],
    vertices: usize,
    table: &mut EdgeTable,
) -> Result<Vec<Edge>, Irregular> {
    table.reset(vertices);
    let mut edges: Vec<Edge> = Vec::with_capacity(loops.len() / 2);
    for (face, at) in faces.iter().enumerate() {
        let corners = &loops[at.first as usize..][..at.count as usize];
        for (i, &from) in corners.iter().enumerate() {
            let to = corners[(i + 1) % corners.len()];
            match table.get(from, to) {
                None => {
                    table.insert(from, to, edges.len() as u32);
                    edges.push(Edge {
                        vertices: [from, to],
                        faces: [face as u32, NONE],
                    });
                }
                Some(index) => {
                    let edge = &mut edges[index as usize];
                    if edge.vertices != [to, from] || edge.faces[1] != NONE {
                        return Err(Irregular);
                    }
                    edge.faces[1] = face as u32;
                }
            }
        }
    }
    if edges.iter().all(|edge| edge.faces[1] != NONE) {
        Ok(edges)
    } else {
        Err(Irregular)
    }
}
