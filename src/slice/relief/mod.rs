//! Relief of cut faces: cracks that look broken rather than sawn.
//!
//! All faces on one plane, of all pieces of a body, get one height for each node of one lattice of triangles (`lattice.rs`). Where
//! a node is too near to anything else of the pieces on both sides, the height is zero (`heights.rs`), so that the triangles of the lattice
//! which are moved lie within the faces of both sides, and are the same ones there. What is left of a face is a flat rim around
//! them (`patch.rs`), which each side may fill as it likes. So the two sides fit each other without a gap, volumes add up to
//! that of the whole, and rims, edges and corners stay where they were, whoever else has them.
//!
//! What the pieces are of (a convex cell or a statue) does not matter. Moved triangles are faces of their own, so that later cuts do not make them flat again.

mod heights;
mod lattice;
mod noise;
mod patch;
pub(crate) mod settings;

use crate::geometry::TriMesh;
use crate::geometry::predicates::{length_scale, plane_tolerance};
use crate::math::Plane;
use crate::slice::attributes;
use crate::slice::cap_planes::CapPlanes;
use heights::{Heights, corners_of};
use lattice::Lattice;
use patch::{Old, Patch, PatchMaker};
use settings::Relief;
use std::ops::Range;

/// How far planes that are one may be apart, in thicknesses of a plane: each side of a crack may have rounded its own.
const SAME_PLANE: f32 = 4.0;

/// Length of an edge of the lattice, in wavelengths.
const SPACING: f64 = 1.0 / 3.0;

/// Gives relief to cut faces, keeping its working memory.
#[derive(Clone, Debug, Default)]
pub(super) struct ReliefMaker {
    patches: PatchMaker,
    /// Triangles of caps: the plane that they are on, their mesh, their number.
    members: Vec<(u32, u32, u32)>,
    is_old: Vec<bool>,
}

impl ReliefMaker {
    /// Gives relief to the faces of `meshes` that are caps.
    pub(super) fn run(
        &mut self,
        meshes: &mut [&mut TriMesh],
        caps: &CapPlanes,
        relief: &Relief,
        seed: u64,
    ) {
        let boxes = meshes.iter().map(|mesh| length_scale(&mesh.aabb()));
        let size = boxes.fold(0.0, f32::max);
        let (plane_of, planes) = distinct_planes(caps, SAME_PLANE * plane_tolerance(size));
        self.find_members(meshes, caps, &plane_of);
        let members = std::mem::take(&mut self.members);
        let mut made: Vec<Vec<([u32; 2], Patch)>> = vec![Vec::new(); meshes.len()];
        let mut start = 0;
        for run in members.chunk_by(|a, b| a.0 == b.0) {
            let range = start..start + run.len();
            start = range.end;
            let plane = &planes[run[0].0 as usize];
            self.make_patches(meshes, (&members, range), plane, (relief, seed), &mut made);
        }
        for (mesh, patches) in meshes.iter_mut().zip(made) {
            if !patches.is_empty() {
                self.apply(mesh, &members, patches, caps.first_free());
            }
        }
        self.members = members;
    }

    /// Sorts the triangles of caps by their planes and meshes.
    fn find_members(&mut self, meshes: &[&mut TriMesh], caps: &CapPlanes, plane_of: &[u32]) {
        self.members.clear();
        for (number, mesh) in (0_u32..).zip(meshes) {
            for triangle in mesh.sheets..mesh.triangles.len() as u32 {
                let cap = caps.cap_of(mesh.faces.of(triangle));
                let member = cap.map(|cap| (plane_of[cap], number, triangle));
                self.members.extend(member);
            }
        }
        self.members.sort_unstable();
    }

    /// Makes the patches of all faces on one plane, or none if one of them cannot be made.
    fn make_patches(
        &mut self,
        meshes: &[&mut TriMesh],
        (members, range): (&[(u32, u32, u32)], Range<usize>),
        plane: &Plane,
        (relief, seed): (&Relief, u64),
        made: &mut [Vec<([u32; 2], Patch)>],
    ) {
        let own = &members[range.clone()];
        let corners = own
            .iter()
            .flat_map(|&(_, mesh, t)| corners_of(meshes[mesh as usize], t));
        let spacing = SPACING * f64::from(relief.wavelength);
        let lattice = Lattice::covering(plane, corners, spacing);
        let mut heights = Heights::new(&lattice, relief);
        let by_mesh = || own.chunk_by(|a, b| a.1 == b.1);
        for faces in by_mesh() {
            let mesh = &*meshes[faces[0].1 as usize];
            self.mark(mesh, faces);
            let all = mesh.sheets..mesh.triangles.len() as u32;
            for triangle in all.filter(|&t| !self.is_old[t as usize]) {
                heights.keep_off(&lattice, corners_of(mesh, triangle));
            }
        }
        heights.find(&lattice, relief, seed);
        let mut patches = Vec::new();
        let mut first = range.start as u32;
        for faces in by_mesh() {
            let number = faces[0].1 as usize;
            let mesh = &*meshes[number];
            self.mark(mesh, faces);
            let triangles: Vec<u32> = faces.iter().map(|face| face.2).collect();
            let edges: Vec<[u32; 2]> = (made[number].iter())
                .flat_map(|(_, patch)| &patch.triangles[..patch.flat])
                .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
                .filter(|ends| ends.iter().all(|&v| (v as usize) < mesh.positions.len()))
                .collect();
            let old = Old {
                mesh,
                triangles: &triangles,
                is_old: &self.is_old,
                made: &edges,
            };
            let Ok(patch) = self.patches.make(&old, &lattice, &heights) else {
                return;
            };
            let end = first + faces.len() as u32;
            patches.extend(patch.map(|patch| (number, [first, end], patch)));
            first = end;
        }
        for (number, own, patch) in patches {
            made[number].push((own, patch));
        }
    }

    /// Marks the triangles of a mesh that are some of `faces`.
    fn mark<'f>(&mut self, mesh: &TriMesh, faces: impl IntoIterator<Item = &'f (u32, u32, u32)>) {
        self.is_old.clear();
        self.is_old.resize(mesh.triangles.len(), false);
        for face in faces {
            self.is_old[face.2 as usize] = true;
        }
    }

    /// Puts patches in the place of the triangles that they were made for. New faces get numbers from `free` on.
    fn apply(
        &mut self,
        mesh: &mut TriMesh,
        members: &[(u32, u32, u32)],
        patches: Vec<([u32; 2], Patch)>,
        mut free: u32,
    ) {
        let of = |[first, end]: [u32; 2]| &members[first as usize..end as usize];
        self.mark(mesh, patches.iter().flat_map(|(own, _)| of(*own)));
        let mut sources: Vec<u32> = (0..mesh.triangles.len() as u32)
            .filter(|&t| !self.is_old[t as usize])
            .collect();
        let mut triangles: Vec<[u32; 3]> = sources
            .iter()
            .map(|&t| mesh.triangles[t as usize])
            .collect();
        let mut faces: Vec<u32> = sources.iter().map(|&t| mesh.faces.of(t)).collect();
        let old = mesh.positions.len() as u32;
        let mut number = mesh.topology_count() as u32;
        for (own, patch) in patches {
            let shift = mesh.positions.len() as u32 - old;
            let moved = |v: u32| if v < old { v } else { v + shift };
            triangles.extend(patch.triangles.iter().map(|t| t.map(moved)));
            let source = of(own)[0].2;
            sources.resize(triangles.len(), source);
            let face = mesh.faces.of(source);
            let is_one = of(own).iter().all(|other| mesh.faces.of(other.2) == face);
            for place in 0..patch.triangles.len() {
                if place < patch.flat && is_one {
                    faces.push(face);
                } else {
                    faces.push(free);
                    free += 1;
                }
            }
            let count = patch.vertices.positions.len();
            attributes::extend_chosen(mesh, &patch.vertices, &[], &patch.vertices, [count, 0]);
            mesh.topology.extend(number..number + count as u32);
            number += count as u32;
        }
        if !mesh.materials.is_empty() {
            let materials = sources.iter().map(|&t| mesh.materials[t as usize]);
            mesh.materials = materials.collect();
        }
        mesh.triangles = triangles;
        mesh.faces.0 = faces;
    }
}

/// Which caps are on one plane, whichever way it faces: for each cap the number of its plane, and the planes.
fn distinct_planes(caps: &CapPlanes, tolerance: f32) -> (Vec<u32>, Vec<Plane>) {
    let all: Vec<Plane> = caps.planes().collect();
    let mut order: Vec<u32> = (0..all.len() as u32).collect();
    let height = |cap: u32| all[cap as usize].offset.abs();
    order.sort_unstable_by(|&a, &b| height(a).total_cmp(&height(b)).then(a.cmp(&b)));
    let mut plane_of = vec![u32::MAX; all.len()];
    let mut planes: Vec<Plane> = Vec::new();
    // The first of the distinct planes, in the order of their heights, that may still be near.
    let mut first = 0;
    for cap in order {
        let plane = all[cap as usize];
        while planes
            .get(first)
            .is_some_and(|p| p.offset.abs() < height(cap) - tolerance)
        {
            first += 1;
        }
        let is_same = |other: &Plane| {
            let sign = 1.0_f32.copysign(other.normal.dot(plane.normal));
            // The normals of one plane differ by rounding only.
            other.normal.distance(sign * plane.normal) <= SAME_PLANE * plane_tolerance(1.0)
                && (other.offset - sign * plane.offset).abs() <= tolerance
        };
        let found = planes[first..].iter().position(is_same);
        plane_of[cap as usize] = match found {
            Some(place) => (first + place) as u32,
            None => {
                planes.push(plane);
                planes.len() as u32 - 1
            }
        };
    }
    (plane_of, planes)
}
