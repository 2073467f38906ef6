//! What is kept of pairs that touch.

use crate::contact::body_manifold::{BodyManifold, BodyPlace};

/// Of a pair that does not touch.
pub(crate) const NO_TOUCH: u32 = u32::MAX;

/// Where the last test of a pair found that it touches, and what manifolds are written from: four cache lines. Most pairs of a
/// heap do not touch, and have none.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
pub(crate) struct Touch {
    pub(crate) patch: BodyManifold,
    pub(crate) friction: f32,
    pub(crate) restitution: f32,
}

const _: () = assert!(size_of::<Touch>() == 4 * 64);

/// A list whose elements stay where they are.
#[derive(Clone, Debug, Default)]
pub(crate) struct Slab<T> {
    pub(crate) list: Vec<T>,
    pub(crate) free: Vec<u32>,
}

impl<T> Slab<T> {
    #[inline]
    pub(crate) fn add(&mut self, value: T) -> u32 {
        if let Some(at) = self.free.pop() {
            self.list[at as usize] = value;
            return at;
        }
        self.list.push(value);
        self.list.len() as u32 - 1
    }

    #[inline]
    pub(crate) fn len(&self) -> usize {
        self.list.len() - self.free.len()
    }
}

/// The touches of a run of pairs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Touches {
    pub(crate) slab: Slab<Touch>,
    /// How many have come since they were sorted.
    pub(crate) unsorted: usize,
    /// By place: where the next touch of the same pair is. Empty where no pair has two.
    next: Vec<u32>,
}

impl Touches {
    /// Where the pair touches, if it does.
    #[inline]
    pub(crate) fn of(&self, touch: u32) -> Option<&Touch> {
        self.slab.list.get(touch as usize)
    }

    /// The touch at a place that a term tells.
    #[inline]
    pub(crate) fn at(&self, touch: u32) -> &Touch {
        &self.slab.list[touch as usize]
    }

    /// The least gap of the touches of a pair whose bodies are in these places, m; negative where they overlap, infinite without a touch.
    pub(crate) fn gap(&self, first: u32, [a, b]: &[BodyPlace; 2]) -> f32 {
        let (mut at, mut least) = (first, f32::INFINITY);
        while let Some(touch) = self.of(at) {
            least = least.min(touch.patch.gap(a, b));
            at = self.after(at);
        }
        least
    }

    /// Notes where the pair touches.
    #[inline]
    pub(crate) fn set(&mut self, at: &mut u32, touch: Touch) {
        if *at != NO_TOUCH {
            let mut rest = self.unlink(*at);
            self.end(&mut rest);
            self.slab.list[*at as usize] = touch;
        } else {
            *at = self.slab.add(touch);
            self.unsorted += 1;
        }
    }

    /// Notes that the pair does not touch.
    #[inline]
    pub(crate) fn end(&mut self, at: &mut u32) {
        while *at != NO_TOUCH {
            self.slab.free.push(*at);
            *at = self.unlink(*at);
        }
    }

    /// Whether any pair may have more than one touch.
    #[inline]
    pub(crate) fn has_chains(&self) -> bool {
        !self.next.is_empty()
    }

    /// The next touch of the same pair.
    #[inline]
    pub(crate) fn after(&self, at: u32) -> u32 {
        self.next.get(at as usize).copied().unwrap_or(NO_TOUCH)
    }

    /// Parts a touch from the next one of the same pair, and tells where that is.
    #[inline]
    fn unlink(&mut self, at: u32) -> u32 {
        let next = self.next.get_mut(at as usize);
        next.map_or(NO_TOUCH, |next| std::mem::replace(next, NO_TOUCH))
    }

    /// Notes that the pair touches at several places, in this order.
    pub(crate) fn set_all(
        &mut self,
        at: &mut u32,
        touches: impl DoubleEndedIterator<Item = Touch>,
    ) {
        self.end(at);
        for touch in touches.rev() {
            let place = self.slab.add(touch);
            self.unsorted += 1;
            if *at != NO_TOUCH {
                let needed = self.next.len().max(place as usize + 1);
                self.next.resize(needed, NO_TOUCH);
                self.next[place as usize] = *at;
            }
            *at = place;
        }
    }

    /// Puts the touches of pairs, of which these are the first ones, into the order of the pairs. `spare`: a list of any content.
    pub(crate) fn sort<'t>(
        &mut self,
        spare: &mut Vec<Touch>,
        firsts: impl Iterator<Item = &'t mut u32>,
    ) {
        spare.clear();
        let mut links = Vec::new();
        for first in firsts.filter(|first| **first != NO_TOUCH) {
            let mut at = std::mem::replace(first, spare.len() as u32);
            loop {
                spare.push(*self.at(at));
                at = self.after(at);
                if at == NO_TOUCH {
                    break;
                }
                links.resize(spare.len(), NO_TOUCH);
                links[spare.len() - 1] = spare.len() as u32;
            }
        }
        std::mem::swap(&mut self.slab.list, spare);
        self.slab.free.clear();
        self.next = links;
        self.unsorted = 0;
    }

    /// How many there are.
    #[inline]
    pub(crate) fn len(&self) -> usize {
        self.slab.len()
    }
}
