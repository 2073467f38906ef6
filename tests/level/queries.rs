//! Questions are answered as looking at every body in double precision answers them.
//!
//! What grazes may be hit or missed by rounding: an answer must lie between those for bodies a little larger and a little smaller.

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use allocation_counter::measure;
use bevy_cleave::prelude::*;
use glam::{DQuat, DVec3, Quat, Vec3};

const H: f32 = 1.0 / 60.0;

/// Cases of each kind.
const CASES: usize = 100_000;

/// A convex body in double precision, world frame.
struct Solid {
    planes: Vec<(DVec3, f64)>,
    triangles: Vec<[DVec3; 3]>,
}

impl Solid {
    fn of(hull: &ConvexHull, pose: &Pose) -> Self {
        let turn = DQuat::from_array(pose.rotation.to_array().map(f64::from)).normalize();
        let at = pose.position.as_dvec3();
        let place = |v: Vec3| turn * v.as_dvec3() + at;
        let planes = hull.faces().iter().map(|face| {
            let normal = (turn * face.plane.normal.as_dvec3()).normalize();
            let corners = hull.face_loop(face).iter();
            let heights = corners.map(|&v| normal.dot(place(hull.vertices()[v as usize])));
            (normal, heights.fold(f64::NEG_INFINITY, f64::max))
        });
        let corner = |v: u32| place(hull.vertices()[v as usize]);
        Self {
            planes: planes.collect(),
            triangles: hull.triangles().map(|t| t.map(corner)).collect(),
        }
    }

    /// Where a ray enters the solid grown by `by` on all faces, and where it leaves it.
    fn passage(&self, origin: DVec3, direction: DVec3, by: f64) -> Option<[f64; 2]> {
        let mut passage = [f64::NEG_INFINITY, f64::INFINITY];
        for &(normal, offset) in &self.planes {
            let (height, rate) = (normal.dot(origin) - offset - by, normal.dot(direction));
            if rate.abs() < 1e-12 {
                if height > 0.0 {
                    return None;
                }
            } else if rate < 0.0 {
                passage[0] = passage[0].max(-height / rate);
            } else {
                passage[1] = passage[1].min(-height / rate);
            }
        }
        (passage[0] <= passage[1] && passage[1] >= 0.0).then_some(passage)
    }

    /// Where a ray hits the grown solid; infinite if it does not.
    fn hit(&self, ray: &Ray, is_solid: bool, by: f64) -> f64 {
        let (origin, direction) = (ray.origin().as_dvec3(), ray.direction().as_dvec3());
        let at = match self.passage(origin, direction, by) {
            None => f64::INFINITY,
            Some([enters, _]) if enters > 0.0 => enters,
            Some(_) if is_solid => 0.0,
            Some([_, leaves]) => leaves,
        };
        if at <= f64::from(ray.max_distance()) + by.max(0.0) {
            at
        } else {
            f64::INFINITY
        }
    }

    /// Signed distance of a point from the surface.
    fn distance(&self, point: DVec3) -> f64 {
        let heights = self.planes.iter().map(|(n, offset)| n.dot(point) - offset);
        let height = heights.fold(f64::NEG_INFINITY, f64::max);
        if height <= 0.0 {
            return height;
        }
        let triangles = self.triangles.iter();
        let distances = triangles.map(|t| (nearest_on(t, point) - point).length());
        distances.fold(f64::INFINITY, f64::min)
    }
}

/// The nearest point of a triangle: its inside if the point is over it, else that of an edge.
fn nearest_on(&[a, b, c]: &[DVec3; 3], point: DVec3) -> DVec3 {
    let normal = (b - a).cross(c - a);
    let edges = [(a, b), (b, c), (c, a)];
    if edges
        .iter()
        .all(|(p, q)| (*q - *p).cross(point - *p).dot(normal) >= 0.0)
    {
        return point - normal * (point - a).dot(normal) / normal.length_squared();
    }
    let on_edges = edges.map(|(p, q)| {
        let share = ((point - p).dot(q - p) / (q - p).length_squared()).clamp(0.0, 1.0);
        p + share * (q - p)
    });
    let by_distance =
        |p: &DVec3, q: &DVec3| (*p - point).length().total_cmp(&(*q - point).length());
    on_edges
        .into_iter()
        .min_by(by_distance)
        .expect("three edges")
}

fn random_shape(dice: &mut Dice) -> ConvexMesh {
    let size = 0.2 + dice.unit();
    match dice.below(5) {
        0 => ConvexMesh::cuboid(size, 0.5 * size, 0.2 * size),
        1 => ConvexMesh::regular_prism(3 + dice.below(6) as u32, 0.5 * size, size),
        2 => ConvexMesh::icosphere(0.5 * size, 1),
        3 => ConvexMesh::cuboid(2.0 * size, 0.02 * size, 0.1 * size),
        _ => {
            let points: Vec<Vec3> = (0..8).map(|_| size * dice.direction()).collect();
            ConvexMesh::from_points(&points)
        }
    }
    .expect("a valid shape")
}

fn random_pose(dice: &mut Dice, reach: f32) -> Pose {
    Pose::new(dice.vector(-reach, reach), dice.rotation())
}

/// Bodies that have moved, some fast, some that were moved or came after the step, and some that are gone.
fn scene(dice: &mut Dice, count: usize) -> Simulation {
    let mut simulation = awake();
    let insert = |simulation: &mut Simulation, dice: &mut Dice| {
        let kind = [RigidBody::Dynamic, RigidBody::Static][dice.below(2)];
        let mut desc = BodyDesc::new(kind, Shape::Convex(random_shape(dice)));
        desc.pose = random_pose(dice, 4.0);
        desc.linear_velocity = [0.0, 100.0][dice.below(2)] * dice.direction();
        desc.angular_velocity = [0.0, 30.0][dice.below(2)] * dice.direction();
        desc.layers.memberships = 1 << dice.below(2);
        simulation.bodies.insert(desc).expect("usable")
    };
    for _ in 0..count {
        insert(&mut simulation, dice);
    }
    for _ in 0..2 {
        simulation.step(H);
    }
    for slot in 0..count as u32 {
        match dice.below(8) {
            0 => simulation.bodies.remove(slot),
            1 => (simulation.bodies.set_pose(slot, random_pose(dice, 4.0))).expect("usable"),
            _ => {}
        }
    }
    for _ in 0..count / 8 {
        insert(&mut simulation, dice);
    }
    simulation
}

/// What may happen to bodies between two looks at them.
fn disturb(simulation: &mut Simulation, dice: &mut Dice) {
    for _ in 0..dice.below(5) {
        let bodies = &mut simulation.bodies;
        let there: Vec<u32> = bodies.iter().collect();
        let slot = there[dice.below(there.len())];
        let pose = bodies.pose(slot);
        match dice.below(5) {
            0 if there.len() > 2 => bodies.remove(slot),
            1 => {
                let shape = Shape::Convex(random_shape(dice));
                let mut desc = BodyDesc::new(RigidBody::Dynamic, shape);
                desc.pose = random_pose(dice, 4.0);
                bodies.insert(desc).expect("usable");
            }
            2 => bodies
                .set_pose(slot, random_pose(dice, 4.0))
                .expect("usable"),
            3 => {
                let near = pose.position + dice.vector(-1e-3, 1e-3);
                let near = Pose::new(near, pose.rotation);
                bodies.set_pose(slot, near).expect("usable");
            }
            _ => {
                let plane = Plane::through(pose.position, dice.direction());
                simulation.slice(slot, plane).expect("a body");
            }
        }
    }
}

/// The index goes from look to look with what moves a little, far, comes, goes and is cut.
#[test]
fn an_index_that_is_kept_answers_as_a_new_one_does() {
    let mut dice = Dice::new(12);
    for count in [3, 12, 200] {
        let mut simulation = scene(&mut dice, count);
        let solids = solids(&simulation);
        for round in 0..80 {
            disturb(&mut simulation, &mut dice);
            if dice.below(3) > 0 {
                simulation.step(H);
            }
            let mut new = QueryIndex::default();
            new.refresh(&simulation.bodies);
            simulation.query_index.refresh(&simulation.bodies);
            let bodies = &simulation.bodies;
            let views = [&new, &simulation.query_index].map(|index| index.queries(bodies));
            for _ in 0..20 {
                let all = QueryFilter::all();
                let ray = random_ray(&mut dice, &solids);
                let point = dice.vector(-6.0, 6.0);
                let (mut hits, mut found) = (Vec::new(), Vec::new());
                let answers = views.map(|queries| {
                    queries.cast_ray_all(&ray, &all, &mut hits);
                    let region = Aabb {
                        min: point - Vec3::ONE,
                        max: point + Vec3::ONE,
                    };
                    queries
                        .overlap_box(&region, &all, &mut found)
                        .expect("usable");
                    let near = queries.closest_point(point, 3.0, &all).expect("usable");
                    let first = queries.cast_ray(&ray, &all);
                    (hits.clone(), found.clone(), near, first)
                });
                assert_eq!(answers[0], answers[1], "{count} bodies, round {round}");
            }
        }
    }
}

fn solids(simulation: &Simulation) -> Vec<(u32, Solid)> {
    let bodies = &simulation.bodies;
    let solid = |slot| {
        let hull = bodies.convex(slot).expect("convex").hull();
        (slot, Solid::of(hull, &bodies.pose(slot)))
    };
    bodies.iter().map(solid).collect()
}

/// Rays at random, through corners and edges, along faces, from inside, without length.
fn random_ray(dice: &mut Dice, solids: &[(u32, Solid)]) -> Ray {
    let (_, solid) = &solids[dice.below(solids.len())];
    let triangle = solid.triangles[dice.below(solid.triangles.len())].map(|p| p.as_vec3());
    let [a, b, c] = triangle;
    let from = dice.vector(-6.0, 6.0);
    let length = [0.0, 0.3, 3.0, 30.0, f32::INFINITY][dice.below(5)];
    let on_face = (a + b + c) / 3.0;
    let (origin, direction) = match dice.below(7) {
        0 => (from, a - from),
        1 => (from, a.lerp(b, dice.unit()) - from),
        2 => (on_face, b - a),
        3 => (a, b - a),
        4 => (
            on_face - 0.01 * (b - a).cross(c - a).normalize(),
            dice.direction(),
        ),
        5 => (from, dice.direction()),
        _ => (from, [Vec3::X, Vec3::NEG_Y, Vec3::Z][dice.below(3)]),
    };
    let ray = Ray::new(origin, direction, length);
    let ray = ray.unwrap_or_else(|_| Ray::new(from, Vec3::X, length).expect("usable"));
    if dice.below(3) == 0 {
        ray.hollow()
    } else {
        ray
    }
}

#[test]
fn rays_hit_what_looking_at_every_body_finds() {
    let mut dice = Dice::new(1);
    let (mut hits, mut all) = (0, Vec::new());
    for _ in 0..CASES / 1000 {
        let mut simulation = scene(&mut dice, 60);
        let solids = solids(&simulation);
        let queries = simulation.queries();
        for _ in 0..1000 {
            let ray = random_ray(&mut dice, &solids);
            let is_solid = ray != ray.hollow();
            let slack = 3e-5 * (1.0 + f64::from(ray.origin().length()));
            let hit = queries.cast_ray(&ray, &QueryFilter::all());
            let found = hit.map_or(f64::INFINITY, |hit| f64::from(hit.distance));
            // Each body is hit somewhere between these; a hollow one at once, perhaps, if the ray begins on its surface.
            let (mut least, mut most) = (f64::INFINITY, f64::INFINITY);
            for (_, solid) in &solids {
                let ends = [slack, 0.0, -slack].map(|by| solid.hit(&ray, is_solid, by));
                let [low, high] = [
                    ends.iter().copied().fold(f64::INFINITY, f64::min),
                    ends.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                ];
                let is_on = !is_solid && solid.distance(ray.origin().as_dvec3()).abs() < slack;
                least = least.min(if is_on { 0.0 } else { low - slack });
                most = most.min(high + slack);
            }
            assert!(
                (least..=most).contains(&found),
                "{ray:?}: {hit:?} {least} {most}"
            );
            assert_eq!(
                queries.is_ray_blocked(&ray, &QueryFilter::all()),
                hit.is_some()
            );
            queries.cast_ray_all(&ray, &QueryFilter::all(), &mut all);
            assert_eq!(all.first(), hit.as_ref());
            let is_sure = |(_, s): &&(u32, Solid)| {
                [slack, -slack]
                    .iter()
                    .all(|&by| s.hit(&ray, is_solid, by).is_finite())
            };
            let surely = solids.iter().filter(is_sure);
            assert!(surely.count() <= all.len(), "{ray:?}");
            assert!(
                all.windows(2)
                    .all(|pair| pair[0].distance <= pair[1].distance)
            );
            if let Some(hit) = hit.filter(|hit| hit.distance > 0.0) {
                hits += 1;
                let (_, solid) = solids.iter().find(|(s, _)| *s == hit.body).expect("there");
                assert!(
                    solid.distance(hit.point.as_dvec3()).abs() < 2.0 * slack,
                    "{hit:?}"
                );
                let is_outward = hit.normal.dot(ray.direction()) < 1e-5;
                assert!(is_outward || !is_solid, "{hit:?}");
                let face = hit.face.expect("a hull has faces") as usize;
                let normal = solid.planes[face].0.as_vec3();
                assert!(normal.dot(hit.normal) > 0.9999, "{hit:?}");
            }
        }
    }
    assert!(hits > CASES / 5, "{hits}");
}

#[test]
fn near_places_are_what_looking_at_every_body_finds() {
    let mut dice = Dice::new(2);
    let mut all = Vec::new();
    for _ in 0..CASES / 1000 {
        let mut simulation = scene(&mut dice, 30);
        let solids = solids(&simulation);
        let queries = simulation.queries();
        for _ in 0..1000 {
            let (_, solid) = &solids[dice.below(solids.len())];
            let corner = solid.triangles[0][0].as_vec3();
            let point = [dice.vector(-6.0, 6.0), corner][dice.below(2)];
            let limit = [0.0, 0.5, 3.0, f32::INFINITY][dice.below(4)];
            let distances = solids.iter().map(|(_, s)| s.distance(point.as_dvec3()));
            let distances: Vec<f64> = distances.collect();
            let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
            let hit = queries
                .closest_point(point, limit, &QueryFilter::all())
                .expect("usable");
            let slack = 3e-5;
            match hit {
                Some(hit) => {
                    assert!(
                        (f64::from(hit.distance) - least).abs() < slack,
                        "{hit:?} {least}"
                    );
                    let away = (point - hit.point).dot(hit.normal);
                    assert!((away - hit.distance).abs() < 1e-4, "{hit:?} {point}");
                }
                None => assert!(least > f64::from(limit) - slack, "{point} {least}"),
            }
            queries
                .within_radius(point, limit, &QueryFilter::all(), &mut all)
                .expect("usable");
            assert_eq!(all.first().map(|h| h.body), hit.map(|h| h.body));
            let is_within = |by: f64| move |d: &&f64| **d <= f64::from(limit) + by;
            let within = |by: f64| distances.iter().filter(is_within(by)).count();
            assert!(
                (within(-slack)..=within(slack)).contains(&all.len()),
                "{point} {limit}"
            );
        }
    }
}

#[test]
fn a_shape_of_parts_meets_what_the_first_of_its_parts_meets() {
    let mut dice = Dice::new(11);
    let all = QueryFilter::all();
    let (mut touched, mut overlapped) = (0, 0);
    for _ in 0..CASES / 1000 {
        let mut simulation = scene(&mut dice, 40);
        let queries = simulation.queries();
        for _ in 0..50 {
            let parts: Vec<(Pose, ConvexMesh)> = (0..1 + dice.below(4))
                .map(|_| (random_pose(&mut dice, 0.5), random_shape(&mut dice)))
                .collect();
            let compound = Compound::new(parts.clone()).expect("usable");
            let (pose, limit) = (random_pose(&mut dice, 4.0), 2.0 * dice.unit());
            let whole = QueryShape::from(&compound);
            let part = |(at, mesh): &'_ (Pose, ConvexMesh)| (pose * *at, mesh.clone());
            let parts: Vec<(Pose, ConvexMesh)> = parts.iter().map(part).collect();
            let direction = dice.direction();

            let cast = ShapeCast::new(whole, pose, direction, limit).expect("usable");
            let found = queries.cast_shape(&cast, &all).map(|hit| hit.distance);
            let of_part = |(at, mesh): &(Pose, ConvexMesh)| {
                let cast = ShapeCast::new(QueryShape::from(mesh), *at, direction, limit);
                queries.cast_shape(&cast.expect("usable"), &all)
            };
            let first = parts.iter().filter_map(of_part).map(|hit| hit.distance);
            let first = first.min_by(f32::total_cmp);
            // What is touched depends on the size of the whole.
            let is_same = match (found, first) {
                (Some(found), Some(first)) => (found - first).abs() < 1e-4,
                (Some(only), None) | (None, Some(only)) => (only - limit).abs() < 1e-4,
                (None, None) => true,
            };
            assert!(is_same, "{found:?} {first:?}");
            touched += usize::from(found.is_some_and(|distance| distance > 0.0));

            let (mut found, mut of_parts, mut some) = (Vec::new(), Vec::new(), Vec::new());
            let asked = queries.overlap_shape(&whole, &pose, &all, &mut found);
            asked.expect("usable");
            for (at, mesh) in &parts {
                let shape = QueryShape::from(mesh);
                let asked = queries.overlap_shape(&shape, at, &all, &mut some);
                asked.expect("usable");
                of_parts.append(&mut some);
            }
            of_parts.sort_unstable_by_key(|&slot| queries.bodies().id(slot));
            of_parts.dedup();
            assert_eq!(found, of_parts);
            overlapped += found.len();
        }
    }
    assert!(touched > 200 && overlapped > 200, "{touched} {overlapped}");
}

/// All differences of two hulls' corners, as the hull that a moved point would meet; none if it is too flat to be one.
fn difference(target: &ConvexHull, moved: &ConvexHull, turn: Quat) -> Option<ConvexHull> {
    let points: Vec<Vec3> = (target.vertices().iter())
        .flat_map(|t| moved.vertices().iter().map(move |m| *t - turn * *m))
        .collect();
    ConvexHull::from_points(&points).ok()
}

#[test]
fn moved_hulls_touch_and_overlap_as_their_difference_does() {
    let mut dice = Dice::new(3);
    let (mut touched, mut overlapped, mut found) = (0, 0, Vec::new());
    for _ in 0..CASES / 50 {
        let [target, moved] = [(); 2].map(|()| random_shape(&mut dice));
        let turn = dice.rotation();
        let Some(sum) = difference(target.hull(), moved.hull(), turn) else {
            continue;
        };
        let solid = Solid::of(&sum, &Pose::IDENTITY);
        let mut simulation = awake();
        let desc = BodyDesc::new(RigidBody::Static, Shape::Convex(target.clone()));
        simulation.bodies.insert(desc).expect("usable");
        let queries = simulation.queries();
        for _ in 0..50 {
            let pose = Pose::new(dice.vector(-2.0, 2.0), turn);
            let corner = sum.vertices()[dice.below(sum.vertices().len())];
            let direction = [dice.direction(), corner - pose.position][dice.below(2)];
            let length = [0.5, 5.0, f32::INFINITY][dice.below(3)];
            let way = Ray::new(pose.position, direction, length).expect("usable");
            let cast = ShapeCast::new((&moved).into(), pose, direction, length).expect("usable");
            let hit = queries.cast_shape(&cast, &QueryFilter::all());
            let at = hit.map_or(f64::INFINITY, |hit| f64::from(hit.distance));
            let slack = 5e-5;
            let bounds = [slack, -slack].map(|by| solid.hit(&way, true, by));
            let is_between = at >= bounds[0] - slack && at <= bounds[1] + slack;
            assert!(is_between, "{cast:?}: {hit:?} {bounds:?}");
            if let Some(hit) = hit.filter(|hit| hit.distance > 1e-3) {
                touched += 1;
                let there = Solid::of(target.hull(), &Pose::IDENTITY);
                assert!(there.distance(hit.point.as_dvec3()).abs() < 1e-3, "{hit:?}");
                assert!(hit.normal.dot(way.direction()) < 1e-3, "{hit:?}");
            }
            queries
                .overlap_shape(&(&moved).into(), &pose, &QueryFilter::all(), &mut found)
                .expect("usable");
            let distance = solid.distance(pose.position.as_dvec3());
            assert!(distance.abs() < slack || (distance < 0.0) == (found == [0]));
            overlapped += found.len();
        }
    }
    assert!(
        touched > CASES / 10 && overlapped > CASES / 50,
        "{touched} {overlapped}"
    );
}

#[test]
fn moved_spheres_stop_at_their_radius() {
    let mut dice = Dice::new(4);
    let mut touched = 0;
    for _ in 0..CASES / 100 {
        let target = random_shape(&mut dice);
        let solid = Solid::of(target.hull(), &Pose::IDENTITY);
        let mut simulation = awake();
        let desc = BodyDesc::new(RigidBody::Static, Shape::Convex(target));
        simulation.bodies.insert(desc).expect("usable");
        let queries = simulation.queries();
        for _ in 0..100 {
            let radius = [0.01, 0.3, 2.0][dice.below(3)];
            let pose = random_pose(&mut dice, 3.0);
            let sphere = QueryShape::sphere(radius).expect("usable");
            let direction = dice.direction();
            let cast = ShapeCast::new(sphere, pose, direction, 6.0).expect("usable");
            let hit = queries.cast_shape(&cast, &QueryFilter::all());
            let end = hit.map_or(6.0, |hit| hit.distance);
            let gap = |way: f32| {
                let at = pose.position.as_dvec3() + f64::from(way) * direction.as_dvec3();
                solid.distance(at) - f64::from(radius)
            };
            if gap(0.0) > 1e-4 {
                let before = (0..32).map(|i| gap(end * i as f32 / 32.0));
                let nearest = before.fold(f64::INFINITY, f64::min);
                assert!(
                    nearest > -1e-4,
                    "passed through: {cast:?} {hit:?} {nearest}"
                );
            }
            if let Some(hit) = hit {
                touched += 1;
                assert!(gap(end) < 1e-4, "{cast:?} {hit:?} {}", gap(end));
            }
        }
    }
    assert!(touched > CASES / 20, "{touched}");
}

#[test]
fn filters_leave_out_and_half_spaces_count() {
    let mut simulation = awake();
    let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    let floor = simulation.bodies.insert(floor).expect("usable");
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid");
    let mut insert = |height: f32, memberships| {
        let mut desc = BodyDesc::dynamic(cube.clone(), height * Vec3::Y);
        desc.layers.memberships = memberships;
        simulation.bodies.insert(desc).expect("usable")
    };
    let (low, high) = (insert(2.0, 2), insert(4.0, 4));
    let queries = simulation.queries();
    let ray = Ray::new(10.0 * Vec3::Y, Vec3::NEG_Y, f32::INFINITY).expect("usable");
    let first = |filter: QueryFilter| queries.cast_ray(&ray, &filter).map(|hit| hit.body);
    let only = CollisionLayers {
        memberships: 1,
        filters: 2,
    };
    assert_eq!(first(QueryFilter::all()), Some(high));
    assert_eq!(first(QueryFilter::all().with_layers(only)), Some(low));
    assert_eq!(
        first(QueryFilter::all().excluding(&[low, high])),
        Some(floor)
    );
    assert_eq!(
        first(QueryFilter::all().with_predicate(&|slot| slot == low)),
        Some(low)
    );
    assert_eq!(first(QueryFilter::all().with_predicate(&|_| false)), None);
    let capsule = QueryShape::capsule(0.5, 1.0).expect("usable");
    let above = Pose::new(Vec3::new(5.0, 3.0, 0.0), Quat::IDENTITY);
    let cast = ShapeCast::new(capsule, above, Vec3::NEG_Y, 10.0).expect("usable");
    let hit = queries
        .cast_shape(&cast, &QueryFilter::all())
        .expect("the floor");
    assert!(
        (hit.distance - 2.0).abs() < 1e-6 && hit.normal == Vec3::Y,
        "{hit:?}"
    );
    let mut found = Vec::new();
    let all = Aabb {
        min: Vec3::splat(-0.5),
        max: Vec3::new(0.5, 1.6, 0.5),
    };
    queries
        .overlap_box(&all, &QueryFilter::all(), &mut found)
        .expect("usable");
    assert_eq!(found, [floor, low]);
}

#[test]
fn unusable_questions_are_named() {
    let bad = [Vec3::NAN, Vec3::new(0.0, f32::INFINITY, 0.0)];
    for bad in bad {
        assert!(matches!(
            Ray::new(bad, Vec3::X, 1.0),
            Err(QueryError::NotFinite(_))
        ));
        assert!(matches!(
            Ray::new(Vec3::X, bad, 1.0),
            Err(QueryError::NotFinite(_))
        ));
    }
    assert_eq!(
        Ray::new(Vec3::X, Vec3::ZERO, 1.0),
        Err(QueryError::ZeroDirection)
    );
    assert_eq!(
        Ray::between(Vec3::X, Vec3::X),
        Err(QueryError::ZeroDirection)
    );
    for length in [f32::NAN, -1.0] {
        assert!(matches!(
            Ray::new(Vec3::X, Vec3::X, length),
            Err(QueryError::Length { .. })
        ));
        assert!(QueryShape::sphere(length).is_err());
        assert!(QueryShape::capsule(1.0, length).is_err());
        assert!(QueryShape::cuboid(Vec3::new(1.0, length, 1.0)).is_err());
    }
    let tiny = Ray::new(Vec3::ZERO, 1e-40 * Vec3::X, 1.0).expect("a direction");
    assert_eq!(tiny.direction(), Vec3::X);
    let sphere = QueryShape::sphere(1.0).expect("usable");
    let skewed = Pose::new(Vec3::ZERO, Quat::from_xyzw(0.0, 0.0, 0.0, 2.0));
    assert!(ShapeCast::new(sphere, skewed, Vec3::X, 1.0).is_err());
    let mut simulation = awake();
    let queries = simulation.queries();
    let all = QueryFilter::all();
    assert!(queries.closest_point(Vec3::NAN, 1.0, &all).is_err());
    assert!(
        queries
            .overlap_shape(&sphere, &skewed, &all, &mut Vec::new())
            .is_err()
    );
    let (min, max) = (Vec3::ONE, Vec3::ZERO);
    assert!(
        queries
            .overlap_box(&Aabb { min, max }, &all, &mut Vec::new())
            .is_err()
    );
    assert!(queries.cast_ray(&tiny, &all).is_none(), "an empty scene");
}

#[test]
fn single_answers_take_no_memory() {
    let mut dice = Dice::new(5);
    let mut simulation = scene(&mut dice, 300);
    let queries = simulation.queries();
    let sphere = QueryShape::sphere(0.3).expect("usable");
    let mut hits = 0;
    let allocated = measure(|| {
        for _ in 0..1000 {
            let (from, towards) = (dice.vector(-6.0, 6.0), dice.direction());
            let pose = Pose::new(from, Quat::IDENTITY);
            let ray = Ray::new(from, towards, 20.0).expect("usable");
            let cast = ShapeCast::new(sphere, pose, towards, 20.0).expect("usable");
            let all = &QueryFilter::all();
            hits += usize::from(queries.cast_ray(&ray, all).is_some());
            hits += usize::from(queries.is_ray_blocked(&ray, all));
            hits += usize::from(queries.cast_shape(&cast, all).is_some());
            let near = queries.closest_point(from, 1.0, all).expect("usable");
            hits += usize::from(near.is_some());
        }
    });
    assert_eq!(allocated.count_total, 0, "{allocated:?}");
    assert!(hits > 500, "{hits}");
}

/// What lies on a one-sided level is on its front, though some of its corners have sunk in by the slop: levels are named by what is near,
/// overlaps, and is cast along them.
#[test]
fn what_rests_on_a_level_is_near_it() {
    let mut dice = Dice::new(31);
    let corners = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)];
    let corners = corners.map(|(x, z)| Vec3::new(x, 0.0, z));
    let level = StaticMesh::new(&corners, &[[0, 2, 1], [0, 3, 2]]).expect("a level");
    for round in 0..60 {
        let mut simulation = awake();
        let ground = simulation.bodies.insert(BodyDesc::level(level.clone()));
        let ground = ground.expect("usable");
        let size = dice.vector(0.1, 1.0);
        let shape = ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box");
        let sunk = dice.in_range(0.0, 1e-3) * size.y;
        let tilt = Quat::from_rotation_z(dice.in_range(-1e-4, 1e-4));
        let turn = tilt * Quat::from_rotation_y(dice.in_range(-3.0, 3.0));
        let at = Vec3::new(dice.in_range(-5.0, 5.0), 0.5 * size.y - sunk, 0.0);
        let pose = Pose::new(at, turn);
        let queries = simulation.queries();
        let (query, all) = (QueryShape::hull(shape.hull()), QueryFilter::all());
        let mut hits = Vec::new();
        let near = queries.near_shape(&query, &pose, 0.01, &all, &mut hits);
        near.expect("usable");
        assert!(hits.iter().any(|hit| hit.body == ground), "round {round}");
        let cast = ShapeCast::new(query, pose, -Vec3::Y, 1.0).expect("usable");
        let hit = queries.cast_shape(&cast, &all).expect("the ground");
        assert_eq!((hit.body, hit.distance), (ground, 0.0), "round {round}");
    }
}
