//! The manifolds of a step, one after the other in memory: what the points of each share, and all points packed.
//!
//! A step goes through its manifolds some ten times, and in a scene of thousands it waits for memory as it does. Most passes
//! read only who touches whom: 32 bytes a manifold. A point takes a cache line, and a manifold has one to four of them, two in
//! the mean of a heap.

use crate::contact::point::{ContactPoint, MAX_POINTS};
use crate::simd::prefetch::prefetch;
use crate::threads::parts::{SizedParts, front_mut};
use glam::Vec3;
use std::ops::{Deref, DerefMut, Range};

/// What the points where two bodies touch have in common.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(32))]
pub struct ManifoldHead {
    /// Slot of body A (the one with the smaller id).
    pub a: u32,
    /// Slot of body B.
    pub b: u32,
    /// Unit normal from A to B, world axes.
    pub normal: Vec3,
    /// Coefficient of friction of the pair.
    pub friction: f32,
    /// Coefficient of restitution of the pair.
    pub restitution: f32,
    /// Number of points.
    pub count: u32,
}

const _: () = assert!(size_of::<ManifoldHead>() == 32, "two in a cache line");

/// All points where two bodies touch, by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Manifold {
    /// What they have in common.
    pub head: ManifoldHead,
    /// The points; those beyond the head's `count` are meaningless.
    pub points: [ContactPoint; MAX_POINTS],
}

/// All points where two bodies touch, in a list of [`Manifolds`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldRef<'l> {
    head: &'l ManifoldHead,
    points: &'l [ContactPoint],
}

/// The manifolds of a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Manifolds {
    heads: Vec<ManifoldHead>,
    /// By manifold: the index of its first point.
    firsts: Vec<u32>,
    points: Vec<ContactPoint>,
}

impl Manifold {
    /// The valid points.
    pub fn points(&self) -> &[ContactPoint] {
        &self.points[..self.head.count as usize]
    }

    /// The valid points, for writing.
    pub fn points_mut(&mut self) -> &mut [ContactPoint] {
        &mut self.points[..self.head.count as usize]
    }
}

impl Deref for Manifold {
    type Target = ManifoldHead;

    fn deref(&self) -> &ManifoldHead {
        &self.head
    }
}

impl DerefMut for Manifold {
    fn deref_mut(&mut self) -> &mut ManifoldHead {
        &mut self.head
    }
}

impl Deref for ManifoldRef<'_> {
    type Target = ManifoldHead;

    fn deref(&self) -> &ManifoldHead {
        self.head
    }
}

impl<'l> ManifoldRef<'l> {
    /// What its points have in common.
    pub fn head(self) -> &'l ManifoldHead {
        self.head
    }

    /// Its points.
    pub fn points(self) -> &'l [ContactPoint] {
        self.points
    }

    /// A copy that is no part of the list.
    pub fn to_owned(self) -> Manifold {
        let mut manifold = Manifold {
            head: *self.head,
            ..Manifold::default()
        };
        manifold.points_mut().copy_from_slice(self.points);
        manifold
    }
}

impl Manifolds {
    /// Number of manifolds.
    pub fn len(&self) -> usize {
        self.heads.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.heads.is_empty()
    }

    /// Forgets all of them.
    pub fn clear(&mut self) {
        self.heads.clear();
        self.firsts.clear();
        self.points.clear();
    }

    /// Appends a manifold.
    pub fn push(&mut self, manifold: ManifoldRef<'_>) {
        self.heads.push(*manifold.head);
        self.firsts.push(self.points.len() as u32);
        self.points.extend_from_slice(manifold.points);
    }

    /// The manifold with this index, if there are so many.
    pub fn get(&self, index: usize) -> Option<ManifoldRef<'_>> {
        (index < self.len()).then(|| self.at(index))
    }

    /// All manifolds.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = ManifoldRef<'_>> + Clone {
        (0..self.len()).map(|index| self.at(index))
    }

    /// All manifolds, and their points for writing.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = (&ManifoldHead, &mut [ContactPoint])> {
        self.whole().each()
    }

    /// What the points of each manifold have in common.
    pub fn heads(&self) -> &[ManifoldHead] {
        &self.heads
    }

    /// The points of all manifolds, in their order.
    pub fn points(&self) -> &[ContactPoint] {
        &self.points
    }

    /// The same, for writing.
    pub fn points_mut(&mut self) -> &mut [ContactPoint] {
        &mut self.points
    }

    /// The manifold with this index, which there is.
    pub(crate) fn at(&self, index: usize) -> ManifoldRef<'_> {
        ManifoldRef {
            head: &self.heads[index],
            points: &self.points[self.range(index)],
        }
    }

    /// Where the points of a manifold are.
    fn range(&self, index: usize) -> Range<usize> {
        let first = self.firsts[index] as usize;
        first..first + self.heads[index].count as usize
    }

    /// The same, for writing. The number of points stays what it is.
    pub(crate) fn at_mut(&mut self, index: usize) -> (&mut ManifoldHead, &mut [ContactPoint]) {
        let range = self.range(index);
        (&mut self.heads[index], &mut self.points[range])
    }

    /// Asks for a manifold with `count` points to be brought near.
    #[inline(always)]
    pub(crate) fn prefetch(&self, index: usize, count: usize) {
        prefetch(&self.heads[index]);
        let points = &self.points[self.firsts[index] as usize..];
        points.iter().take(count).for_each(prefetch);
    }

    /// Runs of manifolds whose points are written; `ranges` follow one another and cover all of them.
    pub(crate) fn runs<'l, R>(
        &'l mut self,
        ranges: R,
    ) -> impl ExactSizeIterator<Item = Run<'l>> + DoubleEndedIterator + Send
    where
        R: ExactSizeIterator<Item = Range<usize>> + DoubleEndedIterator + Clone + Send + 'l,
    {
        let (heads, firsts, count) = (&self.heads[..], &self.firsts[..], self.points.len());
        let first = move |index: usize| firsts.get(index).map_or(count, |&first| first as usize);
        let sizes = ranges
            .clone()
            .map(move |range| first(range.end) - first(range.start));
        let points = SizedParts::new(&mut self.points, sizes);
        ranges.zip(points).map(|(range, points)| Run {
            heads: &heads[range.clone()],
            firsts: &firsts[range],
            points,
        })
    }

    /// Runs of `size` manifolds each, of which the last may be shorter.
    pub(crate) fn chunks_mut(
        &mut self,
        size: usize,
    ) -> impl ExactSizeIterator<Item = Run<'_>> + DoubleEndedIterator + Send {
        let count = self.len();
        let range = move |part: usize| part * size..count.min((part + 1) * size);
        self.runs((0..count.div_ceil(size)).map(range))
    }

    /// All of them as one run.
    pub(crate) fn whole(&mut self) -> Run<'_> {
        Run {
            heads: &self.heads,
            firsts: &self.firsts,
            points: &mut self.points,
        }
    }

    /// Makes room for parts that follow one another, and a writer for each; `sizes`: number of manifolds and range of the points
    /// of each. What is not written is left from before.
    pub(crate) fn writers<'l, S>(
        &'l mut self,
        sizes: S,
    ) -> impl ExactSizeIterator<Item = ManifoldWriter<'l>> + DoubleEndedIterator + Send
    where
        S: ExactSizeIterator<Item = (usize, Range<u32>)> + DoubleEndedIterator + Clone + Send + 'l,
    {
        let manifolds = sizes.clone().map(|(manifolds, _)| manifolds);
        let points = sizes.clone().map(|(_, points)| points.len());
        self.heads
            .resize(manifolds.clone().sum(), ManifoldHead::default());
        self.firsts.resize(self.heads.len(), 0);
        self.points
            .resize(points.clone().sum(), ContactPoint::default());
        let heads = SizedParts::new(&mut self.heads, manifolds.clone());
        let firsts = SizedParts::new(&mut self.firsts, manifolds);
        let points = SizedParts::new(&mut self.points, points);
        sizes
            .zip(heads.zip(firsts).zip(points))
            .map(|((_, range), ((heads, firsts), points))| ManifoldWriter {
                heads: heads.iter_mut(),
                firsts: firsts.iter_mut(),
                first: range.start,
                points,
            })
    }
}

impl<'l> FromIterator<ManifoldRef<'l>> for Manifolds {
    fn from_iter<I: IntoIterator<Item = ManifoldRef<'l>>>(manifolds: I) -> Self {
        let mut list = Self::default();
        manifolds
            .into_iter()
            .for_each(|manifold| list.push(manifold));
        list
    }
}

impl<'l> FromIterator<&'l Manifold> for Manifolds {
    fn from_iter<I: IntoIterator<Item = &'l Manifold>>(manifolds: I) -> Self {
        let manifolds = manifolds.into_iter().map(|manifold| ManifoldRef {
            head: &manifold.head,
            points: manifold.points(),
        });
        manifolds.collect()
    }
}

/// A run of manifolds whose points are written.
#[derive(Debug)]
pub(crate) struct Run<'l> {
    heads: &'l [ManifoldHead],
    firsts: &'l [u32],
    points: &'l mut [ContactPoint],
}

impl<'l> Run<'l> {
    /// Each manifold with its points.
    pub(crate) fn each(self) -> impl Iterator<Item = (&'l ManifoldHead, &'l mut [ContactPoint])> {
        let mut rest = self.points;
        let with_points = move |head: &'l ManifoldHead| {
            let points = front_mut(&mut rest, head.count as usize);
            (head, points)
        };
        self.heads.iter().map(with_points)
    }

    /// The points of the manifold with this index within the run.
    pub(crate) fn points_of(&mut self, index: usize) -> &mut [ContactPoint] {
        let first = (self.firsts[index] - self.firsts[0]) as usize;
        &mut self.points[first..first + self.heads[index].count as usize]
    }

    /// Number of manifolds.
    pub(crate) fn len(&self) -> usize {
        self.heads.len()
    }
}

/// Writes a part of a list, manifold by manifold.
#[derive(Debug)]
pub(crate) struct ManifoldWriter<'l> {
    heads: std::slice::IterMut<'l, ManifoldHead>,
    firsts: std::slice::IterMut<'l, u32>,
    /// Index in the list of the next point, and what is left of the points.
    first: u32,
    points: &'l mut [ContactPoint],
}

impl<'l> ManifoldWriter<'l> {
    /// The next manifold, which has `count` points.
    pub(crate) fn next(
        &mut self,
        count: u32,
    ) -> Option<(&'l mut ManifoldHead, &'l mut [ContactPoint])> {
        let head = self.heads.next()?;
        *self.firsts.next()? = self.first;
        self.first += count;
        Some((head, front_mut(&mut self.points, count as usize)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Manifolds with these numbers of points, the gap of each point being its number.
    fn numbered(counts: &[u32]) -> Manifolds {
        let mut next = 0.0;
        let manifolds: Vec<Manifold> = counts
            .iter()
            .map(|&count| {
                let head = ManifoldHead {
                    count,
                    ..ManifoldHead::default()
                };
                let mut manifold = Manifold {
                    head,
                    ..Manifold::default()
                };
                for point in manifold.points_mut() {
                    point.separation = next;
                    next += 1.0;
                }
                manifold
            })
            .collect();
        manifolds.iter().collect()
    }

    #[test]
    fn what_is_pushed_is_what_is_there() {
        let list = numbered(&[2, 0, 4, 1]);
        assert_eq!((list.len(), list.points().len()), (4, 7));
        let copies: Vec<Manifold> = list.iter().map(ManifoldRef::to_owned).collect();
        assert_eq!(copies.iter().collect::<Manifolds>(), list);
        assert_eq!(list.iter().collect::<Manifolds>(), list);
        assert!(
            list.get(1)
                .is_some_and(|manifold| manifold.points().is_empty())
        );
        assert!(list.get(4).is_none());
    }

    #[test]
    fn runs_from_either_end_hold_the_points_of_their_manifolds() {
        let counts = [3, 1, 0, 2, 4, 1, 0];
        let ranges = [0..2, 2..3, 3..3, 3..6, 6..7];
        let mut list = numbered(&counts);
        let expected = list.clone();
        for ends in 0..1 << ranges.len() {
            let mut runs = list.runs(ranges.clone().into_iter());
            let mut left = ranges.clone().into_iter();
            for turn in 0..ranges.len() {
                let (run, range) = if ends >> turn & 1 == 0 {
                    (runs.next(), left.next())
                } else {
                    (runs.next_back(), left.next_back())
                };
                let (mut run, range) = (run.expect("one each"), range.expect("one each"));
                assert_eq!(run.len(), range.len());
                for (index, at) in range.clone().enumerate() {
                    assert_eq!(run.points_of(index), expected.at(at).points());
                }
                for ((head, points), at) in run.each().zip(range) {
                    assert_eq!(
                        (head, &*points),
                        (&expected.heads[at], expected.at(at).points())
                    );
                }
            }
        }
    }

    #[test]
    fn writers_make_the_list_whatever_was_there_before() {
        let counts = [[2, 1].as_slice(), &[], &[4, 0, 3]];
        let whole = counts.concat();
        let expected = numbered(&whole);
        for before in [numbered(&[]), numbered(&[4; 9]), numbered(&[1])] {
            let mut list = before;
            let mut first = 0;
            let sizes = counts.map(|counts| {
                let points: u32 = counts.iter().sum();
                first += points;
                (counts.len(), first - points..first)
            });
            let writers = list.writers(sizes.clone().into_iter());
            for (mut writer, (counts, size)) in writers.zip(counts.iter().zip(sizes)).rev() {
                let mut number = size.1.start as f32;
                for &count in *counts {
                    let (head, points) = writer.next(count).expect("there is room");
                    *head = ManifoldHead {
                        count,
                        ..ManifoldHead::default()
                    };
                    for point in points {
                        *point = ContactPoint {
                            separation: number,
                            ..ContactPoint::default()
                        };
                        number += 1.0;
                    }
                }
                assert!(writer.next(0).is_none());
            }
            assert_eq!(list, expected);
        }
    }
}
