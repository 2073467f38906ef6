//! Hashes of the scenes; see the head of the test for when they may change, and how.

use crate::course::Hashes;
use crate::scene::Scene;

/// Of each scene, the hash of its last state and that of its course.
#[rustfmt::skip]
pub(crate) const GOLDEN: [(Scene, u64, u64); 20] = [
    (Scene::BreakingPile, 0x06f15fe07a17a9c0, 0xdcf180e148aa07fb),
    (Scene::Pyramid, 0x9dd2214b1005e2ad, 0xca00eeda9ab3da28),
    (Scene::Mixed, 0x5dcfa9498b9fc6e5, 0x6f66c5ef00d40e29),
    (Scene::Large, 0xae80727cb1c13c48, 0x67f46ed3767245c3),
    (Scene::LargeBreaking, 0xd4b13df4f11981e3, 0x6fd9f8979a4a238d),
    (Scene::Sleep, 0x4143f67c18ba5077, 0xde21768cc3281a22),
    (Scene::BondedWall, 0xb752bb97d752b3f8, 0xd1b99cb5d0f8aa90),
    (Scene::BrickWall, 0x79c91b8b2d91eea8, 0x1584a4a779577c1f),
    (Scene::Paper, 0xc86208fb5fb549af, 0xf9e5aab1e8819736),
    (Scene::PaperSquare, 0xbec2174850a36d13, 0x3eb7503ea79ecf85),
    (Scene::Exact, 0x82d3186ad753c699, 0x0a3ae67e337d656b),
    (Scene::TowerKept, 0x6fe9f2468c8be9e1, 0x337bc8d173b9be00),
    (Scene::TowerColored, 0x91ff68705e7cb25a, 0x8a8d483a6a3befae),
    (Scene::TowerAutomatic, 0x91ff68705e7cb25a, 0x8a8d483a6a3befae),
    (Scene::HeapColored, 0x5687e88f36dc105e, 0x53ec2df930481441),
    (Scene::HeapKept, 0x3f609f5706101ab1, 0x7ec81ed8be9dfb96),
    (Scene::ColdStart, 0x806672dc003df4a5, 0xc7757bafa1f107af),
    (Scene::Blows, 0x7d3f4ea8fc517fd0, 0xe92c1519ccb85931),
    (Scene::Spinning, 0xf13923e1cf7854d9, 0xef1e9d263dc3d822),
    (Scene::Carried, 0x1b6a2645cef34c9c, 0x6d557c75e5d71977),
];

/// Prints the lines of the constant anew.
pub(crate) fn print(hashes: &[(Scene, Hashes)]) {
    for (scene, Hashes { state, course }) in hashes {
        println!("    (Scene::{scene:?}, 0x{state:016x}, 0x{course:016x}),");
    }
}
