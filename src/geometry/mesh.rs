//! `TriMesh`: triangles with per-vertex attributes.

use crate::geometry::weld::weld;
use crate::geometry::{EdgeCensus, FaceNumbers, KnownClosed, MeshError};
use crate::math::{Aabb, Pose, rotate};
use glam::{DVec3, Vec2, Vec3, Vec4};

/// A triangle mesh with per-vertex attributes.
///
/// A vertex is a position with its attributes; vertices that differ only in attributes (a seam) share a position.
/// `topology[v]` numbers the distinct positions, so that closedness and connectivity are judged on positions while
/// seams stay seams. An attribute array is either empty or has one entry per vertex. The material slots are either empty
/// or one per triangle.
///
/// The first [`sheets`](Self::sheets) triangles may be surfaces without an inside, such as leaves, flags and decals. A cut
/// divides them and caps only the rest, which alone has a volume and can be closed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) normals: Vec<Vec3>,
    pub(crate) colors: Vec<Vec4>,
    pub(crate) uvs: Vec<Vec2>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) materials: Vec<u16>,
    pub(crate) topology: Vec<u32>,
    pub(crate) sheets: u32,
    pub(crate) faces: FaceNumbers,
    pub(crate) known_closed: KnownClosed,
}

impl TriMesh {
    /// A mesh from positions (m) and triangles (vertex indices, counter-clockwise seen from outside).
    ///
    /// Positions with equal coordinates (`-0.0` equals `0.0`) become one number in [`topology`](Self::topology), so a
    /// mesh whose vertices are split along seams is still closed. A triangle with two corners at one position has no
    /// area, and its two remaining edges are each other's reverse, so leaving it out keeps a closed surface closed: such
    /// triangles are dropped here, and later errors count the triangles that are left.
    ///
    /// # Errors
    /// [`MeshError::NotFinite`], [`MeshError::IndexOutOfRange`], or [`MeshError::Empty`] if no triangle is left.
    pub fn new(positions: Vec<Vec3>, mut triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        check_vertices(&positions, &triangles)?;
        let topology = weld(&positions);
        triangles.retain(|corners| {
            let [a, b, c] = corners.map(|i| topology[i as usize]);
            a != b && b != c && c != a
        });
        if triangles.is_empty() {
            return Err(MeshError::Empty);
        }
        Ok(Self {
            positions,
            triangles,
            topology,
            ..Self::default()
        })
    }

    /// The mesh with a normal for each vertex; the caller sees to their unit length.
    ///
    /// # Errors
    /// [`MeshError::AttributeLength`] or [`MeshError::NotFinite`].
    pub fn with_normals(mut self, normals: Vec<Vec3>) -> Result<Self, MeshError> {
        self.check_length("normals", normals.len())?;
        check_finite(&normals, |n| n.is_finite())?;
        self.faces.clear();
        self.normals = normals;
        Ok(self)
    }

    /// The mesh with a linear RGBA color for each vertex.
    ///
    /// # Errors
    /// [`MeshError::AttributeLength`] or [`MeshError::NotFinite`].
    pub fn with_colors(mut self, colors: Vec<Vec4>) -> Result<Self, MeshError> {
        self.check_length("colors", colors.len())?;
        check_finite(&colors, |c| c.is_finite())?;
        self.faces.clear();
        self.colors = colors;
        Ok(self)
    }

    /// The mesh with texture coordinates for each vertex.
    ///
    /// # Errors
    /// [`MeshError::AttributeLength`] or [`MeshError::NotFinite`].
    pub fn with_uvs(mut self, uvs: Vec<Vec2>) -> Result<Self, MeshError> {
        self.check_length("uvs", uvs.len())?;
        check_finite(&uvs, |uv| uv.is_finite())?;
        self.faces.clear();
        self.uvs = uvs;
        Ok(self)
    }

    /// The mesh with a material slot for each of its [`triangles`](Self::triangles): which of a renderer's materials the
    /// triangle is drawn with.
    ///
    /// # Errors
    /// [`MeshError::MaterialLength`].
    pub fn with_materials(mut self, materials: Vec<u16>) -> Result<Self, MeshError> {
        let (found, triangles) = (materials.len(), self.triangles.len());
        if found != triangles {
            return Err(MeshError::MaterialLength { found, triangles });
        }
        self.faces.clear();
        self.materials = materials;
        Ok(self)
    }

    /// The mesh with its first `count` triangles as sheets: surfaces without an inside, which are cut but not capped.
    ///
    /// # Errors
    /// [`MeshError::TooManySheets`] if there are fewer triangles.
    pub fn with_sheets(mut self, count: usize) -> Result<Self, MeshError> {
        let triangles = self.triangles.len();
        if count > triangles {
            return Err(MeshError::TooManySheets { count, triangles });
        }
        self.faces.clear();
        self.sheets = count as u32;
        self.known_closed.clear();
        Ok(self)
    }

    fn check_length(&self, attribute: &'static str, found: usize) -> Result<(), MeshError> {
        let vertices = self.positions.len();
        if found == vertices {
            return Ok(());
        }
        Err(MeshError::AttributeLength {
            attribute,
            found,
            vertices,
        })
    }

    /// Positions, m.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Unit normals, one per vertex, or empty.
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Linear RGBA colors, one per vertex, or empty.
    pub fn colors(&self) -> &[Vec4] {
        &self.colors
    }

    /// Texture coordinates, one per vertex, or empty.
    pub fn uvs(&self) -> &[Vec2] {
        &self.uvs
    }

    /// Triangles as vertex indices, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Material slots, one per triangle, or empty.
    pub fn materials(&self) -> &[u16] {
        &self.materials
    }

    /// How many triangles, the first ones, are sheets: see [`with_sheets`](Self::with_sheets).
    pub fn sheets(&self) -> usize {
        self.sheets as usize
    }

    /// The triangles that are no sheets.
    pub(crate) fn solid(&self) -> &[[u32; 3]] {
        &self.triangles[self.sheets()..]
    }

    /// For each vertex the number of its position; vertices at the same position have the same number.
    pub fn topology(&self) -> &[u32] {
        &self.topology
    }

    /// The smallest box around the vertices.
    pub fn aabb(&self) -> Aabb {
        Aabb::of_points(self.positions.iter().copied())
    }

    /// The positions that triangles use, once for each vertex, in the order of the vertices.
    pub(crate) fn used_positions(&self) -> Vec<Vec3> {
        let mut used: Vec<u32> = self.triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let position = |vertex| self.positions[vertex as usize];
        used.into_iter().map(position).collect()
    }

    /// Checks that the surface, sheets left out, is closed: over [`topology`](Self::topology), each directed edge occurs exactly once and
    /// so does its reverse. A mesh remembers that it was found closed, and so do its copies; parts of a cut know from the
    /// start.
    ///
    /// # Errors
    /// [`MeshError::Open`] or [`MeshError::NonManifold`], whose `from` and `to` are vertex indices.
    pub fn check_closed(&self) -> Result<(), MeshError> {
        self.check_closed_with(&mut EdgeCensus::default())
    }

    /// As [`check_closed`](Self::check_closed), in the memory of `census`.
    pub(crate) fn check_closed_with(&self, census: &mut EdgeCensus) -> Result<(), MeshError> {
        if self.known_closed.is_set() {
            return Ok(());
        }
        if !census.is_closed(self.solid(), &self.topology, self.topology_count()) {
            self.find_open_edge()?;
        }
        self.known_closed.set();
        Ok(())
    }

    /// How many numbers of positions there are room for: the largest plus one.
    pub(crate) fn topology_count(&self) -> usize {
        self.topology.iter().max().map_or(0, |&t| t as usize + 1)
    }

    /// Names the first edge, in order of its ends' positions, that is open or used more than once.
    fn find_open_edge(&self) -> Result<(), MeshError> {
        let mut edges: Vec<HalfEdge> = (self.sheets()..self.triangles.len())
            .flat_map(|triangle| (0..3).map(move |corner| (triangle, corner)))
            .map(|(triangle, corner)| self.half_edge(triangle, corner))
            .collect();
        edges.sort_unstable();
        for run in edges.chunk_by(|a, b| a.ends == b.ends) {
            if let Some(again) = run
                .windows(2)
                .find(|pair| pair[0].reversed == pair[1].reversed)
            {
                let (from, to) = self.half_edge_vertices(&again[1]);
                let triangle = again[1].triangle as usize;
                return Err(MeshError::NonManifold { from, to, triangle });
            }
            if let [lone] = run {
                let (from, to) = self.half_edge_vertices(lone);
                let triangle = lone.triangle as usize;
                return Err(MeshError::Open { from, to, triangle });
            }
        }
        Ok(())
    }

    /// Whether the surface is closed; see [`check_closed`](Self::check_closed).
    pub fn is_closed(&self) -> bool {
        self.check_closed().is_ok()
    }

    fn half_edge(&self, triangle: usize, corner: usize) -> HalfEdge {
        let corners = self.triangles[triangle];
        let from = self.topology[corners[corner] as usize];
        let to = self.topology[corners[(corner + 1) % 3] as usize];
        HalfEdge {
            ends: [from.min(to), from.max(to)],
            reversed: from > to,
            triangle: triangle as u32,
            corner: corner as u8,
        }
    }

    fn half_edge_vertices(&self, edge: &HalfEdge) -> (u32, u32) {
        let corners = self.triangles[edge.triangle as usize];
        let corner = edge.corner as usize;
        (corners[corner], corners[(corner + 1) % 3])
    }

    /// Volume that what is no sheet encloses, m3; negative if the triangles face inwards. Means something only if the mesh is closed.
    ///
    /// Sums signed tetrahedra about the first vertex in `f64`, which keeps the sum exact far from the origin.
    pub fn volume(&self) -> f64 {
        let first = self.solid().first();
        let apex = first.map_or(DVec3::ZERO, |t| self.corner(t[0]));
        let six_volumes: f64 = (self.solid().iter())
            .map(|t| t.map(|v| self.corner(v)))
            .map(|[a, b, c]| (a - apex).dot((b - apex).cross(c - apex)))
            .sum();
        six_volumes / 6.0
    }

    /// Surface area, m2, summed in `f64`.
    pub fn area(&self) -> f64 {
        let corners = self.triangles.iter().map(|t| t.map(|v| self.corner(v)));
        let twice: f64 = corners.map(|[a, b, c]| (b - a).cross(c - a).length()).sum();
        0.5 * twice
    }

    fn corner(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize].as_dvec3()
    }

    /// The mesh moved by `pose`; the inner frame of `pose` is the one the mesh is in now.
    ///
    /// Which vertices count as one position stays as it was, even where rounding makes positions meet.
    pub fn transformed(mut self, pose: &Pose) -> Self {
        for position in &mut self.positions {
            *position = pose.transform_point(*position);
        }
        for normal in &mut self.normals {
            *normal = rotate(pose.rotation, *normal);
        }
        self
    }

    /// The mesh scaled about its origin by `factor` along x, y and z.
    ///
    /// # Errors
    /// [`MeshError::BadScale`] if a factor is not finite and positive, [`MeshError::NotFinite`] if a position overflows.
    pub fn scaled(mut self, factor: Vec3) -> Result<Self, MeshError> {
        if !(factor.is_finite() && factor.min_element() > 0.0) {
            return Err(MeshError::BadScale { factor });
        }
        for position in &mut self.positions {
            *position *= factor;
        }
        check_finite(&self.positions, |p| p.is_finite())?;
        // A normal is a cross product of edges, so it scales with the two other factors; only the direction counts.
        let cofactor = factor.max_element() / factor;
        for normal in &mut self.normals {
            *normal = (*normal * cofactor).normalize_or(*normal);
        }
        Ok(self)
    }
}

/// A directed edge of a triangle, ordered so that sorting puts an edge beside its reverse.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct HalfEdge {
    ends: [u32; 2],
    reversed: bool,
    triangle: u32,
    corner: u8,
}

/// Whether positions are finite and triangles name only such as are there.
///
/// # Errors
/// [`MeshError::NotFinite`] or [`MeshError::IndexOutOfRange`].
pub(crate) fn check_vertices(positions: &[Vec3], triangles: &[[u32; 3]]) -> Result<(), MeshError> {
    check_finite(positions, |p| p.is_finite())?;
    let vertices = positions.len();
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&index) = corners.iter().find(|&&i| i as usize >= vertices) {
            return Err(MeshError::IndexOutOfRange {
                triangle,
                index,
                vertices,
            });
        }
    }
    Ok(())
}

fn check_finite<T>(values: &[T], is_finite: impl Fn(&T) -> bool) -> Result<(), MeshError> {
    match values.iter().position(|value| !is_finite(value)) {
        Some(vertex) => Err(MeshError::NotFinite { vertex }),
        None => Ok(()),
    }
}
