//! Feeds the rooms of `contact` with bodies: phases 3 and 4 of a step.
//!
//! `proxies.rs` tells the broad phase of bodies that have left their boxes, which last some steps. `narrow_phase.rs` goes through the
//! pairs, run by run on several threads; `narrow_phase/part.rs` is one run: which of its pairs are recycled, which are tested, and
//! the manifolds of those that touch. `sensors.rs` finds who is inside of whom, without any effect.
//!
//! Must not know what is done with manifolds. Read `narrow_phase/part.rs` first: `PairRun::test` is the whole way of a pair.

pub(crate) mod narrow_phase;
pub(crate) mod proxies;
pub(crate) mod sensors;
