//! Lists cut along the domains of a batch, for a team of threads.

use super::blocks::{Block, Point};
use super::domains::Domains;
use crate::parts::front_mut;
use crate::team::{MOST_TASKS, Team};
use smallvec::SmallVec;
use std::ops::Range;

/// Parts of a list, on the stack: as many as a team may do at a time.
pub(super) type Parts<P> = SmallVec<[P; MOST_TASKS]>;

/// The ranges that a team works on at a time; all of `0..count` at once without one.
pub(super) fn shares(
    ranges: &[Range<usize>],
    count: usize,
    team: Option<&Team>,
) -> Parts<Range<usize>> {
    if team.is_some() {
        ranges.iter().cloned().collect()
    } else {
        std::iter::once(0..count).collect()
    }
}

/// Parts of a list by body: the leaves and the rest.
pub(super) fn parts_by_body<'a, T>(
    mut list: &'a mut [T],
    cuts: &Domains,
) -> impl Iterator<Item = &'a mut [T]> {
    let shares = cuts.shares_of_bodies(list.len());
    shares.map(move |share| front_mut(&mut list, share.len()))
}

/// Does `work` on what two lists hold of the bodies of each part, all at once where there are no leaves.
pub(super) fn each_part<A: Send, B: Send>(
    cuts: &Domains,
    team: Option<&Team>,
    lists: (&mut [A], &mut [B]),
    work: impl Fn(&mut [A], &mut [B]) + Sync,
) {
    let (a, b) = lists;
    if cuts.leaves().is_empty() {
        return work(a, b);
    }
    let parts = parts_by_body(a, cuts).zip(parts_by_body(b, cuts));
    Team::each(team, &mut parts.collect::<Parts<_>>(), |(a, b)| work(a, b));
}

/// Where the points of some blocks lie.
pub(super) fn points_of(blocks: &[Block]) -> Range<usize> {
    match (blocks.first(), blocks.last()) {
        (Some(first), Some(last)) => first.points.start..last.points.end,
        _ => 0..0,
    }
}

/// The blocks that a team works on at a time, with their points.
pub(super) fn parts_of_blocks<'a>(
    mut blocks: &'a mut [Block],
    mut points: &'a mut [Point],
    domains: &[Range<usize>],
    team: Option<&Team>,
) -> Parts<(&'a mut [Block], &'a mut [Point])> {
    let shares = shares(domains, blocks.len(), team);
    let parts = shares.iter().map(|share| {
        let blocks = front_mut(&mut blocks, share.len());
        let points = front_mut(&mut points, points_of(blocks).len());
        (blocks, points)
    });
    parts.collect()
}
