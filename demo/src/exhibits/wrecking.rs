//! A ball on a chain that swings into a wall: joints beside bonds.

use super::{Stage, brick};
use bevy::prelude::*;
use bevy_cleave::prelude::*;

/// The middle of the beam, m, and its thickness.
const BEAM: Vec3 = Vec3::new(0.0, 3.0, 0.0);
const BAR: f32 = 0.12;
/// Where the chain hangs, clear of the beam, m.
const HOOK: Vec3 = Vec3::new(0.0, 2.9, 0.0);
/// Of a link, m.
const LENGTH: f32 = 0.22;
const THICKNESS: f32 = 0.025;
const LINKS: u8 = 8;
/// Of the ball, m.
const RADIUS: f32 = 0.17;
/// Of iron, kg/m3.
const DENSITY: f32 = 7800.0;
/// How far it is pulled back towards the camera, rad.
const PULLED: f32 = 1.25;

pub(super) fn put_up(stage: &mut Stage, at: Vec3) -> Result {
    let frame = stage.looks.frame.clone();
    stage.fix(Vec3::new(3.2, BAR, BAR), at + BEAM, &frame)?;
    let height = BEAM.y - 0.5 * BAR;
    for side in [-1.5, 1.5] {
        let post = at + Vec3::new(side, 0.5 * height, 0.0);
        stage.fix(Vec3::new(BAR, height, BAR), post, &frame)?;
    }
    brick::put_up(stage, at)?;

    let turn = Quat::from_rotation_x(-PULLED);
    let along = turn * Vec3::NEG_Y;
    let link = ConvexMesh::capsule(THICKNESS, LENGTH - 2.0 * THICKNESS)?;
    let half = 0.5 * LENGTH * Vec3::Y;
    let mut above: (Option<Entity>, Vec3) = (None, at + HOOK);
    for i in 0..LINKS {
        let middle = at + HOOK + (f32::from(i) + 0.5) * LENGTH * along;
        let link = stage.hang(link.clone(), middle, turn, DENSITY);
        let joint = Joint::ball().with_anchors(above.1, half);
        stage.commands.join(above.0, link, joint);
        above = (Some(link), -half);
    }
    let middle = at + HOOK + (f32::from(LINKS) * LENGTH + RADIUS) * along;
    let ball = stage.hang(ConvexMesh::sphere(RADIUS)?, middle, turn, DENSITY);
    let joint = Joint::ball().with_anchors(above.1, RADIUS * Vec3::Y);
    stage.commands.join(above.0, ball, joint);
    Ok(())
}
