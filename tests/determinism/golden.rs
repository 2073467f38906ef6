//! Hashes of the scenes; see the head of the test for when they may change, and how.

use crate::course::Hashes;
use crate::scene::Scene;

/// Of each scene, the hash of its last state and that of its course.
#[rustfmt::skip]
pub(crate) const GOLDEN: [(Scene, u64, u64); 20] = [
    (Scene::BreakingPile, 0x25df919ab749bc3f, 0x19389be54248cd33),
    (Scene::Pyramid, 0x59308d494a227402, 0x465d8d04fe9b1f2e),
    (Scene::Mixed, 0xf5cee83e15cb3258, 0x8e975cedd1d40a29),
    (Scene::Large, 0x966423e71bc5231c, 0x0977c470bccf45b5),
    (Scene::LargeBreaking, 0x92652cfa1a1a9e2d, 0x0885b278801a4872),
    (Scene::Sleep, 0x2a3b6b1098d3c56f, 0x4303a51423c07b3d),
    (Scene::BondedWall, 0x27c7687600f2a707, 0xda7d96f8d033f8fa),
    (Scene::BrickWall, 0x639253a1d09bb6c2, 0xb1249d5ab0958411),
    (Scene::Paper, 0x97a4281bc6e6afda, 0xa7e33f4dbc36fb7c),
    (Scene::PaperSquare, 0x92b0ce04ce0eb332, 0x9c7794fbd0f13e6e),
    (Scene::Exact, 0x820cafbd31fb1f5c, 0x94db7e5285a7c316),
    (Scene::TowerKept, 0xcd260e3d321919f7, 0x4b5dc85e5766d72b),
    (Scene::TowerColored, 0xe14f19463c902fff, 0x7193fd069592e4fa),
    (Scene::TowerAutomatic, 0xe14f19463c902fff, 0x7193fd069592e4fa),
    (Scene::HeapColored, 0x20ee5ea976072a94, 0xe4d2e9589792625f),
    (Scene::HeapKept, 0xb750743a92d580af, 0x1398abc58b7c7b46),
    (Scene::ColdStart, 0x2fe790697694a357, 0x1d2f340733905b7b),
    (Scene::Blows, 0xda65670638ab0c4e, 0x546b24fe22a2ee95),
    (Scene::Spinning, 0xf13923e1cf7854d9, 0xef1e9d263dc3d822),
    (Scene::Carried, 0xe02b3efd1c27d38a, 0x3951f0857714cce3),
];

/// Prints the lines of the constant anew.
pub(crate) fn print(hashes: &[(Scene, Hashes)]) {
    for (scene, Hashes { state, course }) in hashes {
        println!("    (Scene::{scene:?}, 0x{state:016x}, 0x{course:016x}),");
    }
}
