//! Meshes and hulls are valid or refused with a reason; primitives are what they say.

#![expect(
    clippy::disallowed_methods,
    reason = "expected values within a tolerance, and scales of random inputs"
)]

use crate::common::properties::cases;
use crate::models::{
    FLAT_CLOUDS, MODELS, assert_edge_is_bad, closed_models, clouds, model, model_mesh, reference,
    single,
};
use bevy_cleave::geometry::{
    ConvexHull, ConvexMesh, HalfSpaceShape, HullDefect, HullError, MeshError, PlaneError, Side,
    TriMesh, convex_hull_triangles, primitives,
};
use bevy_cleave::math::{Aabb, Plane, Pose};
use bevy_cleave::testing::predicates;
use bevy_cleave::testing::predicates::side;
use glam::{DVec3, Quat, Vec2, Vec3, Vec4};
use proptest::prelude::*;

/// A unit tetrahedron with its corner at the origin.
const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn tetrahedron() -> Vec<Vec3> {
    vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]
}

/// A hull of `points` must be valid and hold all of them within the convexity tolerance.
fn check_hull_of(points: &[Vec3]) -> ConvexHull {
    let hull = ConvexHull::from_points(points).unwrap();
    assert_eq!(hull.validate(), Ok(()));
    let tolerance = f64::from(predicates::convex_tolerance(predicates::length_scale(
        &hull.aabb(),
    )));
    for face in hull.faces() {
        for &point in points {
            let distance = predicates::signed_distance(&face.plane, point);
            assert!(
                distance <= tolerance,
                "{point} lies {distance} outside {face:?}"
            );
        }
    }
    assert_eq!(hull.aabb(), Aabb::of_points(points.iter().copied()));
    hull
}

#[test]
fn all_real_hulls_are_valid_and_hold_their_points() {
    for (index, cloud) in clouds().iter().enumerate() {
        if !FLAT_CLOUDS.contains(&index) {
            check_hull_of(&single(cloud));
        }
    }
    for name in MODELS {
        check_hull_of(&single(&model(name).0));
    }
}

#[test]
fn hull_triangles_are_closed_and_no_point_is_outside() {
    for cloud in clouds() {
        let Ok(triangles) = convex_hull_triangles(&cloud) else {
            continue;
        };
        let outside =
            |[a, b, c]: [DVec3; 3], p: DVec3| (b - a).cross(c - a).normalize_or_zero().dot(p - a);
        for corners in &triangles {
            let corners = corners.map(|v| cloud[v as usize]);
            // Distances are evaluated with rounding errors of coordinates up to 3 km.
            assert!(cloud.iter().all(|&p| outside(corners, p) < 1e-11));
        }
        let mesh = TriMesh::new(single(&cloud), triangles).unwrap();
        assert_eq!(mesh.check_closed(), Ok(()));
    }
}

#[test]
fn closed_models_are_closed_and_open_ones_name_the_open_edge() {
    let closed = closed_models();
    for name in MODELS {
        let mesh = model_mesh(name);
        let verdict = mesh.check_closed();
        assert_eq!(
            verdict.is_ok(),
            closed.contains(&name),
            "{name}: {verdict:?}"
        );
        let body = ConvexMesh::from_mesh(mesh.clone());
        match verdict {
            Ok(()) => assert_eq!(body.unwrap().visual(), Some(&mesh)),
            Err(error) => {
                assert_edge_is_bad(name, &mesh, &error);
                assert_eq!(body.unwrap_err(), HullError::Mesh(error));
            }
        }
    }
}

#[test]
fn welded_vertex_and_triangle_counts_match_the_reference() {
    let reference = reference();
    for name in MODELS {
        let mesh = model_mesh(name);
        let positions = *mesh.topology().iter().max().unwrap() as u64 + 1;
        assert_eq!(positions, reference[name]["vertices_welded"], "{name}");
        assert_eq!(
            mesh.triangles().len() as u64,
            reference[name]["triangles"],
            "{name}"
        );
    }
}

#[test]
fn seams_and_signed_zeros_do_not_open_a_mesh() {
    // Each triangle with corners of its own; the zeros of every other triangle are negative.
    let corners = tetrahedron();
    let mut positions = Vec::new();
    for (number, triangle) in TETRAHEDRON.iter().enumerate() {
        let zero = if number % 2 == 0 { 0.0 } else { -0.0 };
        let signed = |v: Vec3| v.map(|x| if x == 0.0 { zero } else { x });
        positions.extend(triangle.map(|v| signed(corners[v as usize])));
    }
    let triangles = (0..4).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let mesh = TriMesh::new(positions, triangles).unwrap();
    assert!(mesh.is_closed());
    assert_eq!(mesh.topology(), [0, 1, 2, 0, 2, 3, 0, 3, 1, 2, 1, 3]);
    assert!((mesh.volume() - 1.0 / 6.0).abs() < 1e-16);
    assert!((mesh.area() - (1.5 + 0.75_f64.sqrt())).abs() < 1e-15);
}

#[test]
fn triangles_without_area_through_welding_are_dropped_and_the_mesh_stays_closed() {
    // The edge 1-2 is split by a triangle whose corners 1 and 4 are one position.
    let mut positions = tetrahedron();
    positions.push(Vec3::X);
    let triangles = vec![[0, 2, 1], [1, 2, 4], [0, 4, 3], [0, 3, 2], [4, 2, 3]];
    let mesh = TriMesh::new(positions, triangles).unwrap();
    assert_eq!(mesh.triangles().len(), 4);
    assert!(mesh.is_closed());
}

#[test]
fn bad_meshes_are_refused_by_name() {
    let new = |positions, triangles: &[[u32; 3]]| TriMesh::new(positions, triangles.to_vec());
    for bad in [f32::NAN, f32::INFINITY] {
        let mut positions = tetrahedron();
        positions[2].y = bad;
        assert_eq!(
            new(positions, &TETRAHEDRON),
            Err(MeshError::NotFinite { vertex: 2 })
        );
    }
    let out_of_range = MeshError::IndexOutOfRange {
        triangle: 1,
        index: 4,
        vertices: 4,
    };
    assert_eq!(
        new(tetrahedron(), &[[0, 1, 2], [1, 4, 2]]),
        Err(out_of_range)
    );
    assert_eq!(new(tetrahedron(), &[]), Err(MeshError::Empty));
    assert_eq!(new(tetrahedron(), &[[1, 1, 2]]), Err(MeshError::Empty));
    let open = new(tetrahedron(), &TETRAHEDRON[..3]).unwrap();
    let verdict = open.check_closed();
    assert!(
        matches!(verdict, Err(MeshError::Open { .. })),
        "{verdict:?}"
    );
    assert_edge_is_bad("tetrahedron", &open, &verdict.unwrap_err());
    let doubled = new(
        tetrahedron(),
        &[TETRAHEDRON.as_slice(), &TETRAHEDRON[..1]].concat(),
    )
    .unwrap();
    let verdict = doubled.check_closed();
    assert!(
        matches!(verdict, Err(MeshError::NonManifold { .. })),
        "{verdict:?}"
    );
    assert_edge_is_bad("tetrahedron", &doubled, &verdict.unwrap_err());
    let inside_out: Vec<[u32; 3]> = TETRAHEDRON.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let inward = ConvexMesh::from_mesh(new(tetrahedron(), &inside_out).unwrap()).unwrap_err();
    assert!(
        matches!(inward, HullError::Mesh(MeshError::NoVolume { .. })),
        "{inward:?}"
    );
}

#[test]
fn bad_attributes_are_refused_by_name() {
    let mesh = || TriMesh::new(tetrahedron(), TETRAHEDRON.to_vec()).unwrap();
    let length = |attribute| MeshError::AttributeLength {
        attribute,
        found: 3,
        vertices: 4,
    };
    assert_eq!(
        mesh().with_normals(vec![Vec3::X; 3]),
        Err(length("normals"))
    );
    assert_eq!(
        mesh().with_colors(vec![Vec4::ONE; 3]),
        Err(length("colors"))
    );
    assert_eq!(mesh().with_uvs(vec![Vec2::ONE; 3]), Err(length("uvs")));
    assert_eq!(
        mesh().with_uvs(vec![Vec2::NAN; 4]),
        Err(MeshError::NotFinite { vertex: 0 })
    );
    let complete = mesh().with_normals(vec![Vec3::X; 4]).unwrap();
    assert_eq!(complete.normals().len(), 4);
}

#[test]
fn moving_and_scaling_a_mesh_does_what_it_says() {
    let mesh = TriMesh::new(tetrahedron(), TETRAHEDRON.to_vec()).unwrap();
    let mesh = mesh.with_normals(vec![Vec3::Y; 4]).unwrap();
    let quarter_turn = Quat::from_xyzw(0.0, 0.0, 0.5_f32.sqrt(), 0.5_f32.sqrt());
    let moved = mesh
        .clone()
        .transformed(&Pose::new(Vec3::new(1.0, 2.0, 3.0), quarter_turn));
    assert!(moved.positions()[1].abs_diff_eq(Vec3::new(1.0, 3.0, 3.0), 1e-6));
    assert!(moved.normals()[0].abs_diff_eq(Vec3::NEG_X, 1e-6));
    assert!((moved.volume() - mesh.volume()).abs() < 1e-6);
    let scaled = mesh.clone().scaled(Vec3::new(2.0, 3.0, 4.0)).unwrap();
    assert_eq!(scaled.volume(), 24.0 * mesh.volume());
    assert!(scaled.is_closed());
    assert_eq!(scaled.normals()[0], Vec3::Y);
    for factor in [
        Vec3::new(1.0, 0.0, 1.0),
        Vec3::splat(-1.0),
        Vec3::NAN,
        Vec3::INFINITY,
    ] {
        let refused = mesh.clone().scaled(factor);
        assert!(
            matches!(refused, Err(MeshError::BadScale { .. })),
            "{factor}: {refused:?}"
        );
    }
}

#[test]
fn bad_clouds_are_refused_by_name() {
    let refused = |points: &[Vec3]| ConvexHull::from_points(points).unwrap_err();
    for bad in [f32::NAN, f32::NEG_INFINITY] {
        let mut points = tetrahedron();
        points[3].x = bad;
        assert_eq!(refused(&points), HullError::NotFinite { point: 3 });
    }
    assert_eq!(refused(&[]), HullError::TooFewPoints { found: 0 });
    assert_eq!(
        refused(&tetrahedron()[..3]),
        HullError::TooFewPoints { found: 3 }
    );
    let grid = || (0..25).map(|k| ((k % 5) as f32, (k / 5) as f32));
    let flat: Vec<Vec3> = grid()
        .map(|(x, y)| Vec3::new(x, y, 1e-6 * (x * y % 2.0)))
        .collect();
    let tilted: Vec<Vec3> = grid()
        .map(|(x, y)| Vec3::new(x, y, 0.3 * x - 0.7 * y))
        .collect();
    let line: Vec<Vec3> = grid().map(|(x, _)| x * Vec3::new(0.1, 0.2, 0.3)).collect();
    let point = vec![Vec3::splat(0.3); 9];
    for (name, points) in [
        ("flat", flat),
        ("tilted", tilted),
        ("line", line),
        ("point", point),
    ] {
        let error = refused(&points);
        assert!(matches!(error, HullError::Flat { .. }), "{name}: {error:?}");
    }
    for scale in [1e-9, 1e9, 1e38] {
        let points: Vec<Vec3> = tetrahedron().iter().map(|&p| scale * p).collect();
        let error = refused(&points);
        assert!(
            matches!(error, HullError::Size { .. }),
            "{scale}: {error:?}"
        );
    }
}

#[test]
fn bad_faces_are_refused_by_name() {
    let refused = |vertices: Vec<Vec3>, faces: &[[u32; 3]]| {
        ConvexHull::from_faces(vertices, faces).unwrap_err()
    };
    let out_of_range = HullError::IndexOutOfRange {
        face: 0,
        index: 7,
        vertices: 4,
    };
    assert_eq!(refused(tetrahedron(), &[[0, 7, 1]]), out_of_range);
    assert_eq!(
        refused(tetrahedron(), &[[0, 2, 2]]),
        HullError::DegenerateFace { face: 0 }
    );
    let open = refused(tetrahedron(), &TETRAHEDRON[..3]);
    assert!(
        matches!(open, HullError::Invalid(HullDefect::Open { .. })),
        "{open:?}"
    );
    let mut loose = tetrahedron();
    loose.push(Vec3::splat(0.1));
    let loose = refused(loose, &TETRAHEDRON);
    assert!(
        matches!(loose, HullError::Invalid(HullDefect::Euler { .. })),
        "{loose:?}"
    );
    let inward: Vec<[u32; 3]> = TETRAHEDRON.iter().map(|&[a, b, c]| [a, c, b]).collect();
    let inward = refused(tetrahedron(), &inward);
    assert!(
        matches!(inward, HullError::Invalid(HullDefect::NotConvex { .. })),
        "{inward:?}"
    );
    let planes = [Plane {
        normal: Vec3::NAN,
        offset: 0.0,
    }; 4];
    let no_plane = ConvexHull::from_faces_and_planes(tetrahedron(), &TETRAHEDRON, &planes);
    assert_eq!(no_plane, Err(HullError::DegenerateFace { face: 0 }));
    assert!(
        ConvexHull::from_faces(tetrahedron(), &TETRAHEDRON)
            .unwrap()
            .is_valid()
    );
}

#[test]
fn a_dented_box_is_not_convex() {
    let cube = primitives::cuboid(1.0, 1.0, 1.0).unwrap();
    let mut vertices = cube.vertices().to_vec();
    vertices[0] *= 0.5;
    let faces: Vec<[u32; 3]> = cube.triangles().collect();
    let dented = ConvexHull::from_faces(vertices, &faces).unwrap_err();
    assert!(
        matches!(dented, HullError::Invalid(HullDefect::NotConvex { .. })),
        "{dented:?}"
    );
}

#[test]
fn coplanar_triangles_become_polygons_and_needless_points_are_dropped() {
    // A lattice: corners, points on edges, in faces and inside.
    let lattice = |k: i32| Vec3::new((k % 5) as f32, (k / 5 % 5) as f32, (k / 25) as f32) / 4.0;
    let points: Vec<Vec3> = (0..125).map(lattice).collect();
    let turn = Quat::from_xyzw(0.2, -0.3, 0.5, 0.7).normalize();
    for rotation in [Quat::IDENTITY, turn] {
        let turned: Vec<Vec3> = points.iter().map(|&p| rotation * p).collect();
        let hull = check_hull_of(&turned);
        let counts = (
            hull.vertices().len(),
            hull.edges().len(),
            hull.faces().len(),
        );
        assert_eq!(counts, (8, 12, 6));
        assert!((hull.volume() - 1.0).abs() < 1e-6);
    }
}

#[test]
fn primitives_have_their_counts_and_volumes() {
    let counts = |hull: &ConvexHull| {
        (
            hull.vertices().len(),
            hull.edges().len(),
            hull.faces().len(),
        )
    };
    let cuboid = primitives::cuboid(1.0, 2.0, 4.0).unwrap();
    assert_eq!((counts(&cuboid), cuboid.volume()), ((8, 12, 6), 8.0));
    let wedge = primitives::wedge(1.0, 2.0, 4.0).unwrap();
    assert_eq!((counts(&wedge), wedge.volume()), ((6, 9, 5), 4.0));
    for sides in [3, 4, 5, 6, 17, 64, 256] {
        let prism = primitives::regular_prism(sides, 0.5, 2.0).unwrap();
        let n = sides as usize;
        assert_eq!(counts(&prism), (2 * n, 3 * n, n + 2));
        let angle = std::f64::consts::TAU / f64::from(sides);
        let volume = 2.0 * 0.5 * f64::from(sides) * 0.25 * angle.sin();
        assert!(
            (prism.volume() / volume - 1.0).abs() < 1e-6,
            "{sides} sides"
        );
    }
    for (subdivisions, vertices) in [(0, 12), (1, 42), (2, 162), (3, 642), (4, 2562)] {
        let sphere = primitives::icosphere(2.0, subdivisions).unwrap();
        assert_eq!(
            counts(&sphere),
            (vertices, 3 * vertices - 6, 2 * vertices - 4)
        );
        assert!(
            sphere
                .vertices()
                .iter()
                .all(|v| (v.length() - 2.0).abs() < 1e-6)
        );
    }
}

#[test]
fn bad_primitives_are_refused_by_name() {
    for bad in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        for refused in [
            primitives::cuboid(1.0, bad, 1.0),
            primitives::wedge(1.0, 1.0, bad),
            primitives::regular_prism(5, bad, 1.0),
            primitives::regular_prism(5, 1.0, bad),
            primitives::icosphere(bad, 1),
        ] {
            assert!(
                matches!(refused, Err(HullError::Length { .. })),
                "{bad}: {refused:?}"
            );
        }
    }
    for refused in [
        primitives::regular_prism(2, 1.0, 1.0),
        primitives::regular_prism(257, 1.0, 1.0),
        primitives::icosphere(1.0, 5),
    ] {
        assert!(
            matches!(refused, Err(HullError::Count { .. })),
            "{refused:?}"
        );
    }
    let sheet = primitives::cuboid(1.0, 1e-6, 1.0);
    assert!(matches!(sheet, Err(HullError::Flat { .. })), "{sheet:?}");
}

#[test]
fn a_hull_is_drawn_flat_shaded_and_closed() {
    let body = ConvexMesh::wedge(1.0, 2.0, 3.0).unwrap();
    let mesh = body.render_mesh();
    assert!(mesh.is_closed());
    assert_eq!(mesh.positions().len(), 2 * 3 + 3 * 4);
    assert_eq!((mesh.normals().len(), mesh.uvs().len()), (18, 18));
    assert_eq!(mesh.volume(), body.hull().volume());
    assert_eq!(mesh.aabb(), body.aabb());
    for corners in mesh.triangles() {
        let [a, b, c] = corners.map(|v| mesh.positions()[v as usize]);
        let normal = mesh.normals()[corners[0] as usize];
        assert!((b - a).cross(c - a).normalize().dot(normal) > 1.0 - 1e-6);
    }
    // Texture coordinates are metres in the plane of the face.
    for &[a, b, _] in mesh.triangles() {
        let [a, b] = [a as usize, b as usize];
        let in_space = mesh.positions()[a].distance(mesh.positions()[b]);
        assert!((mesh.uvs()[a].distance(mesh.uvs()[b]) - in_space).abs() < 1e-6);
    }
}

#[test]
fn a_visual_mesh_rides_inside_and_is_drawn() {
    let body = ConvexMesh::from_mesh(model_mesh("spot.obj")).unwrap();
    let mesh = body.visual().unwrap();
    assert_eq!(*body.render_mesh(), *mesh);
    let whole = body.aabb();
    assert!(whole.contains(&mesh.aabb()));
    assert!(mesh.volume() < body.hull().volume());
}

#[test]
fn planes_and_half_spaces_check_their_normals() {
    let plane = |normal, offset| predicates::check_plane(&Plane { normal, offset });
    assert_eq!(plane(Vec3::Y, 2.0), Ok(()));
    assert_eq!(plane(Vec3::ZERO, 0.0), Err(PlaneError::ZeroNormal));
    assert!(matches!(
        plane(Vec3::Y * 1.1, 0.0),
        Err(PlaneError::NotUnit { .. })
    ));
    for (normal, offset) in [(Vec3::NAN, 0.0), (Vec3::INFINITY, 0.0), (Vec3::X, f32::NAN)] {
        assert!(matches!(
            plane(normal, offset),
            Err(PlaneError::NotFinite { .. })
        ));
    }
    assert_eq!(
        HalfSpaceShape::new(Vec3::new(0.0, 1e-30, 0.0))
            .unwrap()
            .normal,
        Vec3::Y
    );
    assert_eq!(
        HalfSpaceShape::new(Vec3::new(0.0, -1e30, 0.0))
            .unwrap()
            .normal,
        Vec3::NEG_Y
    );
    assert_eq!(HalfSpaceShape::new(Vec3::ZERO), Err(PlaneError::ZeroNormal));
    assert!(matches!(
        HalfSpaceShape::new(Vec3::NAN),
        Err(PlaneError::NotFinite { .. })
    ));
    let floor = Plane {
        normal: Vec3::Y,
        offset: 1.0,
    };
    let sides = [0.5, 1.0, 1.5].map(|y| side(&floor, Vec3::new(9.0, y, 9.0), 0.25));
    assert_eq!(sides, [Side::Below, Side::On, Side::Above]);
}

fn cloud(size: impl Into<prop::collection::SizeRange>) -> impl Strategy<Value = Vec<Vec3>> {
    prop::collection::vec(
        prop::array::uniform3(-1.0..1.0_f32).prop_map(Vec3::from_array),
        size,
    )
}

/// Points on a coarse lattice, where most planes through three of them hold more.
fn coarse_cloud() -> impl Strategy<Value = Vec<Vec3>> {
    prop::collection::vec(prop::array::uniform3(-2..=2_i32), 12..60).prop_map(|points| {
        points
            .into_iter()
            .map(|p| Vec3::from_array(p.map(|x| x as f32)))
            .collect()
    })
}

fn rotation() -> impl Strategy<Value = Quat> {
    prop::array::uniform4(-1.0..1.0_f32)
        .prop_filter("not zero", |q| q.iter().map(|x| x * x).sum::<f32>() > 1e-2)
        .prop_map(|q| Quat::from_array(q).normalize())
}

/// Hulls of clouds that are not flat are valid; flat ones are refused as such.
fn check_valid_or_flat(points: &[Vec3]) {
    match ConvexHull::from_points(points) {
        Ok(_) => drop(check_hull_of(points)),
        Err(error) => assert!(matches!(error, HullError::Flat { .. }), "{error:?}"),
    }
}

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn hulls_of_random_clouds_are_valid_at_any_scale(points in cloud(8..200), power in -3..=3_i32) {
        let scaled: Vec<Vec3> = points.iter().map(|&p| 10.0_f64.powi(power) as f32 * p).collect();
        check_hull_of(&scaled);
    }

    #[test]
    fn hulls_far_from_the_origin_are_valid(points in cloud(8..60), far in prop::array::uniform3(-500.0..500.0_f32)) {
        let far = Vec3::from_array(far);
        check_valid_or_flat(&points.iter().map(|&p| p + far).collect::<Vec<_>>());
    }

    #[test]
    fn hulls_of_turned_lattices_are_valid(points in coarse_cloud(), turn in rotation()) {
        check_valid_or_flat(&points);
        check_valid_or_flat(&points.iter().map(|&p| turn * p).collect::<Vec<_>>());
    }

    #[test]
    fn hulls_of_thin_clouds_are_valid_or_refused_as_flat(points in cloud(8..60), turn in rotation(), power in 2..8_i32) {
        let thin = Vec3::new(1.0, 1.0, 10.0_f64.powi(-power) as f32);
        check_valid_or_flat(&points.iter().map(|&p| turn * (thin * p)).collect::<Vec<_>>());
    }

    #[test]
    fn the_order_of_points_does_not_change_the_hull(points in cloud(8..60), shift in 1..7_usize) {
        let hull = check_hull_of(&points);
        let mut turned = points.clone();
        turned.rotate_left(shift);
        let other = check_hull_of(&turned);
        prop_assert_eq!(hull.vertices().len(), other.vertices().len());
        prop_assert!((hull.volume() / other.volume() - 1.0).abs() < 1e-14);
    }
}
