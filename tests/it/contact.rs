//! Broad phase, separating axis and manifolds against versions too simple to be wrong.

use bevy_cleave::contact::{
    BodyId, CollisionLayers, LocalManifold, Manifold, NarrowScratch, collide_hulls,
};
use bevy_cleave::geometry::primitives::icosphere;
use bevy_cleave::geometry::{ConvexHull, KdBox, KdCode};
use bevy_cleave::math::{Aabb, Plane, Pose};
use bevy_cleave::testing::contact::{
    Broadphase, ManifoldBody, Pair, Proxy, ProxyKind, ProxyShape, collide_half_space,
};
use glam::{DVec3, Mat3, Quat, Vec3};

use crate::common::dice::Dice;

/// A rotation by roughly `angle` rad (exactly: 2 atan(angle / 2)) about `axis`.
fn turn(axis: Vec3, angle: f32) -> Quat {
    let v = 0.5 * angle * axis.normalize();
    Quat::from_xyzw(v.x, v.y, v.z, 1.0).normalize()
}

const CUBOID_FACES: [[u32; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

/// Corner i has +x if bit 0 is set, +y if bit 1, +z if bit 2; the +y face is scaled by `top` in x and z.
fn frustum(half: Vec3, top: f32, shape: Mat3) -> ConvexHull {
    let corner = |i: u32| {
        let sign = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let taper = if i & 2 == 2 { top } else { 1.0 };
        shape * (half * Vec3::new(sign(0) * taper, sign(1), sign(2) * taper))
    };
    ConvexHull::from_faces((0..8).map(corner).collect(), &CUBOID_FACES).expect("a frustum is valid")
}

fn cuboid(half: Vec3) -> ConvexHull {
    frustum(half, 1.0, Mat3::IDENTITY)
}

/// A prism along y over an n-gon on the unit circle (points at rational angles, so not quite regular).
fn prism(n: u32, shape: Mat3) -> ConvexHull {
    let ring = |i: u32| {
        // t runs over (-1, 1) twice: the right and the left half of the circle.
        let u = 4.0 * (i as f32 + 0.5) / n as f32 - 1.0;
        let (t, side) = if u < 1.0 { (u, 1.0) } else { (u - 2.0, -1.0) };
        let scale = side / (1.0 + t * t);
        Vec3::new((1.0 - t * t) * scale, 0.0, 2.0 * t * scale)
    };
    let vertices = (0..n)
        .map(|i| shape * (ring(i) - Vec3::Y))
        .chain((0..n).map(|i| shape * (ring(i) + Vec3::Y)))
        .collect();
    let mut faces: Vec<Vec<u32>> = vec![(0..n).collect(), (n..2 * n).rev().collect()];
    faces.extend((0..n).map(|i| {
        let j = (i + 1) % n;
        vec![i, n + i, n + j, j]
    }));
    ConvexHull::from_faces(vertices, &faces).expect("a prism is valid")
}

/// A random linear map that keeps orientation and does not flatten.
fn random_shape(random: &mut Dice) -> Mat3 {
    let stretch = Mat3::from_diagonal(random.vector(0.2, 1.0));
    Mat3::from_quat(random.rotation()) * stretch * Mat3::from_quat(random.rotation())
}

fn random_hull(random: &mut Dice) -> ConvexHull {
    match random.below(6) {
        4 => icosphere(random.in_range(0.2, 1.0), random.below(2) as u32).expect("a ball is valid"),
        5 => {
            let points: Vec<Vec3> = (0..4 + random.below(20))
                .map(|_| random.vector(-1.0, 1.0))
                .collect();
            ConvexHull::from_points(&points).expect("random points are not flat")
        }
        0 => cuboid(random.vector(0.1, 1.0)),
        1 => frustum(
            random.vector(0.2, 1.0),
            random.in_range(0.05, 0.95),
            Mat3::IDENTITY,
        ),
        2 => frustum(Vec3::ONE, 0.5, random_shape(random)),
        _ => {
            let n = 3 + random.below(9) as u32;
            prism(n, random_shape(random))
        }
    }
}

fn scaled(hull: &ConvexHull, scale: f32) -> ConvexHull {
    let faces: Vec<&[u32]> = hull.faces().iter().map(|f| hull.face_loop(f)).collect();
    ConvexHull::from_faces(hull.vertices().iter().map(|&v| v * scale).collect(), &faces)
        .expect("a scaled hull is valid")
}

/// All that the brute-force separating axis needs, in A's frame and f64.
struct BodyMass {
    vertices: Vec<DVec3>,
    normals: Vec<DVec3>,
    edges: Vec<DVec3>,
}

impl BodyMass {
    fn new(hull: &ConvexHull, pose: &Pose) -> Self {
        let q = pose.rotation.as_dquat().normalize();
        let vertices: Vec<DVec3> = hull
            .vertices()
            .iter()
            .map(|v| q * v.as_dvec3() + pose.position.as_dvec3())
            .collect();
        let newell = |corners: &[u32]| {
            let origin = vertices[corners[0] as usize];
            corners[1..]
                .windows(2)
                .map(|w| (vertices[w[0] as usize] - origin).cross(vertices[w[1] as usize] - origin))
                .sum::<DVec3>()
                .normalize()
        };
        Self {
            normals: hull
                .faces()
                .iter()
                .map(|f| newell(hull.face_loop(f)))
                .collect(),
            edges: hull
                .edges()
                .iter()
                .map(|e| {
                    let [from, to] = e.vertices.map(|v| vertices[v as usize]);
                    (to - from).normalize()
                })
                .collect(),
            vertices,
        }
    }

    fn highest(&self, axis: DVec3) -> f64 {
        self.vertices
            .iter()
            .map(|v| v.dot(axis))
            .fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Gap between the projections onto `axis`, which points from A to B.
fn separation_along(a: &BodyMass, b: &BodyMass, axis: DVec3) -> f64 {
    -b.highest(-axis) - a.highest(axis)
}

/// The largest separation over all face normals and all edge cross products, and its axis.
fn brute_force_axis(a: &BodyMass, b: &BodyMass) -> (f64, DVec3) {
    let crossed = a
        .edges
        .iter()
        .flat_map(|e| b.edges.iter().map(move |f| e.cross(*f)))
        .filter(|c| c.length() > 1e-6)
        .flat_map(|c| [c.normalize(), -c.normalize()]);
    a.normals
        .iter()
        .copied()
        .chain(b.normals.iter().map(|n| -*n))
        .chain(crossed)
        .map(|axis| (separation_along(a, b, axis), axis))
        .fold((f64::NEG_INFINITY, DVec3::X), |best, next| {
            if next.0 > best.0 { next } else { best }
        })
}

/// Random pairs; three of four are built to be hard.
fn random_pair(random: &mut Dice) -> (ConvexHull, ConvexHull, Pose) {
    let mut a = random_hull(random);
    let mut b = random_hull(random);
    let mut pose = Pose::new(random.vector(-1.5, 1.5), random.rotation());
    match random.below(8) {
        0 | 1 => {}
        // Parallel faces and edges.
        2 => {
            (a, b) = (
                cuboid(random.vector(0.1, 1.0)),
                cuboid(random.vector(0.1, 1.0)),
            );
            pose.rotation = Quat::IDENTITY;
        }
        // Nearly parallel ones, from 0.03 rad down to 1e-6.
        3 => {
            (a, b) = (
                cuboid(random.vector(0.1, 1.0)),
                cuboid(random.vector(0.1, 1.0)),
            );
            let angle = [3e-2, 1e-3, 1e-4, 1e-6][random.below(4)];
            pose.rotation = turn(random.vector(-1.0, 1.0), angle);
        }
        // The same hull against itself.
        4 => {
            b = a.clone();
            pose.rotation = turn(random.vector(-1.0, 1.0), 1e-5);
            pose.position *= 0.5;
        }
        // One far inside the other, or very different sizes.
        5 => {
            let scale = random.in_range(0.01, 0.1);
            b = scaled(&b, scale);
            pose.position *= random.in_range(0.0, 1.0);
        }
        // Edge across edge: two long bars crossed, each standing on an edge.
        6 => {
            let bar = Vec3::new(2.0, 0.2, 0.2);
            (a, b) = (
                frustum(bar, 1.0, Mat3::from_quat(turn(Vec3::X, 0.8))),
                frustum(bar, 1.0, Mat3::from_quat(turn(Vec3::X, 0.8))),
            );
            pose.rotation = turn(Vec3::Y, random.in_range(0.1, 3.0));
            pose.position = Vec3::new(
                random.in_range(-0.5, 0.5),
                random.in_range(0.4, 0.6),
                random.in_range(-0.5, 0.5),
            );
        }
        // Touching: moved along the best axis until the gap is zero to rounding.
        _ => {
            let solid_a = BodyMass::new(&a, &Pose::IDENTITY);
            let (gap, axis) = brute_force_axis(&solid_a, &BodyMass::new(&b, &pose));
            pose.position -= (gap * axis).as_vec3();
        }
    }
    (a, b, pose)
}

/// Deepest separation of a patch.
fn deepest(patch: &LocalManifold) -> f32 {
    patch
        .points()
        .iter()
        .map(|p| p.separation)
        .fold(f32::INFINITY, f32::min)
}

/// Size that tolerances are relative to.
fn size_of(a: &ConvexHull, b: &ConvexHull) -> f32 {
    a.aabb().diagonal().min(b.aabb().diagonal())
}

#[test]
fn separating_axis_agrees_with_brute_force() {
    let mut random = Dice::new(7);
    let mut scratch = NarrowScratch::new();
    let mut touching = 0;
    for case in 0..6000 {
        let (a, b, pose) = random_pair(&mut random);
        let (solid_a, solid_b) = (BodyMass::new(&a, &Pose::IDENTITY), BodyMass::new(&b, &pose));
        let (truth, _) = brute_force_axis(&solid_a, &solid_b);
        let size = size_of(&a, &b);
        let margin = 0.02 * size;
        // Rounding: coordinates of up to 5 m, a handful of operations each.
        let rounding = 4e-6;
        // The documented preference for faces, which may be taken twice (second face, then face over edge).
        let slack = 2.0 * (5e-4 * f64::from(size) + 0.02 * truth.abs()) + rounding;
        let patch = collide_hulls(&a, &b, pose, margin, &mut scratch);
        let Some(patch) = patch else {
            assert!(
                truth > -rounding,
                "case {case}: overlap of {truth} m not found"
            );
            continue;
        };
        touching += 1;
        assert!(
            truth <= f64::from(margin) + rounding,
            "case {case}: {truth} > {margin}"
        );
        let along = separation_along(&solid_a, &solid_b, patch.normal.as_dvec3());
        assert!(
            along >= truth - slack,
            "case {case}: axis gives {along}, best is {truth}"
        );
        let found = f64::from(deepest(&patch));
        assert!(
            found >= truth - slack,
            "case {case}: {found} is deeper than {truth}"
        );
        assert!((patch.normal.length() - 1.0).abs() < 1e-5);
    }
    assert!(touching > 3000, "only {touching} of 6000 pairs touch");
}

/// The hulls of a real model's convex parts, each moved to the origin and scaled to a diagonal of 1.
fn real_hulls() -> Vec<ConvexHull> {
    let clouds = crate::models::clouds();
    let usable = clouds
        .iter()
        .enumerate()
        .filter(|(index, _)| !crate::models::FLAT_CLOUDS.contains(index));
    usable
        .map(|(_, cloud)| {
            let points = crate::models::single(cloud);
            let bounds = Aabb::of_points(points.iter().copied());
            let at_origin = |p: Vec3| (p - bounds.center()) / bounds.diagonal();
            let points: Vec<Vec3> = points.into_iter().map(at_origin).collect();
            ConvexHull::from_points(&points).expect("the part is a body")
        })
        .collect()
}

#[test]
fn separating_axis_agrees_with_brute_force_on_real_hulls() {
    let hulls = real_hulls();
    assert_eq!(hulls.len(), 207);
    let mut random = Dice::new(13);
    let mut scratch = NarrowScratch::new();
    for (case, a) in hulls.iter().enumerate() {
        let b = &hulls[random.below(hulls.len())];
        let mut pose = Pose::new(random.vector(-0.3, 0.3), random.rotation());
        let solid_a = BodyMass::new(a, &Pose::IDENTITY);
        let (gap, axis) = brute_force_axis(&solid_a, &BodyMass::new(b, &pose));
        // 2 mm of overlap along the best axis, as two bodies at rest have it.
        pose.position -= ((gap + 0.002) * axis).as_vec3();
        let solid_b = BodyMass::new(b, &pose);
        let (truth, _) = brute_force_axis(&solid_a, &solid_b);
        let slack = 2.0 * (5e-4 * f64::from(size_of(a, b)) + 0.02 * truth.abs()) + 1e-6;
        let patch = collide_hulls(a, b, pose, 0.01, &mut scratch)
            .unwrap_or_else(|| panic!("case {case}: overlap of {truth} m not found"));
        let along = separation_along(&solid_a, &solid_b, patch.normal.as_dvec3());
        assert!(along >= truth - slack, "case {case}: {along} {truth}");
        let found = f64::from(deepest(&patch));
        assert!(
            (found - truth).abs() < slack,
            "case {case}: {found} {truth}"
        );
    }
}

#[test]
fn deepest_point_of_an_overlap_is_as_deep_as_the_axis_says() {
    let mut random = Dice::new(21);
    let mut scratch = NarrowScratch::new();
    let mut worst = 0.0_f64;
    for case in 0..4000 {
        let (a, b, pose) = random_pair(&mut random);
        let (solid_a, solid_b) = (BodyMass::new(&a, &Pose::IDENTITY), BodyMass::new(&b, &pose));
        let (truth, _) = brute_force_axis(&solid_a, &solid_b);
        if truth > 0.0 {
            continue;
        }
        let size = f64::from(size_of(&a, &b));
        let patch = collide_hulls(&a, &b, pose, 0.0, &mut scratch);
        let Some(patch) = patch else {
            assert!(truth > -4e-6, "case {case}: overlap of {truth} m not found");
            continue;
        };
        worst = worst.max((f64::from(deepest(&patch)) - truth) / size);
    }
    assert!(
        worst < 5e-3,
        "shallower than the overlap by {worst} of the size"
    );
}

#[test]
fn patch_points_lie_on_both_surfaces() {
    let mut random = Dice::new(3);
    let mut scratch = NarrowScratch::new();
    for case in 0..2000 {
        let (a, b, pose) = random_pair(&mut random);
        let size = size_of(&a, &b);
        let Some(patch) = collide_hulls(&a, &b, pose, 0.02 * size, &mut scratch) else {
            continue;
        };
        for point in patch.points() {
            let gap = pose.transform_point(point.on_b) - point.on_a;
            let error = (gap - point.separation * patch.normal).length();
            assert!(
                error < 1e-5,
                "case {case}: on_b - on_a differs from separation * normal by {error}"
            );
        }
    }
}

#[test]
fn cuboid_resting_on_cuboid_has_four_corner_points() {
    let mut scratch = NarrowScratch::new();
    let (a, b) = (cuboid(Vec3::new(2.0, 0.5, 2.0)), cuboid(Vec3::splat(0.5)));
    let pose = Pose::new(Vec3::new(0.3, 0.99, -0.2), Quat::IDENTITY);
    let patch = collide_hulls(&a, &b, pose, 0.01, &mut scratch).expect("they overlap by 1 cm");
    assert_eq!(patch.count, 4);
    assert!((patch.normal - Vec3::Y).length() < 1e-6);
    for point in patch.points() {
        assert!((point.separation + 0.01).abs() < 1e-6, "{point:?}");
        assert!(
            (point.on_b.abs() - Vec3::splat(0.5)).length() < 1e-6,
            "{point:?}"
        );
        assert!((point.on_a.y - 0.5).abs() < 1e-6, "{point:?}");
    }
}

#[test]
fn crossed_edges_meet_in_one_point() {
    let mut scratch = NarrowScratch::new();
    let bar = frustum(
        Vec3::new(2.0, 0.2, 0.2),
        1.0,
        Mat3::from_quat(turn(Vec3::X, 0.828_427_1)),
    );
    // 2 atan(0.414) = 45 degrees: each bar has an edge at height 0.2 sqrt 2.
    let height = 2.0 * 0.2 * 2.0_f32.sqrt() - 0.01;
    let pose = Pose::new(Vec3::new(0.1, height, 0.2), turn(Vec3::Y, 2.0));
    let patch = collide_hulls(&bar, &bar, pose, 0.01, &mut scratch).expect("they overlap by 1 cm");
    assert_eq!(patch.count, 1);
    assert!((patch.normal - Vec3::Y).length() < 1e-5, "{}", patch.normal);
    assert!(
        (patch.points[0].separation + 0.01).abs() < 1e-5,
        "{patch:?}"
    );
    // A's edge runs along x through z = 0, B's along z through x = 0.1.
    assert!((patch.points[0].on_a - Vec3::new(0.1, 0.2 * 2.0_f32.sqrt(), 0.0)).length() < 1e-5);
}

/// One rod across another that leans by a small angle has not one point but a pair, where the face beside its edge lies at least.
#[test]
fn a_rod_that_leans_on_a_rod_has_a_pair_of_points() {
    let mut random = Dice::new(30);
    let mut scratch = NarrowScratch::new();
    for _ in 0..4000 {
        let [t, u] = [(); 2].map(|()| 0.5 / random.in_range(10.0, 1000.0));
        let (lower, upper) = (cuboid(Vec3::new(0.5, t, t)), cuboid(Vec3::new(0.5, u, u)));
        let across = turn(Vec3::Y, random.in_range(0.5, 2.0));
        let lean = random.in_range(-0.01, 0.01);
        let rotation = across * turn(Vec3::X, lean);
        // The lower edge of the upper rod is where the lean brings it.
        let low = u * (1.0 + lean.abs());
        let gap = random.in_range(-1e-3, 1e-3) * u.min(t);
        let pose = Pose::new((t + low + gap) * Vec3::Y, rotation);
        let margin = 0.04 * u.max(t);
        let patch = collide_hulls(&lower, &upper, pose, margin, &mut scratch);
        let patch = patch.expect("they touch");
        assert!(
            patch.points().len() >= 2,
            "{} of {t}, {u} by {lean}",
            patch.points().len()
        );
        let rounding = 2e-4 * u.max(t) + 1e-6;
        assert!(
            (deepest(&patch) - gap).abs() <= rounding,
            "{} {gap}",
            deepest(&patch)
        );
        for point in patch.points() {
            let [on_a, on_b] = [point.on_a, pose.transform_point(point.on_b)];
            let along = (on_b - on_a).dot(patch.normal);
            assert!((along - point.separation).abs() <= rounding);
            assert!((on_b - on_a - along * patch.normal).length() <= rounding);
        }
    }
}

#[test]
fn swapped_order_gives_the_mirrored_patch() {
    let mut random = Dice::new(11);
    let mut scratch = NarrowScratch::new();
    let mut compared = 0;
    for case in 0..2000 {
        let (a, b, pose) = random_pair(&mut random);
        let size = size_of(&a, &b);
        let margin = 0.02 * size;
        let patch = collide_hulls(&a, &b, pose, margin, &mut scratch);
        let other = collide_hulls(&b, &a, pose.inverse(), margin, &mut scratch);
        let (Some(patch), Some(other)) = (patch, other) else {
            continue;
        };
        let mirrored = other.swapped(&pose.inverse());
        // A tie between two faces may be decided the other way; then only the depth must agree, within the preference.
        let depth = deepest(&patch);
        let slack = 4.0 * (5e-4 * size + 0.02 * depth.abs());
        assert!(
            (depth - deepest(&mirrored)).abs() < slack.max(5e-3 * size),
            "case {case}: {patch:?} {mirrored:?}"
        );
        if (mirrored.normal - patch.normal).length() < 1e-5 && patch.count == mirrored.count {
            compared += 1;
        }
    }
    assert!(
        compared > 800,
        "only {compared} pairs gave the same normal and count"
    );
    let (a, b) = (cuboid(Vec3::ONE), cuboid(Vec3::splat(0.5)));
    let pose = Pose::new(Vec3::new(0.2, 1.48, 0.1), Quat::IDENTITY);
    let patch = collide_hulls(&a, &b, pose, 0.01, &mut scratch).expect("overlap");
    let mirrored = collide_hulls(&b, &a, pose.inverse(), 0.01, &mut scratch)
        .expect("overlap")
        .swapped(&pose.inverse());
    assert_eq!(patch.normal, mirrored.normal);
    for point in patch.points() {
        let twin = mirrored
            .points()
            .iter()
            .find(|p| (p.on_a - point.on_a).length() < 1e-6);
        assert!(twin.is_some_and(|p| (p.separation - point.separation).abs() < 1e-6));
    }
}

#[test]
fn contacts_scale_with_the_bodies() {
    let mut random = Dice::new(5);
    let mut scratch = NarrowScratch::new();
    for _ in 0..500 {
        let (a, b, pose) = random_pair(&mut random);
        let margin = 0.02 * size_of(&a, &b);
        let patch = collide_hulls(&a, &b, pose, margin, &mut scratch);
        // Powers of two, so that every product scales without rounding and even ties fall the same way.
        for scale in [2.0_f32.recip().powi_exact(10), 1024.0] {
            let big = Pose::new(pose.position * scale, pose.rotation);
            let (a, b) = (scaled(&a, scale), scaled(&b, scale));
            let same = collide_hulls(&a, &b, big, margin * scale, &mut scratch);
            assert_eq!(patch.map(|p| p.count), same.map(|p| p.count));
            if let (Some(patch), Some(same)) = (patch, same) {
                assert_eq!(patch.normal, same.normal);
                assert_eq!(deepest(&patch) * scale, deepest(&same));
            }
        }
    }
}

/// `powi` differs between platforms; this is repeated multiplication.
trait PowiExact {
    fn powi_exact(self, n: u32) -> Self;
}

impl PowiExact for f32 {
    fn powi_exact(self, n: u32) -> Self {
        (0..n).fold(1.0, |product, _| product * self)
    }
}

#[test]
fn a_round_face_keeps_four_spread_points() {
    let mut scratch = NarrowScratch::new();
    let disc = prism(24, Mat3::from_diagonal(Vec3::new(1.0, 0.1, 1.0)));
    let floor = cuboid(Vec3::new(5.0, 0.5, 5.0));
    let pose = Pose::new(Vec3::new(0.0, 0.6, 0.0), Quat::IDENTITY);
    let patch = collide_hulls(&floor, &disc, pose, 0.01, &mut scratch).expect("touching");
    assert_eq!(patch.count, 4);
    let p: Vec<Vec3> = patch.points().iter().map(|p| p.on_a).collect();
    let area = 0.5 * (p[2] - p[0]).cross(p[3] - p[1]).length();
    // A square in the unit circle has area 2; the prism is a slightly irregular 24-gon.
    assert!(area > 1.8, "{area}: {p:?}");
}

#[test]
fn hull_over_half_space_touches_with_its_lowest_corners() {
    let mut scratch = NarrowScratch::new();
    let hull = cuboid(Vec3::new(0.5, 0.25, 1.0));
    // A floor whose frame is turned and shifted against the hull's.
    let floor = Pose::new(Vec3::new(3.0, -0.24, 1.0), turn(Vec3::Y, 0.7));
    let plane = Plane::through(floor.position, Vec3::Y);
    let patch = collide_half_space(&hull, plane, floor, 0.05, &mut scratch).expect("1 cm deep");
    assert_eq!(patch.count, 4);
    assert_eq!(patch.normal, -Vec3::Y);
    for point in patch.points() {
        assert!((point.separation + 0.01).abs() < 1e-6);
        assert_eq!(point.on_a.y, -0.25);
        assert!(
            point.on_b.y.abs() < 1e-6,
            "on the floor's surface: {point:?}"
        );
        assert!((floor.transform_point(point.on_b).xz_distance(point.on_a)) < 1e-6);
    }
    let high = Plane {
        offset: -0.4,
        ..plane
    };
    assert!(collide_half_space(&hull, high, floor, 0.05, &mut scratch).is_none());
    // Inside to the last corner: still pushed out along the plane's normal, by the lowest face.
    let deep = Plane {
        offset: 10.0,
        ..plane
    };
    let patch = collide_half_space(&hull, deep, floor, 0.05, &mut scratch).expect("buried");
    assert_eq!(deepest(&patch), -10.25);
}

trait HorizontalDistance {
    fn xz_distance(self, other: Vec3) -> f32;
}

impl HorizontalDistance for Vec3 {
    fn xz_distance(self, other: Vec3) -> f32 {
        ((self - other) * Vec3::new(1.0, 0.0, 1.0)).length()
    }
}

#[test]
fn bad_numbers_give_no_contact() {
    let mut scratch = NarrowScratch::new();
    let hull = cuboid(Vec3::ONE);
    let nowhere = Pose::new(Vec3::NAN, Quat::IDENTITY);
    let turned = Pose::new(Vec3::ZERO, Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0));
    for pose in [nowhere, turned, Pose::new(Vec3::INFINITY, Quat::IDENTITY)] {
        assert!(collide_hulls(&hull, &hull, pose, 0.1, &mut scratch).is_none());
    }
    assert!(collide_hulls(&hull, &hull, Pose::IDENTITY, f32::NAN, &mut scratch).is_none());
    let bad = Plane::through(Vec3::ZERO, Vec3::ZERO);
    assert!(collide_half_space(&hull, bad, Pose::IDENTITY, 0.1, &mut scratch).is_none());
}

#[test]
fn anchors_of_a_manifold_meet_in_the_world() {
    let mut random = Dice::new(9);
    let mut scratch = NarrowScratch::new();
    for _ in 0..300 {
        let (a, b, pose) = random_pair(&mut random);
        let Some(patch) = collide_hulls(&a, &b, pose, 0.05, &mut scratch) else {
            continue;
        };
        let pose_a = Pose::new(random.vector(-3.0, 3.0), random.rotation());
        let pose_b = Pose::new(
            pose_a.transform_point(pose.position),
            pose_a.rotation * pose.rotation,
        );
        let body = |slot, pose, hull: &ConvexHull| ManifoldBody {
            slot,
            pose,
            center: Vec3::new(0.1, -0.2, 0.05),
            code_box: Some(KdBox::around(hull.aabb())),
        };
        let (body_a, body_b) = (body(4, pose_a, &a), body(2, pose_b, &b));
        let manifold = Manifold::from_local(&body_a, &body_b, &patch, 0.5, 0.1);
        assert_eq!(
            (manifold.a, manifold.b, manifold.count),
            (4, 2, patch.count)
        );
        for (point, local) in manifold.points().iter().zip(patch.points()) {
            let center = |body: &ManifoldBody| body.pose.transform_point(body.center);
            let from_a = center(&body_a) + point.anchor_a;
            let from_b = center(&body_b) + point.anchor_b;
            assert!((from_a - from_b).length() < 2e-5, "{from_a} {from_b}");
            assert_eq!(
                point.code_a,
                body_a.code_box.map_or(KdCode(0), |k| k.encode(local.on_a))
            );
        }
    }
}

/// The broad phase's promise, by comparing all with all.
fn brute_force_pairs(broadphase: &Broadphase, proxies: &[Option<Proxy>]) -> Vec<(BodyId, BodyId)> {
    let live: Vec<(u32, Proxy)> = proxies
        .iter()
        .enumerate()
        .filter_map(|(slot, p)| Some((slot as u32, (*p)?)))
        .collect();
    let touch = |(s, p): &(u32, Proxy), (t, q): &(u32, Proxy)| {
        let boxes = (broadphase.kept_box(*s), broadphase.kept_box(*t));
        let near = match (p.shape, q.shape, boxes) {
            (_, _, (Some(k), Some(l))) => k.overlaps(&l),
            (ProxyShape::HalfSpace(plane), _, (None, Some(l))) => below(&l, &plane),
            (_, ProxyShape::HalfSpace(plane), (Some(k), None)) => below(&k, &plane),
            _ => false,
        };
        let moves = p.kind == ProxyKind::Moving || q.kind == ProxyKind::Moving;
        near && moves && p.layers.interact(&q.layers)
    };
    let mut pairs = Vec::new();
    for (i, p) in live.iter().enumerate() {
        for q in &live[i + 1..] {
            if touch(p, q) {
                pairs.push((p.1.id.min(q.1.id), p.1.id.max(q.1.id)));
            }
        }
    }
    pairs.sort_unstable();
    pairs
}

/// Whether any of the eight corners is on or below the plane.
fn below(b: &Aabb, plane: &Plane) -> bool {
    (0..8).any(|i| {
        let pick = |axis: usize| {
            if i >> axis & 1 == 1 {
                b.max[axis]
            } else {
                b.min[axis]
            }
        };
        plane.distance(Vec3::new(pick(0), pick(1), pick(2))) <= 0.0
    })
}

fn named_pairs(broadphase: &Broadphase, proxies: &[Option<Proxy>]) -> Vec<(BodyId, BodyId)> {
    let name = |slot: u32| proxies[slot as usize].expect("a pair names live bodies").id;
    broadphase
        .pairs()
        .iter()
        .map(|&Pair { a, b }| (name(a), name(b)))
        .collect()
}

fn random_proxy(random: &mut Dice, id: u32) -> Proxy {
    let center = random.vector(-10.0, 10.0);
    let half = random.vector(0.05, 0.8);
    let shape = if random.below(40) == 0 {
        ProxyShape::HalfSpace(Plane::through(0.8 * center, random.vector(-1.0, 1.0)))
    } else {
        ProxyShape::Box(Aabb {
            min: center - half,
            max: center + half,
        })
    };
    Proxy {
        id: BodyId(id),
        kind: if random.below(5) == 0 {
            ProxyKind::Fixed
        } else {
            ProxyKind::Moving
        },
        layers: CollisionLayers {
            memberships: 1 << random.below(3),
            filters: if random.below(4) == 0 {
                0b011
            } else {
                u32::MAX
            },
        },
        shape,
    }
}

/// One step of a scene: bodies move, a few appear in free slots, vanish, change layer, go bad or jump.
fn disturb(random: &mut Dice, proxies: &mut Vec<Option<Proxy>>, next_id: &mut u32) {
    for slot in proxies.iter_mut() {
        let Some(proxy) = slot else {
            if random.below(4) == 0 {
                *slot = Some(random_proxy(random, *next_id));
                *next_id += 1;
            }
            continue;
        };
        if let ProxyShape::Box(b) = &mut proxy.shape {
            let step = random.vector(-0.06, 0.06) * if random.below(30) == 0 { 50.0 } else { 1.0 };
            b.min += step;
            b.max += step;
        }
        match random.below(200) {
            0..=2 => *slot = None,
            3 => proxy.layers.filters ^= 0b101,
            4 => *slot = Some(random_proxy(random, *next_id + 1_000_000)),
            _ => {}
        }
        *next_id += 1;
    }
    if random.below(3) == 0 {
        proxies.push(Some(random_proxy(random, *next_id)));
        *next_id += 1;
    }
}

#[test]
fn pairs_agree_with_brute_force_over_many_steps() {
    let mut random = Dice::new(1);
    let mut broadphase = Broadphase::new();
    let mut next_id = 200;
    let mut proxies: Vec<_> = (0..200)
        .map(|i| Some(random_proxy(&mut random, i)))
        .collect();
    let mut seen = 0;
    for step in 0..300 {
        disturb(&mut random, &mut proxies, &mut next_id);
        broadphase.update(&proxies, 0.1);
        let found = named_pairs(&broadphase, &proxies);
        assert_eq!(
            found,
            brute_force_pairs(&broadphase, &proxies),
            "step {step}"
        );
        for (slot, proxy) in proxies.iter().enumerate() {
            if let (Some(ProxyShape::Box(b)), Some(kept)) =
                (proxy.map(|p| p.shape), broadphase.kept_box(slot as u32))
            {
                assert!(kept.contains(&b), "step {step}: kept box lost its body");
            }
        }
        seen += found.len();
    }
    assert!(seen > 30_000, "too few pairs to mean anything: {seen}");
    broadphase.update(&[], 0.1);
    assert!(broadphase.pairs().is_empty());
    broadphase.update(&proxies, 0.1);
    assert_eq!(
        named_pairs(&broadphase, &proxies),
        brute_force_pairs(&broadphase, &proxies)
    );
}

#[test]
fn pairs_do_not_depend_on_where_bodies_are_stored() {
    let mut random = Dice::new(2);
    let (mut here, mut there) = (Broadphase::new(), Broadphase::new());
    let mut next_id = 100;
    let mut proxies: Vec<_> = (0..100)
        .map(|i| Some(random_proxy(&mut random, i)))
        .collect();
    for _ in 0..50 {
        disturb(&mut random, &mut proxies, &mut next_id);
        let backwards: Vec<_> = proxies.iter().rev().copied().collect();
        here.update(&proxies, 0.1);
        // Slots shift whenever the list grows, so this tree is torn down and rebuilt again and again.
        there = if random.below(2) == 0 {
            Broadphase::new()
        } else {
            there
        };
        there.update(&backwards, 0.1);
        let tight = |b: &Broadphase, p: &[Option<Proxy>]| {
            let mut pairs = named_pairs(b, p);
            pairs.retain(|pair| tight_boxes_meet(p, *pair));
            pairs
        };
        assert_eq!(tight(&here, &proxies), tight(&there, &backwards));
    }
}

/// Whether the boxes given for two bodies, not the kept ones, overlap.
fn tight_boxes_meet(proxies: &[Option<Proxy>], pair: (BodyId, BodyId)) -> bool {
    let shape = |id| {
        proxies
            .iter()
            .flatten()
            .find(|p| p.id == id)
            .map(|p| p.shape)
    };
    match (shape(pair.0), shape(pair.1)) {
        (Some(ProxyShape::Box(a)), Some(ProxyShape::Box(b))) => a.overlaps(&b),
        _ => false,
    }
}

#[test]
fn absent_and_non_finite_proxies_leave_the_others_alone() {
    let mut random = Dice::new(4);
    let mut proxies: Vec<_> = (0..50)
        .map(|i| Some(random_proxy(&mut random, i)))
        .collect();
    let mut clean = Broadphase::new();
    clean.update(&proxies, 0.1);
    let expected = named_pairs(&clean, &proxies);
    let bad = |id, min: Vec3, max: Vec3| Proxy {
        id: BodyId(id),
        shape: ProxyShape::Box(Aabb { min, max }),
        kind: ProxyKind::Moving,
        layers: CollisionLayers {
            memberships: u32::MAX,
            filters: u32::MAX,
        },
    };
    proxies.push(Some(bad(900, Vec3::NAN, Vec3::ONE)));
    proxies.push(Some(bad(901, Vec3::NEG_INFINITY, Vec3::INFINITY)));
    proxies.push(Some(bad(902, Vec3::ONE, Vec3::NEG_ONE)));
    proxies.push(None);
    let mut dirty = Broadphase::new();
    for _ in 0..3 {
        dirty.update(&proxies, 0.1);
        assert_eq!(named_pairs(&dirty, &proxies), expected);
    }
    // A huge but finite box is a body like any other.
    proxies.push(Some(bad(903, Vec3::splat(-1e30), Vec3::splat(1e30))));
    dirty.update(&proxies, 0.1);
    assert_eq!(
        named_pairs(&dirty, &proxies),
        brute_force_pairs(&dirty, &proxies)
    );
}
