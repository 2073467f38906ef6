//! Questions to a compound are answered as the same questions to its parts as bodies of their own.

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use bevy_cleave::prelude::*;
use glam::Vec3;

const CASES: usize = 20_000;

/// A part of random kind, size and pose.
fn part(dice: &mut Dice) -> (Pose, ConvexMesh) {
    let size = dice.in_range(0.1, 0.6);
    let shape = match dice.below(4) {
        0 => ConvexMesh::sphere(0.5 * size),
        1 => ConvexMesh::capsule(0.2 * size, size),
        2 => ConvexMesh::icosphere(0.5 * size, 1),
        _ => ConvexMesh::cuboid(size, 0.5 * size, 0.3 * size),
    };
    let pose = Pose::new(dice.vector(-0.8, 0.8), dice.rotation());
    (pose, shape.expect("valid sizes"))
}

/// A compound in one scene, and its parts in another one.
fn scenes(dice: &mut Dice, count: usize) -> [Simulation; 2] {
    let place = Pose::new(dice.vector(-1.0, 1.0), dice.rotation());
    let parts: Vec<_> = (0..count).map(|_| part(dice)).collect();
    let mut scenes = [awake(), awake()];
    for (pose, shape) in &parts {
        let desc = BodyDesc {
            pose: place * *pose,
            ..BodyDesc::new(RigidBody::Static, Shape::Convex(shape.clone()))
        };
        scenes[0].bodies.insert(desc).expect("usable");
    }
    let whole = Compound::new(parts).expect("usable parts");
    let desc = BodyDesc {
        pose: place,
        ..BodyDesc::new(RigidBody::Static, Shape::Compound(whole))
    };
    scenes[1].bodies.insert(desc).expect("usable");
    scenes.iter_mut().for_each(|scene| {
        scene.step(1.0 / 60.0);
    });
    scenes
}

/// That both have an answer, or none, and what of it is the same.
fn compare(what: &str, of_parts: Option<QueryHit>, of_whole: Option<QueryHit>) {
    let (a, b) = match (of_parts, of_whole) {
        (None, None) => return,
        (Some(a), Some(b)) => (a, b),
        (a, b) => panic!("{what}: {a:?} {b:?}"),
    };
    assert!(
        (a.distance - b.distance).abs() < 3e-5,
        "{what}: {a:?} {b:?}"
    );
    // Where two parts are equally far either may be told.
    if a.body == b.part {
        assert!(a.point.distance(b.point) < 3e-3, "{what}: {a:?} {b:?}");
    }
}

#[test]
fn rays_casts_and_nearest_points_are_those_of_the_parts() {
    let dice = &mut Dice::new(5);
    let mut counts = [0; 4];
    for count in [1, 3, 8, 9, 40] {
        let [mut parts, mut whole] = scenes(dice, count);
        let all = QueryFilter::all();
        for _ in 0..CASES / 5 {
            let (from, to) = (dice.vector(-2.5, 2.5), dice.vector(-1.5, 1.5));
            let ray = Ray::new(from, to - from, 4.0).expect("usable");
            let [a, b] = [&mut parts, &mut whole].map(|s| s.queries().cast_ray(&ray, &all));
            counts[0] += usize::from(a.is_some());
            compare("ray", a, b);
            let shape = match dice.below(3) {
                0 => QueryShape::sphere(0.1),
                1 => QueryShape::capsule(0.05, 0.2),
                _ => QueryShape::cuboid(Vec3::new(0.1, 0.2, 0.05)),
            }
            .expect("usable");
            let pose = Pose::new(from, dice.rotation());
            let cast = ShapeCast::new(shape, pose, to - from, 4.0).expect("usable");
            let [a, b] = [&mut parts, &mut whole].map(|s| s.queries().cast_shape(&cast, &all));
            counts[1] += usize::from(a.is_some());
            if a.is_none_or(|a| a.distance > 0.0) {
                compare("cast", a, b);
            }
            let [a, b] = [&mut parts, &mut whole].map(|s| {
                let found = s.queries().closest_point(from, 0.5, &all);
                found.expect("usable")
            });
            counts[2] += usize::from(a.is_some());
            compare("closest point", a, b);
            let pose = Pose::new(to, dice.rotation());
            let [a, b] = [&mut parts, &mut whole].map(|s| {
                let mut found = Vec::new();
                s.queries()
                    .overlap_shape(&shape, &pose, &all, &mut found)
                    .expect("usable");
                !found.is_empty()
            });
            counts[3] += usize::from(a);
            assert_eq!(a, b, "overlap");
        }
    }
    assert!(
        counts.iter().all(|&count| count > CASES / 100),
        "{counts:?}"
    );
}

#[test]
fn a_ray_from_inside_leaves_the_whole() {
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid");
    let row = (0..12).map(|i| (Pose::from_position(i as f32 * Vec3::X), cube.clone()));
    let row = Compound::new(row).expect("usable");
    let mut scene = awake();
    let desc = BodyDesc::new(RigidBody::Static, Shape::Compound(row));
    scene.bodies.insert(desc).expect("usable");
    scene.step(1.0 / 60.0);
    let all = QueryFilter::all();
    let from = Vec3::new(0.2, 0.1, 0.1);
    let ray = Ray::new(from, Vec3::X, 100.0).expect("usable");
    let inside = scene.queries().cast_ray(&ray, &all).expect("a hit");
    assert_eq!(inside.distance, 0.0);
    let hollow = ray.hollow();
    let out = scene.queries().cast_ray(&hollow, &all).expect("a hit");
    assert!((out.distance - 11.3).abs() < 1e-4, "{out:?}");
    assert_eq!(out.part, 11);
    let short = Ray::new(from, Vec3::X, 5.0).expect("usable").hollow();
    assert!(scene.queries().cast_ray(&short, &all).is_none());
}
