//! The faces of one piece on one plane, made anew: a flat rim, and within it the triangles of the lattice.

use crate::geometry::TriMesh;
use crate::slice::attributes;
use crate::slice::relief::heights::{Heights, corners_of};
use crate::slice::relief::lattice::Lattice;
use crate::slice::rim_fill::{RimCorner, RimFill};
use glam::{DVec2, DVec3, Vec2, Vec4};

/// No triangle, no vertex.
const NONE: u32 = u32::MAX;

/// How much of the area of a face may be lost or doubled at its rim, as a share: rounding of corners to `f32`.
const AREA_TOLERANCE: f64 = 1e-5;

/// How far outside of a triangle a node counts as in it, as a share of the triangle: it may be on the edge between two.
const INSIDE_TOLERANCE: f64 = 1e-6;

/// What takes the place of some triangles of a mesh.
#[derive(Clone, Debug, Default)]
pub(super) struct Patch {
    /// New vertices, with the attributes of the mesh. Topology numbers mean nothing: each is at a place of its own.
    pub(super) vertices: TriMesh,
    /// Corners below the number of the mesh's vertices are vertices of it, the others those of the patch.
    pub(super) triangles: Vec<[u32; 3]>,
    /// How many triangles, the first ones, are in the plane.
    pub(super) flat: usize,
}

/// Makes patches, keeping its working memory.
#[derive(Clone, Debug, Default)]
pub(super) struct PatchMaker {
    filler: RimFill,
    /// By node: the old triangle that it is in.
    owner: Vec<u32>,
    /// By node: its vertex in the patch.
    vertex: Vec<u32>,
    /// Triangles of the lattice that are moved.
    moved: Vec<[u32; 3]>,
    rim: Vec<[u32; 2]>,
    edges: Vec<([u32; 2], [u32; 2])>,
    /// The vertices of the rim and the nodes.
    local: TriMesh,
    /// By topology number of the mesh: the number in `local`.
    local_of: Vec<u32>,
    chosen: Vec<u32>,
}

/// The mesh of a piece and its triangles that are to be replaced.
#[derive(Clone, Copy, Debug)]
pub(super) struct Old<'a> {
    pub(super) mesh: &'a TriMesh,
    pub(super) triangles: &'a [u32],
    /// By triangle of the mesh: whether it is one of them.
    pub(super) is_old: &'a [bool],
    /// Edges (vertices of the mesh) that other patches have made.
    pub(super) made: &'a [[u32; 2]],
}

impl PatchMaker {
    /// The faces `old` with the relief `heights`; `Ok(None)` if nothing of them is moved.
    ///
    /// # Errors
    /// [`UnsoundRim`] if the rim cannot be filled, because the faces are not those of a surface without self-intersection.
    pub(super) fn make(
        &mut self,
        old: &Old<'_>,
        lattice: &Lattice,
        heights: &Heights,
    ) -> Result<Option<Patch>, UnsoundRim> {
        self.find_owners(old, lattice);
        self.find_moved(lattice, heights);
        if self.moved.is_empty() {
            return Ok(None);
        }
        let twice_area: DVec3 = (old.triangles.iter())
            .map(|&t| twice_area(corners_of(old.mesh, t)))
            .sum();
        let along = twice_area.dot(lattice.normal);
        let side = 1.0_f64.copysign(along);
        let mut patch = Patch::default();
        self.add_nodes(old, lattice, heights, (side, &mut patch))?;
        self.fill_rim(old, (lattice.normal, side), &mut patch);
        patch.flat = patch.triangles.len();
        let flat = self.check(old, &patch, side * lattice.normal)?;
        let spacing = lattice.spacing;
        let cell = 0.75_f64.sqrt() * spacing * spacing;
        let lost = along.abs() - flat - cell * self.moved.len() as f64;
        if lost.abs() > AREA_TOLERANCE * along.abs() {
            return Err(UnsoundRim);
        }
        let first = old.mesh.positions.len() as u32;
        let vertices = &self.vertex;
        patch.triangles.extend(self.moved.iter().map(|nodes| {
            let [a, b, c] = nodes.map(|node| first + vertices[node as usize]);
            if side > 0.0 { [a, b, c] } else { [a, c, b] }
        }));
        Ok(Some(patch))
    }

    /// Finds which old triangle each node is in.
    fn find_owners(&mut self, old: &Old<'_>, lattice: &Lattice) {
        self.owner.clear();
        self.owner.resize(lattice.len(), NONE);
        for &triangle in old.triangles {
            let corners = corners_of(old.mesh, triangle).map(|p| lattice.flat(p));
            let [a, b, c] = corners;
            let slack = DVec2::splat(INSIDE_TOLERANCE * lattice.spacing);
            let (low, high) = (a.min(b).min(c) - slack, a.max(b).max(c) + slack);
            for node in lattice.nodes_within(low, high) {
                let shares = barycentric(corners, lattice.flat_node(node));
                if shares.iter().all(|&share| share >= -INSIDE_TOLERANCE) {
                    self.owner[node as usize] = triangle;
                }
            }
        }
    }

    /// Finds the triangles of the lattice that have a corner which is moved.
    fn find_moved(&mut self, lattice: &Lattice, heights: &Heights) {
        let is_moved =
            |node: &u32| self.owner[*node as usize] != NONE && heights.is_moved(lattice, *node);
        self.moved.clear();
        let all = lattice.triangles();
        self.moved.extend(all.filter(|t| t.iter().any(is_moved)));
    }

    /// Adds the nodes of the moved triangles to a patch.
    fn add_nodes(
        &mut self,
        old: &Old<'_>,
        lattice: &Lattice,
        heights: &Heights,
        (side, patch): (f64, &mut Patch),
    ) -> Result<(), UnsoundRim> {
        self.vertex.clear();
        self.vertex.resize(lattice.len(), NONE);
        for &node in self.moved.iter().flatten() {
            if self.vertex[node as usize] != NONE {
                continue;
            }
            let owner = self.owner[node as usize];
            if owner == NONE {
                return Err(UnsoundRim);
            }
            let vertices = &mut patch.vertices;
            self.vertex[node as usize] = vertices.positions.len() as u32;
            let place = lattice.place(node, heights.over[node as usize]);
            vertices.positions.push(place.as_vec3());
            // What is not moved has the normal of the plane, as the rim has.
            let normal = if heights.is_moved(lattice, node) {
                lattice.normal_at(node, &heights.over)
            } else {
                lattice.normal
            };
            push_attributes(vertices, old.mesh, owner, lattice, node);
            if !old.mesh.normals.is_empty() {
                vertices.normals.push((side * normal).as_vec3());
            }
        }
        Ok(())
    }

    /// Fills what is between the outline of the old triangles and that of the moved ones, which face along `normal` or, with a
    /// negative `side`, against it.
    fn fill_rim(&mut self, old: &Old<'_>, (normal, side): (DVec3, f64), patch: &mut Patch) {
        let first = old.mesh.positions.len() as u32;
        self.rim.clear();
        let corner = |v: u32| old.mesh.topology[v as usize];
        let own = old
            .triangles
            .iter()
            .map(|&t| old.mesh.triangles[t as usize]);
        find_rim(own, corner, &mut self.edges, &mut self.rim);
        self.begin_local(old, patch);
        let outline = self.rim.len();
        find_rim(
            self.moved.iter().copied(),
            |n| n,
            &mut self.edges,
            &mut self.rim,
        );
        let nodes = self.chosen.len() as u32;
        for ends in &mut self.rim[outline..] {
            let [a, b] = ends.map(|node| nodes + self.vertex[node as usize]);
            // The rim has the edge the other way round than the moved triangle.
            *ends = if side < 0.0 { [a, b] } else { [b, a] };
        }
        for ends in &mut self.rim[..outline] {
            *ends = ends.map(|v| self.local_of[old.mesh.topology[v as usize] as usize]);
        }
        self.filler.load(&self.local, self.rim.iter().copied());
        self.exclude_edges(old);
        self.filler.run((side * normal).as_vec3());
        let added = first + patch.vertices.positions.len() as u32;
        let chosen = &self.chosen;
        let number = |corner: RimCorner| match corner {
            RimCorner::Vertex(v) => match v.checked_sub(nodes) {
                None => chosen[v as usize],
                Some(node) => first + node,
            },
            RimCorner::New(place) => added + place,
        };
        let triangles = self.filler.triangles().map(|t| t.map(number));
        patch.triangles.extend(triangles);
        let new = self.filler.new_vertices();
        let count = new.positions.len();
        attributes::extend_chosen(&mut patch.vertices, &self.local, &[], new, [count, 0]);
        for &vertex in &self.chosen {
            self.local_of[old.mesh.topology[vertex as usize] as usize] = NONE;
        }
    }

    /// Takes the vertices of the outline and the nodes.
    fn begin_local(&mut self, old: &Old<'_>, patch: &Patch) {
        let count = self.local_of.len().max(old.mesh.topology_count());
        self.local_of.resize(count, NONE);
        self.chosen.clear();
        for &vertex in self.rim.iter().flatten() {
            let local = &mut self.local_of[old.mesh.topology[vertex as usize] as usize];
            if *local == NONE {
                *local = self.chosen.len() as u32;
                self.chosen.push(vertex);
            }
        }
        let count = patch.vertices.positions.len();
        let local = &mut self.local;
        attributes::clear(local);
        let new = &patch.vertices;
        attributes::extend_chosen(local, old.mesh, &self.chosen, new, [count, 0]);
        let all = self.chosen.len() as u32 + count as u32;
        local.topology.extend(0..all);
    }

    /// Says which edges between corners of the outline the piece has already.
    fn exclude_edges(&mut self, old: &Old<'_>) {
        let triangles = (old.mesh.triangles.iter().zip(old.is_old)).skip(old.mesh.sheets());
        let others = triangles.filter(|(_, is_old)| !**is_old);
        let edges = others.flat_map(|(&[a, b, c], _)| [[a, b], [b, c], [c, a]]);
        for ends in edges.chain(old.made.iter().copied()) {
            let [a, b] = ends.map(|v| self.local_of[old.mesh.topology[v as usize] as usize]);
            if a != NONE && b != NONE {
                self.filler.exclude_edge(a, b);
            }
        }
    }

    /// The area (m2) of the triangles of a patch, none of which may face backwards.
    fn check(&self, old: &Old<'_>, patch: &Patch, normal: DVec3) -> Result<f64, UnsoundRim> {
        let first = old.mesh.positions.len() as u32;
        let place = |v: u32| match v.checked_sub(first) {
            None => old.mesh.positions[v as usize].as_dvec3(),
            Some(new) => patch.vertices.positions[new as usize].as_dvec3(),
        };
        let mut sum = 0.0;
        for t in &patch.triangles {
            let corners = t.map(place);
            let area = twice_area(corners).dot(normal);
            let [a, b, c] = corners;
            let longest = a
                .distance_squared(b)
                .max(b.distance_squared(c))
                .max(c.distance_squared(a));
            if area < -AREA_TOLERANCE * longest {
                return Err(UnsoundRim);
            }
            sum += area;
        }
        Ok(sum)
    }
}

/// A rim that cannot be filled.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnsoundRim;

/// Appends the directed edges of triangles whose reverse none of them has; `key` tells which corners are one.
fn find_rim(
    triangles: impl Iterator<Item = [u32; 3]>,
    key: impl Fn(u32) -> u32,
    edges: &mut Vec<([u32; 2], [u32; 2])>,
    rim: &mut Vec<[u32; 2]>,
) {
    edges.clear();
    edges.extend(
        triangles
            .flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|ends| {
                let [a, b] = ends.map(&key);
                ([a.min(b), a.max(b)], ends)
            }),
    );
    edges.sort_unstable();
    let runs = edges.chunk_by(|a, b| a.0 == b.0);
    rim.extend(runs.filter(|run| run.len() == 1).map(|run| run[0].1));
}

/// Appends the colors and texture coordinates that an old triangle has at a node.
fn push_attributes(
    target: &mut TriMesh,
    mesh: &TriMesh,
    triangle: u32,
    lattice: &Lattice,
    node: u32,
) {
    let corners = mesh.triangles[triangle as usize];
    let flat = corners_of(mesh, triangle).map(|p| lattice.flat(p));
    let shares = barycentric(flat, lattice.flat_node(node)).map(|share| share as f32);
    let parts = || corners.into_iter().zip(shares);
    if !mesh.colors.is_empty() {
        let parts = parts().map(|(v, share)| mesh.colors[v as usize] * share);
        target.colors.push(parts.sum::<Vec4>());
    }
    if !mesh.uvs.is_empty() {
        let parts = parts().map(|(v, share)| mesh.uvs[v as usize] * share);
        target.uvs.push(parts.sum::<Vec2>());
    }
}

/// The weights of the corners of a triangle whose mean is a point; those of a corner where it has no area.
fn barycentric([a, b, c]: [DVec2; 3], point: DVec2) -> [f64; 3] {
    let area = (b - a).perp_dot(c - a);
    if area == 0.0 {
        return [f64::NEG_INFINITY; 3];
    }
    let of = |p: DVec2, q: DVec2| (p - point).perp_dot(q - point) / area;
    [of(b, c), of(c, a), of(a, b)]
}

/// Twice the area of a triangle along its normal, m2.
fn twice_area([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}
