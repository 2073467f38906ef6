//! Hashes of the scenes; see the head of the test for when they may change, and how.

use crate::course::Hashes;
use crate::scene::Scene;

/// Of each scene, the hash of its last state and that of its course.
#[rustfmt::skip]
pub(crate) const GOLDEN: [(Scene, u64, u64); 20] = [
    (Scene::BreakingPile, 0x80433de5be8b22b1, 0x77cffad416b179ac),
    (Scene::Pyramid, 0xa569900564a9ce74, 0x463542b4b384f370),
    (Scene::Mixed, 0xd45322d92eae65d7, 0x134aae2752cd5c9b),
    (Scene::Large, 0xf23f28aa2b93550e, 0x4dc6edcb2e93d4c6),
    (Scene::LargeBreaking, 0xf931e16ef291dfc5, 0x853142c348dde8e4),
    (Scene::Sleep, 0xa7a45a49e5057ae6, 0x2db7af1202e2d1e9),
    (Scene::BondedWall, 0x00fdc21c3efec61d, 0x9fe04d651202df2d),
    (Scene::BrickWall, 0x98504bc70568232e, 0xb614b15e9aad754b),
    (Scene::Paper, 0xea3e4c963b09b0a4, 0x6e0ccd76c7bc4325),
    (Scene::PaperSquare, 0x92b0ce04ce0eb332, 0x9c7794fbd0f13e6e),
    (Scene::Exact, 0x2bb3c9b4fc5e8d0e, 0x96ba6157e4e93486),
    (Scene::TowerKept, 0xbfc299b967140d11, 0xedf22ea803834954),
    (Scene::TowerColored, 0xb98aa00e9dd5e5c1, 0x1edc7e812ba9b95f),
    (Scene::TowerAutomatic, 0xb98aa00e9dd5e5c1, 0x1edc7e812ba9b95f),
    (Scene::HeapColored, 0x0de4ffd3d31dacab, 0xa47aea0fd2620a51),
    (Scene::HeapKept, 0x659cd0ccd3e237b3, 0xab9a37f3e8069c10),
    (Scene::ColdStart, 0x2ca87e1aa2d997e6, 0xe8d87a02805577a8),
    (Scene::Blows, 0xc88d3da0c09dffa3, 0x193ec781b8d62e36),
    (Scene::Spinning, 0xf13923e1cf7854d9, 0xef1e9d263dc3d822),
    (Scene::Carried, 0xb56139ebfa0892b7, 0xdf976a71b3c4791e),
];

/// Prints the lines of the constant anew.
pub(crate) fn print(hashes: &[(Scene, Hashes)]) {
    for (scene, Hashes { state, course }) in hashes {
        println!("    (Scene::{scene:?}, 0x{state:016x}, 0x{course:016x}),");
    }
}
