//! A pane in a frame: held at its rim, it breaks where it is hit, and shards stay in the frame.

use super::{Stage, recipes};
use crate::look::Tinted;
use crate::shapes;
use bevy::prelude::*;
use bevy_cleave::prelude::*;

/// Of the pane, m.
const SIZE: Vec3 = Vec3::new(1.2, 1.0, 0.012);
/// Width and depth of the frame's bars, m.
const BAR: Vec2 = Vec2::new(0.07, 0.09);
/// Height of the lower bar above the floor, m.
const SILL: f32 = 0.22;
/// What holds the pane in the frame, Pa: enough for shards at the rim, too little for what is hit.
const PUTTY: f32 = 4.0e5;

pub(super) fn put_up(stage: &mut Stage, at: Vec3) -> Result {
    let look = stage.looks.frame.clone();
    let center = at + (SILL + BAR.x + 0.5 * SIZE.y) * Vec3::Y;
    let outer = SIZE.truncate() + 2.0 * BAR.x;
    let mut held = Vec::new();
    for side in [-1.0, 1.0] {
        let rail = Vec3::new(outer.x, BAR.x, BAR.y);
        let rail_at = center + side * 0.5 * (SIZE.y + BAR.x) * Vec3::Y;
        held.push(stage.fix(rail, rail_at, &look)?);
        let stile = Vec3::new(BAR.x, SIZE.y, BAR.y);
        let stile_at = center + side * 0.5 * (SIZE.x + BAR.x) * Vec3::X;
        held.push(stage.fix(stile, stile_at, &look)?);
        let foot = Vec3::new(0.09, SILL, 0.4);
        let foot_at = at + Vec3::new(side * 0.5 * SIZE.x, 0.5 * SILL, 0.0);
        stage.fix(foot, foot_at, &look)?;
    }
    let glass = stage.looks.glass.clone();
    let pane = shapes::block(SIZE, 0.001)?;
    let at = Transform::from_translation(center);
    let pane = stage.put(pane, at, 2500.0, recipes::glass(), &glass);
    stage.commands.entity(pane).insert(Tinted);
    held.push(pane);
    stage.commands.bond_neighbors(held, PUTTY);
    Ok(())
}
