//! Bodies that wait to be looked at closer, the nearest ball first: most of them then need not be.

use smallvec::SmallVec;

/// Most bodies that wait; what comes then is looked at at once.
const MOST: usize = 48;

/// Bodies by how near they may be.
#[derive(Debug, Default)]
pub(crate) struct Waiting(SmallVec<[(f32, u32); MOST]>);

impl Waiting {
    pub(crate) fn has_room(&self) -> bool {
        self.0.len() < MOST
    }

    /// Adds the body in a slot, whose surface is not nearer than `least`, m.
    pub(crate) fn add(&mut self, least: f32, slot: u32) {
        self.0.push((least, slot));
    }

    /// All of them, the one that may be nearest first.
    pub(crate) fn nearest_first(&mut self) -> &[(f32, u32)] {
        let order = |a: &(f32, u32), b: &(f32, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        self.0.sort_unstable_by(order);
        &self.0
    }
}
