//! The charts of the library's examples.

#![allow(dead_code, reason = "the examples use the rest")]
#![allow(
    unreachable_pub,
    reason = "the files are shared with the examples, where it is the rule"
)]

#[path = "../../../../examples/support/chart.rs"]
pub(super) mod chart;
#[path = "../../../../examples/support/picture.rs"]
pub(super) mod picture;
#[path = "../../../../examples/support/plot.rs"]
pub(super) mod plot;

type Error = crate::Error;
