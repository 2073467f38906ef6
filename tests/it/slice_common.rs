//! The checks that every cut must pass.

#![allow(dead_code, reason = "each test file uses a part")]

use crate::common::dice::Dice;
use crate::models::model_mesh;
use bevy_cleave::geometry::{ConvexHull, TriMesh};
use bevy_cleave::math::{Aabb, Plane};
use bevy_cleave::slice::{Cut, Halves, HullHalves, Impact, SliceOptions, slice_hull, slice_mesh};
use bevy_cleave::testing::predicates::{length_scale, plane_tolerance, signed_distance};
use glam::{DVec3, Vec3};

/// The hull of a model, as every body made from it has.
pub(crate) fn model_hull(name: &str) -> ConvexHull {
    ConvexHull::from_points(model_mesh(name).positions()).unwrap()
}

/// Worst numbers of many cuts.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Worst {
    pub(crate) cuts: usize,
    pub(crate) missed: usize,
    pub(crate) volume_error: f64,
    pub(crate) cap_error: f64,
    /// Area of the cap against that of the hole it closes, over the square of the body's size.
    pub(crate) section_error: f64,
    /// Area of cap triangles that face the wrong way, over the square of the body's size.
    pub(crate) flipped: f64,
}

/// What is wrong with the surface of `mesh`, judged without the crate's own checks: each directed edge over topology
/// numbers must occur exactly once, and so must its reverse; equal numbers must be equal positions.
pub(crate) fn defect(mesh: &TriMesh) -> Option<String> {
    let (positions, topology) = (mesh.positions(), mesh.topology());
    let count = topology.iter().max().map_or(0, |&t| t as usize + 1);
    let mut place = vec![None; count];
    for (position, &number) in positions.iter().zip(topology) {
        let bits = position.to_array().map(f32::to_bits);
        if *place[number as usize].get_or_insert(bits) != bits || !position.is_finite() {
            return Some(format!("position {number} is in two places, or not finite"));
        }
    }
    // Directed edges in buckets by their first end.
    let mut first = vec![0_usize; count + 1];
    let corner = |v: u32| topology[v as usize] as usize;
    for &v in mesh.triangles().as_flattened() {
        first[corner(v) + 1] += 1;
    }
    for i in 0..count {
        first[i + 1] += first[i];
    }
    let mut fill = first.clone();
    let mut ends = vec![0_usize; 3 * mesh.triangles().len()];
    for triangle in mesh.triangles() {
        for k in 0..3 {
            let (from, to) = (corner(triangle[k]), corner(triangle[(k + 1) % 3]));
            if from == to {
                return Some(format!("triangle {triangle:?} has two equal corners"));
            }
            ends[fill[from]] = to;
            fill[from] += 1;
        }
    }
    for from in 0..count {
        let out = &ends[first[from]..first[from + 1]];
        for (i, &to) in out.iter().enumerate() {
            if out[..i].contains(&to) {
                return Some(format!("edge {from}-{to} occurs twice"));
            }
            if !ends[first[to]..first[to + 1]].contains(&from) {
                return Some(format!("edge {from}-{to} has no partner"));
            }
        }
    }
    None
}

/// Signed and absolute area of the last `count` triangles along `normal`.
fn cap_area(mesh: &TriMesh, count: usize, normal: Vec3) -> (f64, f64) {
    let triangles = &mesh.triangles()[mesh.triangles().len() - count..];
    let areas = triangles.iter().map(|t| {
        let [a, b, c] = t.map(|v| mesh.positions()[v as usize].as_dvec3());
        0.5 * (b - a).cross(c - a).dot(normal.as_dvec3())
    });
    areas.fold((0.0, 0.0), |(signed, absolute), area| {
        (signed + area, absolute + area.abs())
    })
}

/// Area along `normal` of the hole that is left in `mesh` without its last `count` triangles.
///
/// The triangles of a closed surface, as vectors of length area along their normals, sum to zero; so what those of an open
/// one lack is the vector of its hole, however that is filled.
fn hole_area(mesh: &TriMesh, count: usize, normal: Vec3) -> f64 {
    let apex = mesh.positions()[0].as_dvec3();
    let open = &mesh.triangles()[..mesh.triangles().len() - count];
    let sum: DVec3 = open
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| mesh.positions()[v as usize].as_dvec3() - apex);
            0.5 * (b - a).cross(c - a)
        })
        .sum();
    -sum.dot(normal.as_dvec3())
}

/// Cuts `mesh` and checks verdict, closedness, volumes and caps.
pub(crate) fn check_mesh_cut(
    mesh: &TriMesh,
    volume: f64,
    plane: Plane,
    worst: &mut Worst,
) -> Cut<Box<Halves>> {
    let slice = slice_mesh(mesh, plane, SliceOptions::default()).unwrap();
    let verdict = match slice {
        Cut::Below => [true, false],
        Cut::Above => [false, true],
        Cut::Cut(_) => [true, true],
    };
    assert_eq!(
        verdict,
        sides_of(mesh.positions(), &mesh.aabb(), &plane),
        "{plane:?}"
    );
    let Cut::Cut(halves) = &slice else {
        worst.missed += 1;
        return slice;
    };
    for half in [&halves.below, &halves.above] {
        assert_eq!(defect(half), None, "{plane:?}");
    }
    worst.cuts += 1;
    let sum = halves.below.volume() + halves.above.volume();
    worst.volume_error = worst.volume_error.max((sum - volume).abs() / volume);
    let count = halves.cap.triangles;
    let (below, absolute) = cap_area(&halves.below, count, plane.normal);
    let (above, _) = cap_area(&halves.above, count, -plane.normal);
    assert!(
        (below - halves.cap.area).abs() <= 1e-6 * absolute,
        "{plane:?}"
    );
    let scale = absolute.max(f64::MIN_POSITIVE);
    worst.cap_error = worst.cap_error.max((below - above).abs() / scale);
    let size = f64::from(length_scale(&mesh.aabb()));
    for hole in [
        hole_area(&halves.below, count, plane.normal),
        hole_area(&halves.above, count, -plane.normal),
    ] {
        let error = (halves.cap.area - hole).abs();
        worst.section_error = worst.section_error.max(error / (size * size));
    }
    worst.flipped = worst.flipped.max(0.5 * (absolute - below) / (size * size));
    slice
}

/// Whether there is anything below and above the plane, by brute force. A body that is all on the plane counts as above.
fn sides_of(points: &[Vec3], aabb: &Aabb, plane: &Plane) -> [bool; 2] {
    let tolerance = f64::from(plane_tolerance(length_scale(aabb)));
    let distances = || points.iter().map(|&p| signed_distance(plane, p));
    let below = distances().any(|d| d < -tolerance);
    let above = distances().any(|d| d > tolerance);
    [below, above || !below]
}

/// Cuts `hull` and checks verdict, validity and volumes.
pub(crate) fn check_hull_cut(
    hull: &ConvexHull,
    plane: Plane,
    worst: &mut Worst,
) -> Cut<Box<HullHalves>> {
    let slice = slice_hull(hull, plane).unwrap();
    let sides = sides_of(hull.vertices(), &hull.aabb(), &plane);
    let Cut::Cut(halves) = &slice else {
        let verdict = [slice == Cut::Below, slice == Cut::Above];
        assert_eq!(verdict, sides, "{plane:?}");
        worst.missed += 1;
        return slice;
    };
    assert_eq!(sides, [true, true], "{plane:?}");
    for half in [&halves.below, &halves.above] {
        assert_eq!(half.validate(), Ok(()), "{plane:?}");
    }
    worst.cuts += 1;
    let volume = hull.volume();
    let sum = halves.below.volume() + halves.above.volume();
    worst.volume_error = worst.volume_error.max((sum - volume).abs() / volume);
    let [below, above] = [&halves.below, &halves.above].map(last_face_area);
    let scale = below.length().max(f64::MIN_POSITIVE);
    worst.cap_error = worst.cap_error.max((below + above).length() / scale);
    slice
}

/// Vector area of the last face.
pub(crate) fn last_face_area(hull: &ConvexHull) -> DVec3 {
    let face = hull.faces().last().unwrap();
    let points: Vec<DVec3> = hull
        .face_loop(face)
        .iter()
        .map(|&v| hull.vertices()[v as usize].as_dvec3())
        .collect();
    points[1..]
        .windows(2)
        .map(|pair| 0.5 * (pair[0] - points[0]).cross(pair[1] - points[0]))
        .sum()
}

/// An impact on the surface of `hull`, towards its inside.
pub(crate) fn impact_on(hull: &ConvexHull, dice: &mut Dice) -> Impact {
    let face = &hull.faces()[dice.below(hull.faces().len())];
    let corners = hull.face_loop(face);
    let center: Vec3 = corners.iter().map(|&v| hull.vertices()[v as usize]).sum();
    Impact {
        point: center / corners.len() as f32,
        normal: -face.plane.normal,
        impulse: 1.0,
        energy: 1.0,
    }
}
