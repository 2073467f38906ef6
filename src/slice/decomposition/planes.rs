//! Planes by which a solid that is not convex may be cut.
//!
//! A cut helps where it ends at an edge at which the surface is hollow: along one of the two faces there, or between them. Where all
//! edges are slightly hollow, as in a ring, planes across the principal axes divide it evenly.

use crate::geometry::TriMesh;
use crate::geometry::predicates::signed_distance;
use crate::mass::{VolumeIntegrals, principal_axes};
use crate::math::Plane;
use glam::{DVec3, Vec3};

/// Planes along hollow edges that are tried: those of the longest and deepest edges.
const MOST_ALONG_EDGES: usize = 24;

/// Sines of angles between faces below which an edge counts as flat.
const FLAT_EDGE: f64 = 1e-3;

/// Planes are the same if their normals differ by less, and their distances by less of the size.
const SAME: f32 = 1e-4;

/// Places across each axis, as shares of the extents.
const PLACES: [f32; 3] = [0.25, 0.5, 0.75];

/// A plane and how much of hollow edges it lies along.
struct Candidate {
    plane: Plane,
    weight: f64,
}

/// Planes to try; `along_edges_only` leaves out those across the axes, if there are others.
pub(super) fn candidates(mesh: &TriMesh, along_edges_only: bool) -> Vec<Plane> {
    let mut found = along_hollow_edges(mesh);
    found.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    found.truncate(MOST_ALONG_EDGES);
    let mut planes: Vec<Plane> = found.into_iter().map(|candidate| candidate.plane).collect();
    if !along_edges_only || planes.is_empty() {
        across_axes(mesh, &mut planes);
    }
    planes
}

fn position(mesh: &TriMesh, vertex: u32) -> Vec3 {
    mesh.positions()[vertex as usize]
}

fn normal_of(mesh: &TriMesh, triangle: u32) -> Option<DVec3> {
    let corners = mesh.triangles()[triangle as usize];
    let [a, b, c] = corners.map(|v| position(mesh, v).as_dvec3());
    (b - a).cross(c - a).try_normalize()
}

/// Both faces at each hollow edge and the plane between them, each plane once.
fn along_hollow_edges(mesh: &TriMesh) -> Vec<Candidate> {
    let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * mesh.triangles().len());
    for (triangle, corners) in (0..).zip(mesh.triangles()) {
        for k in 0..3 {
            let ends = [corners[k], corners[(k + 1) % 3]].map(|v| mesh.topology()[v as usize]);
            let ends = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            sides.push((ends, 4 * triangle + k as u32));
        }
    }
    sides.sort_unstable();
    let size = mesh.aabb().diagonal();
    let mut found: Vec<Candidate> = Vec::new();
    for edge in sides.chunk_by(|a, b| a.0 == b.0) {
        let &[(_, a), (_, b)] = edge else {
            continue;
        };
        let [Some(first), Some(second)] = [a, b].map(|side| normal_of(mesh, side / 4)) else {
            continue;
        };
        let corners = mesh.triangles()[(a / 4) as usize];
        let ends = [0, 1].map(|k| position(mesh, corners[(a as usize % 4 + k) % 3]));
        let along = (ends[1] - ends[0]).as_dvec3();
        // Counter-clockwise from outside: where the surface is hollow the second face rises over the first.
        let sine = -first.cross(second).dot(along.normalize_or_zero());
        if sine < FLAT_EDGE {
            continue;
        }
        let weight = along.length() * sine;
        for (normal, share) in [(first, 1.0), (second, 1.0), (first - second, 0.5)] {
            let plane = Plane::through(ends[0], normal.as_vec3());
            add(&mut found, plane, share * weight, SAME * size);
        }
    }
    found
}

/// Adds a plane, or its weight if it is there.
fn add(found: &mut Vec<Candidate>, plane: Plane, weight: f64, tolerance: f32) {
    if !(plane.normal.is_finite() && plane.offset.is_finite()) {
        return;
    }
    let is_same = |other: &Plane| {
        other.normal.distance(plane.normal) < SAME
            && (other.offset - plane.offset).abs() < tolerance
    };
    let flipped = |other: &Plane| is_same(&other.flipped());
    match found
        .iter_mut()
        .find(|known| is_same(&known.plane) || flipped(&known.plane))
    {
        Some(known) => known.weight += weight,
        None => found.push(Candidate { plane, weight }),
    }
}

/// Planes across the axes of the frame and the principal axes, through the centroid and at some places.
fn across_axes(mesh: &TriMesh, planes: &mut Vec<Plane>) {
    let integrals = VolumeIntegrals::of_mesh(mesh);
    let (_, frame) = principal_axes(integrals.inertia);
    let own = DVec3::AXES.map(|axis| (frame * axis).as_vec3());
    let is_new = |axis: &Vec3| axis.is_finite() && axis.abs().max_element() < 1.0 - SAME;
    let axes = Vec3::AXES.into_iter().chain(own.into_iter().filter(is_new));
    for axis in axes {
        let across = |offset: f32| Plane {
            normal: axis,
            offset,
        };
        let origin = across(0.0);
        let heights = mesh
            .positions()
            .iter()
            .map(|p| signed_distance(&origin, *p) as f32);
        let (low, high) = heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), at| {
            (low.min(at), high.max(at))
        });
        let places = PLACES.map(|share| low + share * (high - low));
        planes.extend(places.map(across));
        planes.push(across(axis.dot(integrals.centroid.as_vec3())));
    }
}
