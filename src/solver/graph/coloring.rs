//! Manifolds in blocks by color: those of one color share no body, so that their order does not matter.
//!
//! A block takes as many rows as its largest manifold has points. So the manifolds of a color are put into blocks by number
//! of points, the largest first: a pile, whose manifolds have one point or two as often as four, fills its lanes.

use crate::contact::point::MAX_POINTS;
use crate::simd::lanes::WIDTH;
use crate::solver::graph::indices::LaneSlot;
use crate::solver::graph::ordered_packing::Packer;

/// Colors, as bits of a mask; a manifold that finds none free gets a block of its own, behind all others.
const COLORS: usize = 31;

/// A manifold that is to be placed.
#[derive(Clone, Copy, Debug)]
struct Colored {
    /// Its color; that behind the last one if none was free.
    color: u8,
    /// Number of its points.
    points: u8,
}

/// Colors manifolds and places them; buffers are reused.
#[derive(Debug, Default)]
pub struct Coloring {
    /// By body: the colors of its manifolds.
    taken: Vec<u32>,
    manifolds: Vec<Colored>,
    /// By block: points of its largest manifold.
    points: Vec<u16>,
}

impl Packer for Coloring {
    fn begin(&mut self, bodies: usize) {
        self.taken.clear();
        self.taken.resize(bodies, 0);
        self.manifolds.clear();
        self.points.clear();
    }

    fn add(&mut self, bodies: [Option<u32>; 2], count: u32) {
        let bodies = || bodies.into_iter().flatten().map(|body| body as usize);
        let taken = bodies().fold(0, |taken, body| taken | self.taken[body]);
        let color = (!taken).trailing_zeros() as usize;
        if color < COLORS {
            for body in bodies() {
                self.taken[body] |= 1 << color;
            }
        }
        self.manifolds.push(Colored {
            color: color.min(COLORS) as u8,
            points: count as u8,
        });
    }

    fn place(&mut self) -> impl Iterator<Item = LaneSlot> {
        let mut next = first_lanes(&self.manifolds);
        let Self {
            manifolds, points, ..
        } = self;
        manifolds.drain(..).map(
            move |Colored {
                      color,
                      points: count,
                  }| {
                let next = &mut next[usize::from(color)][usize::from(count)];
                let (block, lane) = (*next / WIDTH, *next % WIDTH);
                let is_alone = usize::from(color) == COLORS;
                *next += if is_alone { WIDTH } else { 1 };
                if points.len() <= block {
                    points.resize(block + 1, 0);
                }
                points[block] = points[block].max(u16::from(count));
                LaneSlot {
                    block: block as u32,
                    lane: lane as u16,
                    count: u16::from(count),
                }
            },
        )
    }

    fn points_of_blocks(&self) -> &[u16] {
        &self.points
    }
}

/// By color and number of points: the first of all lanes that such a manifold gets.
fn first_lanes(manifolds: &[Colored]) -> [[usize; MAX_POINTS + 1]; COLORS + 1] {
    let mut lanes = [[0; MAX_POINTS + 1]; COLORS + 1];
    for manifold in manifolds {
        lanes[usize::from(manifold.color)][usize::from(manifold.points)] += 1;
    }
    let mut end = 0_usize;
    for (color, counts) in lanes.iter_mut().enumerate() {
        end = end.next_multiple_of(WIDTH);
        let size = if color == COLORS { WIDTH } else { 1 };
        for count in counts.iter_mut().rev() {
            let first = end;
            end += size * std::mem::replace(count, first);
        }
    }
    lanes
}
