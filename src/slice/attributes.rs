//! Interpolation of vertex attributes on cut edges, and the attributes of the cap.

use crate::geometry::TriMesh;
use glam::{Vec2, Vec3, Vec4};

/// Appends a vertex on the edge from vertex `a` to vertex `b` of `mesh`, the fraction `t` of the way, and returns its
/// number.
///
/// Position and topology are given, because they belong to the edge of the surface and not to one of its attribute
/// vertices. Each attribute is `a + t (b - a)`, kept within the range of its two ends; the normal is scaled to unit
/// length.
pub(super) fn push_between(
    mesh: &mut TriMesh,
    [a, b]: [u32; 2],
    t: f32,
    position: Vec3,
    topology: u32,
) -> u32 {
    let (a, b) = (a as usize, b as usize);
    let number = mesh.positions.len() as u32;
    mesh.positions.push(position);
    mesh.topology.push(topology);
    if !mesh.normals.is_empty() {
        let (from, to) = (mesh.normals[a], mesh.normals[b]);
        // Opposite normals meet at zero; the nearer end's normal stands in.
        let nearer = if t < 0.5 { from } else { to };
        mesh.normals
            .push((from + t * (to - from)).normalize_or(nearer));
    }
    if !mesh.colours.is_empty() {
        let (from, to) = (mesh.colours[a], mesh.colours[b]);
        mesh.colours
            .push((from + t * (to - from)).clamp(from.min(to), from.max(to)));
    }
    if !mesh.uvs.is_empty() {
        let (from, to) = (mesh.uvs[a], mesh.uvs[b]);
        mesh.uvs
            .push((from + t * (to - from)).clamp(from.min(to), from.max(to)));
    }
    number
}

/// Appends the mean of some vertices of `mesh` as a vertex with the given `topology` number, and returns its number.
pub(super) fn push_mean(mesh: &mut TriMesh, vertices: &[u32], topology: u32) -> u32 {
    let weight = 1.0 / vertices.len() as f32;
    let number = mesh.positions.len() as u32;
    mesh.positions.push(mean(&mesh.positions, vertices, weight));
    mesh.topology.push(topology);
    if !mesh.normals.is_empty() {
        let first = mesh.normals[vertices[0] as usize];
        let normal = mean(&mesh.normals, vertices, weight).normalize_or(first);
        mesh.normals.push(normal);
    }
    if !mesh.colours.is_empty() {
        mesh.colours.push(mean(&mesh.colours, vertices, weight));
    }
    if !mesh.uvs.is_empty() {
        mesh.uvs.push(mean(&mesh.uvs, vertices, weight));
    }
    number
}

/// Mean of the chosen values.
fn mean<T>(values: &[T], chosen: &[u32], weight: f32) -> T
where
    T: Copy + Default + std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T>,
{
    chosen
        .iter()
        .map(|&vertex| values[vertex as usize] * weight)
        .fold(T::default(), |sum, value| sum + value)
}

/// Appends a copy of `source`'s vertex `vertex` with another topology number.
pub(super) fn push_copy(mesh: &mut TriMesh, source: &TriMesh, vertex: u32, topology: u32) {
    let v = vertex as usize;
    mesh.positions.push(source.positions[v]);
    mesh.topology.push(topology);
    if !source.normals.is_empty() {
        mesh.normals.push(source.normals[v]);
    }
    if !source.colours.is_empty() {
        mesh.colours.push(source.colours[v]);
    }
    if !source.uvs.is_empty() {
        mesh.uvs.push(source.uvs[v]);
    }
}

/// What the vertices of one cap have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct CapStyle {
    /// Outward unit normal of the cap.
    pub(super) normal: Vec3,
    /// Directions of the texture coordinates in the plane.
    pub(super) tangents: [Vec3; 2],
    /// Colour of the cap, or that of the rim.
    pub(super) colour: Option<Vec4>,
}

/// Appends a cap vertex at the place of `source`'s vertex `vertex`.
///
/// It has the cap's normal, texture coordinates in metres along the plane's tangents, and the colour of the rim unless
/// the style has another one.
pub(super) fn push_cap(
    mesh: &mut TriMesh,
    source: &TriMesh,
    vertex: u32,
    topology: u32,
    style: &CapStyle,
) {
    push_copy(mesh, source, vertex, topology);
    if let Some(normal) = mesh.normals.last_mut() {
        *normal = style.normal;
    }
    if let (Some(colour), Some(chosen)) = (mesh.colours.last_mut(), style.colour) {
        *colour = chosen;
    }
    if let Some(uv) = mesh.uvs.last_mut() {
        let position = source.positions[vertex as usize];
        let [u, v] = style.tangents;
        *uv = Vec2::new(u.dot(position), v.dot(position));
    }
}
