//! The problem row by row: what is solved, by whatever method.
//!
//! `mlcp.rs` states it, in the letters of the literature; `contact_rows.rs` has the Jacobian of a contact and its bounds, `soft_step.rs` what
//! softness and position bias are. `pgs.rs` is the sweep, `acceleration.rs` momentum between sweeps, `residual.rs` how far from
//! solved the rows are.
//!
//! Slow and plain: the lanes of `wide` do the same eight at a time, and tests hold them against this. Must not know lanes, blocks,
//! islands or batches. Read `mlcp.rs` first.

pub(crate) mod acceleration;
pub(crate) mod contact_rows;
pub(crate) mod mlcp;
pub(crate) mod pgs;
pub(crate) mod residual;
pub(crate) mod soft_step;
