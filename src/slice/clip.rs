//! Plane against triangles: which triangles go to which side, and the vertices where edges are cut.
//!
//! Every decision follows from one [`Side`] per topology number, so neighbours always agree: a cut edge gets one cut
//! point for both its triangles (and one vertex per attribute seam at that point), and what is missing a partner on one
//! side is missing it, reversed, on the other.

use super::attributes::push_between;
use super::edge_table::EdgeTable;
use crate::geometry::TriMesh;
use crate::geometry::predicates::{Side, side, signed_distance};
use crate::math::Plane;
use glam::Vec3;

/// The triangles of both sides, before the caps.
#[derive(Debug)]
pub(super) struct Clip {
    /// The old vertices followed by the cut vertices; no triangles.
    pub(super) vertices: TriMesh,
    /// How many topology numbers `vertices` uses.
    pub(super) topology_count: u32,
    /// Topology numbers below this are vertices of the input.
    pub(super) old_topology_count: u32,
    /// Triangles of the part below the plane.
    pub(super) below: Vec<[u32; 3]>,
    /// Triangles of the part above the plane.
    pub(super) above: Vec<[u32; 3]>,
    /// Directed edges (vertex numbers) that the triangles below need a cap to have.
    pub(super) rim: Vec<[u32; 2]>,
    /// All edges of the input between vertices on the plane, over topology numbers.
    pub(super) on_edges: EdgeTable,
    /// All triangles of the input that lie on the plane, as topology numbers in ascending order.
    pub(super) on_triangles: Vec<[u32; 3]>,
}

/// What a plane does to a mesh.
#[derive(Debug)]
pub(super) enum Verdict {
    /// No vertex is above the plane, and at least one is below.
    Below,
    /// No vertex is below the plane.
    Above,
    /// There are vertices on both sides.
    Both(Vec<Side>),
}

/// Classifies the vertices of `mesh`: nearer to the plane than `tolerance` (m) is on it.
pub(super) fn classify(mesh: &TriMesh, plane: &Plane, tolerance: f32) -> Verdict {
    let count = mesh.topology.iter().max().map_or(0, |&t| t as usize + 1);
    let mut sides = vec![Side::On; count];
    for (&position, &number) in mesh.positions.iter().zip(&mesh.topology) {
        sides[number as usize] = side(plane, position, tolerance);
    }
    let mut found = [false; 3];
    for &vertex in mesh.triangles.as_flattened() {
        found[sides[mesh.topology[vertex as usize] as usize] as usize] = true;
    }
    match (found[Side::Below as usize], found[Side::Above as usize]) {
        (true, true) => Verdict::Both(sides),
        (true, false) => Verdict::Below,
        (false, _) => Verdict::Above,
    }
}

/// A point where the plane crosses an edge of the surface.
#[derive(Clone, Copy, Debug)]
struct CutPoint {
    position: Vec3,
    /// Fraction of the way from the end with the smaller topology number.
    t: f32,
    topology: u32,
}

/// An edge between two vertices on the plane, as the first of its two triangles has it.
#[derive(Clone, Copy, Debug)]
struct OnEdge {
    ends: [u32; 2],
    is_below: bool,
}

/// Divides closed `mesh` by `plane`, given the side of each topology number.
pub(super) fn clip(mesh: &TriMesh, plane: &Plane, sides: &[Side]) -> Clip {
    Clipper::new(mesh, plane, sides).run()
}

struct Clipper<'a> {
    mesh: &'a TriMesh,
    plane: &'a Plane,
    sides: &'a [Side],
    cut_points: Vec<CutPoint>,
    /// Undirected edge of topology numbers -> index in `cut_points`.
    cut_point_of: EdgeTable,
    /// Undirected edge of vertices -> cut vertex.
    cut_vertex_of: EdgeTable,
    on_edges: Vec<OnEdge>,
    out: Clip,
}

impl<'a> Clipper<'a> {
    fn new(mesh: &'a TriMesh, plane: &'a Plane, sides: &'a [Side]) -> Self {
        let vertices = TriMesh {
            triangles: Vec::new(),
            positions: mesh.positions.clone(),
            normals: mesh.normals.clone(),
            colours: mesh.colours.clone(),
            uvs: mesh.uvs.clone(),
            topology: mesh.topology.clone(),
        };
        let topology_count = sides.len() as u32;
        Self {
            mesh,
            plane,
            sides,
            cut_points: Vec::new(),
            cut_point_of: EdgeTable::new(sides.len()),
            cut_vertex_of: EdgeTable::new(mesh.positions.len()),
            on_edges: Vec::new(),
            out: Clip {
                vertices,
                topology_count,
                old_topology_count: topology_count,
                below: Vec::with_capacity(mesh.triangles.len()),
                above: Vec::with_capacity(mesh.triangles.len()),
                rim: Vec::new(),
                on_edges: EdgeTable::new(sides.len()),
                on_triangles: Vec::new(),
            },
        }
    }

    fn run(mut self) -> Clip {
        for &triangle in &self.mesh.triangles {
            let sides = triangle.map(|vertex| self.side(vertex));
            match (sides.contains(&Side::Below), sides.contains(&Side::Above)) {
                (true, true) => self.split(triangle, sides),
                (true, false) => self.keep(triangle, true),
                (false, true) => self.keep(triangle, false),
                (false, false) => self.keep_coplanar(triangle),
            }
        }
        self.out
    }

    fn topology(&self, vertex: u32) -> u32 {
        self.mesh.topology[vertex as usize]
    }

    fn side(&self, vertex: u32) -> Side {
        self.sides[self.topology(vertex) as usize]
    }

    /// Puts a whole triangle on one side, and pairs its edges that lie on the plane.
    fn keep(&mut self, triangle: [u32; 3], is_below: bool) {
        if is_below {
            self.out.below.push(triangle);
        } else {
            self.out.above.push(triangle);
        }
        let [a, b, c] = triangle;
        for ends in [[a, b], [b, c], [c, a]] {
            if ends.iter().all(|&vertex| self.side(vertex) == Side::On) {
                self.pair_on_edge(OnEdge { ends, is_below });
            }
        }
    }

    /// A triangle on the plane bounds the material behind it: below if it faces along the normal, above otherwise.
    fn keep_coplanar(&mut self, triangle: [u32; 3]) {
        let [a, b, c] = triangle.map(|v| self.mesh.positions[v as usize].as_dvec3());
        let facing = (b - a).cross(c - a).dot(self.plane.normal.as_dvec3());
        let mut key = triangle.map(|vertex| self.topology(vertex));
        key.sort_unstable();
        self.out.on_triangles.push(key);
        self.keep(triangle, facing > 0.0);
    }

    /// The second of an edge's two triangles finds the first; if they are on different sides, the edge is rim.
    fn pair_on_edge(&mut self, edge: OnEdge) {
        let [from, to] = edge.ends.map(|vertex| self.topology(vertex));
        let Some(first) = self.out.on_edges.get(from, to) else {
            let index = self.on_edges.len() as u32;
            self.out.on_edges.insert(from, to, index);
            self.on_edges.push(edge);
            return;
        };
        let first = self.on_edges[first as usize];
        if first.is_below != edge.is_below {
            let [from, to] = if edge.is_below { edge.ends } else { first.ends };
            self.out.rim.push([to, from]);
        }
    }

    /// Divides a triangle with vertices on both sides.
    ///
    /// The diagonal of the quadrilateral part follows the triangle's orientation, so that two triangles with the same
    /// corners, back to back, get different diagonals and stay a manifold.
    fn split(&mut self, triangle: [u32; 3], sides: [Side; 3]) {
        let rotated = |first: usize| [0, 1, 2].map(|corner| triangle[(first + corner) % 3]);
        if let Some(on) = sides.iter().position(|&s| s == Side::On) {
            let [v, p, q] = rotated(on);
            let cut = self.cut_vertex(p, q);
            if self.side(p) == Side::Below {
                self.out.below.push([v, p, cut]);
                self.out.above.push([v, cut, q]);
                self.out.rim.push([v, cut]);
            } else {
                self.out.above.push([v, p, cut]);
                self.out.below.push([v, cut, q]);
                self.out.rim.push([cut, v]);
            }
            return;
        }
        let lone = (0..3)
            .find(|&i| sides[(i + 1) % 3] == sides[(i + 2) % 3])
            .unwrap_or(0);
        let [l, p, q] = rotated(lone);
        let (cut_p, cut_q) = (self.cut_vertex(l, p), self.cut_vertex(l, q));
        let (tip, base) = ([l, cut_p, cut_q], [[cut_p, p, q], [cut_p, q, cut_q]]);
        if sides[lone] == Side::Below {
            self.out.below.push(tip);
            self.out.above.extend(base);
            self.out.rim.push([cut_q, cut_p]);
        } else {
            self.out.above.push(tip);
            self.out.below.extend(base);
            self.out.rim.push([cut_p, cut_q]);
        }
    }

    /// The vertex where the plane crosses the edge between two vertices: the same for both triangles of the edge, unless
    /// a seam runs along it; then two vertices at the same point.
    fn cut_vertex(&mut self, a: u32, b: u32) -> u32 {
        if let Some(vertex) = self.cut_vertex_of.get(a, b) {
            return vertex;
        }
        let ends = if self.topology(a) < self.topology(b) {
            [a, b]
        } else {
            [b, a]
        };
        let point = self.cut_point(ends);
        let vertex = push_between(
            &mut self.out.vertices,
            ends,
            point.t,
            point.position,
            point.topology,
        );
        self.cut_vertex_of.insert(a, b, vertex);
        vertex
    }

    /// The point where the plane crosses the edge of the surface under `ends`, smaller topology number first.
    fn cut_point(&mut self, ends: [u32; 2]) -> CutPoint {
        let [low, high] = ends.map(|vertex| self.topology(vertex));
        if let Some(index) = self.cut_point_of.get(low, high) {
            return self.cut_points[index as usize];
        }
        let [a, b] = ends.map(|vertex| self.mesh.positions[vertex as usize]);
        let (position, t) = crossing(self.plane, a, b);
        let point = CutPoint {
            position,
            t,
            topology: self.out.topology_count,
        };
        self.out.topology_count += 1;
        let index = self.cut_points.len() as u32;
        self.cut_points.push(point);
        self.cut_point_of.insert(low, high, index);
        point
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
