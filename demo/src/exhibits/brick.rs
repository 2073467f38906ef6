//! A wall: it cracks along its joints, and bricks that are hit break themselves.

use super::{Stage, recipes};
use crate::shapes;
use bevy::prelude::*;
use bevy_cleave::prelude::*;

/// Of a brick, m.
const SIZE: Vec3 = Vec3::new(0.25, 0.125, 0.125);
const COURSES: u8 = 11;
const BRICKS: u8 = 8;

pub(super) fn put_up(stage: &mut Stage, at: Vec3) -> Result {
    let whole = shapes::block(SIZE, 0.006)?;
    let half = shapes::block(SIZE * Vec3::new(0.5, 1.0, 1.0), 0.006)?;
    let mut wall = Vec::new();
    for course in 0..COURSES {
        // Every other course begins and ends with half a brick.
        let is_shifted = course % 2 == 1;
        let (first, count) = if is_shifted {
            (-0.5, BRICKS + 1)
        } else {
            (0.0, BRICKS)
        };
        for i in 0..count {
            let is_half = is_shifted && (i == 0 || i == BRICKS);
            let inwards = match i {
                0 if is_half => 0.25,
                BRICKS if is_half => -0.25,
                _ => 0.0,
            };
            let along = first + f32::from(i) + 0.5 + inwards - 0.5 * f32::from(BRICKS);
            let place = Vec3::new(along * SIZE.x, (f32::from(course) + 0.5) * SIZE.y, 0.0);
            let number = wall.len();
            let look = stage.looks.bricks
                [(number * 7 + usize::from(course)) % stage.looks.bricks.len()]
            .clone();
            let shape = if is_half { &half } else { &whole };
            let place = Transform::from_translation(at + place);
            wall.push(stage.put(
                shape.clone(),
                place,
                1900.0,
                recipes::brick(number as u64),
                &look,
            ));
        }
    }
    stage.commands.bond_neighbors(wall, recipes::MORTAR);
    Ok(())
}
