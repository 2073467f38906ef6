//! Hashes of the scenes; see the head of the test for when they may change, and how.

use crate::course::Hashes;
use crate::scene::Scene;

/// Of each scene, the hash of its last state and that of its course.
#[rustfmt::skip]
pub(crate) const GOLDEN: [(Scene, u64, u64); 20] = [
    (Scene::BreakingPile, 0xb77afb13d1e78973, 0x66430da9b11a6b2a),
    (Scene::Pyramid, 0x59308d494a227402, 0x465d8d04fe9b1f2e),
    (Scene::Mixed, 0x2191d033b5eef63a, 0x03288fd8af99d20b),
    (Scene::Large, 0x966423e71bc5231c, 0x0977c470bccf45b5),
    (Scene::LargeBreaking, 0x37e902a4f7e4ebd9, 0x879508297b6ea522),
    (Scene::Sleep, 0x2a3b6b1098d3c56f, 0x4303a51423c07b3d),
    (Scene::BondedWall, 0xf13e4f03e91b2c03, 0xa86ae9c295a7c29c),
    (Scene::BrickWall, 0x54779d79f35609b7, 0xcd37511d1052acc6),
    (Scene::Paper, 0xea3e4c963b09b0a4, 0x6e0ccd76c7bc4325),
    (Scene::PaperSquare, 0x92b0ce04ce0eb332, 0x9c7794fbd0f13e6e),
    (Scene::Exact, 0x2bb3c9b4fc5e8d0e, 0x96ba6157e4e93486),
    (Scene::TowerKept, 0xcd260e3d321919f7, 0x4b5dc85e5766d72b),
    (Scene::TowerColored, 0xe14f19463c902fff, 0x7193fd069592e4fa),
    (Scene::TowerAutomatic, 0xe14f19463c902fff, 0x7193fd069592e4fa),
    (Scene::HeapColored, 0x20ee5ea976072a94, 0xe4d2e9589792625f),
    (Scene::HeapKept, 0xb750743a92d580af, 0x1398abc58b7c7b46),
    (Scene::ColdStart, 0x2fe790697694a357, 0x1d2f340733905b7b),
    (Scene::Blows, 0x9b60ca7d17f22eb1, 0xef2f613c6b4c7d89),
    (Scene::Spinning, 0xf13923e1cf7854d9, 0xef1e9d263dc3d822),
    (Scene::Carried, 0xe02b3efd1c27d38a, 0x3951f0857714cce3),
];

/// Prints the lines of the constant anew.
pub(crate) fn print(hashes: &[(Scene, Hashes)]) {
    for (scene, Hashes { state, course }) in hashes {
        println!("    (Scene::{scene:?}, 0x{state:016x}, 0x{course:016x}),");
    }
}
