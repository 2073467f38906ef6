//! What the plane makes anew: cut points, the two pieces of each cut face, and the loop of the cap.
//!
//! Vertices are named by their numbers in the hull, with the cut points numbered after them.

use super::Irregular;
use super::classes::{ABOVE, BELOW, Classes, ON};
use crate::geometry::{ConvexHull, Edge};
use crate::math::Plane;
use crate::slice::clip::crossing;
use glam::Vec3;

const NONE: u32 = u32::MAX;

#[derive(Clone, Debug, Default)]
pub(super) struct Rim {
    /// The edges with ends on both sides.
    pub(super) cut_edges: Vec<CutEdge>,
    /// One cut point for each of them.
    pub(super) points: Vec<Vec3>,
    /// For each cut face, the corners of its chord: where its loop goes up through the plane, and where it comes down.
    pub(super) chords: Vec<[u32; 2]>,
    /// The pieces of the cut faces, one after the other, in the part below and in that above.
    pub(super) pieces: [Loops; 2],
    /// Loop of the cap, counter-clockwise seen from above the plane.
    pub(super) cap: Vec<u32>,
    /// For each face the cut points where its loop goes up and comes down; none except while faces are divided.
    crossings: Vec<[u32; 2]>,
    /// For each vertex and cut point, the one that follows it in the cap.
    next: Vec<u32>,
}

/// An edge of the hull with ends on both sides.
#[derive(Clone, Copy, Debug)]
pub(super) struct CutEdge {
    /// Its end below, and that above.
    pub(super) ends: [u32; 2],
    /// Its faces, in the hull's order.
    pub(super) faces: [u32; 2],
    /// Whether the first face runs along it from below to above.
    pub(super) goes_up: bool,
}

/// Face loops, one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Loops {
    corners: Vec<u32>,
    ends: Vec<u32>,
}

impl Loops {
    fn clear(&mut self) {
        self.corners.clear();
        self.ends.clear();
    }

    /// The loops, in order: lists of corners that begin with one, and how many it has.
    pub(super) fn iter(&self) -> impl Iterator<Item = (&[u32], usize)> {
        let mut first = 0;
        self.ends.iter().map(move |&end| {
            let from = std::mem::replace(&mut first, end as usize);
            (&self.corners[from..], end as usize - from)
        })
    }
}

impl Rim {
    /// One cut point for each cut edge, from the end with the smaller number.
    pub(super) fn cut_edges(&mut self, hull: &ConvexHull, plane: &Plane, classes: &Classes) {
        if self.crossings.len() < hull.faces.len() {
            self.crossings.resize(hull.faces.len(), [NONE; 2]);
        }
        self.cut_edges.clear();
        self.cut_edges.extend(classes.cut_edges.iter().map(|&edge| {
            let Edge { vertices, faces } = hull.edges[edge as usize];
            let [from, to] = vertices;
            let goes_up = classes.sides[from as usize] == BELOW;
            CutEdge {
                ends: if goes_up { [from, to] } else { [to, from] },
                faces,
                goes_up,
            }
        }));
        self.points.clear();
        self.points.extend(self.cut_edges.iter().map(|edge| {
            let [a, b] = edge.ends;
            let [low, high] = [a.min(b), a.max(b)].map(|v| hull.vertices[v as usize]);
            crossing(plane, low, high).0
        }));
        let first = hull.vertices.len() as u32;
        for (edge, cut) in self.cut_edges.iter().zip(first..) {
            let [forward, backward] = edge.faces.map(|face| face as usize);
            self.crossings[forward][usize::from(!edge.goes_up)] = cut;
            self.crossings[backward][usize::from(edge.goes_up)] = cut;
        }
    }

    /// Divides the cut faces by chords.
    pub(super) fn divide_faces(
        &mut self,
        hull: &ConvexHull,
        classes: &Classes,
    ) -> Result<(), Irregular> {
        let Self {
            chords,
            pieces,
            crossings,
            ..
        } = self;
        chords.clear();
        pieces.iter_mut().for_each(Loops::clear);
        let mut result = Ok(());
        for &face in classes.cut_faces.indices() {
            let crossings = std::mem::replace(&mut crossings[face as usize], [NONE; 2]);
            let corners = hull.face_loop(&hull.faces[face as usize]);
            let divided = match *corners {
                [a, b, c] => divide_triangle([a, b, c], &classes.sides, crossings, pieces),
                _ => divide_face(corners, &classes.sides, crossings, pieces),
            };
            match divided {
                Ok(chord) => chords.push(chord),
                Err(irregular) => result = Err(irregular),
            }
            for loops in pieces.iter_mut() {
                loops.ends.push(loops.corners.len() as u32);
            }
        }
        result
    }

    /// Joins the chords, and the edges on the plane between the two parts, into the loop of the cap.
    pub(super) fn find_cap(
        &mut self,
        hull: &ConvexHull,
        classes: &Classes,
    ) -> Result<(), Irregular> {
        self.next.clear();
        self.next
            .resize(hull.vertices.len() + self.points.len(), NONE);
        let (mut count, mut start) = (0, NONE);
        let mut join = |from: u32, to: u32| {
            let next = &mut self.next[from as usize];
            let is_free = *next == NONE;
            *next = to;
            count += 1;
            start = from;
            if is_free { Ok(()) } else { Err(Irregular) }
        };
        // The part below runs along a chord from its way up to its way down, and along an edge as its face there does.
        for &[up, down] in &self.chords {
            join(down, up)?;
        }
        for on_edge in &classes.on_edges {
            let [from, to] = hull.edges[on_edge.edge as usize].vertices;
            match on_edge.parts {
                [BELOW, ABOVE] => join(to, from)?,
                [ABOVE, BELOW] => join(from, to)?,
                _ => {}
            }
        }
        self.cap.clear();
        let mut at = start;
        while at != NONE && self.cap.len() < count {
            self.cap.push(at);
            at = self.next[at as usize];
            if at == start {
                break;
            }
        }
        let is_one_loop = count >= 3 && self.cap.len() == count && at == start;
        if is_one_loop && !self.is_doubled(hull, classes) {
            Ok(())
        } else {
            Err(Irregular)
        }
    }

    /// Whether the cap has a vertex of the hull as a corner.
    pub(super) fn has(&self, vertex: u32) -> bool {
        self.next[vertex as usize] != NONE
    }

    /// Whether an edge within one part has the same ends as an edge of the cap.
    fn is_doubled(&self, hull: &ConvexHull, classes: &Classes) -> bool {
        let within = classes.on_edges.iter().filter(|e| e.parts[0] == e.parts[1]);
        let mut ends = within.map(|on_edge| hull.edges[on_edge.edge as usize].vertices);
        ends.any(|[a, b]| self.next[a as usize] == b || self.next[b as usize] == a)
    }
}

/// Divides a triangle without a corner on the plane, and any other as [`divide_face`] does.
///
/// One corner is alone on its side; finding it is one guess where a walk around the loop is many.
fn divide_triangle(
    corners: [u32; 3],
    sides: &[u8],
    [up, down]: [u32; 2],
    pieces: &mut [Loops; 2],
) -> Result<[u32; 2], Irregular> {
    let side = corners.map(|v| sides[v as usize]);
    if side.contains(&ON) || up == NONE || down == NONE {
        return divide_face(&corners, sides, [up, down], pieces);
    }
    let alone = if side[0] == side[1] {
        2
    } else {
        usize::from(side[0] == side[2])
    };
    let [tip, next, last] = [[0, 1, 2], [1, 2, 0], [2, 0, 1]][alone].map(|k| corners[k]);
    let [below, above] = pieces;
    if side[alone] == BELOW {
        below.corners.extend([tip, up, down]);
        above.corners.extend([up, next, last, down]);
    } else {
        // From the first corner below, as `divide_face` does: it decides along which diagonal the piece is read as triangles.
        let piece = if alone == 1 {
            [last, up, down, next]
        } else {
            [next, last, up, down]
        };
        below.corners.extend(piece);
        above.corners.extend([up, tip, down]);
    }
    Ok([up, down])
}

/// Divides one face between the parts, and gives the ends of its chord: where it goes up, and where it comes down.
///
/// Walks around the loop from a vertex below. A vertex on the plane is a crossing if the next vertex off the plane is on
/// the other side; otherwise it stays with its neighbours.
fn divide_face(
    corners: &[u32],
    sides: &[u8],
    [up, down]: [u32; 2],
    [below, above]: &mut [Loops; 2],
) -> Result<[u32; 2], Irregular> {
    let side_of = |vertex: u32| sides[vertex as usize];
    let start = corners.iter().position(|&v| side_of(v) == BELOW);
    let (before, after) = corners.split_at(start.ok_or(Irregular)?);
    // One step beyond the loop, so that a crossing on the last edge is seen.
    let walk = after.iter().chain(before).chain(&after[..1]);
    let (mut is_above, mut crossings, mut chord) = (false, 0, [NONE; 2]);
    for (step, &vertex) in walk.clone().enumerate() {
        let side = side_of(vertex);
        let other = if is_above { BELOW } else { ABOVE };
        let crosses_here = side == ON && {
            let mut ahead = walk.clone().skip(step + 1).map(|&v| side_of(v));
            ahead.find(|&side| side != ON) == Some(other)
        };
        if side == other || crosses_here {
            let cut = match (crosses_here, is_above) {
                (true, _) => vertex,
                (false, false) => up,
                (false, true) => down,
            };
            if cut == NONE || crossings == 2 {
                return Err(Irregular);
            }
            below.corners.push(cut);
            above.corners.push(cut);
            chord[crossings] = cut;
            is_above = !is_above;
            crossings += 1;
        }
        if !crosses_here && step < corners.len() {
            if is_above {
                above.corners.push(vertex);
            } else {
                below.corners.push(vertex);
            }
        }
    }
    if crossings == 2 {
        Ok(chord)
    } else {
        Err(Irregular)
    }
}
