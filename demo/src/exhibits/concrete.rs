//! A wall of concrete around a grid of bars: what a ball goes through falls, and the bars are left standing in the hole.

use super::{Stage, recipes};
use bevy::prelude::*;
use bevy_cleave::prelude::*;

/// Of the wall, m.
const SIZE: Vec3 = Vec3::new(1.8, 1.35, 0.1);
/// From bar to bar, m.
const SPACING: f32 = 0.45;
/// kg/m3.
const DENSITY: f32 = 2400.0;

pub(super) fn put_up(stage: &mut Stage, at: Vec3) -> Result {
    let (wall, bars) = recipes::concrete(SIZE, SPACING)?;
    let at = at + 0.5 * SIZE.y * Vec3::Y;
    // It stands on its foot, and is not hung up on the bars.
    let foot = Anchors::none().and_behind(Vec3::Y, 0.02 - 0.5 * SIZE.y);
    let look = stage.looks.concrete.clone();
    stage.stand((wall.compound()?, Density(DENSITY), foot), at, &look);
    let look = stage.looks.rebar.clone();
    for bar in bars {
        stage.stand(bar.shape, at + bar.pose.position, &look);
    }
    Ok(())
}
