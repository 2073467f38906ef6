//! What is known of a run of pairs, from step to step: flat lists that pairs point into.
//!
//! What the quick look at a pair reads lies in the order of the pairs. What only a closer look reads, and what manifolds are
//! written from, stays where it is when pairs come and go. Touches are put into the order of the pairs now and then, because
//! all of them are read in each step, and a heap that has fallen together has them in the order in which it touched.

use crate::contact::body_id::BodyId;
use crate::contact::pairs::broad_phase::Pair;
use crate::contact::pairs::broad_phase::PairName;
use crate::contact::pairs::broad_phase::name_of;
use crate::contact::pairs::recycle::{MotionBound, PairBody, PairState, PairView, RecycleTest};
use crate::contact::pairs::touches::NO_TOUCH;
use crate::contact::pairs::touches::Slab;
use crate::contact::pairs::touches::Touch;
use crate::contact::pairs::touches::Touches;
use crate::merge::{Merged, merge};
use crate::simd::prefetch::prefetch;
use crate::tuning::TOUCH_DISORDER;
use smallvec::SmallVec;

/// What is known of a run of pairs.
#[derive(Clone, Debug, Default)]
pub(crate) struct PairStore {
    names: Vec<PairName>,
    pub(crate) terms: Vec<RecycleTest>,
    states: Slab<PairState>,
    pub(crate) touches: Touches,
    new_names: Vec<PairName>,
    new_terms: Vec<RecycleTest>,
}

impl PairStore {
    /// Asks for what a closer look at a pair reads.
    pub(crate) fn prefetch(&self, term: &RecycleTest) {
        prefetch(&self.states.list[term.state as usize]);
        if let Some(touch) = self.touches.of(term.touch) {
            prefetch(touch);
        }
    }

    /// A pair as a test sees it.
    pub(crate) fn view<'v>(
        &'v mut self,
        pair: usize,
        bodies: [&'v PairBody; 2],
        paces: [&'v MotionBound; 2],
    ) -> PairView<'v> {
        let term = &mut self.terms[pair];
        PairView {
            bodies,
            paces,
            state: &mut self.states.list[term.state as usize],
            touches: &mut self.touches,
            term,
        }
    }

    /// Brings it into the order of these pairs. Of new ones nothing is known, and what was known of those that are gone is
    /// forgotten.
    pub(crate) fn follow(&mut self, pairs: &[Pair], ids: &[BodyId]) {
        self.new_names.clear();
        self.new_names
            .extend(pairs.iter().map(|&pair| name_of(pair, ids)));
        if self.new_names == self.names {
            return;
        }
        self.new_terms.clear();
        let (states, touches) = (&mut self.states, &mut self.touches);
        let old = self.names.iter().zip(&mut self.terms);
        for pair in merge(old, &self.new_names, |(old, _), new| old.cmp(new)) {
            match pair {
                Merged::Left((_, gone)) => {
                    states.free.push(gone.state);
                    touches.end(&mut gone.touch);
                }
                Merged::Both((_, term), _) => self.new_terms.push(*term),
                Merged::Right(_) => {
                    let term = RecycleTest::new(states.add(PairState::default()));
                    self.new_terms.push(term);
                }
            }
        }
        std::mem::swap(&mut self.names, &mut self.new_names);
        std::mem::swap(&mut self.terms, &mut self.new_terms);
    }

    /// Puts the touches into the order of the pairs, if many of them have come since they were. `spare`: a list of any content.
    pub(crate) fn sort_touches(&mut self, spare: &mut Vec<Touch>) {
        if self.touches.unsorted * TOUCH_DISORDER <= self.touches.len() {
            return;
        }
        let firsts = self.terms.iter_mut().map(|term| &mut term.touch);
        self.touches.sort(spare, firsts);
    }

    /// The pairs that it knows, in order.
    pub(crate) fn names(&self) -> &[PairName] {
        &self.names
    }

    /// Takes what `from` knows of one of its pairs, which comes behind all that are known here.
    pub(crate) fn take(&mut self, from: &Self, pair: usize) {
        let mut term = from.terms[pair];
        // In the order of the pairs.
        let first = Some(term.touch).filter(|&at| at != NO_TOUCH);
        let chain = std::iter::successors(first, |&at| {
            Some(from.touches.after(at)).filter(|&next| next != NO_TOUCH)
        });
        let touches: SmallVec<[Touch; 4]> = chain.map(|at| *from.touches.at(at)).collect();
        term.touch = NO_TOUCH;
        self.touches.set_all(&mut term.touch, touches.into_iter());
        term.state = self.states.add(from.states.list[term.state as usize]);
        self.names.push(from.names[pair]);
        self.terms.push(term);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_of_pairs_that_are_gone_are_used_again() {
        let ids: Vec<BodyId> = (0..40).map(BodyId).collect();
        let mut known = PairStore::default();
        for round in 0..100_u32 {
            let pairs = (0..40).flat_map(|a| (a + 1..40).map(move |b| Pair { a, b }));
            // A third of all pairs, others in each round.
            let pairs: Vec<Pair> = pairs.filter(|p| (p.a * p.b + round) % 3 == 0).collect();
            known.follow(&pairs, &ids);
            for pair in (0..pairs.len()).filter(|pair| pair % 4 == 0) {
                let PairStore { terms, touches, .. } = &mut known;
                match round % 2 {
                    0 => touches.set(&mut terms[pair].touch, Touch::default()),
                    _ => touches.end(&mut terms[pair].touch),
                }
            }
            let touching = known.terms.iter().filter(|term| term.touch != NO_TOUCH);
            assert_eq!(known.touches.len(), touching.count());
            assert_eq!(known.states.len(), pairs.len());
        }
        assert!(known.states.list.len() <= 40 * 40 / 2);
        assert!(known.touches.slab.list.len() <= 40 * 40 / 2);
    }
}
