//! What local steps keep from one to the next.

use crate::contact::impulses::ContactCache;
use crate::contact::manifolds::Manifolds;

/// Buffers of local steps, and what they have found.
#[derive(Debug, Default)]
pub(crate) struct LocalBuffers {
    /// Multipliers of the islands that take the present local steps.
    pub(super) cache: ContactCache,
    pub(super) members: Vec<u32>,
    /// Manifolds of all who waited until now, with the impulses of the whole step; sorted by body ids.
    pub(super) whole: Manifolds,
    /// Of the present group: those of the local steps until now, with the sums of their impulses.
    pub(super) sums: Manifolds,
    pub(super) joined: Manifolds,
}
