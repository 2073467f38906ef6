//! Convex decomposition: known fewest counts, hollows that stay hollow, the bound on how far parts stick out, held against points by
//! brute force.
#![allow(
    clippy::disallowed_methods,
    reason = "what a test expects may differ in the last bit between platforms"
)]
#![allow(clippy::print_stdout, reason = "the test prints what it measured")]

#[path = "../common/mod.rs"]
mod common;

use common::dice::Dice;
use common::mesh_parts::{cuboid, extruded, joined, torus, voxels};

use bevy_cleave::geometry::{ConvexHull, HullError, MeshError, TriMesh, primitives};
use bevy_cleave::math::{Plane, Pose};
use bevy_cleave::slice::{
    ConvexPart, DecompositionError, DecompositionOptions, SliceOptions, decompose, slice_mesh,
    split_components,
};
use glam::{DVec3, Quat, Vec3};

fn parts_of(mesh: &TriMesh) -> Vec<ConvexPart> {
    decompose(mesh, DecompositionOptions::default()).unwrap()
}

/// How often a surface goes around a point, from the solid angles of its triangles.
fn winding(mesh: &TriMesh, point: DVec3) -> f64 {
    let angle = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions()[v as usize].as_dvec3() - point);
        let [la, lb, lc] = [a, b, c].map(DVec3::length);
        let down = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * a.dot(b.cross(c)).atan2(down)
    };
    mesh.triangles().iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// Distance of a point from a triangle: the least over the plane, the edges and the corners.
fn distance_to(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let on = |from: DVec3, to: DVec3| {
        let share = (point - from).dot(to - from) / (to - from).length_squared();
        point.distance(from + share.clamp(0.0, 1.0) * (to - from))
    };
    let border = on(a, b).min(on(b, c)).min(on(c, a));
    let normal = (b - a).cross(c - a).normalize();
    let foot = point - normal.dot(point - a) * normal;
    let is_over = [(a, b), (b, c), (c, a)]
        .iter()
        .all(|&(from, to)| normal.dot((to - from).cross(foot - from)) >= 0.0);
    if is_over {
        border.min(normal.dot(point - a).abs())
    } else {
        border
    }
}

/// Distance of a point from a solid, 0 inside.
fn distance(mesh: &TriMesh, point: DVec3) -> f64 {
    if winding(mesh, point) > 0.5 {
        return 0.0;
    }
    let corners = |t: &[u32; 3]| t.map(|v| mesh.positions()[v as usize].as_dvec3());
    let distances = mesh
        .triangles()
        .iter()
        .map(|t| distance_to(point, corners(t)));
    distances.fold(f64::INFINITY, f64::min)
}

fn is_in(hull: &ConvexHull, point: DVec3, tolerance: f64) -> bool {
    hull.faces().iter().all(|face| {
        let away = face.plane.normal.as_dvec3().dot(point) - f64::from(face.plane.offset);
        away <= tolerance
    })
}

/// A random point of a hull: on its surface every other time, where it is likely to stick out farthest.
fn point_of(hull: &ConvexHull, dice: &mut Dice) -> DVec3 {
    let mut corner = || hull.vertices()[dice.below(hull.vertices().len())].as_dvec3();
    let corners = [corner(), corner(), corner(), corner()];
    let count = 2 + dice.below(3);
    let weights: Vec<f64> = (0..count).map(|_| f64::from(dice.unit()) + 1e-3).collect();
    let sum: f64 = weights.iter().sum();
    (0..count).map(|k| corners[k] * weights[k] / sum).sum()
}

/// What holds for every decomposition: bounds as stated, nothing of the solid lost, volumes that add up, parts that are valid and hardly
/// overlap.
fn check(name: &str, mesh: &TriMesh, parts: &[ConvexPart], options: DecompositionOptions) {
    let size = f64::from(mesh.aabb().diagonal());
    let mut dice = Dice::new(17);
    for part in parts {
        part.hull.validate().unwrap();
        for _ in 0..400 {
            let point = point_of(&part.hull, &mut dice);
            let stated = f64::from(part.concavity) * size;
            let found = distance(mesh, point);
            assert!(
                found <= stated + 1e-5 * size,
                "{name}: {found} of {stated} at {point}"
            );
        }
        if parts.len() < options.max_parts {
            assert!(
                part.concavity <= options.max_concavity,
                "{name}: {}",
                part.concavity
            );
        }
    }
    let volume: f64 = parts.iter().map(|part| part.volume).sum();
    let error = (volume / mesh.volume() - 1.0).abs();
    assert!(error < 1e-4, "{name}: volume is off by {error}");
    let bounds = mesh.aabb();
    for _ in 0..2000 {
        let share = dice.vector(0.0, 1.0);
        let point = (bounds.min + share * bounds.extents()).as_dvec3();
        let is_covered = parts
            .iter()
            .any(|part| is_in(&part.hull, point, 1e-5 * size));
        assert!(
            is_covered || winding(mesh, point) < 0.5,
            "{name}: {point} is in no part"
        );
    }
}

fn checked(name: &str, mesh: &TriMesh, options: DecompositionOptions) -> Vec<ConvexPart> {
    let start = std::time::Instant::now();
    let parts = decompose(mesh, options).unwrap_or_else(|error| panic!("{name}: {error}"));
    let time = start.elapsed();
    check(name, mesh, &parts, options);
    let worst = parts.iter().map(|part| part.concavity).fold(0.0, f32::max);
    let hulls: f64 = parts.iter().map(|part| part.hull.volume()).sum();
    println!(
        "{name:>16}: {:5} triangles, {:2} parts, concavity {worst:.4}, volume of hulls {:.4}, {time:.1?}",
        mesh.triangles().len(),
        parts.len(),
        hulls / mesh.volume(),
    );
    parts
}

/// Cells from rows of text, top row first, two cells thick.
fn letter_of(rows: &[&str]) -> TriMesh {
    let mut cells = Vec::new();
    for (y, row) in rows.iter().rev().enumerate() {
        let solid = row.chars().enumerate().filter(|(_, c)| *c == '#');
        cells.extend(solid.flat_map(|(x, _)| [0, 1].map(|z| [x as i32, y as i32, z])));
    }
    voxels(&cells)
}

/// Boxes of cells, from one corner to the other.
fn boxes(list: &[[[i32; 3]; 2]]) -> TriMesh {
    let mut cells: Vec<[i32; 3]> = Vec::new();
    for [from, to] in list {
        for x in from[0]..to[0] {
            for y in from[1]..to[1] {
                cells.extend((from[2]..to[2]).map(|z| [x, y, z]));
            }
        }
    }
    cells.sort_unstable();
    cells.dedup();
    voxels(&cells)
}

fn table() -> TriMesh {
    let leg = |x: i32, z: i32| [[x, 0, z], [x + 1, 5, z + 1]];
    boxes(&[
        [[0, 5, 0], [8, 6, 6]],
        leg(0, 0),
        leg(7, 0),
        leg(0, 5),
        leg(7, 5),
    ])
}

fn cup() -> TriMesh {
    boxes(&[
        [[0, 0, 0], [6, 1, 6]],
        [[0, 1, 0], [1, 7, 6]],
        [[5, 1, 0], [6, 7, 6]],
        [[1, 1, 0], [5, 7, 1]],
        [[1, 1, 5], [5, 7, 6]],
    ])
}

#[test]
fn polygonal_shapes_have_the_fewest_parts() {
    let known: [(&str, TriMesh, usize); 13] = [
        ("box", boxes(&[[[0; 3], [3, 2, 1]]]), 1),
        (
            "sphere",
            primitives::icosphere(1.0, 3).unwrap().to_mesh(),
            1,
        ),
        ("L", letter_of(&["#...", "#...", "#...", "####"]), 2),
        ("T", letter_of(&["#####", "..#..", "..#..", "..#.."]), 2),
        ("U", letter_of(&["#..#", "#..#", "#..#", "####"]), 3),
        ("plus", letter_of(&[".#.", "###", ".#."]), 3),
        ("H", letter_of(&["#..#", "#..#", "####", "#..#", "#..#"]), 3),
        ("E", letter_of(&["####", "#...", "####", "#...", "####"]), 4),
        ("O", letter_of(&["#####", "#...#", "#...#", "#####"]), 4),
        ("stairs", letter_of(&["#...", "##..", "###.", "####"]), 4),
        ("table", table(), 5),
        ("cup", cup(), 5),
        (
            "two boxes",
            joined(&[
                (cuboid(Vec3::ONE, Vec3::ZERO), false),
                (cuboid(Vec3::ONE, 3.0 * Vec3::X), false),
            ]),
            2,
        ),
    ];
    let mut dice = Dice::new(5);
    for (name, mesh, fewest) in known {
        let turned = Pose::new(dice.vector(-3.0, 3.0), dice.rotation());
        for (mesh, name) in [
            (mesh.clone(), name.to_string()),
            (mesh.transformed(&turned), format!("{name} turned")),
        ] {
            let parts = checked(&name, &mesh, DecompositionOptions::default());
            assert_eq!(parts.len(), fewest, "{name}");
        }
    }
}

/// The letter R: a stem, a bow with a hole, a leg.
fn letter() -> TriMesh {
    let points = [
        [-0.3, -0.5],
        [-0.1, -0.5],
        [-0.1, -0.1],
        [-0.3, -0.1],
        [-0.1, 0.1],
        [-0.3, 0.1],
        [-0.1, 0.3],
        [-0.3, 0.3],
        [-0.1, 0.5],
        [-0.3, 0.5],
        [0.1, 0.3],
        [0.1, 0.5],
        [0.3, 0.4],
        [0.3, 0.1],
        [0.1, 0.1],
        [0.1, -0.1],
        [0.4, -0.5],
        [0.2, -0.5],
    ];
    let polygons: [&[u32]; 10] = [
        &[0, 1, 2, 3],
        &[3, 2, 4, 5],
        &[5, 4, 6, 7],
        &[7, 6, 8, 9],
        &[6, 10, 11, 8],
        &[10, 12, 11],
        &[14, 13, 12, 10],
        &[2, 15, 14, 4],
        &[15, 13, 14],
        &[2, 17, 16, 15],
    ];
    extruded(&points, &polygons, 0.1)
}

#[test]
fn a_letter_r_has_its_hole_and_no_more_than_six_parts() {
    let mesh = letter();
    let parts = checked(
        "R",
        &mesh,
        DecompositionOptions::default().with_max_concavity(0.01),
    );
    assert!(parts.len() <= 6, "{}", parts.len());
    for (x, y) in [(-0.08, 0.12), (0.0, 0.2), (0.08, 0.28), (-0.08, 0.28)] {
        let hole = DVec3::new(x, y, 0.0);
        assert!(
            !parts.iter().any(|part| is_in(&part.hull, hole, 0.0)),
            "{x} {y}"
        );
    }
}

/// A box that leaves a tenth of the walls' thickness free all around does not meet any part.
#[test]
fn something_fits_into_a_cup() {
    let parts = parts_of(&cup());
    let mut dice = Dice::new(9);
    for _ in 0..20_000 {
        let point = Vec3::new(1.1, 1.1, 1.1) + dice.vector(0.0, 1.0) * Vec3::new(3.8, 5.9, 3.8);
        let inside = parts
            .iter()
            .find(|part| is_in(&part.hull, point.as_dvec3(), 0.0));
        assert!(inside.is_none(), "{point}");
    }
}

#[test]
fn something_goes_through_an_arch_and_a_ring() {
    let arc = |k: u32, radius: f32| {
        let angle = std::f32::consts::PI * k as f32 / 12.0;
        [radius * angle.cos(), radius * angle.sin()]
    };
    let points: Vec<[f32; 2]> = (0..=12).flat_map(|k| [arc(k, 0.6), arc(k, 1.0)]).collect();
    let quads: Vec<[u32; 4]> = (0..12).map(|k| [0, 1, 3, 2].map(|i| 2 * k + i)).collect();
    let quads: Vec<&[u32]> = quads.iter().map(|quad| &quad[..]).collect();
    let arch = extruded(&points, &quads, 0.3);
    let parts = checked("arch", &arch, DecompositionOptions::default());
    assert!(parts.len() <= 8, "{}", parts.len());
    let is_free = |parts: &[ConvexPart], point: DVec3| {
        !parts.iter().any(|part| is_in(&part.hull, point, 0.0))
    };
    for k in 0..=100 {
        let z = -0.5 + 0.01 * f64::from(k);
        for (x, y) in [(0.0, 0.05), (0.0, 0.5), (0.4, 0.3), (-0.4, 0.3)] {
            assert!(is_free(&parts, DVec3::new(x, y, z)), "{x} {y} {z}");
        }
    }
    let ring = torus(1.0, 0.25, 32, 16);
    let parts = checked("ring", &ring, DecompositionOptions::default());
    assert!(parts.len() <= 9, "{}", parts.len());
    for k in 0..=100 {
        let y = -0.5 + 0.01 * f64::from(k);
        for (x, z) in [(0.0, 0.0), (0.6, 0.0), (0.0, -0.6), (0.42, 0.42)] {
            assert!(is_free(&parts, DVec3::new(x, y, z)), "{x} {y} {z}");
        }
    }
}

/// Cells that hang together, by chance, as one closed surface.
fn random_cells(dice: &mut Dice) -> TriMesh {
    loop {
        let mut cells: Vec<[i32; 3]> = vec![[0; 3]];
        while cells.len() < 12 {
            let mut next = cells[dice.below(cells.len())];
            next[dice.below(3)] += if dice.below(2) == 0 { 1 } else { -1 };
            if !cells.contains(&next) {
                cells.push(next);
            }
        }
        let mesh = voxels(&cells);
        if mesh.is_closed() && split_components(&mesh).len() == 1 {
            return mesh;
        }
    }
}

/// What a cut by a random plane leaves of a solid, its largest connected part.
fn random_piece(mesh: &TriMesh, dice: &mut Dice) -> TriMesh {
    let bounds = mesh.aabb();
    let point = bounds.center() + 0.2 * bounds.diagonal() * dice.vector(-0.5, 0.5);
    let plane = Plane::through(point, dice.direction());
    let cut = slice_mesh(mesh, plane, SliceOptions::default()).unwrap();
    let Some(halves) = cut.halves() else {
        return mesh.clone();
    };
    let parts = split_components(&halves.below).into_iter();
    parts
        .max_by(|a, b| a.volume().total_cmp(&b.volume()))
        .unwrap()
}

#[test]
fn random_solids_keep_to_the_stated_error() {
    let mut dice = Dice::new(31);
    for k in 0..24 {
        let whole = random_cells(&mut dice);
        let turned = whole.transformed(&Pose::new(dice.vector(-5.0, 5.0), dice.rotation()));
        let mesh = random_piece(&turned, &mut dice);
        let share = [0.005, 0.02, 0.05][k % 3];
        let options = DecompositionOptions::default().with_max_concavity(share);
        checked(&format!("cells {k}"), &mesh, options);
    }
    for k in 0..6 {
        let mesh = random_piece(&torus(1.0, 0.4, 20, 12), &mut dice);
        checked(
            &format!("piece of ring {k}"),
            &mesh,
            DecompositionOptions::default(),
        );
    }
}

#[test]
fn fewer_parts_may_be_asked_for_and_then_the_error_says_so() {
    let ring = torus(1.0, 0.25, 24, 12);
    let mut last = 0.0;
    for max_parts in [8, 4, 3, 2, 1] {
        let options = DecompositionOptions::default().with_max_parts(max_parts);
        let parts = checked(&format!("ring in {max_parts}"), &ring, options);
        assert!(parts.len() <= max_parts);
        let worst = parts.iter().map(|part| part.concavity).fold(0.0, f32::max);
        assert!(worst >= 0.9 * last, "{worst} after {last}");
        last = worst;
    }
    // The hull closes the hole, and on its faces the axis is 1 m sideways and 0.25 m up from the middle of the tube.
    let size = ring.aabb().diagonal();
    let farthest = 1.0625_f32.sqrt() - 0.25;
    assert!((last * size - farthest).abs() < 0.02, "{}", last * size);
}

#[test]
fn a_cavity_stays_hollow() {
    let shell = joined(&[
        (cuboid(Vec3::splat(2.0), Vec3::ZERO), false),
        (cuboid(Vec3::splat(1.6), Vec3::ZERO), true),
    ]);
    let parts = checked("shell", &shell, DecompositionOptions::default());
    assert!(!parts.iter().any(|part| is_in(&part.hull, DVec3::ZERO, 0.0)));
    assert_eq!(parts.len(), 6);
}

#[test]
fn the_same_solid_gives_the_same_parts() {
    let bits = |parts: &[ConvexPart]| -> Vec<u32> {
        let points = parts.iter().flat_map(|part| part.hull.vertices());
        points
            .flat_map(|v| v.to_array().map(f32::to_bits))
            .collect()
    };
    let mesh = letter();
    assert_eq!(bits(&parts_of(&mesh)), bits(&parts_of(&mesh)));
}

/// Scale and place do not matter.
#[test]
fn a_thousandth_and_a_thousandfold_of_a_table_have_its_parts() {
    for scale in [1e-3, 1e3] {
        let mesh = table().scaled(Vec3::splat(scale)).unwrap();
        let away = Pose::new(50.0 * scale * Vec3::ONE, Quat::IDENTITY);
        for mesh in [mesh.clone(), mesh.transformed(&away)] {
            assert_eq!(parts_of(&mesh).len(), 5, "{scale}");
        }
    }
}

#[test]
fn what_cannot_be_decomposed_says_why() {
    let options = DecompositionOptions::default();
    let cube = cuboid(Vec3::ONE, Vec3::ZERO);
    let open = TriMesh::new(cube.positions().to_vec(), cube.triangles()[1..].to_vec()).unwrap();
    let error = decompose(&open, options).unwrap_err();
    assert!(
        matches!(error, DecompositionError::Mesh(MeshError::Open { .. })),
        "{error}"
    );
    let inward = joined(&[(cube.clone(), true)]);
    let error = decompose(&inward, options).unwrap_err();
    assert!(
        matches!(error, DecompositionError::Mesh(MeshError::NoVolume { .. })),
        "{error}"
    );
    let nowhere = Pose::new(Vec3::new(f32::NAN, 0.0, 0.0), Quat::IDENTITY);
    let error = decompose(&cube.clone().transformed(&nowhere), options).unwrap_err();
    assert!(
        matches!(error, DecompositionError::Mesh(MeshError::NotFinite { .. })),
        "{error}"
    );
    let sheets = cube.clone().with_sheets(12).unwrap();
    assert!(decompose(&sheets, options).is_err());
    let flat = cube.clone().scaled(Vec3::new(1.0, 1e-6, 1.0)).unwrap();
    let error = decompose(&flat, options);
    assert!(
        matches!(error, Err(DecompositionError::Hull(HullError::Flat { .. }))),
        "{error:?}"
    );
    for options in [
        options.with_max_concavity(f32::NAN),
        options.with_max_concavity(-0.1),
        options.with_max_concavity(f32::INFINITY),
        options.with_max_parts(0),
    ] {
        let error = decompose(&cube, options).unwrap_err();
        assert!(
            matches!(error, DecompositionError::Options { .. }),
            "{error}"
        );
    }
    // Exact, as far as it can be: ends, within the parts that are allowed.
    let exact = options.with_max_concavity(0.0).with_max_parts(10);
    assert!(decompose(&torus(1.0, 0.3, 12, 8), exact).unwrap().len() <= 10);
}
