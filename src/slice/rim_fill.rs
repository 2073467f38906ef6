//! Holes in a mesh closed by triangles: rims to loops to caps, away from any cut.
//!
//! Works on a copy of the vertices of the rim, so that the work depends on the rim and not on the mesh around it.

use crate::geometry::TriMesh;
use crate::math::Plane;
use crate::slice::attributes;
use crate::slice::border::Border;
use crate::slice::cap::CapFill;
use crate::slice::clip::Clip;
use glam::Vec3;

/// Not met yet.
const NONE: u32 = u32::MAX;

/// Closes rims one after the other, keeping its working memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct RimFill {
    clip: Clip,
    border: Border,
    cap: CapFill,
    /// The vertices of the rim, numbered from 0 on, their positions likewise.
    local: TriMesh,
    /// By local vertex: what it is called in the mesh.
    vertices: Vec<u32>,
    /// By topology number of the mesh: the local one.
    local_of: Vec<u32>,
    /// By local topology number: that of the mesh.
    numbers: Vec<u32>,
    rim: Vec<[u32; 2]>,
}

/// A corner of a triangle that closes a rim.
#[derive(Clone, Copy, Debug)]
pub(crate) enum RimCorner {
    /// A vertex of the mesh.
    Vertex(u32),
    /// A vertex of [`RimFill::new_vertices`], at a place where the mesh has none.
    New(u32),
}

impl RimFill {
    /// Takes the rim: directed edges (vertices of `mesh`) as the new triangles will have them. Each position on it has as
    /// many edges in as out.
    pub(crate) fn load(&mut self, mesh: &TriMesh, rim: impl Iterator<Item = [u32; 2]>) {
        for &number in &self.numbers {
            self.local_of[number as usize] = NONE;
        }
        let count = self.local_of.len().max(mesh.topology_count());
        self.local_of.resize(count, NONE);
        self.numbers.clear();
        self.vertices.clear();
        self.rim.clear();
        attributes::clear(&mut self.local);
        for ends in rim {
            let ends = ends.map(|vertex| self.local_vertex(mesh, vertex));
            self.rim.push(ends);
        }
        let chosen = std::mem::take(&mut self.vertices);
        attributes::extend_chosen(&mut self.local, mesh, &chosen, &TriMesh::default(), [0, 0]);
        self.vertices = chosen;
        self.clip.begin_rim(&self.local, &self.rim);
    }

    /// The local vertex at the position of a vertex; the first one met stands for all at its position.
    fn local_vertex(&mut self, mesh: &TriMesh, vertex: u32) -> u32 {
        let number = mesh.topology[vertex as usize];
        let local = &mut self.local_of[number as usize];
        if *local == NONE {
            *local = self.vertices.len() as u32;
            self.vertices.push(vertex);
            self.numbers.push(number);
            self.local.topology.push(*local);
        }
        *local
    }

    fn local_number(&self, number: u32) -> u32 {
        self.local_of.get(number as usize).copied().unwrap_or(NONE)
    }

    /// Says that the mesh has an edge between two positions (topology numbers) already; those that are not on the rim do
    /// not matter.
    pub(crate) fn exclude_edge(&mut self, a: u32, b: u32) {
        let [a, b] = [a, b].map(|number| self.local_number(number));
        if a != NONE && b != NONE && self.clip.on_edges.get(a, b).is_none() {
            self.clip.on_edges.insert(a, b, 0);
        }
    }

    /// Says that the mesh has a triangle with these positions.
    pub(crate) fn exclude_triangle(&mut self, numbers: [u32; 3]) {
        let mut key = numbers.map(|number| self.local_number(number));
        if !key.contains(&NONE) {
            key.sort_unstable();
            self.clip.on_triangles.push(key);
        }
    }

    /// Closes the rim by triangles that are counter-clockwise seen from where `normal` points, as far as the rim allows.
    pub(crate) fn run(&mut self, normal: Vec3) {
        self.border.run(&self.local, &self.clip);
        let plane = Plane {
            normal,
            offset: 0.0,
        };
        (self.cap).run(&self.local, &mut self.clip, &self.border, &plane);
    }

    /// The triangles.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = [RimCorner; 3]> + '_ {
        let corner = |corner: u32| {
            let vertex = self.cap.corners[corner as usize];
            match vertex.checked_sub(self.clip.old_vertices) {
                None => RimCorner::Vertex(self.vertices[vertex as usize]),
                Some(new) => RimCorner::New(new),
            }
        };
        self.cap.triangles.iter().map(move |t| t.map(corner))
    }

    /// Vertices that a loop needed inside, with the attributes of the mesh. Their topology numbers mean nothing.
    pub(crate) fn new_vertices(&self) -> &TriMesh {
        &self.clip.new
    }
}
