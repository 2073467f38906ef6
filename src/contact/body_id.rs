//! Names of bodies.

/// Name of a body, given once and never again: later bodies have larger numbers.
///
/// Pairs and cache entries are ordered by it, so results do not depend on where a body is stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BodyId(pub u32);
