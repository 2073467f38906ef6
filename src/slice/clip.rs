//! Plane against triangles: which triangles go to which side, and the vertices where edges are cut.
//!
//! Every decision follows from one [`Side`] per position, so neighbors always agree: a cut edge gets one cut point for
//! both its triangles (and one vertex per attribute seam at that point), and what is missing a partner on one side is
//! missing it, reversed, on the other.
//!
//! One pass over the triangles sorts them by the sides of their corners. Most are on one side and need nothing more; only
//! those that the plane cuts or touches are looked at again.

use crate::geometry::TriMesh;
use crate::geometry::predicates::{Side, side, signed_distance};
use crate::math::Plane;
use crate::slice::attributes;
use crate::slice::attributes::push_between;
use crate::slice::cut::Cut;
use crate::slice::edge_table::EdgeTable;
use glam::Vec3;

/// Sides as bits, so that those of a triangle's corners can be joined.
const BELOW: u8 = 1;
const ABOVE: u8 = 2;
const ON: u8 = 4;

/// A triangle of a part that the input does not have: part of a cut one.
#[derive(Clone, Copy, Debug)]
pub(super) struct CutTriangle {
    /// Vertex numbers.
    pub(super) corners: [u32; 3],
    /// The triangle of the input that it is part of.
    pub(super) source: u32,
}

/// A point where the plane crosses an edge of the surface.
#[derive(Clone, Copy, Debug)]
struct CutPoint {
    position: Vec3,
    /// Fraction of the way from the end with the smaller topology number.
    t: f32,
    topology: u32,
}

/// How many triangles are sheets.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SheetCounts {
    pub(super) whole: usize,
    pub(super) cut: usize,
}

/// An edge between two vertices on the plane, as the first of its two triangles has it.
#[derive(Clone, Copy, Debug)]
struct EdgeOnPlane {
    ends: [u32; 2],
    is_below: bool,
}

/// Triangles on their way to the lists of their sides.
struct Sorting<'a> {
    /// Side of each vertex, as a bit.
    sides: &'a [u8],
    /// Room for the triangles below and above.
    whole: [&'a mut [u32]; 2],
    /// How many of each there are.
    counts: [usize; 2],
    /// All sides found.
    found: u8,
    mixed: &'a mut Vec<u32>,
    touching: &'a mut Vec<u32>,
}

impl Sorting<'_> {
    /// Sorts triangles, the first of which has number `first`; all are sheets or none is.
    fn sort<const SHEETS: bool>(&mut self, first: u32, triangles: &[[u32; 3]]) {
        let [below, above] = &mut self.whole;
        let ([mut below_count, mut above_count], mut found) = (self.counts, self.found);
        for (triangle, corners) in (first..).zip(triangles) {
            let [a, b, c] = corners.map(|vertex| self.sides[vertex as usize]);
            let all = a | b | c;
            found |= all;
            // A sheet on the plane bounds nothing; it goes below.
            let parts = match all & (BELOW | ABOVE) {
                0 if SHEETS => BELOW,
                parts => parts,
            };
            // Written always and counted where it belongs, which no processor has to guess.
            below[below_count] = triangle;
            below_count += usize::from(parts == BELOW);
            above[above_count] = triangle;
            above_count += usize::from(parts == ABOVE);
            if parts == 0 || parts == BELOW | ABOVE {
                self.mixed.push(triangle);
            } else if !SHEETS && (a & b | b & c | c & a) & ON != 0 {
                self.touching.push(triangle);
            }
        }
        (self.counts, self.found) = ([below_count, above_count], found);
    }
}

/// The triangles of both sides, before the caps; keeps its working memory.
///
/// Vertex numbers go on where those of the input end: the first of [`new`](Self::new) is number `old_vertices`. Pairs are
/// `[below, above]`.
#[derive(Clone, Debug, Default)]
pub(super) struct Clip {
    /// Number of vertices of the input.
    pub(super) old_vertices: u32,
    /// The vertices on cut edges, and later those inside caps; no triangles.
    pub(super) new: TriMesh,
    /// How many of the new vertices are on cut edges.
    pub(super) cut_vertices: usize,
    /// How many topology numbers old and new vertices use.
    pub(super) topology_count: u32,
    /// Topology numbers below this are vertices of the input.
    pub(super) old_topology_count: u32,
    /// Side of each old vertex, as a bit.
    sides: Vec<u8>,
    /// Triangles of the input that are on one side.
    pub(super) whole: [Vec<u32>; 2],
    /// Triangles that are parts of cut ones.
    pub(super) cut: [Vec<CutTriangle>; 2],
    /// How many of the whole and of the cut triangles of each side, the first ones, are sheets.
    pub(super) sheets: [SheetCounts; 2],
    /// Triangles of the input with corners on both sides, or with none off the plane.
    mixed: Vec<u32>,
    /// Whole triangles with an edge on the plane.
    touching: Vec<u32>,
    /// Directed edges (vertex numbers) that the triangles below need a cap to have.
    pub(super) rim: Vec<[u32; 2]>,
    /// All edges of the input between vertices on the plane, over topology numbers.
    pub(super) on_edges: EdgeTable,
    /// All triangles of the input that lie on the plane, as topology numbers in ascending order.
    pub(super) on_triangles: Vec<[u32; 3]>,
    cut_points: Vec<CutPoint>,
    /// Undirected edge of topology numbers -> index in `cut_points`.
    cut_point_of: EdgeTable,
    /// Undirected edge of vertices -> cut vertex.
    cut_vertex_of: EdgeTable,
    first_on_edges: Vec<EdgeOnPlane>,
}

impl Clip {
    /// Divides closed `mesh` by `plane`; vertices nearer to it than `tolerance` (m) are on it.
    ///
    /// Unless the plane cuts the mesh, only the verdict means anything.
    pub(super) fn run(&mut self, mesh: &TriMesh, plane: &Plane, tolerance: f32) -> Cut {
        self.sides.clear();
        self.sides.extend(
            mesh.positions
                .iter()
                .map(|&position| bit(side(plane, position, tolerance))),
        );
        let found = self.sort_triangles(mesh);
        match (found & BELOW != 0, found & ABOVE != 0) {
            (true, true) => {}
            (true, false) => return Cut::Below,
            (false, _) => return Cut::Above,
        }
        self.reset(mesh);
        let sheets = self
            .mixed
            .partition_point(|&triangle| triangle < mesh.sheets);
        for index in 0..sheets {
            self.split(mesh, plane, self.mixed[index]);
        }
        self.end_sheets();
        for index in 0..self.touching.len() {
            self.keep_edges(mesh, self.touching[index]);
        }
        for index in sheets..self.mixed.len() {
            let triangle = self.mixed[index];
            let corners = mesh.triangles[triangle as usize];
            if corners.iter().all(|&v| self.sides[v as usize] == ON) {
                self.keep_coplanar(mesh, plane, triangle);
            } else {
                self.split(mesh, plane, triangle);
            }
        }
        self.cut_vertices = self.new.positions.len();
        Cut::Cut(())
    }

    /// Takes a rim without any cut: directed edges between vertices of `mesh`, which has no triangles.
    pub(super) fn begin_rim(&mut self, mesh: &TriMesh, rim: &[[u32; 2]]) {
        self.reset(mesh);
        self.rim.extend_from_slice(rim);
    }

    /// Sorts the triangles by the sides of their corners; returns all sides found.
    fn sort_triangles(&mut self, mesh: &TriMesh) -> u8 {
        self.mixed.clear();
        self.touching.clear();
        for whole in &mut self.whole {
            whole.clear();
            whole.resize(mesh.triangles.len(), 0);
        }
        let mut sorting = Sorting {
            sides: &self.sides,
            whole: self.whole.each_mut().map(Vec::as_mut_slice),
            counts: [0; 2],
            found: 0,
            mixed: &mut self.mixed,
            touching: &mut self.touching,
        };
        let (sheets, solid) = mesh.triangles.split_at(mesh.sheets as usize);
        sorting.sort::<true>(0, sheets);
        self.sheets = sorting.counts.map(|whole| SheetCounts { whole, cut: 0 });
        sorting.sort::<false>(mesh.sheets, solid);
        let ([below_count, above_count], found) = (sorting.counts, sorting.found);
        self.whole[0].truncate(below_count);
        self.whole[1].truncate(above_count);
        found
    }

    /// Forgets the cut of the last mesh.
    fn reset(&mut self, mesh: &TriMesh) {
        let topology_count = mesh.topology_count();
        self.old_vertices = mesh.positions.len() as u32;
        attributes::clear(&mut self.new);
        self.topology_count = topology_count as u32;
        self.old_topology_count = topology_count as u32;
        self.cut.iter_mut().for_each(Vec::clear);
        self.rim.clear();
        self.on_edges.clear();
        self.on_triangles.clear();
        self.cut_points.clear();
        self.cut_point_of.clear();
        self.cut_vertex_of.clear();
        self.first_on_edges.clear();
    }

    /// Takes note of the sheets that were cut: they need no cap.
    fn end_sheets(&mut self) {
        self.rim.clear();
        for (sheets, cut) in self.sheets.iter_mut().zip(&self.cut) {
            sheets.cut = cut.len();
        }
    }

    /// The mesh that has vertex number `vertex`, and its place there.
    pub(super) fn find<'a>(&'a self, mesh: &'a TriMesh, vertex: u32) -> (&'a TriMesh, usize) {
        match vertex.checked_sub(self.old_vertices) {
            None => (mesh, vertex as usize),
            Some(place) => (&self.new, place as usize),
        }
    }

    /// Topology number of vertex number `vertex`.
    pub(super) fn topology(&self, mesh: &TriMesh, vertex: u32) -> u32 {
        let (source, place) = self.find(mesh, vertex);
        source.topology[place]
    }

    /// Pairs those edges of a triangle on one side that lie on the plane.
    fn keep_edges(&mut self, mesh: &TriMesh, triangle: u32) {
        let corners = mesh.triangles[triangle as usize];
        let is_below = corners.iter().any(|&v| self.sides[v as usize] == BELOW);
        self.pair_on_edges(mesh, corners, is_below);
    }

    /// A triangle on the plane bounds the material behind it: below if it faces along the normal, above otherwise.
    fn keep_coplanar(&mut self, mesh: &TriMesh, plane: &Plane, triangle: u32) {
        let corners = mesh.triangles[triangle as usize];
        let [a, b, c] = corners.map(|v| mesh.positions[v as usize].as_dvec3());
        let facing = (b - a).cross(c - a).dot(plane.normal.as_dvec3());
        let mut key = corners.map(|vertex| mesh.topology[vertex as usize]);
        key.sort_unstable();
        self.on_triangles.push(key);
        let is_below = facing > 0.0;
        self.whole[usize::from(!is_below)].push(triangle);
        self.pair_on_edges(mesh, corners, is_below);
    }

    fn pair_on_edges(&mut self, mesh: &TriMesh, [a, b, c]: [u32; 3], is_below: bool) {
        for ends in [[a, b], [b, c], [c, a]] {
            if ends.iter().all(|&v| self.sides[v as usize] == ON) {
                self.pair_on_edge(mesh, EdgeOnPlane { ends, is_below });
            }
        }
    }

    /// The second of an edge's two triangles finds the first; if they are on different sides, the edge is rim.
    fn pair_on_edge(&mut self, mesh: &TriMesh, edge: EdgeOnPlane) {
        let [from, to] = edge.ends.map(|vertex| mesh.topology[vertex as usize]);
        let Some(first) = self.on_edges.get(from, to) else {
            let index = self.first_on_edges.len() as u32;
            self.on_edges.insert(from, to, index);
            self.first_on_edges.push(edge);
            return;
        };
        let first = self.first_on_edges[first as usize];
        if first.is_below != edge.is_below {
            let [from, to] = if edge.is_below { edge.ends } else { first.ends };
            self.rim.push([to, from]);
        }
    }

    /// Divides a triangle with vertices on both sides.
    ///
    /// The diagonal of the quadrilateral part follows the triangle's orientation, so that two triangles with the same
    /// corners, back to back, get different diagonals and stay a manifold.
    fn split(&mut self, mesh: &TriMesh, plane: &Plane, triangle: u32) {
        let corners = mesh.triangles[triangle as usize];
        let sides = corners.map(|vertex| self.sides[vertex as usize]);
        let rotated = |first: usize| [0, 1, 2].map(|corner| corners[(first + corner) % 3]);
        if let Some(on) = sides.iter().position(|&s| s == ON) {
            let [v, p, q] = rotated(on);
            let cut = self.cut_vertex(mesh, plane, p, q);
            let side_of_p = usize::from(self.sides[p as usize] == ABOVE);
            self.push(side_of_p, [v, p, cut], triangle);
            self.push(1 - side_of_p, [v, cut, q], triangle);
            let is_below = side_of_p == 0;
            self.rim.push(if is_below { [v, cut] } else { [cut, v] });
            return;
        }
        let lone = (0..3)
            .find(|&i| sides[(i + 1) % 3] == sides[(i + 2) % 3])
            .unwrap_or(0);
        let [l, p, q] = rotated(lone);
        let cut_p = self.cut_vertex(mesh, plane, l, p);
        let cut_q = self.cut_vertex(mesh, plane, l, q);
        let side_of_l = usize::from(sides[lone] == ABOVE);
        self.push(side_of_l, [l, cut_p, cut_q], triangle);
        self.push(1 - side_of_l, [cut_p, p, q], triangle);
        self.push(1 - side_of_l, [cut_p, q, cut_q], triangle);
        let is_below = side_of_l == 0;
        self.rim.push(if is_below {
            [cut_q, cut_p]
        } else {
            [cut_p, cut_q]
        });
    }

    fn push(&mut self, part: usize, corners: [u32; 3], source: u32) {
        self.cut[part].push(CutTriangle { corners, source });
    }

    /// The vertex where the plane crosses the edge between two vertices: the same for both triangles of the edge, unless
    /// a seam runs along it; then two vertices at the same point.
    fn cut_vertex(&mut self, mesh: &TriMesh, plane: &Plane, a: u32, b: u32) -> u32 {
        if let Some(vertex) = self.cut_vertex_of.get(a, b) {
            return vertex;
        }
        let ends = if mesh.topology[a as usize] < mesh.topology[b as usize] {
            [a, b]
        } else {
            [b, a]
        };
        let point = self.cut_point(mesh, plane, ends);
        let vertex = self.old_vertices + self.new.positions.len() as u32;
        push_between(
            &mut self.new,
            mesh,
            ends,
            point.t,
            point.position,
            point.topology,
        );
        self.cut_vertex_of.insert(a, b, vertex);
        vertex
    }

    /// The point where the plane crosses the edge of the surface under `ends`, smaller topology number first.
    fn cut_point(&mut self, mesh: &TriMesh, plane: &Plane, ends: [u32; 2]) -> CutPoint {
        let [low, high] = ends.map(|vertex| mesh.topology[vertex as usize]);
        if let Some(index) = self.cut_point_of.get(low, high) {
            return self.cut_points[index as usize];
        }
        let [a, b] = ends.map(|vertex| mesh.positions[vertex as usize]);
        let (position, t) = crossing(plane, a, b);
        let point = CutPoint {
            position,
            t,
            topology: self.topology_count,
        };
        self.topology_count += 1;
        let index = self.cut_points.len() as u32;
        self.cut_points.push(point);
        self.cut_point_of.insert(low, high, index);
        point
    }
}

fn bit(side: Side) -> u8 {
    match side {
        Side::Below => BELOW,
        Side::Above => ABOVE,
        Side::On => ON,
    }
}

/// Where `plane` crosses the edge from `a` to `b`, whose ends are on different sides, and how far along that is.
///
/// With `d` the signed distances, `t = d_a / (d_a - d_b)` and `p = a + t (b - a)`, in `f64` and rounded once; clamped to
/// the box of the edge, so that a cut never sticks out of the body.
pub(super) fn crossing(plane: &Plane, a: Vec3, b: Vec3) -> (Vec3, f32) {
    let (from, to) = (signed_distance(plane, a), signed_distance(plane, b));
    let t = (from / (from - to)).clamp(0.0, 1.0);
    let point = a.as_dvec3() + t * (b.as_dvec3() - a.as_dvec3());
    (point.as_vec3().clamp(a.min(b), a.max(b)), t as f32)
}
