//! What is done to eight contacts at a time, one in each lane.
//!
//! | file | does |
//! |---|---|
//! | `block.rs` | `Block` and `Point`: what the sweeps read and write |
//! | `prepare.rs` | from manifolds to lanes; effective masses |
//! | `bias.rs` | target velocities from gaps and overlaps; warm start |
//! | `sweep.rs` | the inner loops: one impulse after the other, friction and normal |
//! | `body_pair.rs` | two bodies in each lane: gather, push, scatter; friction projected onto its bound |
//! | `bond.rs` | bounds of impulses, and bonds as rows |
//! | `reanchor.rs` | contact points that follow the motion of their bodies |
//! | `extrapolate.rs` | momentum between sweeps |
//! | `pass.rs`, `contacts.rs` | which of these is done, and over what |
//! | `point_rows.rs` | a point of a lane as rows, for residuals and the exact method |
//!
//! Must not know islands, batches, or who does which part. Read `block.rs` first, then `sweep.rs`; each says which rows of `rows` it does.

pub(crate) mod bias;
pub(crate) mod block;
pub(crate) mod body_pair;
pub(crate) mod bond;
pub(crate) mod contacts;
pub(crate) mod extrapolate;
pub(crate) mod pass;
pub(crate) mod point_rows;
pub(crate) mod prepare;
pub(crate) mod reanchor;
pub(crate) mod sweep;
