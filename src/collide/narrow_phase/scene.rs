//! What all pairs are tested within: the bodies as the step found them, and how far each pair may go in it.

use crate::bodies::store::Bodies;
use crate::collide::proxies::CONTACT_MARGIN;
use crate::contact::narrow::cast::Cast;
use crate::contact::narrow::course::Course;
use crate::contact::pairs::broad_phase::Pair;
use crate::contact::pairs::recycle::{
    MotionBound, PairBody, PairView, RecycleTest, haste, smaller_extent,
};
use crate::math::Pose;

/// Overlap along an axis, as a share of the smaller body's least extent, up to which the bodies count as getting past each other
/// there: some times the sag of a soft contact.
pub(super) const OVERLAP: f32 = 3e-4;

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
    pub(super) fn is_known(&self, pair: Pair, term: &RecycleTest) -> bool {
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
    pub(super) fn cast(&self, pair: Pair, b_in_a: Pose, reach: f32) -> Option<Cast<'_>> {
        let [a, b] = [pair.a, pair.b].map(|slot| self.bodies.convex(slot));
        let extent = smaller_extent(self.paces(pair));
        Some(Cast {
            hulls: [a?.hull(), b?.hull()],
            course: self.course(pair, b_in_a),
            tolerance: OVERLAP * extent,
            reach,
            margin: CONTACT_MARGIN * extent + self.fall,
        })
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
