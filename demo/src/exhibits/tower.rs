//! A tower of stones that is one body, a cluster, until it is shot at: what bonds hold to the ground goes on standing.

use super::Stage;
use crate::look::SHADES;
use crate::shapes;
use bevy::prelude::*;
use bevy_cleave::prelude::*;
use std::f32::consts::TAU;

/// Inner and outer radius of the wall, m, and of the battlements.
const WALL: [f32; 2] = [0.42, 0.56];
const BATTLEMENTS: [f32; 2] = [0.42, 0.62];
/// Of a course, m.
const HEIGHT: f32 = 0.13;
/// Below the battlements, which are a course and every other stone of one more.
const COURSES: u8 = 10;
/// In a course.
const STONES: u8 = 14;
/// Of a stone, as seen from the axis, rad.
const ANGLE: f32 = TAU / STONES as f32;
/// Of sandstone, kg/m3.
const DENSITY: f32 = 2300.0;
/// Of the mortar, Pa.
const STRENGTH: f32 = 2.0e5;

/// Whether the wall has a window instead of this stone.
fn is_window(course: u8, stone: u8) -> bool {
    matches!((course, stone), (4, 0 | 7) | (6, 3 | 10))
}

pub(super) fn put_up(stage: &mut Stage, at: Vec3) -> Result {
    let stones = |radii| -> Result<Vec<ConvexMesh>, HullError> {
        let stone = |slot| shapes::wedge(ANGLE, radii, HEIGHT, 0.008, slot);
        SHADES.into_iter().map(stone).collect()
    };
    let (wall, battlements) = (stones(WALL)?, stones(BATTLEMENTS)?);
    let mut parts: Vec<(Pose, ConvexMesh)> = Vec::new();
    for course in 0..COURSES + 2 {
        let is_gap = |stone: u8| match course {
            ..COURSES => is_window(course, stone),
            _ => course > COURSES && stone % 2 == 1,
        };
        let shapes = if course < COURSES {
            &wall
        } else {
            &battlements
        };
        // Every other course is turned by half a stone.
        let shift = 0.5 * f32::from(course.min(COURSES) % 2);
        for stone in (0..STONES).filter(|&stone| !is_gap(stone)) {
            let turn = Quat::from_rotation_y((f32::from(stone) + shift) * ANGLE);
            let height = (f32::from(course) + 0.5) * HEIGHT;
            let shade = usize::from(stone) * 5 + usize::from(course) * 7;
            let shape = shapes[shade % shapes.len()].clone();
            parts.push((Pose::new(height * Vec3::Y, turn), shape));
        }
    }
    let tower = Cluster::new(parts, STRENGTH)?.compound()?;
    let look = stage.looks.sandstone.clone();
    stage.stand((tower, Density(DENSITY)), at, &look);
    Ok(())
}
