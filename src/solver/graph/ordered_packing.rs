//! Manifolds in blocks in their order: a sweep does what it would do one manifold after the other.
//!
//! Only manifolds that share a body need to keep their order. So blocks are filled one after the other with manifolds all of
//! whose earlier neighbors are in blocks before, as instructions of a program are scheduled; and because a block takes as
//! many rows as its largest manifold has points, with manifolds of as many points as long as eight of them are ready. A
//! pile, half of whose manifolds have one point, fills 97 % of its lanes, where the first free lane behind all neighbors
//! would fill 55 %.

use crate::contact::point::MAX_POINTS;
use crate::simd::lanes::WIDTH;
use crate::solver::graph::indices::LaneSlot;

/// A way to put manifolds into blocks.
pub trait Packer {
    /// Forgets the manifolds and blocks. `bodies` is how many bodies there are.
    fn begin(&mut self, bodies: usize);

    /// Takes the next manifold, with `count` points, which joins these bodies; those that contacts do not move are `None`.
    fn add(&mut self, bodies: [Option<u32>; 2], count: u32);

    /// Places the manifolds that were added; returns their places in the order in which they came.
    fn place(&mut self) -> impl Iterator<Item = LaneSlot>;

    /// Of each block, the points of its largest manifold.
    fn points_of_blocks(&self) -> &[u16];
}

/// No manifold.
const NONE: u32 = u32::MAX;

/// A manifold that is to be placed.
#[derive(Clone, Copy, Debug)]
struct UnplacedManifold {
    /// For each of its bodies the next manifold that joins it.
    next: [u32; 2],
    /// For how many earlier manifolds it waits.
    waits: u8,
    /// Number of its points.
    points: u8,
    place: LaneSlot,
}

/// Places manifolds in their order; buffers are reused.
#[derive(Debug, Default)]
pub struct OrderedPacking {
    /// By body: the last manifold that joins it, times two, plus which of its bodies that is.
    last: Vec<u32>,
    manifolds: Vec<UnplacedManifold>,
    /// By number of points: manifolds that wait for none, as they came to that, and how many of them are placed.
    ready: [Vec<u32>; MAX_POINTS + 1],
    placed: [usize; MAX_POINTS + 1],
    /// By block: points of its largest manifold.
    points: Vec<u16>,
}

impl Packer for OrderedPacking {
    fn begin(&mut self, bodies: usize) {
        self.last.clear();
        self.last.resize(bodies, NONE);
        self.manifolds.clear();
        self.points.clear();
    }

    fn add(&mut self, bodies: [Option<u32>; 2], count: u32) {
        let mut manifold = UnplacedManifold {
            next: [NONE; 2],
            waits: 0,
            points: count as u8,
            place: LaneSlot::default(),
        };
        let index = self.manifolds.len() as u32;
        for (side, body) in bodies.into_iter().enumerate() {
            let Some(body) = body else { continue };
            let last = &mut self.last[body as usize];
            if *last != NONE {
                self.manifolds[(*last / 2) as usize].next[(*last % 2) as usize] = index;
                manifold.waits += 1;
            }
            *last = 2 * index + side as u32;
        }
        self.manifolds.push(manifold);
    }

    fn place(&mut self) -> impl Iterator<Item = LaneSlot> {
        self.ready.iter_mut().for_each(Vec::clear);
        self.placed = [0; MAX_POINTS + 1];
        for (index, manifold) in (0..).zip(&self.manifolds) {
            if manifold.waits == 0 {
                self.ready[usize::from(manifold.points)].push(index);
            }
        }
        while let Some(points) = self.most_ready() {
            self.fill_block(points);
        }
        self.manifolds.drain(..).map(|manifold| manifold.place)
    }

    fn points_of_blocks(&self) -> &[u16] {
        &self.points
    }
}

impl OrderedPacking {
    /// The number of points of which most manifolds are ready or, if of none there are enough for a block, the largest one.
    fn most_ready(&self) -> Option<usize> {
        let ready = |points: usize| self.ready[points].len() - self.placed[points];
        let with_most = (0..=MAX_POINTS).max_by_key(|&points| ready(points))?;
        if ready(with_most) >= WIDTH {
            return Some(with_most);
        }
        (0..=MAX_POINTS).rev().find(|&points| ready(points) > 0)
    }

    /// Fills a block with manifolds that are ready, of `points` points or, when these run out, of fewer.
    fn fill_block(&mut self, points: usize) {
        let block = self.points.len() as u32;
        self.points.push(points as u16);
        let mut taken = [NONE; WIDTH];
        let mut used = 0;
        for count in (0..=points).rev() {
            let ready = &self.ready[count][self.placed[count]..];
            let more = ready.len().min(WIDTH - used);
            taken[used..used + more].copy_from_slice(&ready[..more]);
            self.placed[count] += more;
            used += more;
        }
        for (lane, &index) in taken[..used].iter().enumerate() {
            let manifold = &mut self.manifolds[index as usize];
            manifold.place = LaneSlot {
                block,
                lane: lane as u16,
                count: u16::from(manifold.points),
            };
            for next in manifold.next {
                self.release(next);
            }
        }
    }

    /// A manifold no longer waits for one of those before it.
    fn release(&mut self, index: u32) {
        if index == NONE {
            return;
        }
        let manifold = &mut self.manifolds[index as usize];
        manifold.waits -= 1;
        if manifold.waits == 0 {
            self.ready[usize::from(manifold.points)].push(index);
        }
    }
}
