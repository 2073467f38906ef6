//! What a step costs: 60 hulls that fall and come to rest, natively and as WebAssembly under node, with the widest lanes that the
//! build has and with none. `web/steps.sh` runs it all.

use bevy_cleave::geometry::primitives;
use bevy_cleave::prelude::*;
use bevy_cleave::testing::simd::LaneWidth;
use bevy_math::{Quat, Vec3};
use bevy_platform::time::Instant;

const BODIES: u32 = 60;
const STEPS: u32 = 240;

/// Runs, of which the fastest counts.
const RUNS: usize = 5;

/// Mean time of a step in ms of the first half, while the bodies fall, and of the second, in a heap.
fn measure(lane_width: LaneWidth) -> Result<[f64; 2], Box<dyn std::error::Error>> {
    let mut simulation = Simulation::default();
    simulation.overrides.lane_width = lane_width;
    let floor = HalfSpaceShape { normal: Vec3::Y };
    simulation.bodies.insert(BodyDesc::floor(floor))?;
    for i in 0..BODIES {
        let hull = match i % 3 {
            0 => primitives::cuboid(0.5, 0.4, 0.6)?,
            1 => primitives::regular_prism(7, 0.3, 0.5)?,
            _ => primitives::icosphere(0.3, 1)?,
        };
        let place = Vec3::new(
            (i % 4) as f32,
            1.0 + 0.8 * (i / 16) as f32,
            (i / 4 % 4) as f32,
        );
        let mut body = BodyDesc::dynamic(ConvexMesh::from_hull(hull), 0.7 * place);
        body.pose.rotation = Quat::from_rotation_z(0.3 * i as f32);
        simulation.bodies.insert(body)?;
    }
    let mut half = || {
        let begun = Instant::now();
        (0..STEPS / 2).for_each(|_| simulation.step(1.0 / 60.0));
        1e3 * begun.elapsed().as_secs_f64() / f64::from(STEPS / 2)
    };
    Ok([half(), half()])
}

/// The measurement in words.
#[cfg_attr(target_arch = "wasm32", wasm_bindgen::prelude::wasm_bindgen)]
pub fn report() -> String {
    let widths = [
        ("widest lanes", LaneWidth::Widest),
        ("no lanes", LaneWidth::One),
    ];
    let mut least = [[f64::INFINITY; 2]; 2];
    // In turns, so that what else runs falls on both alike.
    for _ in 0..RUNS {
        for (least, (_, width)) in least.iter_mut().zip(widths) {
            match measure(width) {
                Ok(times) => *least = [0, 1].map(|half| least[half].min(times[half])),
                Err(error) => return error.to_string(),
            }
        }
    }
    let lines = widths
        .iter()
        .zip(least)
        .map(|((name, _), [falling, heaped])| {
            format!(
                "{BODIES} hulls, {name}: {falling:.2} ms a step falling, {heaped:.2} ms in a heap"
            )
        });
    lines.collect::<Vec<_>>().join("\n")
}

fn main() {
    // A page or node asks for the report by itself.
    #[cfg(not(target_arch = "wasm32"))]
    println!("{}", report());
}
