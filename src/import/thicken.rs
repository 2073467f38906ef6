//! Open surfaces that get a back and a rim.

use crate::geometry::TriMesh;
use crate::import::holes::Patch;
use crate::import::soup::{NONE, Soup};
use crate::slice::attributes::extend_chosen;
use glam::{DVec3, Vec3};

/// A back for an open surface with these triangles, `thickness` (m) behind it, and the rim between the two. Topology numbers
/// of new positions go on from `fresh`.
pub(super) fn back(soup: &Soup, triangles: &[u32], thickness: f32, fresh: u32) -> Patch {
    let mut sums = vec![DVec3::ZERO; soup.mesh.topology_count()];
    for &t in triangles {
        let [a, b, c] = soup.mesh.triangles[t as usize].map(|v| soup.position(v).as_dvec3());
        let area = (b - a).cross(c - a);
        for number in soup.places(t as usize) {
            sums[number as usize] += area;
        }
    }
    let mut chosen: Vec<u32> = triangles
        .iter()
        .flat_map(|&t| soup.mesh.triangles[t as usize])
        .collect();
    chosen.sort_unstable();
    chosen.dedup();
    let numbers = chosen
        .iter()
        .map(|&vertex| soup.mesh.topology[vertex as usize]);
    let mut numbers: Vec<u32> = numbers.collect();
    numbers.sort_unstable();
    numbers.dedup();
    let mut patch = Patch::default();
    let mesh = &mut patch.mesh;
    extend_chosen(mesh, &soup.mesh, &chosen, &TriMesh::default(), [0, 0]);
    for (position, &vertex) in mesh.positions.iter_mut().zip(&chosen) {
        let number = soup.mesh.topology[vertex as usize];
        let normal = sums[number as usize].normalize_or(DVec3::Y).as_vec3();
        *position -= thickness * normal;
        mesh.topology
            .push(fresh + numbers.partition_point(|&n| n < number) as u32);
    }
    mesh.normals
        .iter_mut()
        .for_each(|normal| *normal = -*normal);
    let back = |vertex: u32| chosen.partition_point(|&v| v < vertex) as u32;
    for &t in triangles {
        let [a, b, c] = soup.mesh.triangles[t as usize].map(back);
        mesh.triangles.push([a, c, b]);
        mesh.materials.extend(soup.mesh.materials.get(t as usize));
    }
    for half_edge in triangles.iter().flat_map(|&t| 3 * t..3 * t + 3) {
        let twin = soup.twins[half_edge as usize];
        if twin == NONE || triangles.binary_search(&(twin / 3)).is_err() {
            push_rim(soup, mesh, half_edge, back);
        }
    }
    patch
}

/// The rim at a border edge: two triangles with vertices of their own, between front and back.
fn push_rim(soup: &Soup, mesh: &mut TriMesh, half_edge: u32, back: impl Fn(u32) -> u32) {
    let [a, b] = soup.vertices(half_edge);
    let behind = [a, b].map(back);
    let first = mesh.positions.len() as u32;
    // The attributes are those of the front all around.
    extend_chosen(mesh, &soup.mesh, &[b, a, a, b], &TriMesh::default(), [0, 0]);
    mesh.topology
        .extend([b, a].map(|vertex| soup.mesh.topology[vertex as usize]));
    for (vertex, place) in behind.into_iter().zip(first as usize + 2..) {
        mesh.positions[place] = mesh.positions[vertex as usize];
        mesh.topology.push(mesh.topology[vertex as usize]);
    }
    let [p, q, r] = [first, first + 1, first + 2].map(|v| mesh.positions[v as usize]);
    let normal = (q - p).cross(r - p).normalize_or(Vec3::Y);
    if !mesh.normals.is_empty() {
        mesh.normals[first as usize..].fill(normal);
    }
    // From b to a along the front, from a to b along the back.
    mesh.triangles.push([first, first + 1, first + 2]);
    mesh.triangles.push([first, first + 2, first + 3]);
    let material = soup.mesh.materials.get(half_edge as usize / 3).copied();
    mesh.materials.extend(material);
    mesh.materials.extend(material);
}
