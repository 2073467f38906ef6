//! Hashes of the scenes; see the head of the test for when they may change, and how.

use crate::course::Hashes;
use crate::scene::Scene;

/// Of each scene, the hash of its last state and that of its course.
#[rustfmt::skip]
pub(crate) const GOLDEN: [(Scene, u64, u64); 20] = [
    (Scene::BreakingPile, 0xfffb02f112380415, 0x56f0f11ba5b2c566),
    (Scene::Pyramid, 0x59308d494a227402, 0x465d8d04fe9b1f2e),
    (Scene::Mixed, 0xb3e32848237aac58, 0x266025619b6d9669),
    (Scene::Large, 0x6e3ddd0d5aa59bd2, 0x43b22e0a20829597),
    (Scene::LargeBreaking, 0xbe9912fd47666358, 0x5bfb7d2250f2e744),
    (Scene::Sleep, 0xd8b86826f12d6038, 0xcc4ad1c242b7fb04),
    (Scene::BondedWall, 0x2f2938371b67084d, 0x1dd15d45ffc8218e),
    (Scene::BrickWall, 0x22fc4ca81201b774, 0xf0203cc03555b795),
    (Scene::Paper, 0x1c2d8f0076886d99, 0x429c7e717f711cc4),
    (Scene::PaperSquare, 0x9f59984dd77f876e, 0xf59bbba4d072b964),
    (Scene::Exact, 0x820cafbd31fb1f5c, 0x94db7e5285a7c316),
    (Scene::TowerKept, 0xcd260e3d321919f7, 0x4b5dc85e5766d72b),
    (Scene::TowerColored, 0xe14f19463c902fff, 0x7193fd069592e4fa),
    (Scene::TowerAutomatic, 0xe14f19463c902fff, 0x7193fd069592e4fa),
    (Scene::HeapColored, 0xb7342ac2f103f116, 0x6be137358d25cc7b),
    (Scene::HeapKept, 0xf1c6d28d7d86335d, 0x32f0f2297cba6438),
    (Scene::ColdStart, 0xe49b11d09fa180d9, 0x794f854129d511d0),
    (Scene::Blows, 0xda65670638ab0c4e, 0x5b0c7e22fb37207e),
    (Scene::Spinning, 0xf13923e1cf7854d9, 0xef1e9d263dc3d822),
    (Scene::Carried, 0x6654e16e662f478b, 0x63b6b2741c531d5a),
];

/// Prints the lines of the constant anew.
pub(crate) fn print(hashes: &[(Scene, Hashes)]) {
    for (scene, Hashes { state, course }) in hashes {
        println!("    (Scene::{scene:?}, 0x{state:016x}, 0x{course:016x}),");
    }
}
