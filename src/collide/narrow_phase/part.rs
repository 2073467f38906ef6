//! A run of pairs: which of them are tested, and what manifolds they make.

use crate::bodies::body::Shape;
use crate::bodies::store::Bodies;
use crate::collide::narrow_phase::relative_pose;
use crate::collide::narrow_phase::scene::Scene;
use crate::contact::body_manifold::BodyManifold;
use crate::contact::local_manifold::LocalManifold;
use crate::contact::manifolds::{ManifoldHead, ManifoldWriter};
use crate::contact::narrow::cast::CastResult;
use crate::contact::narrow::flush::CompoundScratch;
use crate::contact::narrow::half_space::examine_half_space;
use crate::contact::narrow::level_scratch::LevelScratch;
use crate::contact::narrow::round::patch::RoundScratch;
use crate::contact::narrow::sat::{distance_along, examine_hulls};
use crate::contact::narrow::scratch::{NarrowScratch, SatCache, SatResult};
use crate::contact::pairs::broad_phase::Pair;
use crate::contact::pairs::broad_phase::PairName;
use crate::contact::pairs::recycle::{PairView, Recycle, reach_of_test};
use crate::contact::pairs::store::PairStore;
use crate::contact::pairs::touches::Touch;
use crate::math::{Plane, Pose, rotate};
use crate::simd::prefetch::prefetch;
use crate::tuning::{PAIR_RUN, PAIRS_AHEAD};
use glam::{Quat, Vec3};
use std::ops::Range;

/// A run of pairs that follow each other.
#[derive(Clone, Debug, Default)]
pub(crate) struct PairRun {
    /// The least name of a pair that belongs to it.
    pub(crate) least: PairName,
    /// Its pairs, within those of the broad phase.
    pub(crate) pairs: Range<usize>,
    /// Whether there may be other pairs than are known.
    pub(crate) is_outdated: bool,
    pub(crate) known: PairStore,
    pub(super) scratch: NarrowScratch,
    /// Its pairs that matter to local steps, and the revision of those.
    local: Vec<u32>,
    of_local: u64,
    pub(super) compound_scratch: CompoundScratch,
    pub(super) round_scratch: RoundScratch,
    pub(super) level_scratch: LevelScratch,
    /// Its pairs that touch: index within the part, and where.
    pub(super) touching: Vec<[u32; 2]>,
    /// Where the points of these go: from 0 on until those of the parts before are counted.
    pub(crate) points: Range<u32>,
}

impl PairRun {
    /// A part without pairs, to which those from this name on will belong.
    pub(crate) fn starting_at(least: PairName) -> Self {
        Self {
            least,
            ..Self::default()
        }
    }

    /// Number of its pairs that touch.
    pub(crate) fn touching(&self) -> usize {
        self.touching.len()
    }

    /// Tests the pairs that must be, and counts those that touch.
    pub(crate) fn test(&mut self, scene: &Scene, pairs: &[Pair]) {
        if std::mem::take(&mut self.is_outdated) {
            self.known.follow(pairs, &scene.bodies.ids);
            self.of_local = 0;
        }
        self.points = 0..0;
        let count = if scene.bodies.local.is_on {
            self.test_local(scene, pairs)
        } else {
            self.test_all(scene, pairs)
        };
        self.touching.truncate(count);
    }

    /// Tests those of all pairs that must be; the number of touches.
    fn test_all(&mut self, scene: &Scene, pairs: &[Pair]) -> usize {
        // Whether a pair touches cannot be guessed, so each is listed, and those that do not are written over.
        self.touching.resize(pairs.len() + 1, [0; 2]);
        let mut count = 0;
        for (first, pairs) in (0..).step_by(PAIR_RUN).zip(pairs.chunks(PAIR_RUN)) {
            let unsure = self.find_unsure(scene, pairs, first);
            for at in bits(unsure) {
                self.renew(scene, pairs[at], first + at);
            }
            for (index, &pair) in (first..).zip(pairs) {
                if scene.bodies.needs_look(pair) {
                    count = self.list(index, count);
                }
            }
        }
        count
    }

    /// Tests the pairs that matter to the local steps that are being taken; the number of touches.
    fn test_local(&mut self, scene: &Scene, pairs: &[Pair]) -> usize {
        self.find_local(scene.bodies, pairs);
        self.touching.resize(self.local.len() + 1, [0; 2]);
        let mut count = 0;
        for at in 0..self.local.len() {
            let index = self.local[at] as usize;
            let (pair, term) = (pairs[index], &self.known.terms[index]);
            let paces = scene.paces(pair);
            let margin = scene.margin(paces, paces[0].ahead + paces[1].ahead);
            if !scene.is_known(pair, term) || term.is_wider_than(scene.widest(margin)) {
                self.renew(scene, pair, index);
            }
            count = self.list(index, count);
        }
        count
    }

    /// Lists the pairs that matter to the local steps that are being taken, unless they are the same as before.
    fn find_local(&mut self, bodies: &Bodies, pairs: &[Pair]) {
        if self.of_local != bodies.local.revision {
            self.of_local = bodies.local.revision;
            let indexed = (0..).zip(pairs);
            let matter = indexed.filter(|&(_, &pair)| bodies.needs_local_look([pair.a, pair.b]));
            self.local.clear();
            self.local.extend(matter.map(|(index, _)| index));
        }
    }

    /// Lists a pair after the `count` ones that touch, if it touches; the number of them then.
    #[inline]
    fn list(&mut self, index: usize, count: usize) -> usize {
        let term = &self.known.terms[index];
        self.touching[count] = [index as u32, term.touch];
        let mut count = count + usize::from(term.points > 0);
        self.points.end += term.points;
        if self.known.touches.has_chains() {
            count += self.list_rest(index, count);
        }
        count
    }

    /// Which of a run of pairs, of which `first` is the first, need a closer look: a bit each. What that reads lies anywhere, and
    /// is asked for.
    fn find_unsure(&self, scene: &Scene, pairs: &[Pair], first: usize) -> u64 {
        let mut unsure = 0;
        for (at, (&pair, term)) in pairs.iter().zip(&self.known.terms[first..]).enumerate() {
            if scene.is_known(pair, term) || !scene.bodies.needs_look(pair) {
                continue;
            }
            unsure |= 1 << at;
            self.known.prefetch(term);
            scene.pair(pair).into_iter().for_each(prefetch);
        }
        unsure
    }

    /// Looks closer at a pair, and tests it if that does not help.
    fn renew(&mut self, scene: &Scene, pair: Pair, index: usize) {
        let bodies = scene.bodies;
        if bodies.any_compound && self.renew_compound(scene, pair, index)
            || bodies.any_level && self.renew_on_level(scene, pair, index)
            || bodies.any_round && self.renew_round(scene, pair, index)
        {
            return;
        }
        let mut view = self.known.view(index, scene.pair(pair), scene.paces(pair));
        let margin = scene.margin_of(&view);
        let Recycle::Unknown(axis) = view.verdict(margin, scene.fall, scene.widest(margin)) else {
            return;
        };
        let reach = reach_of_test(view.paces, margin);
        let b_in_a = relative_pose(bodies, pair.a, pair.b);
        if let Some(axis) = axis
            && let Some(distance) = distance_of(bodies, pair, &b_in_a, axis)
            && distance > reach
        {
            view.set_apart(axis, distance);
            return;
        }
        let slots = [pair.a as usize, pair.b as usize];
        let centers = slots.map(|i| bodies.mass[i].center);
        let hint = view.hint(&b_in_a, centers);
        match examine_pair(bodies, pair, b_in_a, reach, hint, &mut self.scratch) {
            SatResult::Separated { axis, distance } => view.set_apart(axis, distance),
            SatResult::Touching(patch) => {
                let bind = |patch: &LocalManifold, turn| touch_of(bodies, pair, patch, turn);
                let touch = bind(&patch, b_in_a.rotation);
                let beside = self.scratch.beside.as_ref();
                let beside = beside.map(|beside| bind(beside, b_in_a.rotation));
                view.state.faces = self.scratch.best_faces;
                if view.needs_cast(&touch.patch, scene.fall)
                    && !bodies.are_bonded(pair.a, pair.b)
                    && let Some(cast) = scene.cast(pair, b_in_a, reach)
                {
                    match cast.outcome(&patch, &mut self.scratch) {
                        CastResult::AsFound => set_near(&mut view, touch, beside, reach),
                        CastResult::Touches(patch, pose) => {
                            view.set_passing(Some(bind(&patch, pose.rotation)));
                        }
                        CastResult::Misses => view.set_passing(None),
                    }
                } else {
                    set_near(&mut view, touch, beside, reach);
                }
            }
        }
    }

    /// Writes the manifolds of the pairs that touch.
    pub(crate) fn write_manifolds(
        &self,
        scene: &Scene,
        pairs: &[Pair],
        mut writer: ManifoldWriter<'_>,
    ) {
        let touches = &self.known.touches;
        for (k, &[at, touch]) in self.touching.iter().enumerate() {
            if let Some(&[next, touch]) = self.touching.get(k + PAIRS_AHEAD) {
                prefetch(touches.at(touch));
                for body in scene.pair(pairs[next as usize]) {
                    prefetch(&body.place);
                }
            }
            let (pair, touch) = (pairs[at as usize], touches.at(touch));
            let Some((head, points)) = writer.next(touch.patch.count) else {
                return;
            };
            let [a, b] = scene.pair(pair);
            *head = ManifoldHead {
                a: pair.a,
                b: pair.b,
                normal: touch.patch.write(&a.place, &b.place, points),
                friction: touch.friction,
                restitution: touch.restitution,
                count: touch.patch.count,
            };
        }
    }
}

/// Notes where a pair of hulls touches, with all points up to `reach` (m), and with what bears besides.
fn set_near(view: &mut PairView, touch: Touch, beside: Option<Touch>, reach: f32) {
    match beside {
        Some(beside) => view.set_near_all([touch, beside].into_iter(), reach, true),
        None => view.set_near(touch, reach),
    }
}

/// A patch of a pair, found while B was turned so in A's frame, with the materials.
pub(super) fn touch_of(bodies: &Bodies, pair: Pair, patch: &LocalManifold, turn: Quat) -> Touch {
    let slots = [pair.a as usize, pair.b as usize];
    let [a, b] = [pair.a, pair.b].map(|slot| bodies.info(slot));
    let centers = slots.map(|i| bodies.mass[i].center);
    let boxes = slots.map(|i| bodies.kd_box[i]);
    let [a, b] = match patch.slot {
        None => [a.surface(), b.surface()],
        Some(slot) => [a, b].map(|body| body.surface_of(slot)),
    };
    Touch {
        patch: BodyManifold::new(patch, turn, centers, boxes),
        friction: a.friction.combined(&b.friction),
        restitution: a.restitution.combined(&b.restitution),
    }
}

/// Numbers of the bits that are set.
fn bits(mut set: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lowest = (set != 0).then(|| set.trailing_zeros() as usize);
        set &= set.wrapping_sub(1);
        lowest
    })
}

/// Distance of two hulls along a unit vector from A to B (A's frame), m; `None` if one is a half-space, which is tested
/// as fast.
fn distance_of(bodies: &Bodies, pair: Pair, b_in_a: &Pose, axis: Vec3) -> Option<f32> {
    let [a, b] = [pair.a, pair.b].map(|slot| bodies.convex(slot));
    Some(distance_along(a?.hull(), b?.hull(), b_in_a, axis))
}

/// Contact of one pair of hulls and half-spaces in A's frame, normal from A to B; what bears besides is in `scratch.beside`.
pub(in crate::collide) fn examine_pair(
    bodies: &Bodies,
    pair: Pair,
    b_in_a: Pose,
    reach: f32,
    hint: SatCache,
    scratch: &mut NarrowScratch,
) -> SatResult {
    match (&bodies.info(pair.a).shape, &bodies.info(pair.b).shape) {
        (Shape::Convex(a), Shape::Convex(b)) => {
            examine_hulls(a.hull(), b.hull(), b_in_a, reach, hint, scratch)
        }
        (Shape::Convex(a), Shape::HalfSpace(b)) => {
            let plane = Plane::through(b_in_a.position, rotate(b_in_a.rotation, b.normal));
            examine_half_space(a.hull(), plane, b_in_a, reach, scratch)
        }
        (Shape::HalfSpace(a), Shape::Convex(b)) => {
            let a_in_b = relative_pose(bodies, pair.b, pair.a);
            let plane = Plane::through(a_in_b.position, rotate(a_in_b.rotation, a.normal));
            match examine_half_space(b.hull(), plane, a_in_b, reach, scratch) {
                SatResult::Touching(patch) => {
                    scratch.beside = scratch.beside.map(|beside| beside.swapped(&a_in_b));
                    SatResult::Touching(patch.swapped(&a_in_b))
                }
                SatResult::Separated { distance, .. } => SatResult::Separated {
                    axis: a.normal,
                    distance,
                },
            }
        }
        // Levels are tested by triangle, and two half-spaces never are.
        _ => SatResult::Touching(LocalManifold::default()),
    }
}
