//! Which manifold goes into which lane of which block; see [`blocks`](super::blocks).

use super::blocks::Place;
use super::lanes::WIDTH;
use std::ops::Range;

/// How manifolds are put into blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum ContactOrder {
    /// Kept where that fills at least half of the lanes, else by colours.
    #[default]
    Automatic,
    /// In their order: a sweep carries support up through a whole stack that was built from the ground.
    Kept,
    /// By colours: those of one colour share no body. Blocks are full and few, and a sweep carries support from a body to its
    /// neighbours only.
    Coloured,
}

/// Colours, as bits of a mask; a manifold that finds none free gets a block of its own, behind all others.
const COLOURS: usize = 31;

/// Colour of those.
const NO_COLOUR: u32 = u32::MAX;

/// How a [`Schedule`] puts manifolds into blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filling {
    /// In their order, each into the first block that it may be in.
    #[default]
    Densely,
    /// By colour: blocks of one colour share no body.
    ByColour,
}

/// Places manifolds; buffers are reused.
#[derive(Debug, Default)]
pub struct Schedule {
    filling: Filling,
    /// By body, in order: the first block behind all that hold it.
    free_from: Vec<u32>,
    /// The first block of the present domain.
    first: u32,
    /// Number of blocks of the domains that are filled.
    ends: Vec<u32>,
    /// By body, coloured: the colours of its manifolds.
    taken: Vec<u32>,
    /// By colour: the block that has a lane left, if any.
    open: Vec<Option<u32>>,
    blocks: Vec<Draft>,
    /// By block: itself if it has a lane left, else a later block, on the way to the first that has.
    next: Vec<u32>,
    /// By block: its number among all blocks in the end.
    rank: Vec<u32>,
}

/// A block that is being filled.
#[derive(Clone, Copy, Debug)]
struct Draft {
    /// Lanes in use.
    used: u16,
    /// Points of its largest manifold.
    points: u16,
    /// Domain, then colour.
    group: (u32, u32),
    /// Its number before all are brought into their order.
    number: u32,
}

impl Schedule {
    /// Forgets the blocks. `bodies` is how many bodies there are.
    pub fn begin(&mut self, bodies: usize, filling: Filling) {
        self.filling = filling;
        self.blocks.clear();
        self.open.clear();
        self.next.clear();
        self.ends.clear();
        self.first = 0;
        if filling == Filling::ByColour {
            self.taken.clear();
            self.taken.resize(bodies, 0);
        } else {
            self.free_from.clear();
            self.free_from.resize(bodies, 0);
        }
    }

    /// Ends a domain: what comes next goes into blocks of its own, behind all others.
    pub fn end_domain(&mut self) {
        self.first = self.blocks.len() as u32;
        self.ends.push(self.first);
        self.open.clear();
        self.taken.fill(0);
    }

    /// Blocks of the domains that have been ended.
    pub fn domains(&self) -> impl Iterator<Item = Range<usize>> {
        let firsts = std::iter::once(&0).chain(&self.ends);
        let ranges = firsts.zip(&self.ends);
        ranges.map(|(first, end)| *first as usize..*end as usize)
    }

    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// The place of the next manifold, with `count` points, which joins these bodies; those that contacts do not move are
    /// `None`. The blocks are not numbered in their order yet, see [`finish`](Self::finish).
    pub fn place(&mut self, bodies: [Option<u32>; 2], count: u32) -> Place {
        let block = match self.filling {
            Filling::Densely => self.place_densely(bodies),
            Filling::ByColour => self.place_by_colour(bodies),
        };
        let draft = &mut self.blocks[block as usize];
        let lane = draft.used;
        draft.used += 1;
        draft.points = draft.points.max(count as u16);
        if usize::from(draft.used) == WIDTH {
            self.close(block);
        }
        Place {
            block,
            lane,
            count: count as u16,
        }
    }

    /// A block has no lane left.
    fn close(&mut self, block: u32) {
        if self.filling == Filling::Densely {
            self.next[block as usize] = block + 1;
        } else if let Some(open) = self
            .open
            .get_mut(self.blocks[block as usize].group.1 as usize)
        {
            *open = None;
        }
    }

    /// Brings the blocks into their order and numbers the places anew.
    pub fn finish<'a>(&mut self, places: impl Iterator<Item = &'a mut Place>) {
        if self.filling == Filling::Densely {
            return;
        }
        self.blocks
            .sort_unstable_by_key(|block| (block.group, block.number));
        self.rank.clear();
        self.rank.resize(self.blocks.len(), 0);
        for (rank, block) in (0..).zip(&self.blocks) {
            self.rank[block.number as usize] = rank;
        }
        for place in places {
            place.block = self.rank[place.block as usize];
        }
    }

    /// Of each block, the points of its largest manifold.
    pub fn points_of_blocks(&self) -> impl ExactSizeIterator<Item = usize> {
        self.blocks.iter().map(|block| usize::from(block.points))
    }

    fn place_densely(&mut self, bodies: [Option<u32>; 2]) -> u32 {
        let block = self.open_from(self.earliest(bodies));
        for body in bodies.into_iter().flatten() {
            self.free_from[body as usize] = block + 1;
        }
        block
    }

    /// The first block of the domain behind those that hold one of the bodies.
    fn earliest(&self, bodies: [Option<u32>; 2]) -> u32 {
        let bodies = bodies.into_iter().flatten();
        let earliest = bodies.map(|body| self.free_from[body as usize]).max();
        earliest.unwrap_or(0).max(self.first)
    }

    /// A block of a colour with a lane left.
    fn open_in(&mut self, colour: u32) -> u32 {
        let i = colour as usize;
        if i >= self.open.len() {
            self.open.resize(i + 1, None);
        }
        let block = self.open[i].unwrap_or_else(|| self.make_block(colour));
        self.open[i] = Some(block);
        block
    }

    /// The first block from `from` on with a lane left; makes it if there is none.
    fn open_from(&mut self, from: u32) -> u32 {
        let mut block = from;
        while let Some(&next) = self.next.get(block as usize) {
            if next == block {
                return block;
            }
            // Halves the way for those who come after.
            let after = self.next.get(next as usize).copied().unwrap_or(next);
            self.next[block as usize] = after;
            block = next;
        }
        self.next.push(block);
        self.make_block(0)
    }

    fn place_by_colour(&mut self, bodies: [Option<u32>; 2]) -> u32 {
        let bodies = || bodies.into_iter().flatten().map(|body| body as usize);
        let taken = bodies().fold(0, |taken, body| taken | self.taken[body]);
        let colour = (!taken).trailing_zeros();
        if colour as usize >= COLOURS {
            return self.make_block(NO_COLOUR);
        }
        for body in bodies() {
            self.taken[body] |= 1 << colour;
        }
        self.open_in(colour)
    }

    fn make_block(&mut self, colour: u32) -> u32 {
        let number = self.blocks.len() as u32;
        self.blocks.push(Draft {
            used: 0,
            points: 0,
            group: (self.ends.len() as u32, colour),
            number,
        });
        number
    }
}
