//! Lists cut into parts, for a team of threads.

use super::blocks::{Block, Point};
use super::team::{MOST_PARTS, Team};
use smallvec::SmallVec;
use std::ops::Range;

/// Parts of a list, on the stack.
pub(super) type Parts<P> = SmallVec<[P; MOST_PARTS]>;

/// Takes the first `count` elements off a list.
pub(super) fn front<'a, T>(list: &mut &'a [T], count: usize) -> &'a [T] {
    let (front, rest) = list.split_at(count.min(list.len()));
    *list = rest;
    front
}

/// Takes the first `count` elements off a list that is written, or all if there are fewer.
pub(super) fn front_mut<'a, T>(list: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let count = count.min(list.len());
    let (front, rest) = std::mem::take(list).split_at_mut(count);
    *list = rest;
    front
}

/// Cuts a list of blocks into `count` parts at most: their blocks and their points.
pub(super) fn of_blocks(
    blocks: &[Block],
    count: usize,
) -> impl Iterator<Item = (Range<usize>, Range<usize>)> {
    let size = blocks.len().div_ceil(count).max(1);
    (0..blocks.len()).step_by(size).map(move |first| {
        let end = (first + size).min(blocks.len());
        (
            first..end,
            blocks[first].points.start..blocks[end - 1].points.end,
        )
    })
}

/// Does `work` on parts of the blocks and their points, of `least` blocks or more where there are several.
pub(super) fn for_blocks(
    blocks: &mut [Block],
    points: &mut [Point],
    least: usize,
    team: Option<&Team>,
    work: impl Fn(&mut [Block], &mut [Point]) + Sync,
) {
    let count = Team::parts(team, blocks.len(), least);
    if count == 1 {
        return work(blocks, points);
    }
    let ranges: Parts<_> = of_blocks(blocks, count).collect();
    let (mut blocks, mut points) = (blocks, points);
    let mut parts: Parts<_> = ranges
        .into_iter()
        .map(|(of_blocks, of_points)| {
            (
                front_mut(&mut blocks, of_blocks.len()),
                front_mut(&mut points, of_points.len()),
            )
        })
        .collect();
    Team::each(team, &mut parts, |(blocks, points)| work(blocks, points));
}
