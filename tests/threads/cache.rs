//! The contact cache.

use crate::common::dice::Dice;
use crate::{alone, on_threads};
use bevy_cleave::contact::{
    BodyId, CacheStats, ContactCache, ContactPoint, Manifold, ManifoldHead, Manifolds,
};
use bevy_cleave::geometry::KdBox;
use bevy_cleave::math::Aabb;
use bevy_cleave::testing::contact::CacheEntry;
use glam::{Quat, Vec3};

const BODIES: usize = 80;
const STEPS: usize = 150;

/// Step length, s.
const H: f32 = 1.0 / 60.0;

/// Bodies in unit boxes, each with a name and a rotation of its own; some have no box.
struct World {
    ids: Vec<BodyId>,
    rotations: Vec<Quat>,
    boxes: Vec<Option<KdBox>>,
}

impl World {
    fn new(random: &mut Dice) -> Self {
        let unit = KdBox::around(Aabb {
            min: Vec3::splat(-0.5),
            max: Vec3::splat(0.5),
        });
        Self {
            // Slots are in another order than names.
            ids: (0..BODIES as u32)
                .map(|i| BodyId(i * 27 % BODIES as u32))
                .collect(),
            rotations: (0..BODIES).map(|_| random.rotation()).collect(),
            boxes: (0..BODIES).map(|i| (i % 9 > 0).then_some(unit)).collect(),
        }
    }

    /// Contact points on both boxes, the same place or one nearby.
    fn points(&self, random: &mut Dice, manifold: &mut Manifold) {
        manifold.count = 1 + random.below(4) as u32;
        let [a, b] = [manifold.a, manifold.b].map(|slot| self.boxes[slot as usize]);
        for point in manifold.points_mut() {
            let place = random.vector(-0.5, 0.5);
            *point = ContactPoint {
                code_a: a.map(|a| a.encode(place)).unwrap_or_default(),
                code_b: b.map(|b| b.encode(place)).unwrap_or_default(),
                ..ContactPoint::default()
            };
        }
    }

    /// All pairs, sorted by name, without points.
    fn pairs(&self) -> Vec<Manifold> {
        let slots = 0..BODIES;
        let pairs = slots
            .clone()
            .flat_map(|a| slots.clone().map(move |b| (a, b)));
        let mut pairs: Vec<_> = pairs
            .filter(|&(a, b)| self.ids[a] < self.ids[b])
            .map(|(a, b)| Manifold {
                head: ManifoldHead {
                    a: a as u32,
                    b: b as u32,
                    normal: Vec3::Y,
                    ..ManifoldHead::default()
                },
                ..Manifold::default()
            })
            .collect();
        pairs.sort_by_key(|m| (self.ids[m.a as usize], self.ids[m.b as usize]));
        pairs
    }

    /// Some pairs begin or cease to touch, some points move to other cells.
    fn change(&self, random: &mut Dice, pairs: &mut [Manifold]) {
        // Most steps change little, some a lot, some nothing.
        let share = [0, 5, 5, 5, 300][random.below(5)];
        for manifold in pairs {
            if random.below(1000) >= share {
                continue;
            }
            match random.below(3) {
                0 => manifold.count = 0,
                1 => self.points(random, manifold),
                _ => {
                    let slot = manifold.a as usize;
                    let points = manifold.points_mut().iter_mut();
                    for (point, code_box) in points.zip(self.boxes[slot]) {
                        let place = code_box.decode_center(point.code_a);
                        point.code_a = code_box.encode(place + random.vector(-0.01, 0.01));
                    }
                }
            }
        }
    }
}

/// What a step gave: statistics, the warm-started points and the whole table.
pub(crate) type Outcome = (
    CacheStats,
    Vec<ContactPoint>,
    Vec<(BodyId, BodyId)>,
    Vec<CacheEntry>,
);

pub(crate) fn play() -> Vec<Outcome> {
    let mut random = Dice::new(77);
    let world = World::new(&mut random);
    let World {
        ids,
        rotations,
        boxes,
    } = &world;
    let mut pairs = world.pairs();
    let mut cache = ContactCache::new();
    let mut outcomes = Vec::new();
    let mut most = 0;
    for step in 0..STEPS {
        world.change(&mut random, &mut pairs);
        let touching = pairs
            .iter()
            .filter(|m| m.count > 0 || random.below(50) == 0);
        let mut manifolds: Manifolds = touching.collect();
        most = most.max(manifolds.len());
        let stats = cache.warm_start(&mut manifolds, ids, rotations, boxes, H);
        let warm = manifolds.points().to_vec();
        for point in manifolds.points_mut() {
            point.normal_impulse = random.unit();
            point.friction_impulse = random.vector(-1.0, 1.0);
        }
        cache.store_and_age(&manifolds, ids, rotations, H);
        let some = [BodyId(step as u32 % 7), BodyId(40)];
        match step % 10 {
            3 => cache.remove_bodies(|id| id == BodyId(step as u32 % 80)),
            5 => cache.suspend(&some),
            7 => cache.resume(&some),
            _ => {}
        }
        let entries = cache.pairs().flat_map(|(a, b)| cache.entries_of(a, b));
        let entries = entries.copied().collect();
        outcomes.push((stats, warm, cache.pairs().collect(), entries));
    }
    assert!(
        most > 1000,
        "parts enough for several threads: {most} manifolds"
    );
    let near: u32 = outcomes.iter().map(|outcome| outcome.0.near_hits).sum();
    let stale: u32 = outcomes.iter().map(|outcome| outcome.0.stale_hits).sum();
    assert!(near > 0 && stale > 0, "{near} near, {stale} stale");
    outcomes
}

#[test]
fn tables_and_statistics_are_the_same_on_one_thread_and_on_five() {
    assert!(alone().cache == on_threads(play));
}
