//! Hashes of the states that the scenes end in; see the head of the test for when they may change, and how.

use crate::scene::Scene;

/// Hash of the last state of each scene.
#[rustfmt::skip]
pub(crate) const GOLDEN: [(Scene, u64); 3] = [
    (Scene::BreakingPile, 0x9e47dec97cc0af10),
    (Scene::Pyramid, 0x96eb235886f9984c),
    (Scene::Mixed, 0x4792e6c43bc76d91),
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
