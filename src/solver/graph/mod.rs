//! Who is solved with whom, and in which order.
//!
//! | file | answers |
//! |---|---|
//! | `islands.rs` | which bodies touch each other, directly or through others |
//! | `relative_motion.rs` | which pairs move so far in the step that their rows must follow |
//! | `partition.rs`, `bisection.rs` | into which subdomains a large island is cut, for several threads |
//! | `lane_assignment.rs` | which lane of which block a manifold gets; kept while nothing changes |
//! | `ordered_packing.rs`, `coloring.rs`, `contact_order.rs` | the two ways to fill blocks, and which one |
//! | `indices.rs` | where a manifold is: `LaneSlot` |
//!
//! Answers are integers: must not know impulses or rows. Two bodies that are joined by something else than a
//! manifold would have to be told to `islands.rs` and `lane_assignment.rs`. Read `islands.rs` first.

pub(crate) mod bisection;
pub(crate) mod coloring;
pub(crate) mod contact_order;
pub(crate) mod indices;
pub(crate) mod islands;
pub(crate) mod lane_assignment;
pub(crate) mod ordered_packing;
pub(crate) mod partition;
pub(crate) mod relative_motion;
