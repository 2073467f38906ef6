//! Work on lists, split into parts for the threads of a team.
//!
//! How a list is split depends on the scene only, never on who does which part, and what parts find is put together in
//! their order: any number of threads gives the same bits.

/// Takes the first `count` elements off a list.
pub(crate) fn front<'l, T>(list: &mut &'l [T], count: usize) -> &'l [T] {
    let (front, rest) = list.split_at(count);
    *list = rest;
    front
}

/// Takes the first `count` elements off a list that is written.
pub(crate) fn front_mut<'l, T>(list: &mut &'l mut [T], count: usize) -> &'l mut [T] {
    let (front, rest) = std::mem::take(list).split_at_mut(count);
    *list = rest;
    front
}

/// Splits a list into pieces of the given sizes, from either end.
#[derive(Debug)]
pub(crate) struct SizedParts<'l, T, S> {
    rest: &'l mut [T],
    sizes: S,
}

impl<'l, T, S> SizedParts<'l, T, S> {
    /// Pieces of `list`; `sizes` add up to its length.
    pub(crate) fn new(list: &'l mut [T], sizes: S) -> Self {
        Self { rest: list, sizes }
    }
}

impl<'l, T, S: Iterator<Item = usize>> Iterator for SizedParts<'l, T, S> {
    type Item = &'l mut [T];

    fn next(&mut self) -> Option<Self::Item> {
        let size = self.sizes.next()?;
        Some(front_mut(&mut self.rest, size))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        self.sizes.size_hint()
    }
}

impl<T, S: DoubleEndedIterator<Item = usize>> DoubleEndedIterator for SizedParts<'_, T, S> {
    fn next_back(&mut self) -> Option<Self::Item> {
        let size = self.sizes.next_back()?;
        let list = std::mem::take(&mut self.rest);
        let (rest, piece) = list.split_at_mut(list.len() - size);
        self.rest = rest;
        Some(piece)
    }
}

impl<T, S: ExactSizeIterator<Item = usize>> ExactSizeIterator for SizedParts<'_, T, S> {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_from_both_ends_are_those_from_the_front() {
        let sizes = [3, 0, 2, 1, 4];
        let mut list: Vec<u32> = (0..10).collect();
        let mut front = list.clone();
        let expected: Vec<_> = SizedParts::new(&mut front, sizes.into_iter()).collect();
        for ends in 0..1 << sizes.len() {
            let mut pieces = SizedParts::new(&mut list, sizes.into_iter());
            let (mut first, mut last) = (Vec::new(), Vec::new());
            for turn in 0..sizes.len() {
                assert_eq!(pieces.len(), sizes.len() - turn);
                if ends >> turn & 1 == 0 {
                    first.extend(pieces.next());
                } else {
                    last.extend(pieces.next_back());
                }
            }
            assert!(pieces.next().is_none() && pieces.next_back().is_none());
            last.reverse();
            first.append(&mut last);
            assert_eq!(first, expected);
        }
    }
}
