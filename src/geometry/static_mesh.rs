//! `StaticMesh`: a level of triangles, shared and immutable, with a tree over them and what their edges are.

use crate::geometry::bvh::{tree_box, tree_of};
use crate::geometry::mesh::check_vertices;
use crate::geometry::weld::weld;
use crate::geometry::wide_tree::WideTree;
use crate::geometry::{MeshError, TriMesh};
use crate::math::{Aabb, Plane};
use bevy_ecs::component::Component;
use glam::Vec3;
use obvhs::ploc::PlocSearchDistance;
use std::sync::Arc;

/// Sine of the angle up to which two triangles at an edge are one plane.
const FLAT: f32 = 1e-3;

/// A triangle is degenerate whose height is less than this share of its longest edge.
const DEGENERATE: f64 = 1e-6;

/// What lies beyond an edge of a triangle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EdgeKind {
    /// A triangle in the same plane.
    Flat,
    /// A triangle that falls away.
    Convex,
    /// A triangle that rises.
    Concave,
    /// Nothing.
    #[default]
    Open,
}

impl EdgeKind {
    /// The same edge seen from the other side.
    pub(crate) fn mirrored(self) -> Self {
        match self {
            Self::Convex => Self::Concave,
            Self::Concave => Self::Convex,
            other => other,
        }
    }
}

/// A mesh of triangles that stand still or are moved by their velocity only: the ground, a house, a cave. Not for dynamic bodies.
///
/// Triangles are solid below: what is behind one does not collide with it, unless the mesh is
/// [two-sided](Self::two_sided). Shared and immutable, so cloning costs one reference count. Coordinates are meters in the
/// entity's frame.
#[derive(Clone, Debug, Component)]
#[component(summary_tick)]
pub struct StaticMesh(Arc<MeshLevel>);

/// A triangle as collision tests and questions read it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LevelTriangle {
    pub(crate) corners: [Vec3; 3],
    pub(crate) plane: Plane,
    /// Beyond the edges from each corner to the next.
    pub(crate) edges: [EdgeKind; 3],
    /// Its number in the list that the mesh was made from.
    pub(crate) index: u32,
}

#[derive(Clone)]
struct MeshLevel {
    triangles: Vec<LevelTriangle>,
    tree: WideTree,
    aabb: Aabb,
    radius: f32,
    left_out: usize,
    is_two_sided: bool,
    /// By number in the list that the mesh was made from; or empty.
    materials: Vec<u16>,
}

impl std::fmt::Debug for MeshLevel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MeshLevel")
            .field("triangles", &self.triangles.len())
            .field("left_out", &self.left_out)
            .field("aabb", &self.aabb)
            .field("is_two_sided", &self.is_two_sided)
            .finish_non_exhaustive()
    }
}

impl StaticMesh {
    /// A level from positions (m) and triangles (vertex indices, counter-clockwise seen from outside). Vertices at one position
    /// are one. Triangles without area are left out and counted ([`left_out`](Self::left_out)).
    ///
    /// # Errors
    /// [`MeshError::NotFinite`], [`MeshError::IndexOutOfRange`], or [`MeshError::Empty`] if no triangle has an area.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Result<Self, MeshError> {
        check_vertices(positions, triangles)?;
        Self::build(positions, triangles)
    }

    /// A level from a mesh, with its material slots.
    ///
    /// # Errors
    /// [`MeshError::Empty`] if no triangle has an area.
    pub fn from_mesh(mesh: &TriMesh) -> Result<Self, MeshError> {
        let level = Self::build(mesh.positions(), mesh.triangles())?;
        match mesh.materials() {
            [] => Ok(level),
            slots => level.with_materials(slots.into()),
        }
    }

    /// The same level with a material slot for each triangle of the list that it was made from, those that were left out among them:
    /// what is drawn there, and what `SurfaceMaterials` of the body say of it.
    ///
    /// # Errors
    /// [`MeshError::MaterialLength`] if it is another number of slots.
    pub fn with_materials(&self, materials: Vec<u16>) -> Result<Self, MeshError> {
        let (found, triangles) = (materials.len(), self.len() + self.left_out());
        if found != triangles {
            return Err(MeshError::MaterialLength { found, triangles });
        }
        Ok(Self(Arc::new(MeshLevel {
            materials,
            ..MeshLevel::clone(&self.0)
        })))
    }

    /// Whether its triangles have material slots.
    pub fn has_materials(&self) -> bool {
        !self.0.materials.is_empty()
    }

    /// The material slot of a triangle, by its number in the list that the mesh was made from, if it has one.
    pub fn material_of(&self, triangle: u32) -> Option<u16> {
        self.0.materials.get(triangle as usize).copied()
    }

    /// A terrain over a grid in x and z: `heights` (m, along y), row by row along z with `columns` in a row along x, `spacing` (m) apart,
    /// the first one over the origin.
    ///
    /// # Errors
    /// [`MeshError::NotFinite`] names the height; [`MeshError::Empty`] if there are not two rows and two columns, or the spacing is not
    /// positive.
    pub fn from_heights(heights: &[f32], columns: usize, spacing: f32) -> Result<Self, MeshError> {
        let rows = heights.len().checked_div(columns).unwrap_or(0);
        if rows < 2 || columns < 2 || !(spacing > 0.0 && spacing.is_finite()) {
            return Err(MeshError::Empty);
        }
        let place = |(i, &height): (usize, &f32)| {
            let (x, z) = (i % columns, i / columns);
            Vec3::new(x as f32 * spacing, height, z as f32 * spacing)
        };
        let positions: Vec<Vec3> = heights[..rows * columns]
            .iter()
            .enumerate()
            .map(place)
            .collect();
        let corner = |x: usize, z: usize| (z * columns + x) as u32;
        let cells = (0..rows - 1).flat_map(|z| (0..columns - 1).map(move |x| (x, z)));
        let triangles: Vec<[u32; 3]> = cells
            .flat_map(|(x, z)| {
                let [a, b] = [corner(x, z), corner(x + 1, z)];
                let [c, d] = [corner(x, z + 1), corner(x + 1, z + 1)];
                [[a, c, d], [a, d, b]]
            })
            .collect();
        Self::new(&positions, &triangles)
    }

    /// The same level, solid on both sides of each triangle: a sheet.
    pub fn two_sided(&self) -> Self {
        Self(Arc::new(MeshLevel {
            is_two_sided: true,
            ..MeshLevel::clone(&self.0)
        }))
    }

    /// The same level, scaled along the axes of its frame by positive factors.
    ///
    /// # Errors
    /// [`MeshError::Empty`] if no triangle has an area then, [`MeshError::NotFinite`] if a vertex is too far out.
    pub fn scaled(&self, scale: Vec3) -> Result<Self, MeshError> {
        let corners = self.0.triangles.iter().flat_map(|t| t.corners);
        let positions: Vec<Vec3> = corners.map(|corner| scale * corner).collect();
        let indices: Vec<[u32; 3]> = (0..self.0.triangles.len() as u32)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect();
        let mut level = Self::new(&positions, &indices)?.0;
        let scaled = Arc::make_mut(&mut level);
        for triangle in &mut scaled.triangles {
            triangle.index = self.0.triangles[triangle.index as usize].index;
        }
        scaled.left_out += self.0.left_out;
        scaled.is_two_sided = self.0.is_two_sided;
        scaled.materials.clone_from(&self.0.materials);
        Ok(Self(level))
    }

    /// Of indices that are in range.
    fn build(positions: &[Vec3], indices: &[[u32; 3]]) -> Result<Self, MeshError> {
        let topology = weld(positions);
        let mut triangles = Vec::with_capacity(indices.len());
        let mut corners = Vec::with_capacity(indices.len());
        for (index, vertices) in (0..).zip(indices) {
            let at = vertices.map(|v| positions[v as usize]);
            if let Some(plane) = plane_of(at) {
                triangles.push(LevelTriangle {
                    corners: at,
                    plane,
                    edges: [EdgeKind::Open; 3],
                    index,
                });
                corners.push(vertices.map(|v| topology[v as usize]));
            }
        }
        if triangles.is_empty() {
            return Err(MeshError::Empty);
        }
        find_edges(&mut triangles, &corners);
        let box_of = |t: &LevelTriangle| Aabb::of_points(t.corners);
        let boxes: Vec<_> = triangles.iter().map(|t| tree_box(&box_of(t))).collect();
        let tree = WideTree::of(&tree_of(&boxes, PlocSearchDistance::VeryLow));
        let all = || triangles.iter().flat_map(|t| t.corners);
        let farthest = all().map(|p| p.length_squared()).fold(0.0, f32::max);
        Ok(Self(Arc::new(MeshLevel {
            aabb: Aabb::of_points(all()),
            radius: farthest.sqrt(),
            left_out: indices.len() - triangles.len(),
            is_two_sided: false,
            materials: Vec::new(),
            triangles,
            tree,
        })))
    }

    /// Its triangles as a mesh to draw, each with corners of its own.
    pub fn to_mesh(&self) -> TriMesh {
        let corners = self.0.triangles.iter().map(|triangle| triangle.corners);
        let positions: Vec<Vec3> = corners.flatten().collect();
        let numbers: Vec<u32> = (0..positions.len() as u32).collect();
        // All of them are finite and have an area.
        let mesh = TriMesh::new(positions, numbers.as_chunks().0.to_vec()).unwrap_or_default();
        let slots = self.0.triangles.iter().map(|t| self.material_of(t.index));
        match slots.collect::<Option<Vec<u16>>>() {
            Some(slots) => mesh.with_materials(slots).unwrap_or_default(),
            None => mesh,
        }
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.0.triangles.len()
    }

    /// Whether there are none, which cannot be.
    pub fn is_empty(&self) -> bool {
        self.0.triangles.is_empty()
    }

    /// How many triangles had no area.
    pub fn left_out(&self) -> usize {
        self.0.left_out
    }

    /// Whether triangles are solid on both sides.
    pub fn is_two_sided(&self) -> bool {
        self.0.is_two_sided
    }

    /// Bounding box in the entity's frame.
    pub fn aabb(&self) -> Aabb {
        self.0.aabb
    }

    /// Largest distance from the origin of the entity's frame, m.
    pub fn radius(&self) -> f32 {
        self.0.radius
    }

    /// Whether two handles are the same shape in memory.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// What lies beyond the three edges of the triangles that were not left out, in order.
    pub fn edge_kinds(&self) -> impl Iterator<Item = [EdgeKind; 3]> + '_ {
        self.0.triangles.iter().map(|triangle| triangle.edges)
    }

    pub(crate) fn triangles(&self) -> &[LevelTriangle] {
        &self.0.triangles
    }

    /// Leaves are places in [`triangles`](Self::triangles).
    pub(crate) fn tree(&self) -> &WideTree {
        &self.0.tree
    }
}

/// The plane of a triangle; none if it has no area.
fn plane_of(corners: [Vec3; 3]) -> Option<Plane> {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    let normal = (b - a).cross(c - a);
    let longest = [b - a, c - b, a - c].map(|e| e.length_squared());
    let longest = longest.into_iter().fold(0.0, f64::max);
    let area = normal.length();
    let has_area = area > DEGENERATE * longest;
    has_area.then(|| {
        let rounded = (normal / area).as_vec3();
        let offset = rounded.as_dvec3().dot((a + b + c) / 3.0) as f32;
        Plane {
            normal: rounded,
            offset,
        }
    })
}

/// The sides of all triangles, sorted by the numbers of their ends, the smaller one first, and then by triangle: the larger end, and
/// four times the triangle and the side. Those whose smaller end is `v` begin at the `v`th number.
fn sides(corners: &[[u32; 3]]) -> (Vec<u32>, Vec<(u32, u32)>) {
    let ends = |of: &[u32; 3], side: usize| {
        let [from, to] = [of[side], of[(side + 1) % 3]];
        (from.min(to), from.max(to))
    };
    let vertices = corners
        .iter()
        .flatten()
        .max()
        .map_or(0, |&most| most as usize + 1);
    let mut starts = vec![0; vertices + 1];
    for of in corners {
        (0..3).for_each(|side| starts[ends(of, side).0 as usize + 1] += 1);
    }
    for v in 0..vertices {
        starts[v + 1] += starts[v];
    }
    let mut next = starts.clone();
    let mut sorted = vec![(0, 0); 3 * corners.len()];
    for (triangle, of) in (0..).zip(corners) {
        for side in 0..3 {
            let (low, high) = ends(of, side);
            let place = &mut next[low as usize];
            sorted[*place as usize] = (high, 4 * triangle + side as u32);
            *place += 1;
        }
    }
    for run in starts.windows(2) {
        sorted[run[0] as usize..run[1] as usize].sort_unstable();
    }
    (starts, sorted)
}

/// Finds out what lies beyond each edge. `corners` are numbers of positions.
fn find_edges(triangles: &mut [LevelTriangle], corners: &[[u32; 3]]) {
    let (starts, sides) = sides(corners);
    let runs = starts
        .windows(2)
        .map(|run| &sides[run[0] as usize..run[1] as usize]);
    for run in runs.flat_map(|run| run.chunk_by(|a, b| a.0 == b.0)) {
        for &(_, own) in run {
            let (triangle, edge) = ((own / 4) as usize, (own % 4) as usize);
            let opposite = corners[triangle][(edge + 2) % 3];
            let plane = triangles[triangle].plane;
            let mut kind = EdgeKind::Open;
            for &(_, other) in run.iter().filter(|other| other.1 / 4 != own / 4) {
                let (other, across) = ((other / 4) as usize, (other % 4) as usize);
                // The same triangle again, or one folded back, is no neighbor.
                if corners[other][(across + 2) % 3] == opposite {
                    continue;
                }
                let tip = triangles[other].corners[(across + 2) % 3];
                let ends = [across, (across + 1) % 3].map(|k| triangles[other].corners[k]);
                let length = (tip - ends[0]).length().max((tip - ends[1]).length());
                let rise = plane.distance(tip);
                kind = if rise > FLAT * length {
                    EdgeKind::Concave
                } else if rise >= -FLAT * length && kind != EdgeKind::Concave {
                    EdgeKind::Flat
                } else if kind == EdgeKind::Open {
                    EdgeKind::Convex
                } else {
                    kind
                };
            }
            triangles[triangle].edges[edge] = kind;
        }
    }
}
