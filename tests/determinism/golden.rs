//! Hashes of the scenes; see the head of the test for when they may change, and how.

use crate::course::Hashes;
use crate::scene::Scene;

/// Of each scene, the hash of its last state and that of its course.
#[rustfmt::skip]
pub(crate) const GOLDEN: [(Scene, u64, u64); 20] = [
    (Scene::BreakingPile, 0x45bbd2d2b20e956c, 0xb423688beaea928f),
    (Scene::Pyramid, 0x9dd2214b1005e2ad, 0xca00eeda9ab3da28),
    (Scene::Mixed, 0x729e547c83da21d7, 0x605d3b0a2387c2b4),
    (Scene::Large, 0x42fedf1008174832, 0x24a5249ee0483e51),
    (Scene::LargeBreaking, 0xd4b13df4f11981e3, 0x6fd9f8979a4a238d),
    (Scene::Sleep, 0xc72ec7fa267724c6, 0x0ebf5690d8de50d8),
    (Scene::BondedWall, 0x5020ca98fb20e995, 0xe2946d591cfa8192),
    (Scene::BrickWall, 0xe202899c852c4e69, 0xb508a0b86396b583),
    (Scene::Paper, 0xc86208fb5fb549af, 0xf9e5aab1e8819736),
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
