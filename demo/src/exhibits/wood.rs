//! A beam of laths on two trestles: it splits along the grain, and its laths break across.

use super::{Stage, recipes};
use crate::shapes;
use bevy::prelude::*;
use bevy_cleave::prelude::*;

/// Of a lath, m; the grain along x.
const SIZE: Vec3 = Vec3::new(2.2, 0.04, 0.06);
const LAYERS: u8 = 3;
const ROWS: u8 = 4;
/// Of the trestles, m.
const HEIGHT: f32 = 0.7;
/// Strength across the grain, and in shear along it, Pa.
const GROWN: [f32; 2] = [2.5e6, 7.0e6];

pub(super) fn put_up(stage: &mut Stage, at: Vec3) -> Result {
    let plinth = stage.looks.plinth.clone();
    for side in [-0.95, 0.95] {
        let place = Vec3::new(side, 0.5 * HEIGHT, 0.0);
        stage.fix(Vec3::new(0.12, HEIGHT, 0.5), at + place, &plinth)?;
    }
    let shape = shapes::block(SIZE, 0.004)?;
    let mut laths: Vec<[Entity; ROWS as usize]> = Vec::new();
    for layer in 0..LAYERS {
        laths.push(std::array::from_fn(|row| {
            let number = usize::from(layer) * usize::from(ROWS) + row;
            let look = stage.looks.laths[number * 2 % stage.looks.laths.len()].clone();
            let y = HEIGHT + (f32::from(layer) + 0.5) * SIZE.y;
            let z = (row as f32 - 0.5 * f32::from(ROWS - 1)) * SIZE.z;
            let place = Transform::from_translation(at + Vec3::new(0.0, y, z));
            stage.put(
                shape.clone(),
                place,
                450.0,
                recipes::lath(number as u64),
                &look,
            )
        }));
    }
    for (layer, row) in
        (0..laths.len()).flat_map(|layer| (0..usize::from(ROWS)).map(move |row| (layer, row)))
    {
        let lath: Entity = laths[layer][row];
        if row > 0 {
            stage
                .commands
                .bond(laths[layer][row - 1], lath, grown(SIZE.x * SIZE.y));
        }
        if layer > 0 {
            stage
                .commands
                .bond(laths[layer - 1][row], lath, grown(SIZE.x * SIZE.z));
        }
    }
    Ok(())
}

fn grown(area: f32) -> Bond {
    let [strength, shear_strength] = GROWN;
    Bond {
        strength,
        shear_strength,
        area,
    }
}
