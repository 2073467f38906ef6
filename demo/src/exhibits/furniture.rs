//! A table and chairs, each one body of several parts: what is hit breaks, and what it held comes apart.

use super::{Stage, recipes};
use crate::shapes;
use bevy::prelude::*;
use bevy_cleave::prelude::*;

/// Of beech, kg/m3.
const DENSITY: f32 = 700.0;
/// Thickness of legs and plates, m.
const LEG: f32 = 0.05;

type Part = (Pose, ConvexMesh);

fn part(size: Vec3, at: Vec3) -> Result<Part, HullError> {
    let shape = shapes::block(size, 0.004)?;
    Ok((Pose::from_position(at), shape))
}

/// A plate whose upper side is at a height, and four legs below its corners.
fn on_legs(size: Vec2, height: f32) -> Result<Vec<Part>, HullError> {
    let plate = Vec3::new(size.x, LEG, size.y);
    let length = height - LEG;
    let mut parts = vec![part(plate, (height - 0.5 * LEG) * Vec3::Y)?];
    for [x, z] in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
        let corner = 0.5 * (plate - LEG) * Vec3::new(x, 0.0, z);
        parts.push(part(
            Vec3::new(LEG, length, LEG),
            corner + 0.5 * length * Vec3::Y,
        )?);
    }
    Ok(parts)
}

fn chair() -> Result<Vec<Part>, HullError> {
    let mut parts = on_legs(Vec2::new(0.42, 0.42), 0.45)?;
    for y in [0.58, 0.78] {
        parts.push(part(
            Vec3::new(0.42, 0.12, 0.03),
            Vec3::new(0.0, y, -0.195),
        )?);
    }
    for x in [-0.195, 0.195] {
        parts.push(part(
            Vec3::new(0.03, 0.42, 0.03),
            Vec3::new(x, 0.66, -0.165),
        )?);
    }
    Ok(parts)
}

pub(super) fn put_up(stage: &mut Stage, at: Vec3) -> Result {
    let table = (on_legs(Vec2::new(1.3, 0.75), 0.74)?, Vec3::ZERO, 0.0);
    let mut pieces = vec![table];
    for (x, z, turn) in [(-0.3, -0.62, 0.2), (0.45, -0.6, -0.1), (0.1, 0.75, 3.3)] {
        pieces.push((chair()?, Vec3::new(x, 0.0, z), turn));
    }
    for (number, (parts, place, turn)) in pieces.into_iter().enumerate() {
        let shape = Compound::new(parts)?;
        let place =
            Transform::from_translation(at + place).with_rotation(Quat::from_rotation_y(turn));
        let look = stage.looks.laths[number % stage.looks.laths.len()].clone();
        let wood = Fracturable {
            strength: 60.0,
            ..recipes::lath(number as u64)
        };
        stage.put(shape, place, DENSITY, wood, &look);
    }
    Ok(())
}
