//! Hashes of the scenes; see the head of the test for when they may change, and how.

use crate::course::Hashes;
use crate::scene::Scene;

/// Of each scene, the hash of its last state and that of its course.
#[rustfmt::skip]
pub(crate) const GOLDEN: [(Scene, u64, u64); 20] = [
    (Scene::BreakingPile, 0x1e2cf088462a853e, 0x1f67463c66a96379),
    (Scene::Pyramid, 0x9dd2214b1005e2ad, 0xca00eeda9ab3da28),
    (Scene::Mixed, 0x11dc14a243c36c75, 0xab25a2099c46ba26),
    (Scene::Large, 0xcb6a65a847ca8413, 0x38820fa4a07d0ebe),
    (Scene::LargeBreaking, 0x838f278e4ea87d86, 0xad9a52a9a3dd5a27),
    (Scene::Sleep, 0xe5499bfc8763b8e9, 0x5d662e9f5c926288),
    (Scene::BondedWall, 0x8d6b4622060304a3, 0x2abdd35236945189),
    (Scene::BrickWall, 0x803358847a0d6b85, 0xc3fce451019d8e06),
    (Scene::Paper, 0xc1440da8ff454ce0, 0x0c4153c421b43d25),
    (Scene::PaperSquare, 0xf40b4add7c076fc5, 0x1e928fa31efe684e),
    (Scene::Exact, 0x2bb3c9b4fc5e8d0e, 0x96ba6157e4e93486),
    (Scene::TowerKept, 0x6fe9f2468c8be9e1, 0x337bc8d173b9be00),
    (Scene::TowerColored, 0x91ff68705e7cb25a, 0x8a8d483a6a3befae),
    (Scene::TowerAutomatic, 0x91ff68705e7cb25a, 0x8a8d483a6a3befae),
    (Scene::HeapColored, 0xce0e91868d0f2b0c, 0xed918cef21bdabaf),
    (Scene::HeapKept, 0xcdb94db96bec636b, 0xd96ee0b4565cfd14),
    (Scene::ColdStart, 0x71d0f48fbcf29726, 0x7b7db1b4757b14a6),
    (Scene::Blows, 0x27709d1a51d249c8, 0xf83d19d82c4e7a89),
    (Scene::Spinning, 0xf13923e1cf7854d9, 0xef1e9d263dc3d822),
    (Scene::Carried, 0xddf6810d7b32b4bc, 0xb8a62bc631760f9f),
];

/// Prints the lines of the constant anew.
pub(crate) fn print(hashes: &[(Scene, Hashes)]) {
    for (scene, Hashes { state, course }) in hashes {
        println!("    (Scene::{scene:?}, 0x{state:016x}, 0x{course:016x}),");
    }
}
