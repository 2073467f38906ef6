//! Chains of cuts of a convex hull; prints how many it has made each time that passes a million.
#![no_main]

#[path = "../../tests/it/hull_chain.rs"]
mod hull_chain;

use libfuzzer_sys::fuzz_target;
use std::sync::atomic::{AtomicUsize, Ordering};

static CUTS: AtomicUsize = AtomicUsize::new(0);

const REPORT: usize = 1_000_000;

fuzz_target!(|bytes: &[u8]| {
    let cuts = hull_chain::cut_chain(bytes);
    let before = CUTS.fetch_add(cuts, Ordering::Relaxed);
    if before / REPORT != (before + cuts) / REPORT {
        eprintln!("{} cuts", before + cuts);
    }
});
