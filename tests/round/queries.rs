//! Questions about round bodies against what their formulas say.

use crate::any_shape;
use crate::common::dice::Dice;
use crate::common::scenes::awake;
use bevy_cleave::prelude::*;
use glam::Vec3;

/// One body at the origin, turned any way.
fn alone(mesh: ConvexMesh, dice: &mut Dice) -> (Simulation, u32) {
    let mut simulation = Simulation {
        gravity: Gravity(Vec3::ZERO),
        ..awake()
    };
    let mut desc = BodyDesc::dynamic(mesh, dice.vector(-1.0, 1.0));
    desc.pose.rotation = dice.rotation();
    let slot = simulation.bodies.insert(desc).expect("usable");
    simulation.step(1e-6);
    (simulation, slot)
}

#[test]
fn rays_meet_a_sphere_where_the_equation_says() {
    let mut dice = Dice::new(1);
    for _ in 0..2000 {
        let radius = dice.in_range(0.1, 1.0);
        let (mut simulation, slot) = alone(ConvexMesh::sphere(radius).expect("usable"), &mut dice);
        let center = simulation.bodies.pose(slot).position;
        let (origin, direction) = (dice.vector(-3.0, 3.0), dice.direction());
        let ray = Ray::new(origin, direction, 10.0).expect("usable");
        let (from, d) = ((origin - center).as_dvec3(), ray.direction().as_dvec3());
        let (half, r) = (from.dot(d), f64::from(radius));
        let square = half * half - from.length_squared() + r * r;
        let hit = simulation.queries().cast_ray(&ray, &QueryFilter::all());
        if from.length() <= r {
            assert_eq!(hit.expect("inside").distance, 0.0);
            let left = simulation
                .queries()
                .cast_ray(&ray.hollow(), &QueryFilter::all());
            let expected = -half + square.sqrt();
            let found = f64::from(left.expect("it leaves").distance);
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
            continue;
        }
        let expected = (square > 0.0 && half < 0.0).then(|| -half - square.sqrt());
        match (hit, expected) {
            (Some(hit), Some(expected)) => {
                assert!((f64::from(hit.distance) - expected).abs() < 1e-5);
                assert!((hit.point.distance(center) - radius).abs() < 1e-5);
            }
            (None, None) => {}
            _ => assert!(square.abs() < 1e-5, "{square}"),
        }
    }
}

#[test]
fn rays_casts_and_nearest_points_agree() {
    let mut dice = Dice::new(2);
    let all = QueryFilter::all();
    let mut met = 0;
    for _ in 0..1500 {
        let mesh = any_shape(&mut dice);
        let (mut simulation, _) = alone(mesh, &mut dice);
        let queries = simulation.queries();
        let (origin, direction) = (dice.vector(-3.0, 3.0), dice.direction());
        let ray = Ray::new(origin, direction, 10.0).expect("usable");
        let nearest = queries.closest_point(origin, 100.0, &all).expect("a point");
        let nearest = nearest.expect("there is a body");
        let hit = queries.cast_ray(&ray, &all);
        if let Some(hit) = hit.filter(|_| nearest.distance > 1e-4) {
            // No ray gets to the body on a shorter way than the shortest.
            assert!(hit.distance > nearest.distance - 1e-4);
            // Where it hits there is the surface.
            let there = queries
                .closest_point(hit.point, 1.0, &all)
                .expect("a point");
            let there = there.expect("on the body");
            assert!(there.distance.abs() < 1e-4, "{}", there.distance);
            // A little ball along the same ray is there earlier by about its radius over the slope.
            let ball = QueryShape::sphere(0.02).expect("usable");
            let pose = Pose::new(origin, glam::Quat::IDENTITY);
            let cast = ShapeCast::new(ball, pose, direction, 10.0).expect("usable");
            let touch = queries.cast_shape(&cast, &all).expect("the ray hits too");
            assert!(touch.distance <= hit.distance - 0.02 + 1e-4);
            let center = ray.at(touch.distance);
            let gap = queries.closest_point(center, 1.0, &all).expect("a point");
            let gap = gap.expect("near").distance;
            assert!((gap - 0.02).abs() < 1e-4 || touch.distance == 0.0, "{gap}");
        }
        // A ray to the nearest point meets it there.
        if nearest.distance > 1e-3 {
            let towards = Ray::between(origin, nearest.point - 0.01 * nearest.normal);
            let hit = queries.cast_ray(&towards.expect("usable"), &all);
            // One that goes by a rim or a tip may miss it by rounding.
            if let Some(hit) = hit {
                met += 1;
                let off = (hit.distance - nearest.distance).abs();
                assert!(off < 1e-3, "{off} m off");
            }
        }
    }
    assert!(met > 1200, "{met}");
}

#[test]
fn overlaps_of_round_bodies_are_where_they_are_near() {
    let mut dice = Dice::new(3);
    let all = QueryFilter::all();
    for _ in 0..1500 {
        let (mut simulation, _) = alone(any_shape(&mut dice), &mut dice);
        let asked = any_shape(&mut dice);
        let shape = QueryShape::from(&asked);
        let pose = Pose::new(dice.vector(-1.0, 1.0), dice.rotation());
        let queries = simulation.queries();
        let (mut found, mut near) = (Vec::new(), Vec::new());
        queries
            .overlap_shape(&shape, &pose, &all, &mut found)
            .expect("usable");
        queries
            .near_shape(&shape, &pose, 5.0, &all, &mut near)
            .expect("usable");
        let distance = near[0].distance;
        assert!(found.is_empty() == (distance > 0.0) || distance.abs() < 1e-4);
    }
}

/// A point of either was told that the moved shape had gone past where rounding left no gap.
#[test]
fn where_a_moved_shape_stops_is_a_point_of_both() {
    let mut dice = Dice::new(4);
    let all = QueryFilter::all();
    let mut hits = 0;
    for _ in 0..1500 {
        let (mut simulation, slot) = alone(any_shape(&mut dice), &mut dice);
        let scale = dice.in_range(0.03, 0.6);
        let moved = any_shape(&mut dice).scaled(Vec3::splat(scale));
        let moved = moved.expect("usable");
        let (origin, aim) = (dice.vector(-3.0, 3.0), dice.vector(-0.2, 0.2));
        let aim = simulation.bodies.pose(slot).position + aim;
        let pose = Pose::new(origin, dice.rotation());
        let shape = QueryShape::from(&moved);
        let cast = ShapeCast::new(shape, pose, aim - origin, 10.0).expect("usable");
        let Some(hit) = simulation.queries().cast_shape(&cast, &all) else {
            continue;
        };
        if hit.distance == 0.0 {
            continue;
        }
        hits += 1;
        let there = origin + hit.distance * (aim - origin).normalize();
        let desc = BodyDesc {
            pose: Pose::new(there, pose.rotation),
            ..BodyDesc::new(RigidBody::Static, Shape::Convex(moved.clone()))
        };
        let mut other = awake();
        other.bodies.insert(desc).expect("usable");
        for simulation in [&mut simulation, &mut other] {
            let near = simulation.queries().closest_point(hit.point, 1.0, &all);
            let off = near.expect("a point").expect("near").distance;
            assert!(off.abs() < 1e-4, "{off} m off");
        }
    }
    assert!(hits > 1000, "{hits}");
}

/// A shape that has got a little into a low box or an edge: how far it is pushed out, and how far it had to go, m.
fn pushed_out(dice: &mut Dice) -> Option<(f32, f32)> {
    let mesh = match dice.below(4) {
        0 => ConvexMesh::cylinder(0.3, 1.6),
        1 => ConvexMesh::cuboid(0.6, 1.6, 0.6),
        2 => ConvexMesh::capsule(0.3, 1.0),
        _ => ConvexMesh::cone(0.3, 1.6),
    };
    let (mesh, size) = (mesh.expect("usable"), dice.vector(0.05, 2.0));
    let low = ConvexMesh::cuboid(size.x, 0.3 * size.y, size.z).expect("usable");
    let (mut simulation, slot) = alone(low, dice);
    let shape = QueryShape::from(&mesh);
    let aim = simulation.bodies.pose(slot).position + dice.vector(-1.0, 1.0);
    let (direction, turn) = (dice.direction(), dice.rotation());
    let start = Pose::new(aim - 6.0 * direction, turn);
    let (queries, all) = (simulation.queries(), QueryFilter::all());
    let cast = ShapeCast::new(shape, start, direction, 12.0).expect("usable");
    let hit = queries.cast_shape(&cast, &all)?;
    let (depth, skin) = (dice.in_range(1e-3, 0.02), 0.01);
    let touching = start.position + hit.distance * direction;
    let within = Pose::new(touching - depth * hit.normal, turn);
    let slider = Slider { shape, skin };
    let slid = queries.move_and_slide(&slider, within, Vec3::ZERO, &all, &mut Vec::new());
    Some((slid.position.distance(within.position), depth + 0.5 * skin))
}

/// It took all of a shape out of a body by the way that led to its middle: 40 cm for 8 mm in a low box.
#[test]
fn what_overlaps_a_little_is_pushed_out_a_little() {
    let mut dice = Dice::new(5);
    let pushed: Vec<_> = (0..3000).filter_map(|_| pushed_out(&mut dice)).collect();
    assert!(pushed.len() > 1000, "{}", pushed.len());
    for (way, needed) in pushed {
        assert!(way < needed + 1e-4, "{way} m instead of {needed} m");
    }
}
