//! Lists cut along the subdomains of a batch, for a team of threads.

use crate::solver::graph::partition::Partition;
use crate::solver::wide::block::points_of;
use crate::solver::wide::block::{Block, Point};
use crate::threads::parts::front_mut;
use crate::threads::team::Team;
use std::ops::Range;

/// The ranges that a team works on at a time; all of `0..count` at once without one.
pub(crate) fn subdomain_slices(
    ranges: &[Range<usize>],
    count: usize,
    team: Option<&Team>,
) -> impl Iterator<Item = Range<usize>> {
    let whole = team.is_none().then_some(0..count);
    let cut = if team.is_some() { ranges } else { &[] };
    whole.into_iter().chain(cut.iter().cloned())
}

/// Parts of a list by body, one for each leaf.
pub(crate) fn parts_by_body<'a, T>(
    mut list: &'a mut [T],
    cuts: &Partition,
) -> impl Iterator<Item = &'a mut [T]> {
    let subdomain_slices = cuts.slices_of_bodies(list.len());
    subdomain_slices.map(move |share| front_mut(&mut list, share.len()))
}

/// Does `work` on what two lists hold of the bodies of each part, all at once where there are no leaves.
pub(crate) fn each_part<A: Send, B: Send>(
    cuts: &Partition,
    team: Option<&Team>,
    lists: (&mut [A], &mut [B]),
    work: impl Fn(&mut [A], &mut [B]) + Sync,
) {
    let (a, b) = lists;
    if cuts.leaves().is_empty() {
        return work(a, b);
    }
    let parts = parts_by_body(a, cuts).zip(parts_by_body(b, cuts));
    Team::each(team, parts, |(a, b)| work(a, b));
}

/// The blocks that a team works on at a time, with their points.
pub(crate) fn parts_of_blocks<'a>(
    mut blocks: &'a mut [Block],
    mut points: &'a mut [Point],
    subdomains: &'a [Range<usize>],
    team: Option<&Team>,
) -> impl Iterator<Item = (&'a mut [Block], &'a mut [Point])> {
    subdomain_slices(subdomains, blocks.len(), team).map(move |share| {
        let blocks = front_mut(&mut blocks, share.len());
        let points = front_mut(&mut points, points_of(blocks).len());
        (blocks, points)
    })
}
