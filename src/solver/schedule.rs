//! Which manifold goes into which lane of which block; see [`blocks`](super::blocks).

use super::blocks::Place;
use super::lanes::WIDTH;

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

/// Places manifolds; buffers are reused.
#[derive(Debug, Default)]
pub struct Schedule {
    by_colour: bool,
    /// By body, in order: the first block behind all that hold it.
    free_from: Vec<u32>,
    /// By body, coloured: the colours of its manifolds.
    taken: Vec<u32>,
    /// By colour: the block that has a lane left, if any.
    open: Vec<Option<u32>>,
    /// By block: lanes in use, points of its largest manifold, and what it comes after the smaller of.
    blocks: Vec<Filling>,
    /// By block: itself if it has a lane left, else a later block, on the way to the first that has.
    next: Vec<u32>,
    /// By block: its number among all blocks in the end.
    rank: Vec<u32>,
}

/// A block that is being filled.
#[derive(Clone, Copy, Debug)]
struct Filling {
    used: u16,
    points: u16,
    colour: u16,
}

impl Schedule {
    /// Forgets the blocks. `bodies` is how many bodies there are.
    pub fn begin(&mut self, bodies: usize, by_colour: bool) {
        self.by_colour = by_colour;
        self.blocks.clear();
        if by_colour {
            self.taken.clear();
            self.taken.resize(bodies, 0);
            self.open.clear();
            self.open.resize(COLOURS, None);
        } else {
            self.free_from.clear();
            self.free_from.resize(bodies, 0);
            self.next.clear();
        }
    }

    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// The place of the next manifold, with `count` points, which joins these bodies; those that contacts do not move are
    /// `None`. The blocks are not numbered in their order yet, see [`finish`](Self::finish).
    pub fn place(&mut self, bodies: [Option<u32>; 2], count: u32) -> Place {
        let block = if self.by_colour {
            self.place_by_colour(bodies)
        } else {
            self.place_in_order(bodies)
        };
        let filling = &mut self.blocks[block as usize];
        let lane = filling.used;
        filling.used += 1;
        filling.points = filling.points.max(count as u16);
        if usize::from(filling.used) == WIDTH {
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
        let colour = usize::from(self.blocks[block as usize].colour);
        if !self.by_colour {
            self.next[block as usize] = block + 1;
        } else if let Some(open) = self.open.get_mut(colour) {
            *open = None;
        }
    }

    /// Brings the blocks into their order and numbers the places anew.
    pub fn finish<'a>(&mut self, places: impl Iterator<Item = &'a mut Place>) {
        if !self.by_colour {
            return;
        }
        let mut first = [0_u32; COLOURS + 2];
        for block in &self.blocks {
            first[usize::from(block.colour) + 1] += 1;
        }
        for colour in 0..=COLOURS {
            first[colour + 1] += first[colour];
        }
        self.rank.clear();
        for block in &self.blocks {
            let rank = &mut first[usize::from(block.colour)];
            self.rank.push(*rank);
            *rank += 1;
        }
        for place in places {
            place.block = self.rank[place.block as usize];
        }
        self.blocks.sort_by_key(|block| block.colour);
    }

    /// Of each block, the points of its largest manifold.
    pub fn points_of_blocks(&self) -> impl ExactSizeIterator<Item = usize> {
        self.blocks.iter().map(|block| usize::from(block.points))
    }

    fn place_in_order(&mut self, bodies: [Option<u32>; 2]) -> u32 {
        let bodies = || bodies.into_iter().flatten().map(|body| body as usize);
        let earliest = bodies().map(|body| self.free_from[body]).max();
        let block = self.open_from(earliest.unwrap_or(0));
        for body in bodies() {
            self.free_from[body] = block + 1;
        }
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
        let colour = (!taken).trailing_zeros() as usize;
        if colour >= COLOURS {
            return self.make_block(COLOURS as u16);
        }
        for body in bodies() {
            self.taken[body] |= 1 << colour;
        }
        if let Some(block) = self.open[colour] {
            return block;
        }
        let block = self.make_block(colour as u16);
        self.open[colour] = Some(block);
        block
    }

    fn make_block(&mut self, colour: u16) -> u32 {
        self.blocks.push(Filling {
            used: 0,
            points: 0,
            colour,
        });
        self.blocks.len() as u32 - 1
    }
}
