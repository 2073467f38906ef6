//! Hashes of the scenes; see the head of the test for when they may change, and how.

use crate::course::Hashes;
use crate::scene::Scene;

/// Of each scene, the hash of its last state and that of its course.
#[rustfmt::skip]
pub(crate) const GOLDEN: [(Scene, u64, u64); 20] = [
    (Scene::BreakingPile, 0x14ddc75f3f37638f, 0xb3f0c5a4ab518dff),
    (Scene::Pyramid, 0x59308d494a227402, 0x465d8d04fe9b1f2e),
    (Scene::Mixed, 0xb3e32848237aac58, 0x266025619b6d9669),
    (Scene::Large, 0x806b40988d8423a7, 0x1886070cbd802718),
    (Scene::LargeBreaking, 0x4487df582ca69e54, 0xffc7e0e5f6446bb1),
    (Scene::Sleep, 0xd6b692a706b088be, 0xbfcdbf7aa2b18473),
    (Scene::BondedWall, 0xd768f9bd2e6b9b13, 0x0b92c7732ff5a390),
    (Scene::BrickWall, 0x3c4c529e57170dbc, 0xf5b12dac21e944a4),
    (Scene::Paper, 0x692a33e400f964ef, 0x58b415dd02c8bf0b),
    (Scene::PaperSquare, 0x9f59984dd77f876e, 0xf59bbba4d072b964),
    (Scene::Exact, 0x820cafbd31fb1f5c, 0x94db7e5285a7c316),
    (Scene::TowerKept, 0xcd260e3d321919f7, 0x4b5dc85e5766d72b),
    (Scene::TowerColored, 0xe14f19463c902fff, 0x7193fd069592e4fa),
    (Scene::TowerAutomatic, 0xe14f19463c902fff, 0x7193fd069592e4fa),
    (Scene::HeapColored, 0x13da7636742095ef, 0xba5f393257739600),
    (Scene::HeapKept, 0xf1c6d28d7d86335d, 0x32f0f2297cba6438),
    (Scene::ColdStart, 0xe49b11d09fa180d9, 0x794f854129d511d0),
    (Scene::Blows, 0x7dc9319f0e3812d4, 0x36606b5e049a36ff),
    (Scene::Spinning, 0xf13923e1cf7854d9, 0xef1e9d263dc3d822),
    (Scene::Carried, 0x6654e16e662f478b, 0x63b6b2741c531d5a),
];

/// Prints the lines of the constant anew.
pub(crate) fn print(hashes: &[(Scene, Hashes)]) {
    for (scene, Hashes { state, course }) in hashes {
        println!("    (Scene::{scene:?}, 0x{state:016x}, 0x{course:016x}),");
    }
}
