//! Where manifolds and bodies are within a batch.

/// Where a manifold is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LaneSlot {
    /// Its block.
    pub block: u32,
    /// Its lane.
    pub lane: u16,
    /// Number of its points.
    pub count: u16,
}
