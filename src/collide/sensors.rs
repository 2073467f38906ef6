//! Who is inside a sensor, or was on the way within the last step. Nothing that moves depends on it.

use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use crate::collide::narrow_phase::compound_near::PartScratch;
use crate::collide::narrow_phase::compound_sense::examine_compound_pair;
use crate::collide::narrow_phase::part::examine_pair;
use crate::collide::narrow_phase::relative_pose;
use crate::collide::narrow_phase::round::examine_round_pair;
use crate::collide::proxies::tight_box;
use crate::contact::body_id::BodyId;
use crate::contact::local_manifold::LocalManifold;
use crate::contact::narrow::level_scratch::LevelScratch;
use crate::contact::narrow::round::patch::RoundScratch;
use crate::contact::narrow::scratch::{NarrowScratch, SatCache, SatResult};
use crate::contact::pairs::broad_phase::{Broadphase, Pair};
use crate::math::{Aabb, Pose, rotate};
use glam::Vec3;

/// Steps of conservative advancement, each as far as two shapes surely do not touch. Halving the distance each time would come
/// within a ten-thousandth of it.
const MAX_ADVANCES: usize = 16;

/// A distance that counts as touching while shapes approach, as a share of the way that they go.
const NEAR: f32 = 1e-4;

/// Two bodies, one of them a sensor, that overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Overlap {
    pub(crate) pair: Pair,
    /// Ids of the two, the smaller one first.
    pub(crate) name: [BodyId; 2],
    /// Unit vector along which they are least apart, from A to B, world axes.
    pub(crate) normal: Vec3,
    /// A point that both have, world, m.
    pub(crate) point: Vec3,
}

#[derive(Clone, Debug, Default)]
struct SenseScratch {
    hulls: NarrowScratch,
    round: RoundScratch,
    level: LevelScratch,
}

/// The overlaps of the last step, and buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sensing {
    /// Sorted by the ids of the pair.
    pub(crate) overlaps: Vec<Overlap>,
    /// Those of the step before.
    before: Vec<Overlap>,
    scratch: SenseScratch,
    found: Vec<u32>,
    boxes: Vec<(u32, Option<Aabb>)>,
}

impl Sensing {
    /// Finds who is inside a sensor, after a step has moved the bodies.
    pub(crate) fn find(&mut self, bodies: &Bodies, broadphase: &Broadphase) {
        std::mem::swap(&mut self.before, &mut self.overlaps);
        self.overlaps.clear();
        self.boxes.clear();
        let active = bodies
            .sensors
            .iter()
            .filter(|&&slot| takes_part(bodies, slot));
        self.boxes
            .extend(active.map(|&slot| (slot, swept_box(bodies, slot))));
        for at in 0..self.boxes.len() {
            let (sensor, region) = self.boxes[at];
            self.found.clear();
            match region {
                Some(region) => {
                    broadphase.search_box(&region, &mut self.found);
                }
                None => self
                    .found
                    .extend(bodies.iter().filter(|&slot| !bodies.is_sensor(slot))),
            }
            // Each pair of sensors once.
            let others = self.boxes[..at].iter();
            let near = others.filter(|(_, other)| match (region, other) {
                (Some(region), Some(other)) => region.overlaps(other),
                _ => true,
            });
            self.found.extend(near.map(|&(slot, _)| slot));
            for &other in &self.found {
                let pair = pair_of(bodies, sensor, other);
                if may_sense(bodies, pair) {
                    let overlap = self.still_inside(bodies, pair);
                    let overlap = overlap.or_else(|| overlap_of(bodies, pair, &mut self.scratch));
                    self.overlaps.extend(overlap);
                }
            }
        }
        self.overlaps.sort_unstable_by_key(|overlap| overlap.name);
    }

    /// The overlap of a pair that had one, if a corner of the one is still in the other. How they are apart is asked when a contact
    /// starts only.
    fn still_inside(&self, bodies: &Bodies, pair: Pair) -> Option<Overlap> {
        let name = name_of(bodies, pair);
        let at = self.before.binary_search_by_key(&name, |known| known.name);
        let normal = self.before[at.ok()?].normal;
        let Pair { a, b } = pair;
        let point = corner_inside(bodies, a, b).or_else(|| corner_inside(bodies, b, a))?;
        Some(Overlap {
            pair,
            name,
            normal,
            point,
        })
    }
}

fn name_of(bodies: &Bodies, pair: Pair) -> [BodyId; 2] {
    [pair.a, pair.b].map(|slot| bodies.id(slot))
}

/// The first corner of a hull if it is in another one, world, m.
fn corner_inside(bodies: &Bodies, around: u32, inner: u32) -> Option<Vec3> {
    let sharp = |slot: u32| bodies.convex(slot).filter(|mesh| !mesh.is_round());
    let (hull, corner) = (sharp(around)?.hull(), sharp(inner)?.hull().vertices()[0]);
    let inside = relative_pose(bodies, around, inner).transform_point(corner);
    let mut planes = hull.lanes.planes.iter();
    let holds = planes.all(|planes| planes.heights(inside).iter().all(|&height| height <= 0.0));
    holds.then(|| bodies.pose(inner).transform_point(corner))
}

fn takes_part(bodies: &Bodies, slot: u32) -> bool {
    bodies.is_active(slot) || bodies.is_asleep(slot)
}

fn pair_of(bodies: &Bodies, s: u32, t: u32) -> Pair {
    if bodies.id(s) < bodies.id(t) {
        Pair { a: s, b: t }
    } else {
        Pair { a: t, b: s }
    }
}

/// Whether the sensor of the pair is to see the other one: what neither moves nor ever will is no news.
fn may_sense(bodies: &Bodies, Pair { a, b }: Pair) -> bool {
    let fixed = |slot: u32| bodies.kind(slot) == RigidBody::Static;
    takes_part(bodies, a)
        && takes_part(bodies, b)
        && !(fixed(a) && fixed(b))
        && bodies.info(a).layers.interact(&bodies.info(b).layers)
}

/// How far the last step moved a body, m.
fn shift(bodies: &Bodies, slot: u32) -> Vec3 {
    if bodies.is_moving(slot) {
        bodies.motion[slot as usize].shift
    } else {
        Vec3::ZERO
    }
}

/// The box of all places where the body was within the last step; nothing for one that no box holds.
fn swept_box(bodies: &Bodies, slot: u32) -> Option<Aabb> {
    let now = tight_box(bodies, slot)?;
    Some(now.swept(-shift(bodies, slot)))
}

/// Where the pair overlaps, if it does or did on its way.
fn overlap_of(bodies: &Bodies, pair: Pair, scratch: &mut SenseScratch) -> Option<Overlap> {
    let now = relative_pose(bodies, pair.a, pair.b);
    let to_a = bodies.rotation[pair.a as usize].inverse();
    let way = rotate(to_a, shift(bodies, pair.b) - shift(bodies, pair.a));
    let length = way.length();
    let mut done = 0.0;
    for _ in 0..MAX_ADVANCES {
        let mut b_in_a = now;
        b_in_a.position -= (1.0 - done) * way;
        let found = examine(bodies, pair, b_in_a, way, scratch);
        let (axis, distance) = match found {
            SatResult::Touching(patch) => return Some(overlap_at(bodies, pair, &patch)),
            SatResult::Separated { axis, distance } => (axis, distance),
        };
        let approach = -axis.dot(way);
        if done >= 1.0 || approach <= 0.0 {
            return None;
        }
        // A little more, or two faces that are parallel would be approached for ever.
        done += (distance + NEAR * length) / approach;
        if done > 1.0 {
            // The distance is a lower bound along one axis: at the end it is looked at once more.
            done = 1.0;
        }
    }
    None
}

/// Contact of one pair in A's frame, in which B comes along `way` (m), or how far they are apart.
fn examine(
    bodies: &Bodies,
    pair: Pair,
    b_in_a: Pose,
    way: Vec3,
    scratch: &mut SenseScratch,
) -> SatResult {
    let SenseScratch {
        hulls,
        round,
        level,
    } = scratch;
    if bodies.any_compound {
        let mut parts = PartScratch {
            hulls: &mut *hulls,
            round: &mut *round,
            level,
        };
        if let Some(found) = examine_compound_pair(bodies, pair, b_in_a, way, &mut parts) {
            return found;
        }
    }
    examine_round_pair(bodies, pair, b_in_a, 0.0, round)
        .unwrap_or_else(|| examine_pair(bodies, pair, b_in_a, 0.0, SatCache::NONE, hulls))
}

fn overlap_at(bodies: &Bodies, pair: Pair, patch: &LocalManifold) -> Overlap {
    let pose = bodies.pose(pair.a);
    let points = patch.points();
    let sum: Vec3 = points.iter().map(|point| point.on_a).sum();
    let [a, b] = [pair.a, pair.b].map(|slot| bodies.center_of_mass(slot));
    let point = if points.is_empty() {
        0.5 * (a + b)
    } else {
        pose.transform_point(sum / points.len() as f32)
    };
    let normal = rotate(pose.rotation, patch.normal);
    Overlap {
        pair,
        name: name_of(bodies, pair),
        normal: normal.try_normalize().unwrap_or(Vec3::Y),
        point,
    }
}
