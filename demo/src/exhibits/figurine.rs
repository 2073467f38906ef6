//! A model of porcelain that falls on a plinth.

use super::{Stage, recipes};
use crate::shapes;
use bevy::prelude::*;
use bevy_cleave::prelude::*;

/// "Spot" by Keenan Crane, CC0.
const SPOT: &str = include_str!("../../../assets/meshes/spot.obj");

/// Of porcelain (2300 kg/m3) with air inside, kg/m3: the mass is that of the whole hull.
const HOLLOW: f32 = 600.0;

pub(super) fn put_up(stage: &mut Stage, at: Vec3) -> Result {
    let plinth = stage.looks.plinth.clone();
    stage.fix(Vec3::new(0.7, 0.36, 0.7), at + 0.18 * Vec3::Y, &plinth)?;
    let shape = shapes::model(SPOT, 0.62).map_err(|error| error.to_string())?;
    // The model looks along -z.
    let place =
        Transform::from_translation(at + 1.35 * Vec3::Y).with_rotation(Quat::from_rotation_y(2.6));
    // It bears being set down, and neither its fall nor a ball.
    let porcelain = Fracturable {
        strength: 120.0,
        min_energy: 60.0,
        pattern: FracturePattern::Voronoi {
            cells: 36,
            focus: 0.7,
        },
        toughness: 40.0,
        max_pieces: 36,
        generations: 1,
        ..recipes::glass()
    };
    let look = stage.looks.porcelain.clone();
    stage.put(shape, place, HOLLOW, porcelain, &look);
    Ok(())
}
