//! Cuts of closed meshes that are not convex, against areas and volumes that are known: holes in caps, cavities, several
//! pieces, handles.
#![allow(
    clippy::disallowed_methods,
    reason = "shapes of tests may differ in the last bit between platforms"
)]

use crate::common::dice::Dice;
use crate::common::mesh_parts::{cuboid, joined, torus, voxels};
use crate::models::{closed_models, model_mesh};
use crate::slice_common::{Worst, check_mesh_cut, defect};
use allocation_counter::measure;
use bevy_cleave::geometry::{MeshError, TriMesh, primitives};
use bevy_cleave::math::Plane;
use bevy_cleave::slice::{
    CapNormals, Halves, MeshSlicer, SliceOptions, slice_mesh, split_components,
};
use glam::{Vec2, Vec3, Vec4};

/// Relative error of an area or a volume that is known.
const EXACT: f64 = 1e-6;

/// Cuts, checks everything that every cut must satisfy, and the area and number of loops of the cap.
fn cut(mesh: &TriMesh, plane: Plane, area: f64, loops: usize) -> Halves {
    let mut worst = Worst::default();
    let slice = check_mesh_cut(mesh, mesh.volume(), plane, &mut worst);
    let halves = slice.halves().unwrap();
    assert!(worst.volume_error <= EXACT, "{worst:?}");
    assert!(worst.flipped <= 1e-8, "{worst:?}");
    assert_eq!(halves.cap.loops, loops);
    let error = (halves.cap.area - area).abs() / area;
    assert!(error <= EXACT, "area {} is not {area}", halves.cap.area);
    halves
}

/// Area of a regular polygon.
fn polygon_area(corners: u32, circumradius: f64) -> f64 {
    let angle = std::f64::consts::TAU / f64::from(corners);
    0.5 * f64::from(corners) * circumradius * circumradius * angle.sin()
}

#[test]
fn torus_cut_along_its_axis_has_two_discs() {
    let ring = torus(2.0, 0.5, 40, 24);
    // Half way between two rows of vertices the section is the polygon of a row, narrowed along the radius by the cosine
    // of half a step.
    let half_step = 0.5 * std::f64::consts::TAU / 40.0;
    let area = 2.0 * polygon_area(24, 0.5) * half_step.cos();
    let (sin, cos) = half_step.sin_cos();
    let normal = Vec3::new(-sin as f32, 0.0, cos as f32);
    let halves = cut(&ring, Plane::through(Vec3::ZERO, normal), area, 2);
    assert_eq!(split_components(&halves.below).len(), 1);
    // Through vertices, it is the polygon itself.
    let halves = cut(
        &ring,
        Plane::through(Vec3::ZERO, Vec3::Z),
        2.0 * polygon_area(24, 0.5),
        2,
    );
    assert!((halves.below.volume() - halves.above.volume()).abs() <= EXACT * ring.volume());
}

#[test]
fn torus_cut_across_its_axis_is_an_annulus() {
    let ring = torus(2.0, 0.5, 40, 24);
    // A row of vertices lies on the plane on either side.
    let area = polygon_area(40, 2.5) - polygon_area(40, 1.5);
    let plane = Plane::through(Vec3::ZERO, Vec3::Y);
    let halves = cut(&ring, plane, area, 2);
    for half in [&halves.below, &halves.above] {
        assert_eq!(split_components(half).len(), 1);
    }
}

#[test]
fn hollow_box_has_a_frame_for_a_cap() {
    let outer = cuboid(Vec3::new(2.0, 3.0, 4.0), Vec3::ZERO);
    let cavity = cuboid(Vec3::new(1.0, 1.5, 3.0), Vec3::new(0.1, -0.2, 0.3));
    let hollow = joined(&[(&outer, false), (&cavity, true)]);
    assert!((hollow.volume() - (24.0 - 4.5)).abs() < 1e-5);
    let halves = cut(&hollow, Plane::through(Vec3::ZERO, Vec3::Y), 8.0 - 3.0, 2);
    for half in [&halves.below, &halves.above] {
        assert_eq!(split_components(half).len(), 1);
    }
    // Beside the cavity the cap has no hole, and the cavity stays where it is.
    let halves = cut(
        &hollow,
        Plane::through(Vec3::new(0.0, 1.0, 0.0), Vec3::Y),
        8.0,
        1,
    );
    let below = split_components(&halves.below);
    assert_eq!(below.len(), 1, "a cavity is no piece");
    assert!((below[0].volume() - (2.5 * 8.0 - 4.5)).abs() < 1e-5);
}

#[test]
fn nested_shells_have_nested_borders_and_come_apart() {
    // A box in a box in a box, each in the cavity of the last; sizes 6, 5 | 4, 3 | 2.
    let boxes: Vec<TriMesh> = (2..=6)
        .map(|size| cuboid(Vec3::splat(size as f32), Vec3::ZERO))
        .collect();
    let parts = [
        (&boxes[4], false),
        (&boxes[3], true),
        (&boxes[2], false),
        (&boxes[1], true),
        (&boxes[0], false),
    ];
    let shells = joined(&parts);
    let area = 36.0 - 25.0 + 16.0 - 9.0 + 4.0;
    let plane = Plane::through(Vec3::new(0.1, 0.05, 0.0), Vec3::X);
    let halves = cut(&shells, plane, area, 5);
    for half in [&halves.below, &halves.above] {
        let pieces = split_components(half);
        assert_eq!(pieces.len(), 3);
        for piece in &pieces {
            assert_eq!(defect(piece), None);
        }
        let sum: f64 = pieces.iter().map(TriMesh::volume).sum();
        assert!((sum - half.volume()).abs() <= EXACT * half.volume());
    }
    let volumes: Vec<f64> = split_components(&shells)
        .iter()
        .map(TriMesh::volume)
        .collect();
    for (volume, expected) in volumes.iter().zip([216.0 - 125.0, 64.0 - 27.0, 8.0]) {
        assert!((volume - expected).abs() < 1e-4, "{volumes:?}");
    }
}

#[test]
fn u_shape_cut_across_both_legs_makes_three_pieces() {
    let legs = voxels(&[
        [0, 0, 0],
        [1, 0, 0],
        [2, 0, 0],
        [0, 1, 0],
        [0, 2, 0],
        [2, 1, 0],
        [2, 2, 0],
    ]);
    let halves = cut(
        &legs,
        Plane::through(Vec3::new(0.0, 1.7, 0.0), Vec3::Y),
        2.0,
        2,
    );
    let (base, tips) = (
        split_components(&halves.below),
        split_components(&halves.above),
    );
    assert_eq!((base.len(), tips.len()), (1, 2));
    for tip in &tips {
        assert_eq!(defect(tip), None);
        assert!((tip.volume() - 1.3).abs() < 1e-5);
    }
    assert!((base[0].volume() - (3.0 + 2.0 * 0.7)).abs() < 1e-5);
}

#[test]
fn two_handles_are_cut_flat_and_across() {
    // An eight: two holes side by side, genus 2.
    let rows = [[1; 5], [1, 0, 1, 0, 1], [1; 5]];
    let mut cells = Vec::new();
    for (z, row) in (0..).zip(rows) {
        for (x, is_solid) in (0..).zip(row) {
            if is_solid == 1 {
                cells.push([x, 0, z]);
            }
        }
    }
    let eight = voxels(&cells);
    let flat = Plane::through(Vec3::new(0.0, 0.3, 0.0), Vec3::Y);
    cut(&eight, flat, 13.0, 3);
    let across = Plane::through(Vec3::new(0.0, 0.0, 1.5), Vec3::Z);
    let halves = cut(&eight, across, 3.0, 3);
    assert_eq!(split_components(&halves.below).len(), 1);
    // Along the walls of the holes: faces lie on the plane.
    let along = Plane::through(Vec3::new(0.0, 0.0, 1.0), Vec3::Z);
    cut(&eight, along, 3.0, 3);
}

#[test]
fn random_planes_cut_shapes_with_handles_and_cavities() {
    let outer = cuboid(Vec3::new(2.0, 3.0, 4.0), Vec3::ZERO);
    let ring = torus(0.9, 0.05, 30, 12);
    let shapes = [
        torus(2.0, 0.5, 40, 24),
        joined(&[(&outer, false), (&ring, true)]),
        voxels(&[
            [0, 0, 0],
            [1, 0, 0],
            [0, 1, 0],
            [0, 0, 1],
            [1, 1, 1],
            [0, 1, 1],
            [1, 0, 1],
        ]),
    ];
    for (index, mesh) in shapes.iter().enumerate() {
        let (mut dice, mut worst) = (Dice::new(31), Worst::default());
        for _ in 0..1000 {
            let plane = dice.plane_through(mesh.positions());
            check_mesh_cut(mesh, mesh.volume(), plane, &mut worst);
        }
        assert!(worst.volume_error <= EXACT, "{index}: {worst:?}");
        assert!(worst.section_error <= 6e-8, "{index}: {worst:?}");
        assert!(worst.flipped <= 1e-8, "{index}: {worst:?}");
    }
}

#[test]
fn components_of_cut_models_are_closed_and_add_up() {
    for name in closed_models() {
        let mesh = model_mesh(name);
        let mut dice = Dice::new(32);
        for _ in 0..20 {
            let plane = dice.plane_through(mesh.positions());
            let slice = slice_mesh(&mesh, plane, SliceOptions::default()).unwrap();
            let Some(halves) = slice.halves() else {
                continue;
            };
            for half in [&halves.below, &halves.above] {
                let pieces = split_components(half);
                let count: usize = pieces.iter().map(|piece| piece.triangles().len()).sum();
                assert_eq!(count, half.triangles().len(), "{name}");
                for piece in &pieces {
                    assert_eq!(defect(piece), None, "{name}");
                }
                let sum: f64 = pieces.iter().map(TriMesh::volume).sum();
                assert!(
                    (sum - half.volume()).abs() <= EXACT * mesh.volume(),
                    "{name}"
                );
                assert_eq!(pieces, split_components(half), "{name}: the same again");
            }
        }
    }
}

/// A cube with all attributes and two material slots.
fn dressed_cube() -> TriMesh {
    let mesh = primitives::cuboid(1.0, 1.0, 1.0).unwrap().to_mesh();
    let colors = mesh.positions().iter().map(|p| (p + 0.5).extend(1.0));
    let colors = colors.collect();
    let slots = (0..mesh.triangles().len() as u16).map(|t| t % 2).collect();
    mesh.with_colors(colors)
        .unwrap()
        .with_materials(slots)
        .unwrap()
}

#[test]
fn material_slots_survive_repeated_cuts() {
    let (mut dice, mut slicer) = (Dice::new(33), MeshSlicer::default());
    let mut pieces = vec![dressed_cube()];
    for generation in 0..6 {
        let options = SliceOptions {
            cap_material: Some(10 + generation),
            ..SliceOptions::default()
        };
        let plane = Plane::through(dice.vector(-0.2, 0.2), dice.direction());
        let mut parts = Vec::new();
        for piece in pieces {
            match slicer.slice(&piece, plane, options).unwrap().halves() {
                Some(halves) => parts.extend([halves.below, halves.above]),
                None => parts.push(piece),
            }
        }
        pieces = parts;
        let mut area = [0.0; 2];
        for piece in &pieces {
            assert_eq!(piece.materials().len(), piece.triangles().len());
            for (corners, &slot) in piece.triangles().iter().zip(piece.materials()) {
                let [a, b, c] = corners.map(|v| piece.positions()[v as usize]);
                let of_this = 0.5 * f64::from((b - a).cross(c - a).length());
                // Corners of a cap on one edge of it make a triangle without area, which lies on a face of the cube too.
                if of_this < 1e-7 {
                    continue;
                }
                let is_on = |face: f32, k: usize| [a, b, c].iter().all(|p| p[k] == face);
                let is_outer = (0..3).any(|k| is_on(0.5, k) || is_on(-0.5, k));
                assert_eq!(slot < 2, is_outer, "only cut faces have the cap's slot");
                if is_outer {
                    area[usize::from(slot)] += of_this;
                }
            }
        }
        // Each face of the cube is one triangle of either slot.
        assert!(area.iter().all(|a| (a - 3.0).abs() < 1e-5), "{area:?}");
    }
    assert!(pieces.len() > 20);
}

#[test]
fn meshes_without_slots_stay_without() {
    let mesh = cuboid(Vec3::ONE, Vec3::ZERO);
    let plane = Plane::through(Vec3::ZERO, Vec3::X);
    let halves = slice_mesh(&mesh, plane, SliceOptions::default())
        .unwrap()
        .halves()
        .unwrap();
    assert!(halves.below.materials().is_empty() && halves.above.materials().is_empty());
    let wrong = mesh.with_materials(vec![0; 3]);
    let expected = MeshError::MaterialLength {
        found: 3,
        triangles: 12,
    };
    assert_eq!(wrong, Err(expected));
}

#[test]
fn smooth_caps_have_the_normals_of_their_rim() {
    let sphere = primitives::icosphere(1.0, 2).unwrap();
    let normals = sphere.vertices().iter().map(|v| v.normalize()).collect();
    let mesh = TriMesh::new(sphere.vertices().to_vec(), sphere.triangles().collect())
        .and_then(|mesh| mesh.with_normals(normals))
        .unwrap();
    let plane = Plane::through(Vec3::splat(0.1), Vec3::new(0.3, 1.0, 0.2));
    for (cap_normals, is_flat) in [(CapNormals::Flat, true), (CapNormals::Smooth, false)] {
        let options = SliceOptions {
            cap_normals,
            ..SliceOptions::default()
        };
        let halves = slice_mesh(&mesh, plane, options).unwrap().halves().unwrap();
        let cap = halves.below.triangles().len() - halves.cap.triangles;
        for &vertex in halves.below.triangles()[cap..].as_flattened() {
            let normal = halves.below.normals()[vertex as usize];
            let outwards = halves.below.positions()[vertex as usize].normalize();
            let expected = if is_flat { plane.normal } else { outwards };
            assert!(normal.distance(expected) < 0.02, "{normal} {expected}");
        }
    }
}

#[test]
fn cap_texture_is_in_metres_on_the_plane() {
    let mesh = dressed_cube();
    let mut dice = Dice::new(34);
    for _ in 0..100 {
        let plane = Plane::through(dice.vector(-0.3, 0.3), dice.direction());
        let halves = slice_mesh(&mesh, plane, SliceOptions::default())
            .unwrap()
            .halves()
            .unwrap();
        for half in [&halves.below, &halves.above] {
            for corners in &half.triangles()[half.triangles().len() - halves.cap.triangles..] {
                let corner = |k: usize| {
                    (
                        half.positions()[corners[k] as usize],
                        half.uvs()[corners[k] as usize],
                    )
                };
                for k in 0..3 {
                    let ((p, uv), (q, uw)): ((Vec3, Vec2), _) = (corner(k), corner((k + 1) % 3));
                    assert!((p.distance(q) - uv.distance(uw)).abs() < 1e-5);
                }
            }
        }
    }
}

#[test]
fn slicer_that_is_used_again_gives_the_same_parts() {
    let (mut slicer, mut halves) = (MeshSlicer::default(), Halves::default());
    let mut dice = Dice::new(35);
    let meshes = [
        model_mesh("spot.obj"),
        dressed_cube(),
        torus(2.0, 0.5, 40, 24),
    ];
    for turn in 0..60 {
        let mesh = &meshes[turn % 3];
        let plane = dice.plane_through(mesh.positions());
        let options = SliceOptions {
            cap_color: (turn % 2 == 0).then_some(Vec4::ONE),
            ..SliceOptions::default()
        };
        let fresh = slice_mesh(mesh, plane, options).unwrap().halves();
        let verdict = slicer
            .slice_into(mesh, plane, options, &mut halves)
            .unwrap();
        assert_eq!(fresh.is_some(), verdict.is_cut());
        if let Some(fresh) = fresh {
            assert_eq!(fresh, halves);
        }
    }
}

#[test]
fn repeated_cuts_allocate_nothing() {
    let seen = measure(|| drop(std::hint::black_box(Vec::<u8>::with_capacity(1))));
    assert_eq!(seen.count_total, 1, "allocations are counted");
    let mut dice = Dice::new(36);
    for mesh in [
        model_mesh("spot.obj"),
        dressed_cube(),
        torus(2.0, 0.5, 40, 24),
    ] {
        let planes: Vec<Plane> = (0..50)
            .map(|_| dice.plane_through(mesh.positions()))
            .collect();
        let (mut slicer, mut halves) = (MeshSlicer::default(), Halves::default());
        let mut cut_all = || {
            for &plane in &planes {
                let options = SliceOptions::default();
                slicer
                    .slice_into(&mesh, plane, options, &mut halves)
                    .unwrap();
            }
        };
        cut_all();
        let allocated = measure(cut_all);
        assert_eq!(allocated.count_total, 0, "{allocated:?}");
    }
}

#[test]
fn crowded_vertices_are_no_obstacle() {
    // Two fans of 3000 triangles, tip to tip over one rim: thousands of edges meet at two vertices.
    let count = 3000_u32;
    let rim = (0..count).map(|i| {
        let (sin, cos) = (std::f32::consts::TAU * i as f32 / count as f32).sin_cos();
        Vec3::new(cos, 0.0, sin)
    });
    let positions: Vec<Vec3> = [Vec3::Y, Vec3::NEG_Y].into_iter().chain(rim).collect();
    let triangles = (0..count).flat_map(|i| {
        let [a, b] = [2 + i, 2 + (i + 1) % count];
        [[0, b, a], [1, a, b]]
    });
    let mesh = TriMesh::new(positions, triangles.collect()).unwrap();
    assert!(mesh.is_closed());
    let area = polygon_area(count, 0.5);
    cut(
        &mesh,
        Plane::through(Vec3::new(0.0, 0.5, 0.0), Vec3::Y),
        area,
        1,
    );
}
