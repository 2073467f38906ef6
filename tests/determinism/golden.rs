//! Hashes of the scenes; see the head of the test for when they may change, and how.

use crate::course::Hashes;
use crate::scene::Scene;

/// Of each scene, the hash of its last state and that of its course.
#[rustfmt::skip]
pub(crate) const GOLDEN: [(Scene, u64, u64); 20] = [
    (Scene::BreakingPile, 0x8de658ad234905d2, 0x81b8b29407317c3f),
    (Scene::Pyramid, 0x9dd2214b1005e2ad, 0xca00eeda9ab3da28),
    (Scene::Mixed, 0xb73c08562f4b3369, 0x7547ef3bb29b7b3d),
    (Scene::Large, 0x4dc445200a9fdb0a, 0xe0e002eb85c33dfc),
    (Scene::LargeBreaking, 0xc908ad8da2984032, 0x327967da5c794f3b),
    (Scene::Sleep, 0x3fdc1724dec908b3, 0x3bd47743c2bce94c),
    (Scene::BondedWall, 0x79bc2b0a8632ffca, 0x0b7af76e898f8953),
    (Scene::BrickWall, 0x6bd7eab189b2d9e8, 0x661632f4576888a1),
    (Scene::Paper, 0x4356a100bd717d6c, 0xf8e3ac8e03cf851a),
    (Scene::PaperSquare, 0x7cde7c874130f4de, 0x03aa89af9d2a4baa),
    (Scene::Exact, 0x62b01d52d1156c79, 0xf1679240cea1a771),
    (Scene::TowerKept, 0x6fe9f2468c8be9e1, 0x337bc8d173b9be00),
    (Scene::TowerColored, 0x91ff68705e7cb25a, 0x8a8d483a6a3befae),
    (Scene::TowerAutomatic, 0x91ff68705e7cb25a, 0x8a8d483a6a3befae),
    (Scene::HeapColored, 0x6913ace518e5e376, 0x5f41c8b2c6d0597e),
    (Scene::HeapKept, 0x3005d8654902db25, 0x42186cc188dc6a1e),
    (Scene::ColdStart, 0x3b3283236b01728d, 0xdb1ee0c4ef22b841),
    (Scene::Blows, 0x904dc801a20d7b29, 0x15ee936b941043e0),
    (Scene::Spinning, 0xf13923e1cf7854d9, 0xef1e9d263dc3d822),
    (Scene::Carried, 0x70e76c6ca2f274f6, 0x69a4ab5c9320eccd),
];

/// Prints the lines of the constant anew.
pub(crate) fn print(hashes: &[(Scene, Hashes)]) {
    for (scene, Hashes { state, course }) in hashes {
        println!("    (Scene::{scene:?}, 0x{state:016x}, 0x{course:016x}),");
    }
}
