//! What a step costs: 60 hulls that fall and come to rest, natively and, by `web/steps.sh`, as WebAssembly under node.

use bevy::math::{Quat, Vec3};
use bevy::platform::time::Instant;
use bevy_cleave::geometry::primitives;
use bevy_cleave::prelude::*;

const BODIES: u32 = 60;
const STEPS: u32 = 240;

/// Mean time of a step in ms of the first half, while the bodies fall, and of the second, in a heap.
fn measure() -> Result<[f64; 2], Box<dyn std::error::Error>> {
    let mut simulation = Simulation::default();
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
    match measure() {
        Ok([falling, heaped]) => {
            format!("{BODIES} hulls: {falling:.2} ms a step falling, {heaped:.2} ms in a heap")
        }
        Err(error) => error.to_string(),
    }
}

fn main() {
    println!("{}", report());
}
