//! The contact cache: ages, matching, scaling, and hit rates of resting, sliding and rolling bodies.

use crate::common::dice::Dice;
use bevy_cleave::contact::{
    BodyId, CacheStats, ContactCache, ContactPoint, Manifold, ManifoldHead, Manifolds,
    NarrowScratch, collide_hulls,
};
use bevy_cleave::geometry::{ConvexHull, KdBox, KdCode};
use bevy_cleave::math::{Aabb, Plane, Pose};
use bevy_cleave::testing::contact::{MAX_AGE, ManifoldBody, collide_half_space};
use glam::{Quat, Vec3};
use std::collections::HashMap;

/// Step length, s.
const H: f32 = 1.0 / 60.0;

/// Two bodies, ids 3 and 8 in slots 0 and 1, unrotated.
const IDS: [BodyId; 2] = [BodyId(3), BodyId(8)];
const ROTATIONS: [Quat; 2] = [Quat::IDENTITY; 2];

fn unit_box() -> KdBox {
    KdBox::around(Aabb {
        min: Vec3::splat(-0.5),
        max: Vec3::splat(0.5),
    })
}

fn unit_boxes() -> [Option<KdBox>; 2] {
    [Some(unit_box()); 2]
}

/// A manifold of slots 0 and 1 with the given points.
fn manifold(points: &[ContactPoint]) -> Manifold {
    let mut manifold = Manifold {
        head: ManifoldHead {
            a: 0,
            b: 1,
            normal: Vec3::Y,
            friction: 0.5,
            restitution: 0.0,
            count: points.len() as u32,
        },
        points: Default::default(),
    };
    manifold.points_mut().copy_from_slice(points);
    manifold
}

/// Manifolds as the cache takes them.
fn list(manifolds: &[Manifold]) -> Manifolds {
    manifolds.iter().collect()
}

/// A point at the same place in both unit boxes.
fn point_at(place: Vec3, normal_impulse: f32) -> ContactPoint {
    let code = unit_box().encode(place);
    ContactPoint {
        code_a: code,
        code_b: code,
        normal_impulse,
        ..ContactPoint::default()
    }
}

/// One whole step: warm start, "solve" to the given impulses, store. Returns what the warm start gave.
fn step(cache: &mut ContactCache, points: &[ContactPoint], h: f32) -> (Vec<f32>, CacheStats) {
    let mut manifolds = list(&[manifold(points)]);
    let stats = cache.warm_start(&mut manifolds, &IDS, &ROTATIONS, &unit_boxes(), h);
    let warm = manifolds
        .points()
        .iter()
        .map(|p| p.normal_impulse)
        .collect();
    cache.store_and_age(&list(&[manifold(points)]), &IDS, &ROTATIONS, h);
    (warm, stats)
}

/// One step in which the pair does not touch.
fn step_apart(cache: &mut ContactCache) {
    cache.warm_start(&mut list(&[]), &IDS, &ROTATIONS, &unit_boxes(), H);
    cache.store_and_age(&list(&[]), &IDS, &ROTATIONS, H);
}

fn ages(cache: &ContactCache) -> Vec<u32> {
    cache.entries_of(IDS[0], IDS[1]).map(|e| e.age).collect()
}

#[test]
fn ages_grow_by_one_per_step_and_entries_are_gone_after_ten() {
    let mut cache = ContactCache::new();
    step(&mut cache, &[point_at(Vec3::ZERO, 1.0)], H);
    assert_eq!(ages(&cache), [0]);
    for age in 1..=MAX_AGE {
        step_apart(&mut cache);
        assert_eq!(ages(&cache), [age]);
    }
    assert_eq!(MAX_AGE, 10);
    step_apart(&mut cache);
    assert!(
        cache.is_empty(),
        "an entry of age 10 that is missed once more is evicted"
    );
    assert_eq!(cache.pairs().count(), 0);
}

#[test]
fn a_hit_resets_the_age_to_zero() {
    let mut cache = ContactCache::new();
    let point = point_at(Vec3::ZERO, 1.0);
    step(&mut cache, &[point], H);
    for _ in 0..7 {
        step_apart(&mut cache);
    }
    assert_eq!(ages(&cache), [7]);
    let (_, stats) = step(&mut cache, &[point], H);
    assert_eq!(stats.stale_hits, 1);
    assert_eq!(ages(&cache), [0]);
    let (warm, stats) = step(&mut cache, &[point], H);
    assert_eq!((warm, stats.exact_hits), (vec![1.0], 1));
    assert_eq!(ages(&cache), [0]);
}

#[test]
fn a_multiplier_is_not_applied_after_a_step_apart() {
    let mut cache = ContactCache::new();
    let point = point_at(Vec3::ZERO, 5.0);
    step(&mut cache, &[point], H);
    step_apart(&mut cache);
    let (warm, stats) = step(&mut cache, &[point], H);
    assert_eq!(
        warm,
        [0.0],
        "the bodies were apart: the old impulse would be a kick"
    );
    assert_eq!(
        (stats.stale_hits, stats.exact_hits, stats.hit_rate()),
        (1, 0, 0.0)
    );
}

#[test]
fn impulses_scale_with_the_step_length() {
    let mut cache = ContactCache::new();
    let point = point_at(Vec3::ZERO, 3.0);
    step(&mut cache, &[point], 0.01);
    let (warm, _) = step(&mut cache, &[point], 0.02);
    assert_eq!(warm, [6.0]);
    let (warm, _) = step(&mut cache, &[point], 0.005);
    assert_eq!(warm, [0.75]);
    let (warm, _) = step(&mut cache, &[point], 0.0);
    assert_eq!(warm, [0.0]);
    // A step of no length says nothing of the next one's impulses.
    let (warm, stats) = step(&mut cache, &[point], 0.01);
    assert_eq!((warm, stats.exact_hits), (vec![0.0], 1));
}

#[test]
fn impulses_that_are_not_numbers_are_never_applied() {
    let mut cache = ContactCache::new();
    let places = [Vec3::ZERO, Vec3::splat(0.3)];
    step(
        &mut cache,
        &[point_at(places[0], f32::NAN), point_at(places[1], 2.0)],
        H,
    );
    let (warm, _) = step(&mut cache, &places.map(|p| point_at(p, 1.0)), H);
    assert_eq!(warm, [0.0, 2.0]);
}

#[test]
fn friction_turns_with_body_a_and_stays_tangential() {
    let mut cache = ContactCache::new();
    let mut before = manifold(&[point_at(Vec3::ZERO, 1.0)]);
    before.points[0].friction_impulse = Vec3::new(0.3, 0.0, 0.4);
    cache.store_and_age(&list(&[before]), &IDS, &ROTATIONS, H);
    // A quarter turn about y takes x to -z and z to x; then the normal is tilted by 0.6/0.8.
    let turned = [
        Quat::from_xyzw(0.0, 0.5_f32.sqrt(), 0.0, 0.5_f32.sqrt()),
        Quat::IDENTITY,
    ];
    let mut after = manifold(&[point_at(Vec3::ZERO, 0.0)]);
    after.normal = Vec3::new(0.6, 0.8, 0.0);
    let normal = after.normal;
    let mut after = list(&[after]);
    cache.warm_start(&mut after, &IDS, &turned, &unit_boxes(), H);
    let friction = after.points()[0].friction_impulse;
    let turned = Vec3::new(0.4, 0.0, -0.3);
    let expected = turned - normal * normal.dot(turned);
    assert!(
        (friction - expected).length() < 1e-6,
        "{friction} {expected}"
    );
    assert!(friction.dot(normal).abs() < 1e-6);
}

#[test]
fn nearest_match_is_one_to_one_and_closest_first() {
    let mut cache = ContactCache::new();
    let at = |x: f32| Vec3::new(x, -0.5, 0.0);
    step(
        &mut cache,
        &[point_at(at(0.100), 1.0), point_at(at(0.108), 2.0)],
        H,
    );
    // Both moved by 6 mm: the first is now nearer to the second's old place (2 mm) than to its own (6 mm).
    // The closest couple goes first, and each entry goes once.
    let (warm, stats) = step(
        &mut cache,
        &[point_at(at(0.106), 1.0), point_at(at(0.114), 2.0)],
        H,
    );
    assert_eq!(stats.near_hits, 2);
    assert_eq!(warm, [2.0, 1.0]);
    // Three points, two entries: one misses.
    let points = [0.1065, 0.1145, 0.116].map(|x| point_at(at(x), 1.0));
    let (_, stats) = step(&mut cache, &points, H);
    assert_eq!((stats.near_hits, stats.misses), (2, 1));
    // Farther than 2 % of the body: no match.
    let (warm, stats) = step(&mut cache, &[point_at(at(0.2), 1.0)], H);
    assert_eq!((warm, stats.misses), (vec![0.0], 1));
}

#[test]
fn exact_match_goes_before_nearer_claims() {
    let mut cache = ContactCache::new();
    let at = |x: f32| Vec3::new(x, -0.5, 0.0);
    step(&mut cache, &[point_at(at(0.1), 7.0)], H);
    // The first point is near, the second is in the very cell.
    let (warm, stats) = step(
        &mut cache,
        &[point_at(at(0.101), 0.0), point_at(at(0.1), 0.0)],
        H,
    );
    assert_eq!(warm, [0.0, 7.0]);
    assert_eq!((stats.exact_hits, stats.near_hits, stats.misses), (1, 0, 1));
}

#[test]
fn a_body_without_box_is_matched_on_the_other_side() {
    let mut cache = ContactCache::new();
    let boxes = [Some(unit_box()), None];
    let at = |x: f32, impulse: f32| ContactPoint {
        code_b: KdCode(0),
        ..point_at(Vec3::new(x, -0.5, 0.0), impulse)
    };
    let before = list(&[manifold(&[at(-0.5, 1.0), at(0.5, 2.0)])]);
    cache.store_and_age(&before, &IDS, &ROTATIONS, H);
    let mut after = list(&[manifold(&[at(0.495, 0.0), at(-0.5, 0.0)])]);
    let stats = cache.warm_start(&mut after, &IDS, &ROTATIONS, &boxes, H);
    assert_eq!((stats.exact_hits, stats.near_hits), (1, 1));
    assert_eq!(
        [
            after.points()[0].normal_impulse,
            after.points()[1].normal_impulse
        ],
        [2.0, 1.0]
    );
    // Without any box only the codes are left.
    let mut after = list(&[manifold(&[at(0.495, 0.0), at(-0.5, 0.0)])]);
    let stats = cache.warm_start(&mut after, &IDS, &ROTATIONS, &[None, None], H);
    assert_eq!((stats.exact_hits, stats.near_hits, stats.misses), (1, 0, 1));
}

#[test]
fn small_body_on_vast_ground_is_matched_on_the_small_body() {
    // Cells of the ground are half a metre: all corners of the crate fall into one of them.
    let ground = KdBox::around(Aabb {
        min: Vec3::splat(-500.0),
        max: Vec3::splat(500.0),
    });
    let boxes = [Some(ground), Some(unit_box())];
    let corner = |x: f32, z: f32, impulse: f32| ContactPoint {
        code_a: ground.encode(Vec3::new(x, 0.0, z)),
        ..point_at(Vec3::new(x, -0.5, z), impulse)
    };
    let mut cache = ContactCache::new();
    let before = list(&[manifold(&[corner(-0.1, -0.1, 1.0), corner(0.1, 0.1, 2.0)])]);
    cache.store_and_age(&before, &IDS, &ROTATIONS, H);
    let mut after = list(&[manifold(&[
        corner(0.105, 0.1, 0.0),
        corner(-0.105, -0.1, 0.0),
    ])]);
    cache.warm_start(&mut after, &IDS, &ROTATIONS, &boxes, H);
    assert_eq!(
        [
            after.points()[0].normal_impulse,
            after.points()[1].normal_impulse
        ],
        [2.0, 1.0]
    );
}

#[test]
fn removed_bodies_are_forgotten_and_others_kept() {
    let ids = [BodyId(1), BodyId(2), BodyId(5)];
    let rotations = [Quat::IDENTITY; 3];
    let pair = |a: u32, b: u32| {
        let mut pair = manifold(&[point_at(Vec3::ZERO, 1.0)]);
        (pair.a, pair.b) = (a, b);
        pair
    };
    let mut cache = ContactCache::new();
    cache.store_and_age(
        &list(&[pair(0, 1), pair(0, 2), pair(1, 2)]),
        &ids,
        &rotations,
        H,
    );
    assert_eq!(cache.len(), 3);
    cache.remove_bodies(|id| id == BodyId(2));
    assert_eq!(cache.pairs().collect::<Vec<_>>(), [(BodyId(1), BodyId(5))]);
    cache.clear();
    assert!(cache.is_empty());
}

/// What the plain scheme stores under (A, code A, B, code B).
#[derive(Clone, Copy, Debug, PartialEq)]
struct NaiveEntry {
    impulse: f32,
    age: u32,
}

/// (A, code A, B, code B).
type Key = (BodyId, KdCode, BodyId, KdCode);

/// The plain scheme as one hash map.
#[derive(Default)]
struct NaiveCache(HashMap<Key, NaiveEntry>);

impl NaiveCache {
    fn step(&mut self, keys: &[(Key, f32)]) -> Vec<f32> {
        let warm = keys
            .iter()
            .map(|(key, _)| {
                self.0
                    .get(key)
                    .filter(|e| e.age == 0)
                    .map_or(0.0, |e| e.impulse)
            })
            .collect();
        self.0.values_mut().for_each(|e| e.age += 1);
        for &(key, impulse) in keys {
            self.0.insert(key, NaiveEntry { impulse, age: 0 });
        }
        self.0.retain(|_, e| e.age <= MAX_AGE);
        warm
    }
}

/// A random manifold of a pair, or none; codes are out of a few, no code twice.
fn random_manifold(random: &mut Dice, a: usize, b: usize) -> Option<Manifold> {
    if random.below(3) > 0 {
        return None;
    }
    let first = random.below(6) as u32;
    let points: Vec<ContactPoint> = (0..1 + random.below(4) as u32)
        .map(|i| ContactPoint {
            code_a: KdCode(first + i),
            code_b: KdCode(7),
            ..ContactPoint::default()
        })
        .collect();
    let mut found = manifold(&points);
    (found.a, found.b) = (a as u32, b as u32);
    Some(found)
}

/// Random manifolds with random impulses, sorted; of a thousand pairs, `kept` are as `before`.
fn random_manifolds(
    random: &mut Dice,
    ids: &[BodyId],
    before: &[Manifold],
    kept: usize,
) -> Vec<Manifold> {
    let name = |m: &Manifold| (ids[m.a as usize], ids[m.b as usize]);
    let mut manifolds = Vec::new();
    for a in 0..ids.len() {
        for b in (0..ids.len()).filter(|&b| ids[a] < ids[b]) {
            if random.below(1000) < kept {
                let found = before.binary_search_by_key(&(ids[a], ids[b]), name);
                manifolds.extend(found.map(|index| before[index]));
            } else {
                manifolds.extend(random_manifold(random, a, b));
            }
        }
    }
    for point in manifolds.iter_mut().flat_map(Manifold::points_mut) {
        point.normal_impulse = random.in_range(-1.0, 1.0) + 2.0;
    }
    manifolds.sort_by_key(name);
    manifolds
}

/// Plays random steps and compares with the plain scheme; of a thousand pairs, `kept` stay as they were in each.
fn check_against_hash_map(ids: &[BodyId], steps: usize, kept: usize) {
    let (rotations, boxes) = (vec![Quat::IDENTITY; ids.len()], vec![None; ids.len()]);
    let mut random = Dice::new(12345);
    let mut cache = ContactCache::new();
    let mut naive = NaiveCache::default();
    let mut solved = Vec::new();
    for number in 0..steps {
        // Now and then nothing touches.
        solved = if number % 50 == 49 {
            Vec::new()
        } else {
            random_manifolds(&mut random, ids, &solved, kept)
        };
        let mut manifolds = list(&solved);
        cache.warm_start(&mut manifolds, ids, &rotations, &boxes, H);
        cache.store_and_age(&list(&solved), ids, &rotations, H);
        let keys: Vec<_> = solved
            .iter()
            .flat_map(|m| m.points().iter().map(|p| (m.a, m.b, *p)))
            .map(|(a, b, p)| {
                (
                    (ids[a as usize], p.code_a, ids[b as usize], p.code_b),
                    p.normal_impulse,
                )
            })
            .collect();
        let expected = naive.step(&keys);
        let warm: Vec<f32> = manifolds
            .iter()
            .flat_map(|m| m.points().iter().map(|p| p.normal_impulse))
            .collect();
        assert_eq!(warm, expected, "step {number}");
        assert_eq!(cache.len(), naive.0.len(), "step {number}");
        let sorted = cache.pairs().is_sorted_by(|l, r| l < r);
        assert!(sorted, "step {number}");
        let mut found = 0;
        for (a, b) in cache.pairs() {
            for entry in cache.entries_of(a, b) {
                let twin = naive.0[&(a, entry.code_a, b, entry.code_b)];
                assert_eq!((entry.normal_impulse, entry.age), (twin.impulse, twin.age));
                found += 1;
            }
            let ages = cache.entries_of(a, b).map(|entry| entry.age);
            assert!(ages.is_sorted() && cache.entries_of(a, b).count() > 0);
        }
        assert_eq!(found, naive.0.len(), "step {number}");
    }
}

#[test]
fn merge_of_sorted_lists_equals_a_hash_map() {
    check_against_hash_map(&[4, 0, 9, 7, 2, 5].map(BodyId), 2000, 0);
}

#[test]
fn merge_in_several_parts_equals_a_hash_map() {
    // Some 700 of 2016 pairs touch.
    let ids: Vec<BodyId> = (0..64).map(|i| BodyId(i * 37 % 64)).collect();
    for kept in [0, 900, 999] {
        check_against_hash_map(&ids, 120, kept);
    }
}

/// Share of steps in which a point at the middle of a face keeps its code under jitter of 0.1 um.
fn share_of_kept_codes(code_box: &KdBox) -> f32 {
    let mut random = Dice::new(99);
    let place = |random: &mut Dice| Vec3::new(0.0, -0.5, 0.0) + 1e-7 * random.vector(-1.0, 1.0);
    let mut last = code_box.encode(place(&mut random));
    let mut kept = 0;
    for _ in 0..1000 {
        let code = code_box.encode(place(&mut random));
        kept += u32::from(code == last);
        last = code;
    }
    kept as f32 / 1000.0
}

#[test]
fn shifted_grid_ends_flips_at_the_middle_of_a_face() {
    let plain = KdBox {
        min: Vec3::splat(-0.5),
        extents: Vec3::ONE,
    };
    // Two axes lie on a split plane, so a code is kept in one of four steps.
    assert!(
        share_of_kept_codes(&plain) < 0.35,
        "{}",
        share_of_kept_codes(&plain)
    );
    assert_eq!(share_of_kept_codes(&unit_box()), 1.0);
}

/// A body (id 1) that moves over another (id 0, at rest at the origin).
struct Scene {
    floor: ConvexHull,
    body: ConvexHull,
}

/// Hit rates over a motion.
#[derive(Debug)]
struct Rates {
    /// Share of points found under their own codes: all that a cache with exact keys finds.
    exact: f32,
    /// Share of points found by code or by nearness.
    all: f32,
    /// Share of found points that moved by more than 5 mm on both bodies.
    wrong: f32,
    /// Most entries alive at once.
    entries: usize,
}

impl Scene {
    /// Plays a motion, one pose per step, through narrow phase and cache.
    fn measure(&self, motion: impl Iterator<Item = Pose>) -> Rates {
        let boxes = [&self.floor, &self.body].map(|hull| Some(KdBox::around(hull.aabb())));
        let ids = [BodyId(0), BodyId(1)];
        let mut cache = ContactCache::new();
        let mut scratch = NarrowScratch::new();
        let mut last: Vec<[Vec3; 2]> = Vec::new();
        let mut total = CacheStats::default();
        let (mut wrong, mut entries) = (0, 0);
        for (number, pose) in motion.enumerate() {
            let patch = collide_hulls(&self.floor, &self.body, pose, 0.02, &mut scratch)
                .expect("the body never leaves the floor");
            let body = |slot: u32, pose| ManifoldBody {
                slot,
                pose,
                center: Vec3::ZERO,
                code_box: boxes[slot as usize],
            };
            let (a, b) = (body(0, Pose::IDENTITY), body(1, pose));
            let mut manifolds = list(&[Manifold::from_local(&a, &b, &patch, 0.5, 0.0)]);
            let rotations = [Quat::IDENTITY, pose.rotation];
            let stats = cache.warm_start(&mut manifolds, &ids, &rotations, &boxes, H);
            if number > 0 {
                total.add(&stats);
            }
            let places: Vec<[Vec3; 2]> = patch.points().iter().map(|p| [p.on_a, p.on_b]).collect();
            for (point, place) in manifolds.points_mut().iter_mut().zip(&places) {
                // The "impulse" is the number of the point, so that the warm start tells which one was found.
                if point.normal_impulse > 0.0 {
                    let found = last[point.normal_impulse as usize - 1];
                    let moved = (0..2).map(|i| (place[i] - found[i]).length());
                    wrong += u32::from(moved.fold(f32::INFINITY, f32::min) > 0.005);
                }
            }
            for (i, point) in manifolds.points_mut().iter_mut().enumerate() {
                point.normal_impulse = (i + 1) as f32;
            }
            cache.store_and_age(&manifolds, &ids, &rotations, H);
            entries = entries.max(cache.len());
            last = places;
        }
        Rates {
            exact: total.exact_hits as f32 / total.points as f32,
            all: total.hit_rate(),
            wrong: wrong as f32 / (total.exact_hits + total.near_hits).max(1) as f32,
            entries,
        }
    }
}

fn cuboid(half: Vec3) -> ConvexHull {
    let corner = |i: u32| {
        let sign = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        half * Vec3::new(sign(0), sign(1), sign(2))
    };
    let faces = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    ConvexHull::from_faces((0..8).map(corner).collect(), &faces).expect("a cuboid is valid")
}

/// A prism of 16 sides about the z axis, radius 0.5 m, length 1 m.
fn roller() -> ConvexHull {
    let n = 16;
    let ring = |i: u32, z: f32| {
        let u = 4.0 * (i as f32 + 0.5) / n as f32 - 1.0;
        let (t, side) = if u < 1.0 { (u, 1.0) } else { (u - 2.0, -1.0) };
        let scale = 0.5 * side / (1.0 + t * t);
        Vec3::new((1.0 - t * t) * scale, 2.0 * t * scale, z)
    };
    let vertices = (0..n)
        .map(|i| ring(i, -0.5))
        .chain((0..n).map(|i| ring(i, 0.5)))
        .collect();
    let mut faces: Vec<Vec<u32>> = vec![(0..n).rev().collect(), (n..2 * n).collect()];
    faces.extend((0..n).map(|i| {
        let j = (i + 1) % n;
        vec![i, j, n + j, n + i]
    }));
    ConvexHull::from_faces(vertices, &faces).expect("a prism is valid")
}

/// A 10 m floor whose top is y = 0.5, and a unit cube.
fn cube_on_floor() -> Scene {
    Scene {
        floor: cuboid(Vec3::new(5.0, 0.5, 5.0)),
        body: cuboid(Vec3::splat(0.5)),
    }
}

/// Translation at `speed` m/s with 10 um of jitter, resting 0.1 mm deep.
fn slide(speed: f32, steps: u32) -> impl Iterator<Item = Pose> {
    let mut random = Dice::new(7);
    (0..steps).map(move |i| {
        let along = speed * H * i as f32;
        let place = Vec3::new(0.8 * along - 3.0, 0.9999, 0.6 * along - 2.1);
        Pose::new(place + 1e-5 * random.vector(-1.0, 1.0), Quat::IDENTITY)
    })
}

/// A hull that rolls without slip along x at about `speed` m/s, turning over its lowest edge.
fn roll(hull: &ConvexHull, speed: f32, steps: u32) -> impl Iterator<Item = Pose> {
    let angle = speed * H / 0.5;
    let turn = Quat::from_xyzw(0.0, 0.0, -0.5 * angle, 1.0).normalize();
    let mut pose = Pose::new(Vec3::new(-3.0, 1.0, 0.2), Quat::IDENTITY);
    (0..steps).map(move |_| {
        let lowest = |pose: &Pose| {
            hull.vertices()
                .iter()
                .map(|&v| pose.transform_point(v))
                .fold(Vec3::INFINITY, |low, v| if v.y < low.y { v } else { low })
        };
        let pivot = lowest(&pose);
        pose.position = pivot + turn * (pose.position - pivot);
        pose.rotation = (turn * pose.rotation).normalize();
        pose.position.y += 0.4999 - lowest(&pose).y;
        pose
    })
}

/// A cube that spins about the vertical at 5 rad/s.
fn spin(steps: u32) -> impl Iterator<Item = Pose> {
    let turn = Quat::from_xyzw(0.0, 0.5 * 5.0 * H, 0.0, 1.0).normalize();
    let mut pose = Pose::new(Vec3::new(0.3, 0.9999, 0.2), Quat::IDENTITY);
    (0..steps).map(move |_| {
        pose.rotation = (turn * pose.rotation).normalize();
        pose
    })
}

/// Asserts what holds of any motion: at least the share `all` of the points is found, none wrongly.
fn check_found(name: &str, rates: &Rates, all: f32) {
    assert!(rates.all >= all, "{name}: {rates:?}");
    assert_eq!(rates.wrong, 0.0, "{name}: {rates:?}");
    assert!(
        rates.entries <= 44,
        "{name}: at most 4 points times 11 ages: {rates:?}"
    );
}

/// As [`check_found`], and the share that exact keys find is the one of the module's table, which has three digits.
fn check(name: &str, rates: &Rates, exact: f32, all: f32) {
    check_found(name, rates, all);
    assert!((rates.exact - exact).abs() < 0.001, "{name}: {rates:?}");
}

#[test]
fn resting_contacts_are_found_by_their_codes() {
    // At 2000 places, so that chance does not put the corners in the middle of the floor's cells.
    let scene = cube_on_floor();
    let mut random = Dice::new(31);
    let mut exact = 0.0;
    for _ in 0..2000 {
        let shift = 2.0 * random.vector(-1.0, 1.0) * Vec3::new(1.0, 0.0, 1.0);
        let rest = slide(0.0, 60).map(|pose| Pose::new(pose.position + shift, pose.rotation));
        let rates = scene.measure(rest);
        check_found("rest", &rates, 1.0);
        exact += rates.exact / 2000.0;
    }
    // A cell of the floor measures 5 x 10 mm in the plane. Two places within 10 um are on average two thirds of that apart,
    // so that a step crosses a border with a chance of 2/3 * 10 um * (1 / 5 mm + 1 / 10 mm) = 0.2 %.
    assert!((exact - 0.998).abs() < 0.001, "{exact}");
}

#[test]
fn sliding_contacts_are_found_by_nearness() {
    let scene = cube_on_floor();
    check("slide 0.05", &scene.measure(slide(0.05, 600)), 0.823, 1.0);
    check("slide 0.5", &scene.measure(slide(0.5, 600)), 0.0, 1.0);
    check("slide 2", &scene.measure(slide(2.0, 180)), 0.0, 1.0);
}

#[test]
fn spinning_contacts_are_found_by_nearness() {
    check("spin", &cube_on_floor().measure(spin(600)), 0.0, 1.0);
}

#[test]
fn rolling_contacts_miss_only_where_new_edges_touch() {
    let hull = roller();
    let scene = Scene {
        floor: cuboid(Vec3::new(5.0, 0.5, 5.0)),
        body: hull.clone(),
    };
    check(
        "roll 0.2",
        &scene.measure(roll(&hull, 0.2, 600)),
        0.986,
        0.989,
    );
    check(
        "roll 1",
        &scene.measure(roll(&hull, 1.0, 300)),
        0.931,
        0.943,
    );
}

#[test]
fn contacts_with_a_half_space_stay_warm_while_sliding() {
    let hull = cuboid(Vec3::splat(0.5));
    let boxes = [None, Some(KdBox::around(hull.aabb()))];
    let ids = [BodyId(0), BodyId(1)];
    let rotations = [Quat::IDENTITY; 2];
    let mut scratch = NarrowScratch::new();
    let mut cache = ContactCache::new();
    for (number, pose) in slide(2.0, 120).enumerate() {
        let floor_in_hull = Pose::new(Vec3::Y * 0.5, Quat::IDENTITY);
        let floor_in_hull = Pose::new(floor_in_hull.position - pose.position, Quat::IDENTITY);
        let plane = Plane::through(floor_in_hull.position, Vec3::Y);
        let patch = collide_half_space(&hull, plane, floor_in_hull, 0.02, &mut scratch)
            .expect("the cube rests on the floor")
            .swapped(&floor_in_hull);
        let body = |slot: u32, pose| ManifoldBody {
            slot,
            pose,
            center: Vec3::ZERO,
            code_box: boxes[slot as usize],
        };
        let floor = body(0, Pose::new(Vec3::Y * 0.5, Quat::IDENTITY));
        let manifold = Manifold::from_local(&floor, &body(1, pose), &patch, 0.5, 0.0);
        let mut manifolds = list(&[manifold]);
        let stats = cache.warm_start(&mut manifolds, &ids, &rotations, &boxes, H);
        assert_eq!(manifold.normal, Vec3::Y);
        assert_eq!(stats.exact_hits, if number == 0 { 0 } else { 4 });
        cache.store_and_age(&manifolds, &ids, &rotations, H);
    }
}
