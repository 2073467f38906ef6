//! Hashes of the states that the scenes end in; see the head of the test for when they may change, and how.

use crate::scene::Scene;

/// Hash of the last state of each scene.
#[rustfmt::skip]
pub(crate) const GOLDEN: [(Scene, u64); 3] = [
    (Scene::BreakingPile, 0x3861dca9f546408d),
    (Scene::Pyramid, 0x7ca534c397372eb2),
    (Scene::Mixed, 0xd951659fb9a0b1ed),
];

/// Prints the constant anew.
pub(crate) fn print(hashes: &[(Scene, u64)]) {
    println!(
        "pub(crate) const GOLDEN: [(Scene, u64); {}] = [",
        hashes.len()
    );
    for (scene, hash) in hashes {
        println!("    (Scene::{scene:?}, 0x{hash:016x}),");
    }
    println!("];");
}
