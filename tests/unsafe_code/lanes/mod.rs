//! Lanes, blocks and the schedule that fills them: the same bits for every width, and what a sweep row by row does.

mod arrangement;
mod batches;
mod blocks;
mod islands;
mod operations;
mod schedule;

use bevy_cleave::testing::simd::LaneWidth;

/// All widths; the first one is what the others are held against.
const WIDTHS: [LaneWidth; 3] = [LaneWidth::One, LaneWidth::Four, LaneWidth::Widest];
