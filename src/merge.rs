//! Two sorted lists, walked side by side: what of one belongs to what of the other, without search or hashing.
//!
//! All that lives from step to step is sorted by pairs of body ids, and is brought in line with the pairs of the present step
//! like this.

use std::cmp::Ordering;
use std::iter::Peekable;

/// What comes next in the order of both lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Merged<L, R> {
    /// Only in the left list.
    Left(L),
    /// Only in the right list.
    Right(R),
    /// In both.
    Both(L, R),
}

impl<L, R> Merged<L, R> {
    /// What each list has.
    #[inline(always)]
    pub(crate) fn into_options(self) -> (Option<L>, Option<R>) {
        match self {
            Self::Left(left) => (Some(left), None),
            Self::Right(right) => (None, Some(right)),
            Self::Both(left, right) => (Some(left), Some(right)),
        }
    }
}

/// Elements of two lists in their common order; see [`merge`].
pub(crate) struct Merge<L: Iterator, R: Iterator, C> {
    left: Peekable<L>,
    right: Peekable<R>,
    order: C,
}

/// Merges two lists, each of which ascends in `order`.
#[inline(always)]
pub(crate) fn merge<L, R, C>(
    left: impl IntoIterator<IntoIter = L>,
    right: impl IntoIterator<IntoIter = R>,
    order: C,
) -> Merge<L, R, C>
where
    L: Iterator,
    R: Iterator,
    C: Fn(&L::Item, &R::Item) -> Ordering,
{
    Merge {
        left: left.into_iter().peekable(),
        right: right.into_iter().peekable(),
        order,
    }
}

impl<L, R, C> Iterator for Merge<L, R, C>
where
    L: Iterator,
    R: Iterator,
    C: Fn(&L::Item, &R::Item) -> Ordering,
{
    type Item = Merged<L::Item, R::Item>;

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        // Where one list is at its end, the other needs no look ahead.
        let Some(right) = self.right.peek() else {
            return self.left.next().map(Merged::Left);
        };
        let Some(left) = self.left.peek() else {
            return self.right.next().map(Merged::Right);
        };
        match (self.order)(left, right) {
            Ordering::Less => self.left.next().map(Merged::Left),
            Ordering::Greater => self.right.next().map(Merged::Right),
            Ordering::Equal => self.left.next().zip(self.right.next()).map(both),
        }
    }
}

#[inline(always)]
fn both<L, R>((left, right): (L, R)) -> Merged<L, R> {
    Merged::Both(left, right)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_of_lists_is_merged_in_order() {
        let list = |bits: u32| (0..6).filter(move |bit| bits >> bit & 1 == 1);
        for (left, right) in (0..64).flat_map(|left| (0..64).map(move |right| (left, right))) {
            let merged: Vec<_> = merge(list(left), list(right), Ord::cmp).collect();
            let expected: Vec<_> = list(left | right)
                .map(|n: u32| match (left >> n & 1, right >> n & 1) {
                    (1, 1) => Merged::Both(n, n),
                    (1, _) => Merged::Left(n),
                    _ => Merged::Right(n),
                })
                .collect();
            assert_eq!(merged, expected);
        }
    }
}
