//! What waits while a tree is walked: a stack, or a heap whose first entry is the nearest.

use smallvec::SmallVec;

/// A child that waits to be looked at, behind its distance or the square of it: one number, so that the order of numbers is that of
/// distances.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Waiting(u64);

/// Deeper trees take memory.
pub(super) type Stack = SmallVec<[Waiting; 96]>;

impl Waiting {
    /// The root.
    pub(super) const ROOT: Self = Self(0);
    /// After all others.
    pub(super) const LAST: Self = Self(u64::MAX);

    /// Of a distance that is not negative, -0 apart.
    #[inline(always)]
    pub(super) fn new(distance: f32, child: u32) -> Self {
        Self(u64::from(distance.abs().to_bits()) << 32 | u64::from(child))
    }

    #[inline(always)]
    pub(super) fn distance(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }

    #[inline(always)]
    pub(super) fn child(self) -> u32 {
        self.0 as u32
    }
}

/// Adds to a binary heap whose first entry is the least.
#[inline]
pub(super) fn push_heap(heap: &mut Stack, entry: Waiting) {
    let mut at = heap.len();
    heap.push(entry);
    while at > 0 && entry < heap[(at - 1) / 2] {
        heap[at] = heap[(at - 1) / 2];
        at = (at - 1) / 2;
    }
    heap[at] = entry;
}

/// Takes the least entry of such a heap.
#[inline]
pub(super) fn pop_nearest(heap: &mut Stack) -> Option<Waiting> {
    let last = heap.pop()?;
    let Some(&nearest) = heap.first() else {
        return Some(last);
    };
    let (mut at, entries) = (0, &mut heap[..]);
    while 2 * at + 1 < entries.len() {
        let [left, right] = [2 * at + 1, (2 * at + 2).min(entries.len() - 1)];
        let least = if entries[right] < entries[left] {
            right
        } else {
            left
        };
        if last <= entries[least] {
            break;
        }
        entries[at] = entries[least];
        at = least;
    }
    entries[at] = last;
    Some(nearest)
}
