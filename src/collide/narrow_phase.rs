//! From bodies to manifolds: feeds the contact layer with the bodies' boxes, shapes and materials.
//!
//! Pairs are independent, so they are split into parts for a team of threads, if there is one. What is known of a pair
//! lives with its part (`contact/known.rs`), so the split stays what it is until parts have become too unequal.
//! It depends on the scene only, and the parts are joined in order: any number of threads gives the same bits.

mod compound;
pub(super) mod compound_near;
pub(super) mod compound_sense;
mod level;
pub(super) mod part;
pub(super) mod round;
mod scene;

use crate::bodies::store::Bodies;
use crate::collide::narrow_phase::part::PairRun;
use crate::collide::narrow_phase::scene::Scene;
use crate::collide::proxies::{Boxes, Lookahead};
use crate::contact::body_id::BodyId;
use crate::contact::body_manifold::BodyPlace;
use crate::contact::manifolds::Manifolds;
use crate::contact::pairs::broad_phase::name_of;
use crate::contact::pairs::broad_phase::{Broadphase, Pair};
use crate::contact::pairs::recycle::{MotionBound, PairBody};
use crate::contact::pairs::touches::Touch;
use crate::math::{Pose, rotate};
use crate::threads::team::Team;
use crate::tuning::{
    MAX_PAIR_PARTS, MAX_PART_GROWTH, MIN_PROXIES, PAIRS_PER_PART, PARTS_WORTH_HELP,
    TOUCHES_WORTH_SORTING,
};
use glam::Mat3;

/// What is known of the pairs from step to step, and buffers.
#[derive(Clone, Debug, Default)]
pub struct NarrowPhase {
    boxes: Boxes,
    /// Bodies by slot.
    bodies: Vec<PairBody>,
    paces: Vec<MotionBound>,
    /// What is known of the pairs.
    parts: Vec<PairRun>,
    /// Revision and length of the pair list that they follow.
    of_pairs: Option<(u64, usize)>,
    /// The part whose touches are sorted next.
    next_sorted: usize,
    spare_touches: Vec<Touch>,
}

/// How far apart bodies may be that sleep in contact, as a share of the smaller least extent: what bears has sunk in, or is off by rounding.
const RESTING: f32 = 1e-4;

/// Whether the contacts of `pairs` pairs are worth a team.
pub(crate) fn is_worth_help(pairs: usize) -> bool {
    pairs >= PARTS_WORTH_HELP * PAIRS_PER_PART
}

/// Brings the pairs of `broadphase` up to date with the bodies.
pub fn update_pairs(
    broadphase: &mut Broadphase,
    narrow: &mut NarrowPhase,
    bodies: &Bodies,
    ahead: Lookahead,
) {
    narrow.boxes.update(broadphase, bodies, ahead);
}

impl NarrowPhase {
    /// Fills `manifolds` with the contacts of all pairs, in their order. Impulses are zero.
    pub fn collide(
        &mut self,
        bodies: &Bodies,
        broadphase: &Broadphase,
        ahead: Lookahead,
        manifolds: &mut Manifolds,
        team: Option<&Team>,
    ) {
        let pairs = broadphase.pairs();
        let known = Some((broadphase.revision(), pairs.len()));
        if std::mem::replace(&mut self.of_pairs, known) != known {
            self.share_out(pairs, &bodies.ids);
        }
        self.sort_touches();
        self.load_bodies(bodies, ahead, team);
        let scene = &Scene {
            bodies,
            seen: &self.bodies,
            paces: &self.paces,
            fall: ahead.fall,
        };
        Team::each_of_many(team, self.parts.iter_mut(), |part| {
            part.test(scene, &pairs[part.pairs.clone()]);
        });
        let mut first = 0;
        for part in &mut self.parts {
            part.points = first..first + part.points.end;
            first = part.points.end;
        }
        let parts = self.parts.iter();
        let sizes = parts
            .clone()
            .map(|part| (part.touching(), part.points.clone()));
        let writers = manifolds.writers(sizes);
        Team::each_of_many(team, writers.zip(parts), |(writer, part)| {
            part.write_manifolds(scene, &pairs[part.pairs.clone()], writer);
        });
    }

    /// Those of `pairs` of which one sleeps and that touch: their contacts are within reach, and no farther apart than rounding.
    pub(crate) fn dormant_pairs(
        &self,
        pairs: &[Pair],
        bodies: &Bodies,
    ) -> impl Iterator<Item = [u32; 2]> {
        self.parts.iter().flat_map(move |part| {
            let pairs = pairs.get(part.pairs.clone()).unwrap_or(&[]);
            let known = pairs.iter().zip(&part.known.terms);
            let near = known.filter(|(_, term)| term.points > 0);
            near.map(|(pair, term)| ([pair.a, pair.b], term.touch))
                .filter(|(slots, _)| slots.iter().all(|&slot| bodies.contains(slot)))
                .filter(|(slots, _)| slots.iter().any(|&slot| bodies.is_asleep(slot)))
                .filter(|&(slots, touch)| {
                    let [a, b] = slots.map(|slot| bodies.min_extent[slot as usize]);
                    let places = slots.map(|slot| place_of(bodies, slot));
                    part.known.touches.gap(touch, &places) <= RESTING * a.min(b)
                })
                .map(|(slots, _)| slots)
        })
    }

    /// Tells each part its pairs, which are others than before.
    fn share_out(&mut self, pairs: &[Pair], ids: &[BodyId]) {
        self.find_ends(pairs, ids);
        let most = self.parts.iter().map(|part| part.pairs.len()).max();
        let count = pairs
            .len()
            .div_ceil(PAIRS_PER_PART)
            .clamp(1, MAX_PAIR_PARTS);
        let too_large = MAX_PART_GROWTH * pairs.len().div_ceil(count);
        if most.is_none_or(|most| most > too_large) || self.parts.len() > MAX_PART_GROWTH * count {
            self.split(pairs, ids, count);
            self.find_ends(pairs, ids);
        }
        for part in &mut self.parts {
            part.is_outdated = true;
        }
    }

    /// Finds which pairs belong to which part, by their names.
    fn find_ends(&mut self, pairs: &[Pair], ids: &[BodyId]) {
        let mut end = pairs.len();
        for part in self.parts.iter_mut().rev() {
            let first = pairs.partition_point(|&pair| name_of(pair, ids) < part.least);
            part.pairs = first..end;
            end = first;
        }
    }

    /// Splits the pairs into `count` equal parts.
    fn split(&mut self, pairs: &[Pair], ids: &[BodyId], count: usize) {
        let least = |part: usize| match part {
            0 => Default::default(),
            _ => name_of(pairs[part * pairs.len() / count], ids),
        };
        let before = std::mem::replace(
            &mut self.parts,
            (0..count)
                .map(|part| PairRun::starting_at(least(part)))
                .collect(),
        );
        let mut at = 0;
        for known in before.iter().map(|part| &part.known) {
            for (pair, &name) in known.names().iter().enumerate() {
                while self.parts.get(at + 1).is_some_and(|p| p.least <= name) {
                    at += 1;
                }
                self.parts[at].known.take(known, pair);
            }
        }
    }

    /// Sorts the touches of one part, if there are many and the part has need of it: the next part follows in the next step.
    fn sort_touches(&mut self) {
        let touches = self.parts.iter().map(|part| part.known.touches.len());
        if touches.sum::<usize>() < TOUCHES_WORTH_SORTING {
            return;
        }
        self.next_sorted = (self.next_sorted + 1) % self.parts.len();
        let part = &mut self.parts[self.next_sorted];
        part.known.sort_touches(&mut self.spare_touches);
    }

    /// Collects what pairs read of the bodies.
    fn load_bodies(&mut self, bodies: &Bodies, ahead: Lookahead, team: Option<&Team>) {
        self.bodies.resize(bodies.slots(), PairBody::default());
        self.paces.resize(bodies.slots(), MotionBound::default());
        if bodies.local.is_on {
            for &slot in &bodies.local.slots {
                let i = slot as usize;
                let (body, pace) = (&mut self.bodies[i], &mut self.paces[i]);
                load_body(bodies, slot, ahead, body, pace);
            }
            return;
        }
        let size = Team::part_size(team, bodies.slots(), MIN_PROXIES);
        let parts = self.bodies.chunks_mut(size);
        let parts = parts.zip(self.paces.chunks_mut(size)).enumerate();
        Team::each_of_many(team, parts, |(index, (seen, paces))| {
            let slots = ((index * size) as u32..).zip(seen.iter_mut().zip(paces));
            // What sleeps has not moved.
            for (slot, (body, pace)) in slots.filter(|&(slot, _)| !bodies.is_asleep(slot)) {
                load_body(bodies, slot, ahead, body, pace);
            }
        });
    }
}

/// Brings what pairs know of the body in `slot` up to date.
fn load_body(
    bodies: &Bodies,
    slot: u32,
    ahead: Lookahead,
    body: &mut PairBody,
    pace: &mut MotionBound,
) {
    let now = pair_body(bodies, slot, ahead);
    let motion = now.motion_since(body);
    pace.walk(motion);
    pace.ahead = now.travel.length() + now.turning;
    pace.min_extent = bodies.min_extent[slot as usize];
    pace.version = bodies.version[slot as usize];
    *body = now;
}

fn place_of(bodies: &Bodies, slot: u32) -> BodyPlace {
    let i = slot as usize;
    BodyPlace {
        center: bodies.center[i],
        turn: Mat3::from_quat(bodies.rotation[i]),
    }
}

/// The body in `slot` as its pairs see it.
fn pair_body(bodies: &Bodies, slot: u32, ahead: Lookahead) -> PairBody {
    let i = slot as usize;
    let is_half_space = bodies.min_extent[i] == f32::INFINITY && bodies.radius(slot) == 0.0;
    PairBody {
        place: place_of(bodies, slot),
        rotation: bodies.rotation[i],
        radius: if is_half_space {
            f32::INFINITY
        } else {
            bodies.radius(slot)
        },
        travel: ahead.travel(bodies, slot),
        turning: ahead.turn(bodies, slot),
        spin: ahead.spin(bodies, slot),
    }
}

/// `a_from_b`, from the difference of the centers of mass, which is exact far from the origin too.
pub(crate) fn relative_pose(bodies: &Bodies, a: u32, b: u32) -> Pose {
    let (i, j) = (a as usize, b as usize);
    let a_from_world = bodies.rotation[i].inverse();
    let rotation = a_from_world * bodies.rotation[j];
    let centers = rotate(a_from_world, bodies.center[j] - bodies.center[i]);
    Pose::new(
        centers + bodies.mass[i].center - rotate(rotation, bodies.mass[j].center),
        rotation,
    )
}
