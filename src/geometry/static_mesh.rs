//! `StaticMesh`: a level of triangles, shared and immutable, with a tree over them and what their edges are.

use crate::geometry::bvh::{tree_box, tree_of};
use crate::geometry::flat_ground::{FlatGround, FlatNodes};
use crate::geometry::level_edges::find_edges;
use crate::geometry::level_triangle::{EdgeKind, LevelTriangle};
use crate::geometry::mesh::check_vertices;
use crate::geometry::weld::weld;
use crate::geometry::wide_tree::WideTree;
use crate::geometry::{MeshError, TriMesh};
use crate::math::{Aabb, Plane};
use bevy_ecs::component::Component;
use glam::Vec3;
use obvhs::ploc::PlocSearchDistance;
use std::sync::Arc;

/// A triangle is degenerate whose height is less than this share of its longest edge.
const DEGENERATE: f64 = 1e-6;

/// A mesh of triangles that stand still or are moved by their velocity only: the ground, a house, a cave. Not for dynamic bodies.
///
/// Triangles are solid below: what is behind one does not collide with it, unless the mesh is
/// [two-sided](Self::two_sided). Shared and immutable, so cloning costs one reference count. Coordinates are meters in the
/// entity's frame.
#[derive(Clone, Debug, Component)]
#[component(summary_tick)]
pub struct StaticMesh(Arc<MeshLevel>);

#[derive(Clone)]
struct MeshLevel {
    /// In the order of the tree's leaves: what lies together stands together.
    triangles: Vec<LevelTriangle>,
    tree: WideTree,
    /// Where it is a plane.
    flat: FlatNodes,
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
        let mut level = MeshLevel::clone(&self.0);
        level.set_materials(materials);
        Ok(Self(Arc::new(level)))
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
        let triangles = self.in_order();
        let corners = triangles.iter().flat_map(|t| t.corners);
        let positions: Vec<Vec3> = corners.map(|corner| scale * corner).collect();
        let indices: Vec<[u32; 3]> = (0..triangles.len() as u32)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect();
        let mut level = Self::new(&positions, &indices)?.0;
        let scaled = Arc::make_mut(&mut level);
        for triangle in &mut scaled.triangles {
            triangle.index = triangles[triangle.index as usize].index;
        }
        scaled.left_out += self.0.left_out;
        scaled.is_two_sided = self.0.is_two_sided;
        scaled.set_materials(self.0.materials.clone());
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
        let mut tree = WideTree::of(&tree_of(&boxes, PlocSearchDistance::VeryLow));
        let order = tree.renumber().into_iter();
        let triangles: Vec<LevelTriangle> = order.map(|at| triangles[at as usize]).collect();
        let all = || triangles.iter().flat_map(|t| t.corners);
        let farthest = all().map(|p| p.length_squared()).fold(0.0, f32::max);
        Ok(Self(Arc::new(MeshLevel {
            aabb: Aabb::of_points(all()),
            radius: farthest.sqrt(),
            left_out: indices.len() - triangles.len(),
            is_two_sided: false,
            materials: Vec::new(),
            flat: FlatNodes::of(&triangles, &tree, |_| None),
            triangles,
            tree,
        })))
    }

    /// Its triangles as a mesh to draw, each with corners of its own.
    pub fn to_mesh(&self) -> TriMesh {
        let triangles = self.in_order();
        let corners = triangles.iter().map(|triangle| triangle.corners);
        let positions: Vec<Vec3> = corners.flatten().collect();
        let numbers: Vec<u32> = (0..positions.len() as u32).collect();
        // All of them are finite and have an area.
        let mesh = TriMesh::new(positions, numbers.as_chunks().0.to_vec()).unwrap_or_default();
        let slots = triangles.iter().map(|t| self.material_of(t.index));
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
        self.in_order().into_iter().map(|triangle| triangle.edges)
    }

    /// Its triangles in the order in which they were given.
    fn in_order(&self) -> Vec<LevelTriangle> {
        let mut triangles = self.0.triangles.clone();
        triangles.sort_unstable_by_key(|triangle| triangle.index);
        triangles
    }

    pub(crate) fn triangles(&self) -> &[LevelTriangle] {
        &self.0.triangles
    }

    /// The plane that a box sees of the level, if it sees nothing else; `is_by_slot`: and if it is of one material.
    pub(crate) fn flat_ground(&self, b: &Aabb, is_by_slot: bool) -> Option<FlatGround> {
        let level = &*self.0;
        let slot = |triangle: &LevelTriangle| match is_by_slot {
            true => self.material_of(triangle.index),
            false => None,
        };
        level.flat.ground(&level.triangles, &level.tree, b, slot)
    }

    /// Leaves are places in [`triangles`](Self::triangles).
    pub(crate) fn tree(&self) -> &WideTree {
        &self.0.tree
    }
}

impl MeshLevel {
    /// By number in the list that the mesh was made from.
    fn set_materials(&mut self, materials: Vec<u16>) {
        let slot = |triangle: &LevelTriangle| materials.get(triangle.index as usize).copied();
        self.flat = FlatNodes::of(&self.triangles, &self.tree, slot);
        self.materials = materials;
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
