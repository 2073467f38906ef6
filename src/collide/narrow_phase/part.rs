//! A run of pairs: which of them are tested, and what manifolds they make.

use crate::bodies::body::Shape;
use crate::bodies::store::Bodies;
use crate::collide::narrow_phase::relative_pose;
use crate::collide::proxies::CONTACT_MARGIN;
use crate::contact::body_manifold::BodyManifold;
use crate::contact::local_manifold::LocalManifold;
use crate::contact::manifolds::{ManifoldHead, ManifoldWriter};
use crate::contact::narrow::cast::{Cast, CastResult};
use crate::contact::narrow::course::Course;
use crate::contact::narrow::flush::CompoundScratch;
use crate::contact::narrow::half_space::examine_half_space;
use crate::contact::narrow::level_scratch::LevelScratch;
use crate::contact::narrow::round::patch::RoundScratch;
use crate::contact::narrow::sat::{distance_along, examine_hulls};
use crate::contact::narrow::scratch::{NarrowScratch, SatCache, SatResult};
use crate::contact::pairs::broad_phase::Pair;
use crate::contact::pairs::broad_phase::PairName;
use crate::contact::pairs::recycle::{
    MotionBound, PairBody, PairView, Recycle, RecycleTest, haste, reach_of_test, smaller_extent,
};
use crate::contact::pairs::store::PairStore;
use crate::contact::pairs::touches::Touch;
use crate::math::{Plane, Pose, rotate};
use crate::simd::prefetch::prefetch;
use crate::tuning::{PAIR_RUN, PAIRS_AHEAD};
use glam::{Quat, Vec3};
use std::ops::Range;

/// Overlap along an axis, as a share of the least extent of the larger body that contacts move, up to which bodies count as getting past
/// each other there: some times the sag of a soft contact, by which neighbors in a floor stand higher or lower.
const OVERLAP: f32 = 3e-4;

/// The same of the smaller body at most: what stands higher is an obstacle.
const OBSTACLE: f32 = 5e-3;

/// Bodies that move together meet if one of them is stopped within the step. They have a contact then if the gap between them is
/// less than this share of the smaller one's least extent.
const STOPPED: f32 = 0.1;

/// How many times as far as it must be a contact may have been looked for that is kept for a local step: a look costs a test, and each
/// point that is too far away to matter costs in all sweeps.
const WIDE: f32 = 3.0;

/// What all parts read.
pub(crate) struct Scene<'s> {
    pub(crate) bodies: &'s Bodies,
    pub(crate) seen: &'s [PairBody],
    pub(crate) paces: &'s [MotionBound],
    pub(crate) fall: f32,
}

impl Scene<'_> {
    pub(crate) fn pair(&self, pair: Pair) -> [&PairBody; 2] {
        [&self.seen[pair.a as usize], &self.seen[pair.b as usize]]
    }

    pub(super) fn paces(&self, pair: Pair) -> [&MotionBound; 2] {
        [&self.paces[pair.a as usize], &self.paces[pair.b as usize]]
    }

    /// Up to which gap the contacts of a pair may have been looked for that are kept, if those up to `margin` (m) matter.
    #[inline]
    pub(super) fn widest(&self, margin: f32) -> f32 {
        match self.bodies.local.is_on {
            true => WIDE * margin,
            false => f32::INFINITY,
        }
    }

    /// Whether what is known of a pair surely holds in this step: the quick look.
    #[inline]
    fn is_known(&self, pair: Pair, term: &RecycleTest) -> bool {
        let paces = self.paces(pair);
        let margin = self.margin(paces, paces[0].ahead + paces[1].ahead);
        term.surely_holds(paces, margin) && PairView::is_quiet(term, paces)
    }

    /// How a pair moves within the step, from this pose on.
    pub(super) fn course(&self, pair: Pair, b_in_a: Pose) -> Course {
        let [now_a, now_b] = self.pair(pair);
        let from_world = now_a.place.turn.transpose();
        Course {
            b_in_a,
            centers: [pair.a, pair.b].map(|slot| self.bodies.mass[slot as usize].center),
            travel: from_world * (now_b.travel - now_a.travel),
            spins: [now_a, now_b].map(|body| from_world * body.spin),
            radii: [now_a, now_b].map(|body| body.radius),
            end: haste([now_a, now_b], self.fall),
        }
    }

    /// How a pair of hulls moves within the step, from which they touch with this pose if they are nearer than `reach` (m).
    fn cast(&self, pair: Pair, b_in_a: Pose, reach: f32) -> Option<Cast<'_>> {
        let [a, b] = [pair.a, pair.b].map(|slot| self.bodies.convex(slot));
        let extent = smaller_extent(self.paces(pair));
        Some(Cast {
            hulls: [a?.hull(), b?.hull()],
            course: self.course(pair, b_in_a),
            tolerance: self.passable(pair),
            reach,
            margin: CONTACT_MARGIN * extent + self.fall,
        })
    }

    /// Overlap along an axis up to which the bodies of a pair count as getting past each other there, m.
    pub(super) fn passable(&self, pair: Pair) -> f32 {
        let extent = smaller_extent(self.paces(pair));
        let moved = [pair.a, pair.b].map(|slot| {
            let is_moved = self.bodies.velocity[slot as usize].inverse_mass > 0.0;
            f32::from(u8::from(is_moved)) * self.paces[slot as usize].min_extent
        });
        let sag = OVERLAP * moved[0].max(moved[1]);
        sag.clamp(OVERLAP * extent, OBSTACLE * extent)
    }

    /// Up to which gap the bodies of a pair may touch within the step by how they move, m.
    pub(super) fn margin_of(&self, view: &PairView) -> f32 {
        let [a, b] = view.bodies;
        let fastest = a.travel.length().max(b.travel.length());
        let stopped = fastest.min(STOPPED * smaller_extent(view.paces));
        let approach = (b.travel - a.travel).length().max(stopped);
        self.margin(view.paces, approach + a.turning + b.turning)
    }

    /// Bodies farther apart than this, m, cannot touch within the step, if they approach by no more than `approach`.
    pub(super) fn margin(&self, paces: [&MotionBound; 2], approach: f32) -> f32 {
        CONTACT_MARGIN * smaller_extent(paces) + self.fall + approach
    }
}

/// A run of pairs that follow each other.
#[derive(Debug, Default)]
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
                view.state.faces = self.scratch.best_faces;
                if view.needs_cast(&touch.patch, scene.fall)
                    && !bodies.are_bonded(pair.a, pair.b)
                    && let Some(cast) = scene.cast(pair, b_in_a, reach)
                {
                    match cast.outcome(&patch, &mut self.scratch) {
                        CastResult::AsFound => view.set_near(touch, reach),
                        CastResult::Touches(patch, pose) => {
                            view.set_passing(Some(bind(&patch, pose.rotation)));
                        }
                        CastResult::Misses => view.set_passing(None),
                    }
                } else {
                    view.set_near(touch, reach);
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

/// Contact of one pair of hulls and half-spaces in A's frame, normal from A to B.
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
                SatResult::Touching(patch) => SatResult::Touching(patch.swapped(&a_in_b)),
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
