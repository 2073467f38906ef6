//! Hashes of the scenes; see the head of the test for when they may change, and how.

use crate::course::Hashes;
use crate::scene::Scene;

/// Of each scene, the hash of its last state and that of its course.
#[rustfmt::skip]
pub(crate) const GOLDEN: [(Scene, u64, u64); 20] = [
    (Scene::BreakingPile, 0x460797a0313d57ee, 0xeecbd1df683245b1),
    (Scene::Pyramid, 0x9dd2214b1005e2ad, 0xca00eeda9ab3da28),
    (Scene::Mixed, 0xb88cc45cfd983cbb, 0xa898081f2ed7c2fe),
    (Scene::Large, 0xb35138fddee9b745, 0x763e4d316b57367f),
    (Scene::LargeBreaking, 0x0160f91c7380774a, 0x6ab1086078bea161),
    (Scene::Sleep, 0xbd47933a040eeda0, 0x1838a99f439ede9f),
    (Scene::BondedWall, 0xf34806ef3dbe4a93, 0x473a2bf76c11570d),
    (Scene::BrickWall, 0x14b151bccb63e7a1, 0xa3a3ba51fb346dab),
    (Scene::Paper, 0xe63d10651f1e95c2, 0xeeca3127578ea7c1),
    (Scene::PaperSquare, 0x9c83fc850511c32d, 0x2e2931fd9f48c68e),
    (Scene::Exact, 0x2bb3c9b4fc5e8d0e, 0x96ba6157e4e93486),
    (Scene::TowerKept, 0x6fe9f2468c8be9e1, 0x337bc8d173b9be00),
    (Scene::TowerColored, 0x91ff68705e7cb25a, 0x8a8d483a6a3befae),
    (Scene::TowerAutomatic, 0x91ff68705e7cb25a, 0x8a8d483a6a3befae),
    (Scene::HeapColored, 0x318d7fbc599bd7cc, 0xc7adc2ce8ddc0831),
    (Scene::HeapKept, 0x8132315c1754b1b6, 0xf38ffe675a658661),
    (Scene::ColdStart, 0x3facd7e23c85d39c, 0x12d5e5639dddcfa3),
    (Scene::Blows, 0xd19ab51adfcfa534, 0xb0e4b3c9c24e4aee),
    (Scene::Spinning, 0xf13923e1cf7854d9, 0xef1e9d263dc3d822),
    (Scene::Carried, 0x011245960547c01d, 0x9188567eb0a89ea4),
];

/// Prints the lines of the constant anew.
pub(crate) fn print(hashes: &[(Scene, Hashes)]) {
    for (scene, Hashes { state, course }) in hashes {
        println!("    (Scene::{scene:?}, 0x{state:016x}, 0x{course:016x}),");
    }
}
