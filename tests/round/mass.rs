//! Mass, center and inertia of round shapes against integrals over their insides.

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use bevy_cleave::mass::VolumeIntegrals;
use bevy_cleave::prelude::*;
use glam::{DMat3, DVec3, Vec3};
use std::f64::consts::PI;

/// Layers of the numeric integral along each axis.
const LAYERS: usize = 60;

/// Volume, center and inertia of all points that count, by summing up cells of a grid over a box.
fn by_cells(aabb: Aabb, is_inside: impl Fn(DVec3) -> bool) -> VolumeIntegrals {
    let (min, size) = (aabb.min.as_dvec3(), aabb.extents().as_dvec3());
    let cell = size / LAYERS as f64;
    let (mut volume, mut first, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
    for k in 0..LAYERS * LAYERS * LAYERS {
        let place = [k % LAYERS, k / LAYERS % LAYERS, k / LAYERS / LAYERS];
        let place = DVec3::from_array(place.map(|i| i as f64 + 0.5));
        let at = min + place * cell;
        if is_inside(at) {
            volume += 1.0;
            first += at;
            second += DMat3::from_cols(at * at.x, at * at.y, at * at.z);
        }
    }
    let unit = cell.x * cell.y * cell.z;
    let centroid = first / volume;
    let outer = DMat3::from_cols(
        centroid * centroid.x,
        centroid * centroid.y,
        centroid * centroid.z,
    );
    let second = (second - outer * volume) * unit;
    let trace = second.x_axis.x + second.y_axis.y + second.z_axis.z;
    VolumeIntegrals {
        volume: volume * unit,
        centroid,
        inertia: DMat3::from_diagonal(DVec3::splat(trace)) - second,
    }
}

fn largest(m: DMat3) -> f64 {
    m.to_cols_array()
        .into_iter()
        .map(f64::abs)
        .fold(0.0, f64::max)
}

#[test]
fn spheres_and_cylinders_have_the_mass_of_the_book() {
    let (r, h, density) = (0.4_f32, 1.2_f32, 700.0_f32);
    let check = |mesh: ConvexMesh, volume: f64, along: f64, across: f64, center: Vec3| {
        let mass = MassProperties::of_shape(&mesh, density).expect("a solid");
        let expected = volume * f64::from(density);
        let close = |found: f32, right: f64| (f64::from(found) / right - 1.0).abs() < 1e-6;
        assert!(close(mass.mass, expected), "{} {expected}", mass.mass);
        let inertia = mass.inertia();
        assert!(close(inertia.y_axis.y, expected * along), "{inertia}");
        assert!(close(inertia.x_axis.x, expected * across), "{inertia}");
        assert!(close(inertia.z_axis.z, expected * across), "{inertia}");
        assert!((mass.center - center).length() < 1e-6, "{}", mass.center);
    };
    let (r2, l) = (f64::from(r) * f64::from(r), f64::from(h));
    let ball = 4.0 / 3.0 * PI * r2 * f64::from(r);
    let tube = PI * r2 * l;
    let sphere = ConvexMesh::sphere(r).expect("a sphere");
    check(sphere, ball, 0.4 * r2, 0.4 * r2, Vec3::ZERO);
    let cylinder = ConvexMesh::cylinder(r, h).expect("a cylinder");
    check(
        cylinder,
        tube,
        0.5 * r2,
        r2 / 4.0 + l * l / 12.0,
        Vec3::ZERO,
    );
    let cone = ConvexMesh::cone(r, h).expect("a cone");
    let across = 3.0 / 20.0 * r2 + 3.0 / 80.0 * l * l;
    check(cone, tube / 3.0, 0.3 * r2, across, -0.25 * h * Vec3::Y);
    let capsule = ConvexMesh::capsule(r, h).expect("a capsule");
    let volume = ball + tube;
    let along = (tube * 0.5 * r2 + ball * 0.4 * r2) / volume;
    let half = 0.5 * l;
    let caps = 0.4 * r2 + half * half + 0.75 * half * f64::from(r);
    let across = (tube * (r2 / 4.0 + l * l / 12.0) + ball * caps) / volume;
    check(capsule, volume, along, across, Vec3::ZERO);
}

#[test]
fn rounded_hulls_have_the_mass_of_all_that_is_within_their_radius() {
    let mut dice = Dice::new(11);
    for round in 0..6 {
        let points: Vec<Vec3> = (0..5 + round).map(|_| dice.vector(-0.5, 0.5)).collect();
        let core = ConvexMesh::from_points(&points).expect("a hull");
        let radius = dice.in_range(0.05, 0.5);
        let mesh = core.rounded(radius).expect("a rounded hull");
        let found = VolumeIntegrals::of_shape(&mesh);
        // Asked by the nearest point of the core, which is of another part of the crate.
        let mut simulation = awake();
        let desc = BodyDesc {
            kind: RigidBody::Static,
            ..BodyDesc::dynamic(core, Vec3::ZERO)
        };
        simulation.bodies.insert(desc).expect("usable");
        simulation.step(1e-3);
        let queries = simulation.queries();
        let all = QueryFilter::all();
        let is_inside = |at: DVec3| {
            let hit = queries.closest_point(at.as_vec3(), radius, &all);
            hit.expect("a point").is_some()
        };
        let expected = by_cells(mesh.aabb(), is_inside);
        let off = (found.volume / expected.volume - 1.0).abs();
        assert!(off < 3e-3, "volume {} {}", found.volume, expected.volume);
        let off = found.centroid.distance(expected.centroid);
        assert!(
            off < 2e-3,
            "center {} {}",
            found.centroid,
            expected.centroid
        );
        let off = largest(found.inertia - expected.inertia) / largest(expected.inertia);
        assert!(off < 5e-3, "inertia {} {}", found.inertia, expected.inertia);
    }
}

#[test]
fn a_box_with_round_edges_follows_steiners_formula() {
    let (size, r) = (Vec3::new(1.0, 0.6, 0.3), 0.2_f32);
    let cuboid = ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box");
    let found = VolumeIntegrals::of_shape(&cuboid.rounded(r).expect("a rounded box"));
    let (s, r) = (size.as_dvec3(), f64::from(r));
    let (area, edges) = (2.0 * (s.x * s.y + s.y * s.z + s.z * s.x), s.x + s.y + s.z);
    let volume = s.x * s.y * s.z + area * r + PI * r * r * edges + 4.0 / 3.0 * PI * r * r * r;
    assert!(
        (found.volume / volume - 1.0).abs() < 1e-6,
        "{} {volume}",
        found.volume
    );
    assert!(found.centroid.length() < 1e-7);
}

#[test]
fn a_shape_that_is_scaled_has_the_mass_of_one_made_so() {
    let pairs = [
        (
            ConvexMesh::sphere(0.2),
            ConvexMesh::sphere(0.4),
            Vec3::splat(2.0),
        ),
        (
            ConvexMesh::capsule(0.2, 0.5),
            ConvexMesh::capsule(0.4, 1.0),
            Vec3::splat(2.0),
        ),
        (
            ConvexMesh::cone(0.2, 0.5),
            ConvexMesh::cone(0.4, 1.5),
            Vec3::new(2.0, 3.0, 2.0),
        ),
    ];
    for (small, large, factor) in pairs {
        let scaled = small
            .and_then(|small| small.scaled(factor))
            .expect("usable");
        assert!(scaled.is_round());
        let [a, b] = [&scaled, &large.expect("usable")].map(VolumeIntegrals::of_shape);
        assert!((a.volume / b.volume - 1.0).abs() < 1e-6);
    }
    let egg = ConvexMesh::sphere(0.2).and_then(|s| s.scaled(Vec3::new(1.0, 2.0, 1.0)));
    assert!(!egg.expect("a hull").is_round());
}
