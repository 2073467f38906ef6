//! Interpolation of vertex attributes on cut edges, and the attributes of the cap.

use crate::geometry::TriMesh;
use crate::slice::CapNormals;
use glam::{Vec2, Vec3, Vec4};

/// Forgets vertices and triangles; keeps the memory.
pub(super) fn clear(mesh: &mut TriMesh) {
    let TriMesh {
        positions,
        normals,
        colors,
        uvs,
        triangles,
        materials,
        topology,
        sheets,
        faces,
        known_closed,
    } = mesh;
    positions.clear();
    normals.clear();
    colors.clear();
    uvs.clear();
    triangles.clear();
    materials.clear();
    topology.clear();
    *sheets = 0;
    faces.clear();
    known_closed.clear();
}

/// Appends to `target` a vertex on the edge from vertex `a` to vertex `b` of `source`, the fraction `t` of the way.
///
/// Position and topology are given, because they belong to the edge of the surface and not to one of its attribute
/// vertices. Each attribute is `a + t (b - a)`, kept within the range of its two ends; the normal is scaled to unit
/// length.
pub(crate) fn push_between(
    target: &mut TriMesh,
    source: &TriMesh,
    [a, b]: [u32; 2],
    t: f32,
    position: Vec3,
    topology: u32,
) {
    let (a, b) = (a as usize, b as usize);
    target.positions.push(position);
    target.topology.push(topology);
    if !source.normals.is_empty() {
        let (from, to) = (source.normals[a], source.normals[b]);
        // Opposite normals meet at zero; the nearer end's normal stands in.
        let nearer = if t < 0.5 { from } else { to };
        target
            .normals
            .push((from + t * (to - from)).normalize_or(nearer));
    }
    if !source.colors.is_empty() {
        let (from, to) = (source.colors[a], source.colors[b]);
        target
            .colors
            .push((from + t * (to - from)).clamp(from.min(to), from.max(to)));
    }
    if !source.uvs.is_empty() {
        let (from, to) = (source.uvs[a], source.uvs[b]);
        target
            .uvs
            .push((from + t * (to - from)).clamp(from.min(to), from.max(to)));
    }
}

/// The mean of some vertices, each given as a mesh and its place there, as a mesh of one vertex.
///
/// `vertices` are not empty, and their meshes have the same attributes.
pub(super) fn mean_vertex<'a>(
    vertices: impl ExactSizeIterator<Item = (&'a TriMesh, usize)>,
    topology: u32,
) -> MeanVertex {
    let weight = 1.0 / vertices.len() as f32;
    let mut mean = MeanVertex {
        topology,
        ..MeanVertex::default()
    };
    for (mesh, place) in vertices {
        mean.position += mesh.positions[place] * weight;
        add_mean(&mut mean.normal, &mesh.normals, place, weight);
        add_mean(&mut mean.color, &mesh.colors, place, weight);
        add_mean(&mut mean.uv, &mesh.uvs, place, weight);
        mean.first_normal = mean.first_normal.or(mesh.normals.get(place).copied());
    }
    mean
}

fn add_mean<T>(sum: &mut Option<T>, values: &[T], place: usize, weight: f32)
where
    T: Copy + Default + std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T>,
{
    if let Some(&value) = values.get(place) {
        *sum = Some(sum.unwrap_or_default() + value * weight);
    }
}

/// A vertex that is the mean of others, with those attributes that they have.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MeanVertex {
    topology: u32,
    position: Vec3,
    normal: Option<Vec3>,
    /// Stands in for the mean of normals that cancel.
    first_normal: Option<Vec3>,
    color: Option<Vec4>,
    uv: Option<Vec2>,
}

impl MeanVertex {
    /// Appends the vertex to `mesh`.
    pub(super) fn push_to(&self, mesh: &mut TriMesh) {
        mesh.positions.push(self.position);
        mesh.topology.push(self.topology);
        let first = self.first_normal.unwrap_or_default();
        mesh.normals
            .extend(self.normal.map(|normal| normal.normalize_or(first)));
        mesh.colors.extend(self.color);
        mesh.uvs.extend(self.uv);
    }
}

/// Appends the vertices `chosen` of `old` and the first `count` of `new`, with those attributes that `old` has, but
/// without topology numbers. Room for `more` vertices is made as well.
pub(crate) fn extend_chosen(
    mesh: &mut TriMesh,
    old: &TriMesh,
    chosen: &[u32],
    new: &TriMesh,
    [count, more]: [usize; 2],
) {
    fn extend<T: Copy>(
        target: &mut Vec<T>,
        old: &[T],
        chosen: &[u32],
        new: &[T],
        [count, more]: [usize; 2],
    ) {
        if !old.is_empty() {
            target.reserve(chosen.len() + count + more);
            target.extend(chosen.iter().map(|&vertex| old[vertex as usize]));
            target.extend_from_slice(&new[..count]);
        }
    }
    let counts = [count, more];
    extend(
        &mut mesh.positions,
        &old.positions,
        chosen,
        &new.positions,
        counts,
    );
    extend(
        &mut mesh.normals,
        &old.normals,
        chosen,
        &new.normals,
        counts,
    );
    extend(&mut mesh.colors, &old.colors, chosen, &new.colors, counts);
    extend(&mut mesh.uvs, &old.uvs, chosen, &new.uvs, counts);
}

/// What the vertices of one cap have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct CapStyle {
    /// Outward unit normal of the cap.
    pub(super) normal: Vec3,
    /// Whether the vertices have that normal.
    pub(super) normals: CapNormals,
    /// Directions of the texture coordinates in the plane.
    pub(super) tangents: [Vec3; 2],
    /// Color of the cap, or that of the rim.
    pub(super) color: Option<Vec4>,
}

/// Appends a cap vertex at the place of vertex `place` of `source`, with the attributes that `mesh` has.
///
/// It has the cap's normal or the rim's, texture coordinates in metres along the plane's tangents, and the color of the
/// rim unless the style has another one.
pub(super) fn push_cap(
    mesh: &mut TriMesh,
    source: &TriMesh,
    place: usize,
    topology: u32,
    style: &CapStyle,
) {
    let position = source.positions[place];
    mesh.positions.push(position);
    mesh.topology.push(topology);
    if let Some(&normal) = source.normals.get(place) {
        mesh.normals.push(match style.normals {
            CapNormals::Flat => style.normal,
            CapNormals::Smooth => normal,
        });
    }
    mesh.colors
        .extend(style.color.or(source.colors.get(place).copied()));
    if !source.uvs.is_empty() {
        let [u, v] = style.tangents;
        mesh.uvs.push(Vec2::new(u.dot(position), v.dot(position)));
    }
}
