//! Pieces of one mesh that hang together, as meshes of their own.
//!
//! Triangles hang together across edges; two surfaces that share no more than a point are two. The wall of a cavity is a
//! surface of its own that encloses a negative volume; it belongs to the smallest surface around it. Sheets that hang on
//! nothing go with the nearest surface that encloses something.

use crate::disjoint_sets::DisjointSets;
use crate::geometry::TriMesh;
use crate::math::Aabb;
use crate::slice::attributes;
use crate::slice::edge_lists::EdgeLists;
use crate::slice::mesh_slicer::VertexNumbers;
use glam::{DVec3, Vec3};

/// The connected pieces of `mesh`, cavities with what they are in, attributes and material slots kept.
///
/// The pieces come in the order of their first triangles in `mesh`, and their triangles in the order in which they are
/// there. A mesh in one piece gives one mesh, without vertices that no triangle uses; a mesh without triangles none. The
/// pieces of a closed mesh are closed. A mesh that is open falls apart as well, but what its cavities are has no meaning.
pub fn split_components(mesh: &TriMesh) -> Vec<TriMesh> {
    meshes_of(mesh, &labels(mesh))
}

/// For each triangle the number of the piece that it is part of, which is that of the first surface of the piece.
pub(super) fn labels(mesh: &TriMesh) -> Vec<u32> {
    let mut labels = surfaces(mesh);
    let count = label_count(&labels);
    if count > 1 {
        let owners = owners(mesh, &labels, count);
        for label in &mut labels {
            *label = owners[*label as usize];
        }
        if mesh.sheets > 0 {
            attach_sheets(mesh, &mut labels, count);
        }
    }
    labels
}

/// The largest label plus one.
pub(super) fn label_count(labels: &[u32]) -> usize {
    labels.iter().max().map_or(0, |&last| last as usize + 1)
}

/// The triangles of each label as a mesh, in the order of the labels.
pub(super) fn meshes_of(mesh: &TriMesh, labels: &[u32]) -> Vec<TriMesh> {
    let mut numbers = VertexNumbers::default();
    (0..label_count(labels) as u32)
        .filter_map(|label| piece(mesh, labels, label, &mut numbers))
        .collect()
}

/// For each triangle the number of the surface that it is part of, counted in the order of first triangles.
fn surfaces(mesh: &TriMesh) -> Vec<u32> {
    let mut sets = DisjointSets::new(mesh.triangles.len());
    let mut first_on_edge = EdgeLists::default();
    first_on_edge.reset(mesh.topology_count());
    for (triangle, corners) in (0..).zip(&mesh.triangles) {
        let [a, b, c] = corners.map(|vertex| mesh.topology[vertex as usize]);
        for [from, to] in [[a, b], [b, c], [c, a]] {
            match first_on_edge.get(from, to) {
                Some(first) => sets.join(first, triangle),
                None => first_on_edge.insert(from, to, triangle),
            }
        }
    }
    // The root of a set is its first triangle, which is met before all others.
    let mut labels: Vec<u32> = Vec::with_capacity(mesh.triangles.len());
    let mut count = 0;
    for triangle in 0..mesh.triangles.len() as u32 {
        let root = sets.root(triangle);
        if root == triangle {
            labels.push(count);
            count += 1;
        } else {
            labels.push(labels[root as usize]);
        }
    }
    labels
}

/// For each surface the one that it goes with: itself, or for a cavity the smallest one around it.
fn owners(mesh: &TriMesh, labels: &[u32], count: usize) -> Vec<u32> {
    let mut volumes = vec![0.0; count];
    let mut first = vec![None; count];
    for (corners, &label) in mesh.solid().iter().zip(&labels[mesh.sheets()..]) {
        // About a corner of its own, so that a small surface far away keeps its sign.
        let apex = *first[label as usize].get_or_insert(position(mesh, corners[0]));
        let [a, b, c] = corners.map(|vertex| position(mesh, vertex) - apex);
        volumes[label as usize] += a.dot(b.cross(c));
    }
    (0..count)
        .map(|cavity| {
            let Some(probe) = first[cavity].filter(|_| volumes[cavity] < 0.0) else {
                return cavity as u32;
            };
            (0..count)
                .filter(|&outer| volumes[outer] > -volumes[cavity])
                .filter(|&outer| encloses(mesh, labels, outer as u32, probe))
                .min_by(|&a, &b| volumes[a].total_cmp(&volumes[b]))
                .unwrap_or(cavity) as u32
        })
        .collect()
}

/// Gives parts that are sheets only the label of the part whose box is nearest to theirs, if there is one with a solid.
fn attach_sheets(mesh: &TriMesh, labels: &mut [u32], count: usize) {
    let mut boxes = vec![Aabb::EMPTY; count];
    let mut is_solid = vec![false; count];
    for (triangle, (corners, &label)) in mesh.triangles.iter().zip(&*labels).enumerate() {
        is_solid[label as usize] |= triangle >= mesh.sheets();
        let around = &mut boxes[label as usize];
        for corner in corners.map(|vertex| mesh.positions[vertex as usize]) {
            around.min = around.min.min(corner);
            around.max = around.max.max(corner);
        }
    }
    let gap = |a: &Aabb, b: &Aabb| {
        let apart = (a.min - b.max).max(b.min - a.max).max(Vec3::ZERO);
        // Boxes that overlap are told apart by how far their centers are.
        (
            apart.length_squared(),
            a.center().distance_squared(b.center()),
        )
    };
    let owners: Vec<u32> = (0..count)
        .map(|label| {
            let solids = (0..count).filter(|&other| is_solid[other]);
            let nearest = solids.min_by(|&a, &b| {
                let [a, b] = [a, b].map(|other| gap(&boxes[label], &boxes[other]));
                a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
            });
            let owner = if is_solid[label] { None } else { nearest };
            owner.unwrap_or(label) as u32
        })
        .collect();
    for label in labels {
        *label = owners[*label as usize];
    }
}

fn position(mesh: &TriMesh, vertex: u32) -> DVec3 {
    mesh.positions[vertex as usize].as_dvec3()
}

/// Whether a ray along +x from `point` leaves surface number `label` once more often than it enters it.
pub(crate) fn encloses(mesh: &TriMesh, labels: &[u32], label: u32, point: DVec3) -> bool {
    let own = mesh.solid().iter().zip(&labels[mesh.sheets()..]);
    let crossed = own.filter(|&(corners, &l)| l == label && is_crossed(mesh, corners, point));
    crossed.count() % 2 == 1
}

/// Whether a ray along +x from `point` crosses a triangle.
///
/// Seen along x: whether a ray along +y crosses an odd number of its edges. An edge is evaluated from the end with the
/// smaller number, so that both its triangles agree about it.
fn is_crossed(mesh: &TriMesh, corners: &[u32; 3], p: DVec3) -> bool {
    let [a, b, c] = *corners;
    let crosses = |from: u32, to: u32| {
        let number = |vertex: u32| mesh.topology[vertex as usize];
        let [low, high] = if number(from) < number(to) {
            [from, to]
        } else {
            [to, from]
        };
        let (a, b) = (position(mesh, low), position(mesh, high));
        (a.z > p.z) != (b.z > p.z) && p.y < a.y + (p.z - a.z) / (b.z - a.z) * (b.y - a.y)
    };
    if !(crosses(a, b) ^ crosses(b, c) ^ crosses(c, a)) {
        return false;
    }
    let [a, b, c] = corners.map(|vertex| position(mesh, vertex));
    let normal = (b - a).cross(c - a);
    // On the triangle's plane at the point's y and z; the normal has an x, or the triangle would be a line seen along x.
    normal.dot(a - p) / normal.x > 0.0
}

/// The mesh without vertices and topology numbers that no triangle uses.
pub(crate) fn compacted(mesh: &TriMesh) -> TriMesh {
    let labels = vec![0; mesh.triangles.len()];
    piece(mesh, &labels, 0, &mut VertexNumbers::default()).unwrap_or_default()
}

/// The triangles with one label as a mesh.
fn piece(
    mesh: &TriMesh,
    labels: &[u32],
    label: u32,
    numbers: &mut VertexNumbers,
) -> Option<TriMesh> {
    let mut part = TriMesh::default();
    numbers.reset(mesh.positions.len());
    let chosen = (0..).zip(labels).filter(|&(_, &l)| l == label);
    for (triangle, _) in chosen {
        let triangle: usize = triangle;
        part.sheets += u32::from(triangle < mesh.sheets());
        part.triangles
            .push(mesh.triangles[triangle].map(|corner| numbers.of(corner)));
        part.materials.extend(mesh.materials.get(triangle));
        part.faces.0.extend(mesh.faces.0.get(triangle));
    }
    attributes::extend_chosen(
        &mut part,
        mesh,
        numbers.chosen(),
        &TriMesh::default(),
        [0, 0],
    );
    numbers.extend_topology(&mut part, mesh, &[], mesh.topology_count());
    if mesh.known_closed.is_set() {
        part.known_closed.set();
    }
    (!part.triangles.is_empty()).then_some(part)
}
