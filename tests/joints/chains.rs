//! Chains neither stretch nor lag, whatever hangs on them.

use crate::scene::{H, chain};
use glam::Vec3;

#[test]
fn chains_under_any_load_keep_their_length() {
    for links in [10, 30, 100] {
        for ratio in [1.0, 100.0, 1000.0] {
            let mut chain = chain(links, ratio, Vec3::X, Vec3::ZERO);
            let gap = chain.largest_gap(120, H);
            println!("{links} links, load {ratio}: {gap:e} m");
            let bound = if ratio > 100.0 { 1e-3 } else { 1e-4 };
            assert!(gap < bound, "{links} links, load {ratio}: {gap} m");
        }
    }
}
