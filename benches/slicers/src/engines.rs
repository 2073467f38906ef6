//! The ways to slice a body into two closed, unconverged halves.

use crate::bodies::Body;
use bevy_cleave::geometry::{ConvexHull, TriMesh};
use bevy_cleave::mass::VolumeIntegrals;
use bevy_cleave::math::Plane;
use bevy_cleave::slice::{Cut, Halves, HullHalves, HullSlicer, MeshSlicer, SliceOptions, slice_hull, slice_mesh};
use bevy_cleave::testing::math::tangents;
use boolmesh::prelude::{Manifold, OpType, compute_boolean};
use glam::Vec3;
use parry3d::math::Vector;
use parry3d::query::SplitResult;
use parry3d::shape::{TriMesh as Parry, TriMeshFlags};
use std::hint::black_box;

/// One way to slice.
pub struct Engine<'a> {
    pub name: &'static str,
    /// Cuts the body by a plane; whether that gave two halves.
    pub slice: Box<dyn FnMut(&Plane) -> bool + 'a>,
}

impl<'a> Engine<'a> {
    fn new(name: &'static str, slice: impl FnMut(&Plane) -> bool + 'a) -> Self {
        Self { name, slice: Box::new(slice) }
    }
}

/// What the others are compared with.
pub const REFERENCE: &str = "parry3d 0.31, f32";

/// All engines that can cut `body`.
pub fn engines(body: &Body) -> Vec<Engine<'_>> {
    let mut engines = Vec::new();
    if let Some(hull) = &body.hull {
        engines.extend(hull_engines(hull));
    }
    engines.extend(mesh_engines(&body.mesh));
    engines.extend(parry_engines(&body.mesh));
    engines.push(boolmesh_engine(&body.mesh));
    engines
}

fn hull_engines(hull: &ConvexHull) -> [Engine<'_>; 3] {
    let (mut slicer, mut halves) = (HullSlicer::default(), HullHalves::copies_of(hull));
    let render_mesh = hull.to_mesh();
    [
        Engine::new("`HullSlicer::slice_into`: hulls, lanes and mass, kept memory", move |&plane| {
            let verdict = slicer.slice_into(black_box(hull), plane, &mut halves);
            black_box([&halves.below, &halves.above].map(VolumeIntegrals::of_hull));
            verdict == Ok(Cut::Cut(()))
        }),
        Engine::new("`slice_hull`: the same, new memory", move |&plane| {
            matches!(black_box(slice_hull(black_box(hull), plane)), Ok(Cut::Cut(_)))
        }),
        Engine::new("`slice_mesh`: with normals and texture coordinates of each face", move |&plane| {
            is_cut(slice_mesh(black_box(&render_mesh), plane, SliceOptions::default()))
        }),
    ]
}

/// The table-driven clip of the paper, which takes any closed mesh.
fn mesh_engines(mesh: &TriMesh) -> [Engine<'_>; 3] {
    let (mut slicer, mut halves) = (MeshSlicer::default(), Default::default());
    [
        Engine::new("`MeshSlicer::slice_into`: table-driven clip, kept memory", move |&plane| {
            let verdict = slicer.slice_into(black_box(mesh), plane, SliceOptions::default(), &mut halves);
            verdict == Ok(Cut::Cut(()))
        }),
        Engine::new("`slice_mesh`: the same, new memory", move |&plane| {
            is_cut(slice_mesh(black_box(mesh), plane, SliceOptions::default()))
        }),
        Engine::new("`TriMesh::new` and `slice_mesh`: the same with set-up", move |&plane| {
            let (positions, triangles) = (mesh.positions().to_vec(), mesh.triangles().to_vec());
            let mesh = TriMesh::new(positions, triangles).expect("a valid mesh");
            is_cut(slice_mesh(&mesh, plane, SliceOptions::default()))
        }),
    ]
}

fn is_cut<E>(slice: Result<Cut<Box<Halves>>, E>) -> bool {
    matches!(black_box(slice), Ok(Cut::Cut(_)))
}

fn parry_engines(mesh: &TriMesh) -> [Engine<'_>; 2] {
    let ready = parry_mesh(mesh);
    [
        Engine::new(REFERENCE, move |plane| parry_split(black_box(&ready), plane)),
        Engine::new("parry3d 0.31, f32, with set-up", move |plane| parry_split(&parry_mesh(mesh), plane)),
    ]
}

fn parry_mesh(mesh: &TriMesh) -> Parry {
    let positions = mesh.positions().iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
    Parry::with_flags(positions, mesh.triangles().to_vec(), TriMeshFlags::ORIENTED).expect("a valid mesh")
}

fn parry_split(mesh: &Parry, plane: &Plane) -> bool {
    let normal = Vector::new(plane.normal.x, plane.normal.y, plane.normal.z);
    let result = black_box(mesh.local_split(normal, plane.offset, 1e-6));
    matches!(result, SplitResult::Pair(..))
}

/// It has no cut by a plane: one half is the body without a large box on the plane, the other one what is in both.
fn boolmesh_engine(mesh: &TriMesh) -> Engine<'_> {
    let body = boolmesh_of(mesh.positions(), mesh.triangles().iter().copied());
    let size = mesh.aabb().diagonal();
    Engine::new("boolmesh 0.2.2 (Manifold's port), f64: difference and intersection with a box", move |plane| {
        let cutter = half_space(plane, mesh.aabb().center(), size);
        let half = |operation| compute_boolean(black_box(&body), &cutter, operation).is_ok_and(|part| part.nf > 0);
        half(OpType::Subtract) & half(OpType::Intersect)
    })
}

fn boolmesh_of(positions: &[Vec3], triangles: impl Iterator<Item = [u32; 3]>) -> Manifold {
    let positions: Vec<f64> = positions.iter().flat_map(|p| p.to_array()).map(f64::from).collect();
    let corners: Vec<usize> = triangles.flatten().map(|corner| corner as usize).collect();
    Manifold::new(&positions, &corners).expect("a manifold")
}

/// A box that has everything within `size` (m) of `center` above the plane, and nothing below it.
fn half_space(plane: &Plane, center: Vec3, size: f32) -> Manifold {
    let [u, v] = tangents(plane.normal).map(|axis| 2.0 * size * axis);
    let foot = center - plane.distance(center) * plane.normal;
    let base = [foot - u - v, foot + u - v, foot + u + v, foot - u + v];
    let top = base.map(|corner| corner + 4.0 * size * plane.normal);
    let sides = (0..4_u32).flat_map(|k| {
        let next = (k + 1) % 4;
        [[k, next, next + 4], [k, next + 4, k + 4]]
    });
    let ends = [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]];
    boolmesh_of(&[base, top].concat(), sides.chain(ends))
}
