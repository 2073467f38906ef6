//! Hashes of the scenes; see the head of the test for when they may change, and how.

use crate::course::Hashes;
use crate::scene::Scene;

/// Of each scene, the hash of its last state and that of its course.
#[rustfmt::skip]
pub(crate) const GOLDEN: [(Scene, u64, u64); 20] = [
    (Scene::BreakingPile, 0xd3f3640387cec281, 0x4e5c19c2a232247d),
    (Scene::Pyramid, 0x9dd2214b1005e2ad, 0xca00eeda9ab3da28),
    (Scene::Mixed, 0x6d6affbaf6a05a05, 0xf171b69b25f7e303),
    (Scene::Large, 0xcac0d3da3e03a86c, 0x86ba35cfc74eeb5f),
    (Scene::LargeBreaking, 0x9353a8bef9a21fc3, 0x2a5964d1c15798c1),
    (Scene::Sleep, 0x6066439205823df5, 0x37637cc0814b40fa),
    (Scene::BondedWall, 0x9d761d0146dce084, 0x9a6e43ed71efc953),
    (Scene::BrickWall, 0xdab722317fc77ca8, 0x8736b4669a0e9a46),
    (Scene::Paper, 0xea3e4c963b09b0a4, 0x6e0ccd76c7bc4325),
    (Scene::PaperSquare, 0x92b0ce04ce0eb332, 0x9c7794fbd0f13e6e),
    (Scene::Exact, 0x2bb3c9b4fc5e8d0e, 0x96ba6157e4e93486),
    (Scene::TowerKept, 0x6fe9f2468c8be9e1, 0x337bc8d173b9be00),
    (Scene::TowerColored, 0x91ff68705e7cb25a, 0x8a8d483a6a3befae),
    (Scene::TowerAutomatic, 0x91ff68705e7cb25a, 0x8a8d483a6a3befae),
    (Scene::HeapColored, 0x12827bff324ceca3, 0xb07c530b6ceab647),
    (Scene::HeapKept, 0x9ebfab6d533cd77e, 0x5caa400dbd5e5a60),
    (Scene::ColdStart, 0x2fe790697694a357, 0x1d2f340733905b7b),
    (Scene::Blows, 0xb4fda9da28adb7c8, 0xfd0b2bf9cda3dd4e),
    (Scene::Spinning, 0xf13923e1cf7854d9, 0xef1e9d263dc3d822),
    (Scene::Carried, 0xe02b3efd1c27d38a, 0x3951f0857714cce3),
];

/// Prints the lines of the constant anew.
pub(crate) fn print(hashes: &[(Scene, Hashes)]) {
    for (scene, Hashes { state, course }) in hashes {
        println!("    (Scene::{scene:?}, 0x{state:016x}, 0x{course:016x}),");
    }
}
