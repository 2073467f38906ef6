//! Hashes of the scenes; see the head of the test for when they may change, and how.

use crate::course::Hashes;
use crate::scene::Scene;

/// Of each scene, the hash of its last state and that of its course.
#[rustfmt::skip]
pub(crate) const GOLDEN: [(Scene, u64, u64); 20] = [
    (Scene::BreakingPile, 0xe2729812e2155aea, 0xec7a407ac6264583),
    (Scene::Pyramid, 0x9dd2214b1005e2ad, 0xca00eeda9ab3da28),
    (Scene::Mixed, 0x729e547c83da21d7, 0x605d3b0a2387c2b4),
    (Scene::Large, 0x42fedf1008174832, 0x24a5249ee0483e51),
    (Scene::LargeBreaking, 0xb3218e20aee16ad7, 0xfec9b8c02f79babb),
    (Scene::Sleep, 0xc72ec7fa267724c6, 0x0ebf5690d8de50d8),
    (Scene::BondedWall, 0x4d2254850fce9686, 0xaeda340d342183bf),
    (Scene::BrickWall, 0x5aaa392856822b43, 0x1f66f39dda951ab8),
    (Scene::Paper, 0x0f6f6479bb66d961, 0x95de03203dff4e59),
    (Scene::PaperSquare, 0xbec2174850a36d13, 0x3eb7503ea79ecf85),
    (Scene::Exact, 0x2bb3c9b4fc5e8d0e, 0x96ba6157e4e93486),
    (Scene::TowerKept, 0x6fe9f2468c8be9e1, 0x337bc8d173b9be00),
    (Scene::TowerColored, 0x91ff68705e7cb25a, 0x8a8d483a6a3befae),
    (Scene::TowerAutomatic, 0x91ff68705e7cb25a, 0x8a8d483a6a3befae),
    (Scene::HeapColored, 0x0ba8306c59d1bf76, 0xf0791d3911461325),
    (Scene::HeapKept, 0xbe358d93b6aa151c, 0x742b7110348cb319),
    (Scene::ColdStart, 0xa21d64307394f630, 0x6ff9280910a194bb),
    (Scene::Blows, 0x6bf311a7e3165d3c, 0xe11775f4cacbfb34),
    (Scene::Spinning, 0xf13923e1cf7854d9, 0xef1e9d263dc3d822),
    (Scene::Carried, 0x65c7d5f583ed84f9, 0xe2113c4960ec4054),
];

/// Prints the lines of the constant anew.
pub(crate) fn print(hashes: &[(Scene, Hashes)]) {
    for (scene, Hashes { state, course }) in hashes {
        println!("    (Scene::{scene:?}, 0x{state:016x}, 0x{course:016x}),");
    }
}
