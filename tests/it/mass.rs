//! Exact polyhedral integrals agree with independent ones, and behave as mass does.

#![expect(
    clippy::disallowed_methods,
    reason = "expected values within a tolerance, and scales of random inputs"
)]

use crate::common::properties::cases;
use crate::models::{
    Expected, FAR_CLOUD, FLAT_CLOUDS, MODELS, clouds, model, model_mesh, reference, single,
};
use bevy_cleave::geometry::{ConvexHull, ConvexMesh, HullError, convex_hull_triangles};
use bevy_cleave::mass::{
    MassError, MassProperties, VolumeIntegrals, particle_inertia, principal_axes, volume_integrals,
};
use bevy_cleave::testing::approximate;
use glam::{DMat3, DQuat, DVec3, Mat3, Vec3};
use proptest::prelude::*;

/// Relative errors of volume, area, centroid, inertia and principal moments. Vectors and tensors are relative to their
/// own largest entry or, for the centroid, to the size of the body's box, because single components can be zero.
fn check(
    name: &str,
    found: &VolumeIntegrals,
    area: f64,
    size: f64,
    expected: &Expected,
    tolerance: f64,
) {
    let (principal, _) = principal_axes(found.inertia);
    let tensor_scale = expected.principal.max_element();
    let errors = [
        ("volume", (found.volume / expected.volume - 1.0).abs()),
        ("area", (area / expected.area - 1.0).abs()),
        (
            "centroid",
            (found.centroid - expected.centroid).abs().max_element() / size,
        ),
        (
            "inertia",
            max_abs(found.inertia - expected.inertia) / tensor_scale,
        ),
        (
            "principal",
            (principal / expected.principal - 1.0).abs().max_element(),
        ),
    ];
    for (what, error) in errors {
        assert!(
            error <= tolerance,
            "{name}: {what} off by {error:e}, allowed {tolerance:e}"
        );
    }
}

fn max_abs(m: DMat3) -> f64 {
    m.to_cols_array()
        .into_iter()
        .map(f64::abs)
        .fold(0.0, f64::max)
}

fn area(positions: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let corners = triangles.iter().map(|t| t.map(|v| positions[v as usize]));
    corners
        .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length())
        .sum()
}

fn size(positions: &[DVec3]) -> f64 {
    let min = positions.iter().copied().reduce(DVec3::min).unwrap();
    let max = positions.iter().copied().reduce(DVec3::max).unwrap();
    (max - min).length()
}

fn check_f64(name: &str, positions: &[DVec3], triangles: &[[u32; 3]], expected: &Expected) {
    let found = volume_integrals(positions, triangles.iter().copied());
    check(
        name,
        &found,
        area(positions, triangles),
        size(positions),
        expected,
        1e-12,
    );
}

fn check_hull(name: &str, positions: &[DVec3], expected: &Expected) {
    let triangles = convex_hull_triangles(positions).unwrap();
    check_f64(&format!("hull of {name}"), positions, &triangles, expected);
    let hull = ConvexHull::from_points(&single(positions)).unwrap();
    let found = VolumeIntegrals::of_hull(&hull);
    let name = format!("f32 hull of {name}");
    check(
        &name,
        &found,
        hull.to_mesh().area(),
        size(positions),
        expected,
        1e-5,
    );
}

#[test]
fn hulls_of_all_models_match_the_reference() {
    let reference = reference();
    for name in MODELS {
        let (positions, _) = model(name);
        check_hull(name, &positions, &Expected::parse(&reference[name]["hull"]));
    }
}

#[test]
fn closed_models_match_the_reference() {
    let reference = reference();
    let closed = crate::models::closed_models();
    assert_eq!(closed.len(), 10);
    for name in closed {
        let (positions, triangles) = model(name);
        let expected = Expected::parse(&reference[name]["mesh"]);
        check_f64(name, &positions, &triangles, &expected);
        let mesh = model_mesh(name);
        let found = VolumeIntegrals::of_mesh(&mesh);
        check(name, &found, mesh.area(), size(&positions), &expected, 1e-5);
        assert!(
            (mesh.volume() / expected.volume - 1.0).abs() < 1e-5,
            "{name}"
        );
    }
}

#[test]
fn real_collision_hulls_match_the_reference_and_the_two_flat_ones_are_refused() {
    let reference = reference();
    let clouds = clouds();
    assert_eq!(clouds.len(), 209);
    for (index, cloud) in clouds.iter().enumerate() {
        let entry = &reference["horizon_hull_points.json"][index];
        assert_eq!(entry["error"].is_string(), FLAT_CLOUDS.contains(&index));
        if FLAT_CLOUDS.contains(&index) {
            let refused = ConvexHull::from_points(&single(cloud));
            assert!(
                matches!(refused, Err(HullError::Flat { .. })),
                "cloud {index}: {refused:?}"
            );
        } else {
            let expected = Expected::parse(entry);
            check_hull(&format!("cloud {index}"), cloud, &expected);
            check_joined_faces_keep_the_volume(index, cloud, &expected);
        }
    }
}

/// The file prints f32 numbers with 9 digits, so that reading the text as f64 gives other points by up to 1e-9 of the
/// coordinate. That matters for one body of 2.6 m by 0.2 m which lies 3 km from its origin; all others have to agree
/// with the reference itself.
fn check_joined_faces_keep_the_volume(index: usize, cloud: &[DVec3], expected: &Expected) {
    let points = single(cloud);
    let hull = ConvexHull::from_points(&points).unwrap();
    let same_points: Vec<DVec3> = points.iter().map(|p| p.as_dvec3()).collect();
    let triangles = convex_hull_triangles(&same_points).unwrap();
    let exact = volume_integrals(&same_points, triangles.into_iter()).volume;
    assert!((hull.volume() / exact - 1.0).abs() < 1e-6, "cloud {index}");
    if index != FAR_CLOUD {
        assert!(
            (hull.volume() / expected.volume - 1.0).abs() < 1e-6,
            "cloud {index}"
        );
    }
}

/// What a body gets, in f32, against the reference: mass, center relative to the size of the box, principal moments.
fn check_mass_properties(name: &str, positions: &[DVec3], expected: &Expected, center_bound: f64) {
    let hull = ConvexHull::from_points(&single(positions)).unwrap();
    let mass = MassProperties::of_hull(&hull, 1.0).unwrap();
    let relative = f64::from(mass.mass) / expected.volume - 1.0;
    assert!(relative.abs() <= 1e-5, "{name}: mass off by {relative:e}");
    let offset = mass.center.as_dvec3() - expected.centroid;
    let offset = offset.abs().max_element() / size(positions);
    assert!(offset <= center_bound, "{name}: center off by {offset:e}");
    let moments = mass.principal.as_dvec3() / expected.principal - 1.0;
    let worst = moments.abs().max_element();
    assert!(worst <= 1e-5, "{name}: principal moments off by {worst:e}");
}

#[test]
fn mass_properties_in_single_precision_match_the_reference() {
    let reference = reference();
    for name in MODELS {
        let expected = Expected::parse(&reference[name]["hull"]);
        check_mass_properties(name, &model(name).0, &expected, 1e-5);
    }
    let (mut checked, mut far) = (0, Vec::new());
    for (index, cloud) in clouds().iter().enumerate() {
        if FLAT_CLOUDS.contains(&index) {
            continue;
        }
        let expected = Expected::parse(&reference["horizon_hull_points.json"][index]);
        // Kilometres from its origin, the center as f32 is off by up to half a last digit of its largest coordinate.
        let half_ulp = 0.5 * f64::from(f32::EPSILON) * power_of_two_below(expected.centroid);
        let rounding = half_ulp / size(cloud);
        if rounding > 1e-5 {
            far.push(index);
        }
        let name = format!("cloud {index}");
        check_mass_properties(&name, cloud, &expected, rounding.max(1e-5));
        checked += 1;
    }
    // The second is 7 m of body at 2.3 km.
    assert_eq!((checked, far), (207, vec![FAR_CLOUD, 138]));
}

/// The largest power of two that is not above the largest coordinate.
fn power_of_two_below(v: DVec3) -> f64 {
    let largest = v.abs().max_element();
    f64::from_bits(largest.to_bits() & f64::INFINITY.to_bits())
}

#[test]
fn cuboid_has_its_textbook_inertia() {
    let (x, y, z) = (2.0, 3.0, 4.0);
    let body = ConvexMesh::cuboid(x, y, z).unwrap();
    let mass = MassProperties::of_hull(body.hull(), 500.0).unwrap();
    assert_eq!(mass.mass, 500.0 * 24.0);
    assert_eq!(mass.center, Vec3::ZERO);
    let twelfth = mass.mass / 12.0;
    let expected = twelfth * Vec3::new(x * x + y * y, x * x + z * z, y * y + z * z);
    assert!((mass.principal / expected - 1.0).abs().max_element() < 1e-6);
    // The smallest moment is about the longest axis, so the body's tensor has the order zyx.
    let tensor = Mat3::from_diagonal(Vec3::new(expected.z, expected.y, expected.x));
    assert!(mass.inertia().abs_diff_eq(tensor, 1e-6 * expected.z));
    let product = mass.inertia() * mass.inverse_inertia();
    assert!(product.abs_diff_eq(Mat3::IDENTITY, 1e-6));
    assert_eq!(mass.inverse_mass(), 1.0 / 12000.0);
}

#[test]
fn tetrahedron_has_its_textbook_integrals() {
    // Corners at the origin and at 1 on each axis: V = 1/6, c = 1/4, I_xx = 1/80 and I_xy = 1/480 about the centroid.
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let found = volume_integrals(&corners, triangles.into_iter());
    assert!((found.volume - 1.0 / 6.0).abs() < 1e-16);
    assert!((found.centroid - 0.25).abs().max_element() < 1e-15);
    let expected = DMat3::from_diagonal(DVec3::splat(1.0 / 80.0 - 1.0 / 480.0))
        + DMat3::from_cols_array(&[1.0 / 480.0; 9]);
    assert!(max_abs(found.inertia - expected) < 1e-16);
}

#[test]
fn joining_two_halves_gives_the_whole() {
    let whole = VolumeIntegrals::of_hull(ConvexMesh::cuboid(2.0, 1.0, 1.0).unwrap().hull());
    let half = |shift: f32| {
        let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).unwrap();
        let points: Vec<Vec3> = cube
            .hull()
            .vertices()
            .iter()
            .map(|&v| v + shift * Vec3::X)
            .collect();
        VolumeIntegrals::of_hull(&ConvexHull::from_points(&points).unwrap())
    };
    let joined = half(-0.5).joined_with(&half(0.5));
    assert!((joined.volume - whole.volume).abs() < 1e-15);
    assert!((joined.centroid - whole.centroid).length() < 1e-15);
    assert!(max_abs(joined.inertia - whole.inertia) < 1e-15);
    let far = DVec3::new(3.0, -4.0, 5.0);
    let shifted = whole.inertia + particle_inertia(2.0, far);
    assert!(max_abs(whole.inertia_about(far) - shifted) < 1e-13);
}

#[test]
fn bad_densities_volumes_and_scales_are_refused() {
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).unwrap();
    for density in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let refused = MassProperties::of_hull(cube.hull(), density);
        assert!(
            matches!(refused, Err(MassError::Density { .. })),
            "{density}: {refused:?}"
        );
    }
    let good = VolumeIntegrals::of_hull(cube.hull());
    for volume in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = MassProperties::from_integrals(&VolumeIntegrals { volume, ..good }, 1.0);
        assert!(
            matches!(refused, Err(MassError::Volume { .. })),
            "{volume}: {refused:?}"
        );
    }
    for inertia in [DMat3::ZERO, -good.inertia, DMat3::NAN] {
        let refused = MassProperties::from_integrals(&VolumeIntegrals { inertia, ..good }, 1.0);
        assert!(
            matches!(refused, Err(MassError::Inertia { .. })),
            "{refused:?}"
        );
    }
    let heavy = MassProperties::of_hull(cube.hull(), f32::MAX);
    assert!(
        matches!(heavy, Err(MassError::OutOfRange { .. })),
        "{heavy:?}"
    );
    let open: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];
    let nothing = volume_integrals(&open, std::iter::empty());
    assert!(matches!(
        MassProperties::from_integrals(&nothing, 1.0),
        Err(MassError::Volume { .. })
    ));
}

#[test]
fn approximations_are_what_they_say() {
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).unwrap();
    let exact = VolumeIntegrals::of_hull(cube.hull());
    let corners = cube.hull().vertices();
    assert_eq!(approximate::mean_of_vertices(corners), DVec3::ZERO);
    // All mass at half the space diagonal: (1/4 + 1/4) against (1 + 1) / 12.
    let particles = approximate::vertices_as_particles(corners, 1.0, DVec3::ZERO);
    assert!(max_abs(particles - 3.0 * exact.inertia) < 1e-15);
    let full = DMat3::from_cols_array(&[4.0, 1.0, 2.0, 1.0, 5.0, 3.0, 2.0, 3.0, 6.0]);
    let diagonal = DMat3::from_diagonal(DVec3::new(4.0, 5.0, 6.0));
    assert_eq!(approximate::off_diagonals_dropped(full), diagonal);
}

fn symmetric() -> impl Strategy<Value = DMat3> {
    (prop::array::uniform6(-1.0..1.0_f64), -6..6_i32).prop_map(|([a, b, c, d, e, f], power)| {
        10.0_f64.powi(power) * DMat3::from_cols_array(&[a, d, e, d, b, f, e, f, c])
    })
}

fn rotation() -> impl Strategy<Value = DQuat> {
    prop::array::uniform4(-1.0..1.0_f64)
        .prop_filter("not zero", |q| q.iter().map(|x| x * x).sum::<f64>() > 1e-3)
        .prop_map(|q| DQuat::from_array(q).normalize())
}

fn cloud() -> impl Strategy<Value = Vec<DVec3>> {
    prop::collection::vec(
        prop::array::uniform3(-1.0..1.0_f64).prop_map(DVec3::from_array),
        8..60,
    )
}

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn principal_axes_rebuild_the_tensor(tensor in symmetric()) {
        let (values, frame) = principal_axes(tensor);
        let r = DMat3::from_quat(frame);
        let rebuilt = r * DMat3::from_diagonal(values) * r.transpose();
        prop_assert!(max_abs(rebuilt - tensor) <= 4e-15 * max_abs(tensor));
        prop_assert!(values.x <= values.y && values.y <= values.z);
        prop_assert!(frame.is_normalized());
    }

    #[test]
    fn principal_axes_of_almost_equal_moments_stay_orthonormal(tensor in symmetric(), exponent in 3..18_i32) {
        let scale = max_abs(tensor).max(1e-300);
        let nearly_round = DMat3::IDENTITY + 10.0_f64.powi(-exponent) / scale * tensor;
        let (values, frame) = principal_axes(nearly_round);
        let r = DMat3::from_quat(frame);
        prop_assert!(max_abs(r * DMat3::from_diagonal(values) * r.transpose() - nearly_round) <= 4e-15);
    }

    #[test]
    fn principal_moments_do_not_change_under_rotation(points in cloud(), turn in rotation()) {
        let turned: Vec<DVec3> = points.iter().map(|&p| turn * p).collect();
        let moments = |points: &[DVec3]| {
            let triangles = convex_hull_triangles(points).unwrap();
            principal_axes(volume_integrals(points, triangles.into_iter()).inertia).0
        };
        let (before, after) = (moments(&points), moments(&turned));
        prop_assert!((after - before).abs().max_element() < 1e-13 * before.z);
    }

    #[test]
    fn integrals_far_from_the_origin_are_those_at_the_origin(points in cloud(), far in 1.0..1e3_f64) {
        // A shift by whole multiples of 1/8 of points on a grid of 2^-20 is exact in f64.
        let shift = DVec3::new(1.0, -2.0, 0.5) * (far * 8.0).round() / 8.0;
        let grid = |p: &DVec3| (*p * 1_048_576.0).round() / 1_048_576.0;
        let near: Vec<DVec3> = points.iter().map(grid).collect();
        let away: Vec<DVec3> = near.iter().map(|&p| p + shift).collect();
        let triangles = convex_hull_triangles(&near).unwrap();
        let here = volume_integrals(&near, triangles.iter().copied());
        let there = volume_integrals(&away, triangles.iter().copied());
        prop_assert_eq!(here.volume, there.volume);
        prop_assert_eq!(here.inertia, there.inertia);
        prop_assert!((there.centroid - here.centroid - shift).length() < 1e-15 * shift.length() + 1e-15);
    }
}
