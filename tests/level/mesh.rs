//! Bodies on a level of triangles behave as on ground in one piece: nothing catches at an edge, and nothing falls through.

#![expect(
    clippy::disallowed_methods,
    reason = "shapes of scenes, and drawn speeds"
)]
#![expect(clippy::print_stdout, reason = "the measured figures are the result")]

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use crate::common::structures::{block, cuboid};
use bevy_cleave::geometry::EdgeKind;
use bevy_cleave::prelude::*;
use glam::{DVec3, Quat, Vec3};

const H: f32 = 1.0 / 60.0;

/// Ground as positions and triangles.
type Ground = (Vec<Vec3>, Vec<[u32; 3]>);

/// A square grid of so many cells around the origin, of a height, with inner corners put aside.
fn grid(dice: &mut Dice, cells: usize, size: f32, height: impl Fn(Vec3) -> f32) -> Ground {
    let cell = size / cells as f32;
    let mut positions = Vec::new();
    for i in 0..=cells {
        for k in 0..=cells {
            let is_inner = i > 0 && k > 0 && i < cells && k < cells;
            let off = if is_inner {
                dice.vector(-0.3, 0.3)
            } else {
                Vec3::ZERO
            };
            let at = cell * (Vec3::new(i as f32, 0.0, k as f32) + off)
                - 0.5 * size * Vec3::new(1.0, 0.0, 1.0);
            positions.push(Vec3::new(at.x, height(at), at.z));
        }
    }
    let corner = |i: usize, k: usize| (i * (cells + 1) + k) as u32;
    let mut triangles = Vec::new();
    for i in 0..cells {
        for k in 0..cells {
            let [a, b, c, d] = [
                corner(i, k),
                corner(i + 1, k),
                corner(i + 1, k + 1),
                corner(i, k + 1),
            ];
            triangles.extend(if dice.below(2) == 0 {
                [[a, d, c], [a, c, b]]
            } else {
                [[a, d, b], [b, d, c]]
            });
        }
    }
    (positions, triangles)
}

/// Flat ground of long thin triangles that fan out from a corner far away.
fn fan(count: usize, size: f32) -> Ground {
    let mut positions = vec![Vec3::new(-size, 0.0, 0.0)];
    positions.extend(
        (0..=count).map(|i| Vec3::new(size, 0.0, size * (2.0 * i as f32 / count as f32 - 1.0))),
    );
    let triangles = (1..=count as u32).map(|i| [0, i, i + 1]);
    let triangles = triangles.map(|[a, b, c]| [a, c, b]).collect();
    (positions, triangles)
}

/// Triangles doubled, others without area, and one cell cut so that corners meet edges.
fn spoil((mut positions, mut triangles): Ground, dice: &mut Dice) -> Ground {
    for _ in 0..triangles.len() / 4 {
        let [a, b, c] = triangles[dice.below(triangles.len())];
        match dice.below(3) {
            0 => triangles.push([b, c, a]),
            1 => triangles.push([a, a, b]),
            _ => {
                // A corner in the middle of an edge that the neighbor does not have.
                let at = triangles
                    .iter()
                    .position(|t| *t == [a, b, c])
                    .expect("it is there");
                let middle = positions.len() as u32;
                positions.push(0.5 * (positions[a as usize] + positions[b as usize]));
                triangles[at] = [a, middle, c];
                triangles.push([middle, b, c]);
            }
        }
    }
    (positions, triangles)
}

fn level_of((positions, triangles): &Ground) -> StaticMesh {
    StaticMesh::new(positions, triangles).expect("a usable ground")
}

fn fixed(mesh: StaticMesh, mu: f32) -> BodyDesc {
    BodyDesc {
        friction: Friction::new(mu),
        ..BodyDesc::level(mesh)
    }
}

fn slider(dice: &mut Dice) -> (ConvexMesh, f32) {
    let size = 0.3 + dice.unit();
    match dice.below(4) {
        0 => (cuboid(Vec3::splat(size)), 0.5 * size),
        1 => (cuboid(Vec3::new(size, 0.2 * size, 0.7 * size)), 0.1 * size),
        2 => (
            cuboid(Vec3::new(2.0 * size, 0.1 * size, 0.1 * size)),
            0.05 * size,
        ),
        _ => {
            let prism = ConvexMesh::regular_prism(3 + dice.below(6) as u32, 0.5 * size, 0.4 * size);
            (prism.expect("valid sizes"), 0.2 * size)
        }
    }
}

#[test]
fn sliding_over_triangles_is_sliding_over_a_plane() {
    let mut worst = [0.0_f32; 2];
    for seed in 0..120 {
        let mut dice = Dice::new(seed);
        let ground = match dice.below(3) {
            0 => fan(40 + dice.below(200), 30.0),
            1 => grid(&mut dice, 40, 40.0, |_| 0.0),
            _ => {
                let plain = grid(&mut dice, 30, 40.0, |_| 0.0);
                spoil(plain, &mut dice)
            }
        };
        let (shape, height) = slider(&mut dice);
        let speed = 0.1 * 300.0_f32.powf(dice.unit());
        let mu = [0.0, 0.1][dice.below(2)];
        let yaw = Quat::from_rotation_y(3.0 * dice.unit());
        let steps = ((14.0 / speed / H) as usize).min(120);
        let run = |level: BodyDesc| {
            let mut simulation = awake();
            simulation.bodies.insert(level).expect("usable");
            let mut body = block(&shape, Vec3::new(-7.0, height, 0.1), mu);
            body.pose.rotation = yaw;
            body.linear_velocity = speed * Vec3::X;
            let body = simulation.bodies.insert(body).expect("usable");
            (0..steps).for_each(|_| simulation.step(H));
            (
                simulation.bodies.center_of_mass(body),
                simulation.bodies.velocity(body),
            )
        };
        let plane = BodyDesc {
            friction: Friction::new(mu),
            ..BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y })
        };
        let ((x, (v, w)), (y, (u, spin))) = (run(fixed(level_of(&ground), mu)), run(plane));
        let off = (v - u).length() / speed + 0.1 * (w - spin).length() / speed;
        worst[0] = worst[0].max(off);
        worst[1] = worst[1].max((x - y).y.abs() / height);
        assert!(
            off < 2e-3,
            "{seed}: {v} instead of {u} at {speed} m/s, turning by {w}"
        );
        assert!(
            (x - y).y.abs() < 1e-3 * height,
            "{seed}: {x} instead of {y}"
        );
    }
    println!(
        "speed off by {:.1e}, height by {:.1e} of the body",
        worst[0], worst[1]
    );
}

#[test]
fn a_ridge_and_a_dome_are_passed_without_a_hop() {
    for seed in 0..20 {
        let mut dice = Dice::new(100 + seed);
        let (bend, speed) = (0.002 + 0.01 * dice.unit(), 1.0 + 3.0 * dice.unit());
        let (mut positions, triangles) =
            grid(&mut dice, 40, 40.0, |at| -bend * at.length_squared());
        // Two sides of a roof for every other member.
        if seed % 2 == 0 {
            positions.iter_mut().for_each(|p| p.y = -0.05 * p.x.abs());
        }
        let mut simulation = awake();
        let level = StaticMesh::new(&positions, &triangles).expect("usable");
        simulation.bodies.insert(fixed(level, 0.0)).expect("usable");
        let mut body = block(&cuboid(Vec3::splat(0.5)), Vec3::new(-6.0, 0.0, 0.0), 0.0);
        let under = if seed % 2 == 0 { -0.3 } else { -36.0 * bend };
        body.pose.position.y = under + 0.27;
        body.linear_velocity = Vec3::new(speed, 0.0, 0.0);
        let body = simulation.bodies.insert(body).expect("usable");
        (0..60).for_each(|_| simulation.step(H));
        let energy = |s: &Simulation| {
            let mass = f64::from(s.bodies.mass(body).mass);
            let height = f64::from(s.bodies.center_of_mass(body).y);
            s.bodies.kinetic_energy(body) / mass + 9.81 * height
        };
        let before = energy(&simulation);
        for _ in 0..120 {
            simulation.step(H);
            let (v, w) = simulation.bodies.velocity(body);
            assert!(v.y.abs() < 0.2 * v.length() + 0.05, "{seed}: hops at {v}");
            // A cube tips over the ridge of a roof.
            let most = if seed % 2 == 0 { 3.0 } else { 1.0 };
            assert!(w.length() < most, "{seed}: turns by {w}");
        }
        let lost = (before - energy(&simulation)) / f64::from(0.5 * speed * speed);
        println!("{seed}: {speed:.2} m/s, bend {bend:.4}, lost {lost:.4}");
        assert!(
            (-0.06..0.15).contains(&lost),
            "{seed}: lost {lost} of the energy"
        );
    }
}

#[test]
fn shots_at_rough_ground_do_not_get_through() {
    let mut dice = Dice::new(7);
    let mut fallen = 0;
    for member in 0..150 {
        let bumps = dice.in_range(0.0, 0.3);
        let ground = grid(&mut dice, 60, 60.0, |at| {
            bumps * ((at.x * 0.9).sin() + (at.z * 0.7).cos())
        });
        let mut simulation = awake();
        simulation
            .bodies
            .insert(fixed(level_of(&ground), 0.5))
            .expect("usable");
        let (shape, _) = slider(&mut dice);
        let speed = 3.0 * 100.0_f32.powf(dice.unit());
        let towards = Vec3::new(dice.in_range(-3.0, 3.0), 0.0, dice.in_range(-3.0, 3.0));
        let from = Vec3::new(dice.in_range(-10.0, 10.0), 8.0, dice.in_range(-10.0, 10.0));
        let mut body = block(&shape, from, 0.5);
        body.pose.rotation = dice.rotation();
        body.linear_velocity = speed * (towards - from).normalize();
        let body = simulation.bodies.insert(body).expect("usable");
        let mut trace = Vec::new();
        for _ in 0..60 {
            simulation.step(H);
            let at = simulation.bodies.center_of_mass(body);
            let (v, _) = simulation.bodies.velocity(body);
            let contacts = simulation.report.contacts;
            trace.push(format!("{at:.3} at {v:.2} m/s, {contacts} contacts"));
            let is_over = at.x.abs() < 29.0 && at.z.abs() < 29.0;
            // A splinter that turns may be below for some steps.
            if is_over && at.y < -2.0 * bumps - 1.0 {
                fallen += 1;
                println!(
                    "{member}: {speed} m/s, bumps {bumps}:\n{}",
                    trace.join("\n")
                );
                break;
            }
        }
    }
    assert_eq!(fallen, 0, "{fallen} fell through");
}

#[test]
fn bodies_come_to_rest_in_a_room_and_on_a_terrain() {
    let mut dice = Dice::new(9);
    let (mut positions, mut triangles) = grid(&mut dice, 20, 20.0, |_| 0.0);
    // Two walls that meet in a corner.
    for (from, to) in [
        (Vec3::new(-3.0, 0.0, 10.0), Vec3::new(-3.0, 0.0, -10.0)),
        (Vec3::new(-10.0, 0.0, -3.0), Vec3::new(10.0, 0.0, -3.0)),
    ] {
        let first = positions.len() as u32;
        positions.extend([from, to, to + 40.0 * Vec3::Y, from + 40.0 * Vec3::Y]);
        triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    let level = StaticMesh::new(&positions, &triangles).expect("usable");
    let mut simulation = awake();
    simulation.bodies.insert(fixed(level, 0.5)).expect("usable");
    let mut slots = Vec::new();
    for i in 0..12 {
        let (shape, _) = slider(&mut dice);
        let mut body = block(&shape, Vec3::new(-1.5, 1.0 + 1.5 * i as f32, -1.5), 0.5);
        body.linear_velocity = Vec3::new(-4.0, 0.0, -4.0);
        slots.push(simulation.bodies.insert(body).expect("usable"));
    }
    (0..900).for_each(|_| simulation.step(H));
    for slot in slots {
        let at = simulation.bodies.center_of_mass(slot);
        let (v, _) = simulation.bodies.velocity(slot);
        assert!(at.x > -3.0 && at.z > -3.0 && at.y > 0.0, "outside: {at}");
        assert!(v.length() < 0.05, "still moves by {v}");
    }
}

#[test]
fn stones_come_to_rest_on_many_triangles_as_on_one() {
    // Points of faces beside the one that a stone stands on once took the place of those that bear it: four of ten rocked for ever.
    for (cells, height) in [(400, 0.0), (400, 0.02), (40, 0.05)] {
        let mut dice = Dice::new(3);
        let mut bumps = Dice::new(5);
        let heights: Vec<f32> = (0..(cells + 1) * (cells + 1))
            .map(|_| height * (bumps.unit() - 0.5))
            .collect();
        let level = StaticMesh::from_heights(&heights, cells + 1, 40.0 / cells as f32);
        let mut level = fixed(level.expect("usable"), 0.5);
        level.pose.position = Vec3::new(-20.0, 0.0, -20.0);
        let mut simulation = awake();
        simulation.bodies.insert(level).expect("usable");
        let mut slots = Vec::new();
        for i in 0..60 {
            let points: Vec<Vec3> = (0..16).map(|_| 0.45 * dice.direction()).collect();
            let stone = ConvexMesh::from_points(&points).expect("a hull");
            let at = Vec3::new(
                4.0 * (i % 8) as f32 - 14.0,
                0.8,
                4.0 * (i / 8) as f32 - 14.0,
            );
            let mut body = block(&stone, at, 0.5);
            body.pose.rotation = dice.rotation();
            slots.push(simulation.bodies.insert(body).expect("usable"));
        }
        (0..480).for_each(|_| simulation.step(H));
        let moves = |slot: &&u32| {
            let (v, w) = simulation.bodies.velocity(**slot);
            v.length() + 0.3 * w.length() > 2e-3
        };
        let moving = slots.iter().filter(moves).count();
        println!(
            "{moving} of 60 stones move on cells of {} m with heights of {height} m",
            40.0 / cells as f32
        );
        let most = if height > 0.0 { 10 } else { 0 };
        assert!(moving <= most, "{moving} of 60 move on {cells} cells");
    }
}

#[test]
fn unusable_levels_are_named_and_edges_are_found() {
    let square = [Vec3::ZERO, Vec3::X, Vec3::Z, Vec3::new(1.0, 0.0, 1.0)];
    let both = [[0, 2, 3], [0, 3, 1]];
    let level = |p: &[Vec3], t: &[[u32; 3]]| StaticMesh::new(p, t);
    assert!(matches!(
        level(&[Vec3::NAN], &[]),
        Err(MeshError::NotFinite { vertex: 0 })
    ));
    assert!(matches!(
        level(&square, &[[0, 1, 4]]),
        Err(MeshError::IndexOutOfRange { .. })
    ));
    assert!(matches!(level(&square, &[]), Err(MeshError::Empty)));
    assert!(matches!(
        level(&square, &[[0, 0, 1]]),
        Err(MeshError::Empty)
    ));
    assert!(StaticMesh::from_heights(&[0.0; 9], 3, 0.0).is_err());
    let good = level(&square, &[both[0], both[1], [0, 1, 1]]).expect("usable");
    assert_eq!((good.len(), good.left_out()), (2, 1));
    let across = |lift: f32| {
        let mut bent = square;
        bent[1].y = lift;
        let mesh = level(&bent, &both).expect("usable");
        let all: Vec<EdgeKind> = mesh.edge_kinds().flatten().collect();
        assert_eq!(all.iter().filter(|k| **k == EdgeKind::Open).count(), 4);
        all[2]
    };
    let kinds = [0.0, 0.2, -0.2].map(across);
    assert_eq!(kinds, [EdgeKind::Flat, EdgeKind::Concave, EdgeKind::Convex]);
    let mut body = BodyDesc::level(good);
    body.kind = RigidBody::Dynamic;
    assert_eq!(awake().bodies.insert(body), Err(BodyError::DynamicLevel));
}

#[test]
fn no_ray_gets_through_between_triangles_and_hits_name_them() {
    let mut dice = Dice::new(3);
    let ground = grid(&mut dice, 30, 30.0, |at| {
        0.3 * (at.x.sin() + (0.7 * at.z).cos())
    });
    let level = level_of(&ground);
    let (positions, triangles) = &ground;
    let mut simulation = awake();
    simulation.bodies.insert(fixed(level, 0.5)).expect("usable");
    let queries = simulation.queries();
    let all = QueryFilter::all();
    let pierced = |t: &[u32; 3], ray: &Ray| {
        let [a, b, c] = t.map(|v| positions[v as usize].as_dvec3() - ray.origin().as_dvec3());
        let d = ray.direction().as_dvec3();
        let side = |p: DVec3, q: DVec3| d.dot(p.cross(q));
        let normal = (b - a).cross(c - a);
        let is_in = [side(a, b), side(b, c), side(c, a)]
            .iter()
            .all(|s| *s <= 1e-9);
        let at = normal.dot(a) / normal.dot(d);
        (is_in && normal.dot(d) < 0.0 && at >= 0.0).then_some(at)
    };
    for i in 0..20_000 {
        let [a, b, c] = triangles[dice.below(triangles.len())].map(|v| positions[v as usize]);
        let target = [a, a.lerp(b, dice.unit()), (a + b + c) / 3.0][i % 3];
        if target.x.abs() > 14.0 || target.z.abs() > 14.0 {
            continue;
        }
        let from = target + dice.vector(-6.0, 6.0) + 10.0 * Vec3::Y;
        let ray = Ray::new(from, target - from, 100.0).expect("usable");
        let hit = queries
            .cast_ray(&ray, &all)
            .expect("the ground has no holes");
        let found = triangles.iter().filter_map(|t| pierced(t, &ray));
        let least = found.fold(f64::INFINITY, f64::min);
        assert!(
            (f64::from(hit.distance) - least).abs() < 1e-4,
            "{hit:?} {least}"
        );
        let [a, b, c] =
            triangles[hit.triangle.expect("of a mesh") as usize].map(|v| positions[v as usize]);
        let normal = (b - a).cross(c - a).normalize();
        assert!(normal.dot(hit.normal) > 0.9999);
        assert!(normal.dot(hit.point - a).abs() < 1e-4, "{hit:?}");
        let sphere = QueryShape::sphere(0.3).expect("usable");
        let cast = ShapeCast::new(
            sphere,
            Pose::new(from, Quat::IDENTITY),
            target - from,
            100.0,
        );
        let stop = queries
            .cast_shape(&cast.expect("usable"), &all)
            .expect("the ground has no holes");
        assert!(stop.distance <= hit.distance + 1e-4);
        let center = ray.at(stop.distance);
        let near = queries
            .closest_point(center, 1.0, &all)
            .expect("usable")
            .expect("near");
        assert!((near.distance - 0.3).abs() < 1e-4, "{near:?}");
    }
}
