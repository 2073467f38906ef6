//! What the plane makes anew: cut points, the two pieces of each cut face, and the loop of the cap.
//!
//! Vertices are named by their numbers in the hull, with the cut points numbered after them.

use crate::geometry::{ConvexHull, Edge};
use crate::math::Plane;
use crate::simd::lanes::LaneWidth;
use crate::slice::convex::IrregularCut;
use crate::slice::convex::classes::{ABOVE, BELOW, Classes, ON};
use crate::slice::convex::cut_points::CutEdge;
use crate::slice::convex::cut_points::find_cut_points;
use glam::Vec3;
use std::ops::Range;

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

/// Face loops, one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Loops {
    corners: Corners,
    /// Where each loop ends.
    ends: Vec<u32>,
}

impl Loops {
    /// The loops, in order: lists of corners that begin with one, and how many it has.
    pub(super) fn iter(&self) -> impl Iterator<Item = (&[u32], usize)> {
        let mut first = 0;
        self.ends.iter().map(move |&end| {
            let from = std::mem::replace(&mut first, end as usize);
            (&self.corners.list[from..], end as usize - from)
        })
    }
}

/// Corners of loops, one after the other.
#[derive(Clone, Debug, Default)]
struct Corners {
    /// The corners, and behind them room.
    list: Vec<u32>,
    filled: usize,
}

impl Corners {
    /// Adds so many of four corners.
    #[inline(always)]
    fn push_short(&mut self, corners: [u32; 4], count: usize) {
        if self.list.len() < self.filled + corners.len() {
            self.grow();
        }
        let room = &mut self.list[self.filled..];
        if let Some(room) = room.first_chunk_mut() {
            *room = corners;
        }
        self.filled += count;
    }

    /// Adds a corner.
    fn push(&mut self, corner: u32) {
        self.push_short([corner; 4], 1);
    }

    /// Adds corners.
    fn push_all(&mut self, runs: &[&[u32]]) {
        for run in runs {
            run.iter().for_each(|&corner| self.push(corner));
        }
    }

    #[cold]
    fn grow(&mut self) {
        self.list.resize(2 * self.filled + MIN_ROOM, NONE);
    }
}

/// Corners that there is room for at the least.
const MIN_ROOM: usize = 64;

impl Rim {
    /// One cut point for each cut edge.
    pub(super) fn cut_edges(
        &mut self,
        hull: &ConvexHull,
        plane: &Plane,
        classes: &Classes,
        width: LaneWidth,
    ) {
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
        find_cut_points(
            width,
            plane,
            &hull.vertices,
            &self.cut_edges,
            &mut self.points,
        );
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
    ) -> Result<(), IrregularCut> {
        let Self {
            chords,
            pieces,
            crossings,
            ..
        } = self;
        let cut = classes.cut_faces.indices();
        let (sides, [below, above]) = (classes.sides.as_slice(), pieces);
        chords.resize(cut.len(), [NONE; 2]);
        for loops in [&mut *below, &mut *above] {
            loops.corners.filled = 0;
            loops.ends.resize(cut.len(), 0);
        }
        let ends = below.ends.iter_mut().zip(&mut above.ends);
        let mut corners = [&mut below.corners, &mut above.corners];
        let mut result = Ok(());
        for ((&face, chord), (end_below, end_above)) in cut.iter().zip(chords).zip(ends) {
            let crossings = std::mem::replace(&mut crossings[face as usize], [NONE; 2]);
            match divide(
                hull.face_loop(&hull.faces[face as usize]),
                sides,
                crossings,
                &mut corners,
            ) {
                Ok(divided) => *chord = divided,
                Err(irregular) => result = Err(irregular),
            }
            *end_below = corners[0].filled as u32;
            *end_above = corners[1].filled as u32;
        }
        result
    }

    /// Joins the chords, and the edges on the plane between the two parts, into the loop of the cap.
    pub(super) fn find_cap(
        &mut self,
        hull: &ConvexHull,
        classes: &Classes,
    ) -> Result<(), IrregularCut> {
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
            if is_free { Ok(()) } else { Err(IrregularCut) }
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
            Err(IrregularCut)
        }
    }

    /// Whether an edge within one part has the same ends as an edge of the cap.
    fn is_doubled(&self, hull: &ConvexHull, classes: &Classes) -> bool {
        let within = classes.on_edges.iter().filter(|e| e.parts[0] == e.parts[1]);
        let mut ends = within.map(|on_edge| hull.edges[on_edge.edge as usize].vertices);
        ends.any(|[a, b]| self.next[a as usize] == b || self.next[b as usize] == a)
    }
}

/// The corners of the pieces below and above.
type FacePieces<'a> = [&'a mut Corners; 2];

/// Divides one face between the parts, and gives the ends of its chord: where it goes up, and where it comes down.
#[inline(always)]
fn divide(
    corners: &[u32],
    sides: &[u8],
    crossings: [u32; 2],
    pieces: &mut FacePieces<'_>,
) -> Result<[u32; 2], IrregularCut> {
    let divided = match *corners {
        [a, b, c] => divide_triangle([a, b, c], sides, crossings, pieces),
        _ => divide_off_plane(corners, sides, crossings, pieces),
    };
    divided.map_or_else(|| divide_face(corners, sides, crossings, pieces), Ok)
}

/// Corners of a piece of a triangle: 0 to 2 are those of the triangle, [`UP`] and [`DOWN`] those of the chord.
type FacePiece = [u8; 4];

/// Where the triangle's loop goes up through the plane.
const UP: u8 = 3;
/// Where it comes down.
const DOWN: u8 = 4;

/// Pieces of a triangle below and above the plane, by which of its corners are below, the first one's bit the lowest. One of
/// the two has three corners, and its last one here means nothing.
///
/// The piece below begins with the first corner below, as in [`divide_face`]: it decides along which diagonal the piece is
/// read as triangles.
static PIECES: [[FacePiece; 2]; 8] = [
    UNDIVIDED,
    [[0, UP, DOWN, 0], [UP, 1, 2, DOWN]],
    [[1, UP, DOWN, 0], [UP, 2, 0, DOWN]],
    [[0, 1, UP, DOWN], [UP, 2, DOWN, 0]],
    [[2, UP, DOWN, 0], [UP, 0, 1, DOWN]],
    [[0, UP, DOWN, 2], [UP, 1, DOWN, 0]],
    [[1, 2, UP, DOWN], [UP, 0, DOWN, 0]],
    UNDIVIDED,
];

/// Of a triangle that has all corners on one side.
const UNDIVIDED: [FacePiece; 2] = [[0; 4]; 2];

/// Divides a triangle without a corner on the plane, as [`divide_face`] does. Nothing, and nothing done, for any other.
///
/// There is no guessing which corners are below, so that they name a row of a table.
#[inline(always)]
fn divide_triangle(
    [a, b, c]: [u32; 3],
    sides: &[u8],
    [up, down]: [u32; 2],
    pieces: &mut FacePieces<'_>,
) -> Option<[u32; 2]> {
    let [of_a, of_b, of_c] = [sides[a as usize], sides[b as usize], sides[c as usize]];
    if of_a.min(of_b).min(of_c) == ON || up == NONE || down == NONE {
        return None;
    }
    let below = (of_a & BELOW) | (of_b & BELOW) << 1 | (of_c & BELOW) << 2;
    let pieces_of = &PIECES[usize::from(below)];
    if *pieces_of == UNDIVIDED {
        return None;
    }
    let corners = [a, b, c, up, down, NONE, NONE, NONE];
    let counts = [
        2 + below.count_ones() as usize,
        5 - below.count_ones() as usize,
    ];
    let corner = |number: u8| corners[usize::from(number % 8)];
    let piece = |[a, b, c, d]: [u8; 4]| [corner(a), corner(b), corner(c), corner(d)];
    pieces[0].push_short(piece(pieces_of[0]), counts[0]);
    pieces[1].push_short(piece(pieces_of[1]), counts[1]);
    Some([up, down])
}

/// Divides a face without a corner on the plane, as [`divide_face`] does. Nothing, and nothing done, for any other and for
/// one whose loop does not go up once and come down once.
#[inline(never)]
fn divide_off_plane(
    corners: &[u32],
    sides: &[u8],
    [up, down]: [u32; 2],
    [below, above]: &mut FacePieces<'_>,
) -> Option<[u32; 2]> {
    let side = |place: usize| sides[corners[place] as usize];
    let count = corners.len();
    // The corners from `first` to `last` are on the same side, and those before and behind on the other.
    let inner_side = if side(0) == BELOW { ABOVE } else { BELOW };
    let first = (1..count).find(|&place| side(place) == inner_side)?;
    let last = (first..count)
        .find(|&place| side(place) != inner_side)
        .unwrap_or(count);
    let outer_side = BELOW + ABOVE - inner_side;
    let is_outer = |mut places: Range<usize>| places.all(|place| side(place) == outer_side);
    if up == NONE || down == NONE || !is_outer(0..first) || !is_outer(last..count) {
        return None;
    }
    let (before, inner, behind) = (&corners[..first], &corners[first..last], &corners[last..]);
    if inner_side == ABOVE {
        below.push_all(&[before, &[up, down], behind]);
        above.push_all(&[&[up], inner, &[down]]);
    } else {
        // From the first corner below, as `divide_face` does: it decides along which diagonal the piece is read as triangles.
        below.push_all(&[inner, &[up, down]]);
        above.push_all(&[&[up], behind, before, &[down]]);
    }
    Some([up, down])
}

/// Divides any face, as [`divide`] says.
///
/// Walks around the loop from a vertex below. A vertex on the plane is a crossing if the next vertex off the plane is on
/// the other side; otherwise it stays with its neighbors.
#[inline(never)]
fn divide_face(
    corners: &[u32],
    sides: &[u8],
    [up, down]: [u32; 2],
    [below, above]: &mut FacePieces<'_>,
) -> Result<[u32; 2], IrregularCut> {
    let side_of = |vertex: u32| sides[vertex as usize];
    let start = corners.iter().position(|&v| side_of(v) == BELOW);
    let (before, after) = corners.split_at(start.ok_or(IrregularCut)?);
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
                return Err(IrregularCut);
            }
            below.push(cut);
            above.push(cut);
            chord[crossings] = cut;
            is_above = !is_above;
            crossings += 1;
        }
        if !crosses_here && step < corners.len() {
            if is_above {
                above.push(vertex);
            } else {
                below.push(vertex);
            }
        }
    }
    if crossings == 2 {
        Ok(chord)
    } else {
        Err(IrregularCut)
    }
}
