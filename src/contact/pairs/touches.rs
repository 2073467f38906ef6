//! What is kept of pairs that touch.

use crate::contact::body_manifold::BodyManifold;
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
#[derive(Debug, Default)]
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
#[derive(Debug, Default)]
pub(crate) struct Touches {
    pub(crate) slab: Slab<Touch>,
    /// How many have come since they were sorted.
    pub(crate) unsorted: usize,
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

    /// Notes where the pair touches.
    #[inline]
    pub(crate) fn set(&mut self, at: &mut u32, touch: Touch) {
        if let Some(old) = self.slab.list.get_mut(*at as usize) {
            *old = touch;
        } else {
            *at = self.slab.add(touch);
            self.unsorted += 1;
        }
    }

    /// Notes that the pair does not touch.
    #[inline]
    pub(crate) fn end(&mut self, at: &mut u32) {
        if *at != NO_TOUCH {
            self.slab.free.push(*at);
            *at = NO_TOUCH;
        }
    }

    /// How many there are.
    #[inline]
    pub(crate) fn len(&self) -> usize {
        self.slab.len()
    }
}
