//! What numbers refer to where manifolds and bodies are within a batch.
//!
//! A body has a slot in [`Bodies`](crate::bodies::store::Bodies) for life, and a [`BodyNumber`] in each island or batch that it is of.
//! A manifold has a [`ManifoldIndex`] in the list of a step, and a [`LaneSlot`] in the batch that solves it.

/// A body within an island or a batch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(transparent)]
pub struct BodyNumber(pub u32);

impl BodyNumber {
    /// As an index into lists by body.
    #[inline(always)]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A manifold within the list of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[repr(transparent)]
pub struct ManifoldIndex(pub u32);

impl ManifoldIndex {
    /// As an index into lists by manifold.
    #[inline(always)]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Where a manifold is within a batch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LaneSlot {
    /// Its block.
    pub block: u32,
    /// Its lane.
    pub lane: u16,
    /// Number of its points.
    pub count: u16,
}
