//! Triangles of one flat face, made few again after cuts.
//!
//! A cut divides triangles and not faces: each leaves corners on the diagonals of the caps before it, and the next one divides
//! what these made. Here the triangles of each face become its outline, corners on straight lines that both faces beside
//! them can do without are left out, and the outline is filled anew. What is a face travels with the triangles
//! ([`FaceNumbers`](crate::geometry::FaceNumbers)), so nothing is guessed from coordinates but which corners lie on a line.
//!
//! Attributes are affine within a face, so each corner that stays has the attributes that it had and those between follow.

mod fill;

use crate::geometry::TriMesh;
use crate::geometry::predicates::{length_scale, plane_tolerance};
use crate::slice::edge_lists::EdgeLists;
use crate::slice::rim_fill::RimFill;
use glam::DVec3;

/// No face, no point.
const NONE: u32 = u32::MAX;

/// Half the width of a line in thicknesses of a plane: both ends of an edge on a plane may be off by one.
const LINE_WIDTH: f64 = 2.0;

/// Merges the triangles of faces, keeping its working memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct FaceMerger {
    filler: RimFill,
    /// Solid triangles in the order of their faces, and where each face ends.
    order: Vec<u32>,
    faces: Vec<FaceRange>,
    /// Border edges of all faces, face by face, as vertices.
    border: Vec<[u32; 2]>,
    /// By position: the faces that have a border edge from there, as far as there are two; then whether it stays.
    points: Vec<Point>,
    /// Border edges after straight corners were left out, face by face.
    outline: Vec<[u32; 2]>,
    edges: EdgeLists,
    /// By position, for the face in work: its border edge from there.
    next: Vec<u32>,
    scratch: Vec<([u32; 2], u32)>,
    chain: Vec<u32>,
    merged: TriMesh,
}

/// A face: its triangles in [`FaceMerger::order`], its border and its outline.
#[derive(Clone, Copy, Debug, Default)]
struct FaceRange {
    triangles: [u32; 2],
    border: [u32; 2],
    outline: [u32; 2],
    loops: u32,
    is_simple: bool,
}

/// What is known of a position.
#[derive(Clone, Copy, Debug)]
struct Point {
    faces: [u32; 2],
    stays: bool,
    is_decided: bool,
}

impl FaceMerger {
    /// Merges the triangles of each face of a closed mesh whose faces are known, but those of face `kept`, whose corners all
    /// stay and whose triangles are the last ones.
    pub(crate) fn merge(&mut self, mesh: &mut TriMesh, kept: Option<u32>) {
        if mesh.faces.0.len() != mesh.triangles.len() || mesh.triangles.is_empty() {
            return;
        }
        self.sort(mesh);
        // Nothing to merge where each face is a triangle.
        if self.faces.len() == self.order.len() {
            return;
        }
        self.find_borders(mesh, kept);
        if !self.drop_straight(mesh) {
            return;
        }
        if self.fill(mesh, kept) {
            std::mem::swap(mesh, &mut self.merged);
        }
    }

    fn sort(&mut self, mesh: &TriMesh) {
        let sheets = mesh.sheets;
        let faces = &mesh.faces.0;
        self.order.clear();
        self.order.extend(sheets..mesh.triangles.len() as u32);
        // Faces in the order of their numbers: that of the mesh before the first cut, then caps in the order of cuts.
        self.order.sort_unstable_by_key(|&t| (faces[t as usize], t));
        self.faces.clear();
        let mut first = 0;
        for run in self
            .order
            .chunk_by(|&a, &b| faces[a as usize] == faces[b as usize])
        {
            let end = first + run.len() as u32;
            self.faces.push(FaceRange {
                triangles: [first, end],
                ..FaceRange::default()
            });
            first = end;
        }
    }

    /// The edges of each face that its own triangles have once.
    fn find_borders(&mut self, mesh: &TriMesh, kept: Option<u32>) {
        let point = Point {
            faces: [NONE; 2],
            stays: false,
            is_decided: false,
        };
        self.points.clear();
        self.points.resize(mesh.topology_count(), point);
        self.border.clear();
        for (number, face) in (0_u32..).zip(&mut self.faces) {
            let [first, end] = face.triangles.map(|t| t as usize);
            let own = &self.order[first..end];
            face.border[0] = self.border.len() as u32;
            let half_edges = own.iter().flat_map(|&t| {
                let [a, b, c] = mesh.triangles[t as usize];
                [[a, b], [b, c], [c, a]]
            });
            if own.len() == 1 {
                self.border.extend(half_edges);
            } else {
                self.scratch.clear();
                self.scratch
                    .extend(half_edges.enumerate().map(|(place, ends)| {
                        let [a, b] = ends.map(|v| mesh.topology[v as usize]);
                        ([a.min(b), a.max(b)], place as u32)
                    }));
                self.scratch.sort_unstable();
                for run in self.scratch.chunk_by(|a, b| a.0 == b.0) {
                    if let [(_, place)] = *run {
                        let corners = mesh.triangles[own[place as usize / 3] as usize];
                        let k = place as usize % 3;
                        self.border.push([corners[k], corners[(k + 1) % 3]]);
                    }
                }
            }
            face.border[1] = self.border.len() as u32;
            let is_fixed = own.len() == 1 || kept == Some(mesh.faces.0[own[0] as usize]);
            for &[from, _] in &self.border[face.border[0] as usize..] {
                let point = &mut self.points[mesh.topology[from as usize] as usize];
                match point.faces {
                    [NONE, _] => point.faces[0] = number,
                    [a, NONE] if a != number => point.faces[1] = number,
                    _ => point.stays = true,
                }
                point.stays |= is_fixed;
            }
        }
    }

    /// Leaves out corners on straight lines; whether the outlines are sound.
    fn drop_straight(&mut self, mesh: &TriMesh) -> bool {
        let tolerance = LINE_WIDTH * f64::from(plane_tolerance(length_scale(&mesh.aabb())));
        self.next.clear();
        self.next.resize(self.points.len(), NONE);
        for face in 0..self.faces.len() {
            if self.faces[face].triangles[1] - self.faces[face].triangles[0] > 1 {
                self.straighten(mesh, face, tolerance);
            }
        }
        self.make_outlines(mesh)
    }

    /// Decides about the corners of a face that only one other face has; the first of the two faces decides.
    fn straighten(&mut self, mesh: &TriMesh, face: usize, tolerance: f64) {
        let [first, end] = self.faces[face].border;
        let number = |vertex: u32| mesh.topology[vertex as usize];
        for edge in first..end {
            self.next[number(self.border[edge as usize][0]) as usize] = edge;
        }
        for edge in first..end {
            let start = number(self.border[edge as usize][0]);
            if !self.points[start as usize].stays {
                continue;
            }
            let mut chain = std::mem::take(&mut self.chain);
            chain.clear();
            chain.push(self.border[edge as usize][0]);
            let mut at = self.border[edge as usize][1];
            let is_own = |point: &Point| !point.stays && point.faces[0] == face as u32;
            while is_own(&self.points[number(at) as usize]) && chain.len() <= (end - first) as usize
            {
                chain.push(at);
                at = self.border[self.next[number(at) as usize] as usize][1];
            }
            chain.push(at);
            for &vertex in &chain {
                self.points[number(vertex) as usize].is_decided = true;
            }
            if chain.len() > 2 {
                self.keep_bends(mesh, &chain, tolerance);
            }
            self.chain = chain;
        }
        // Loops in which no corner stays for another reason, and corners of one face only, stay as they are.
        for &[from, _] in &self.border[first as usize..end as usize] {
            let point = &mut self.points[number(from) as usize];
            let is_own = point.faces[0] == face as u32;
            point.stays |= is_own && (!point.is_decided || point.faces[1] == NONE);
        }
    }

    /// Keeps the corners of a chain without which it would leave the tolerance: D. H. Douglas and T. K. Peucker, "Algorithms for
    /// the Reduction of the Number of Points Required to Represent a Digitized Line", Cartographica 10(2), 1973.
    fn keep_bends(&mut self, mesh: &TriMesh, chain: &[u32], tolerance: f64) {
        let position = |vertex: u32| mesh.positions[vertex as usize].as_dvec3();
        let mut left = vec![(0, chain.len() - 1)];
        while let Some((first, last)) = left.pop() {
            let (a, b) = (position(chain[first]), position(chain[last]));
            let distance = |place: usize| distance_to_segment(position(chain[place]), a, b);
            let inner = first + 1..last;
            let Some(farthest) = inner.max_by(|&i, &j| distance(i).total_cmp(&distance(j))) else {
                continue;
            };
            if distance(farthest) > tolerance {
                self.points[mesh.topology[chain[farthest] as usize] as usize].stays = true;
                left.extend([(first, farthest), (farthest, last)]);
            }
        }
    }

    /// The outlines of all faces, if each has three corners and each edge is there once in each direction.
    fn make_outlines(&mut self, mesh: &TriMesh) -> bool {
        let number = |vertex: u32| mesh.topology[vertex as usize];
        self.outline.clear();
        self.edges.reset(self.points.len());
        let mut pairs = 0_usize;
        for face in &mut self.faces {
            let [first, end] = face.border;
            face.outline[0] = self.outline.len() as u32;
            if end - first == 3 {
                let edges = &self.border[first as usize..end as usize];
                self.outline.extend_from_slice(edges);
                (face.loops, face.is_simple) = (1, true);
            } else {
                for edge in first..end {
                    self.next[number(self.border[edge as usize][0]) as usize] = edge;
                }
                for edge in first..end {
                    let [from, mut to] = self.border[edge as usize];
                    if !stays(&self.points[number(from) as usize]) {
                        continue;
                    }
                    while !stays(&self.points[number(to) as usize]) {
                        to = self.border[self.next[number(to) as usize] as usize][1];
                    }
                    self.outline.push([from, to]);
                }
            }
            face.outline[1] = self.outline.len() as u32;
            let own = &self.outline[face.outline[0] as usize..];
            if own.len() < 3 {
                return false;
            }
            for &ends in own {
                let [from, to] = ends.map(number);
                match self.edges.get_mut(from, to) {
                    None => self.edges.insert(from, to, if from < to { 1 } else { 2 }),
                    Some(sides) => {
                        let side = if from < to { 1 } else { 2 };
                        if *sides & side != 0 {
                            return false;
                        }
                        *sides |= side;
                        pairs += 1;
                    }
                }
            }
        }
        self.count_loops(mesh);
        2 * pairs == self.outline.len()
    }

    /// How many loops each outline has, and whether no corner is in it twice.
    fn count_loops(&mut self, mesh: &TriMesh) {
        let number = |vertex: u32| mesh.topology[vertex as usize] as usize;
        for face in &mut self.faces {
            let own = &self.outline[face.outline[0] as usize..face.outline[1] as usize];
            if own.len() == 3 {
                (face.loops, face.is_simple) = (1, true);
                continue;
            }
            own.iter()
                .for_each(|&[from, _]| self.next[number(from)] = NONE);
            face.is_simple = true;
            for (place, &[from, _]) in (0_u32..).zip(own) {
                face.is_simple &= self.next[number(from)] == NONE;
                self.next[number(from)] = place;
            }
            face.loops = 0;
            for &[from, _] in own {
                let mut at = from;
                let mut is_new = false;
                while self.next[number(at)] != NONE {
                    let edge = self.next[number(at)];
                    self.next[number(at)] = NONE;
                    at = own[edge as usize][1];
                    is_new = true;
                }
                face.loops += u32::from(is_new);
            }
        }
    }
}

fn stays(point: &Point) -> bool {
    point.stays
}

fn distance_to_segment(point: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let t =
        ((point - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    point.distance(a + t * along)
}
