//! Which manifold goes into which lane of which block; see [`blocks`](super::blocks).

use super::blocks::Place;
use super::lanes::WIDTH;

/// Places manifolds in order; buffers are reused.
#[derive(Debug, Default)]
pub struct Schedule {
    /// By body: the first block behind all that hold it.
    free_from: Vec<u32>,
    /// By block: lanes in use.
    used: Vec<u16>,
    /// By block: points of its largest manifold.
    points: Vec<u32>,
    /// By block: itself if it has a lane left, else a later block, on the way to the first that has.
    next: Vec<u32>,
}

impl Schedule {
    /// Forgets the blocks. `bodies` is how many bodies there are.
    pub fn begin(&mut self, bodies: usize) {
        self.free_from.clear();
        self.free_from.resize(bodies, 0);
        self.used.clear();
        self.points.clear();
        self.next.clear();
    }

    /// Of each block, the points of its largest manifold.
    pub fn points_of_blocks(&self) -> impl ExactSizeIterator<Item = usize> {
        self.points.iter().map(|&count| count as usize)
    }

    /// The place of the next manifold, with `count` points, which joins these bodies; those that contacts do not move are
    /// `None`.
    pub fn place(&mut self, bodies: [Option<u32>; 2], count: u32) -> Place {
        let bodies = || bodies.into_iter().flatten().map(|body| body as usize);
        let earliest = bodies().map(|body| self.free_from[body]).max();
        let block = self.open(earliest.unwrap_or(0));
        let i = block as usize;
        let lane = self.used[i];
        self.used[i] += 1;
        if self.used[i] as usize == WIDTH {
            self.next[i] = block + 1;
        }
        for body in bodies() {
            self.free_from[body] = block + 1;
        }
        self.points[i] = self.points[i].max(count);
        Place {
            block,
            lane,
            count: count as u16,
        }
    }

    /// The first block from `from` on with a lane left; makes it if there is none.
    fn open(&mut self, from: u32) -> u32 {
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
        self.used.push(0);
        self.points.push(0);
        self.next.push(block);
        block
    }
}
