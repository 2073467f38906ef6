//! Shapes of about length 1.

use super::{log_range, once_in};
use crate::judge::dice::Dice;
use crate::judge::scene::{Form, Smooth};
use bevy_cleave::geometry::{ConvexHull, primitives};
use glam::Vec3;

pub(crate) fn cuboid(dice: &mut Dice) -> Form {
    let mut side = || log_range(dice, 0.25, 1.0);
    Form::Box(Vec3::new(side(), side(), side()))
}

fn corners(hull: ConvexHull) -> Form {
    Form::Hull(hull.vertices().to_vec())
}

/// The hull of some random points in a random ellipsoid.
pub(crate) fn hull(dice: &mut Dice) -> Form {
    let count = 4 + log_range(dice, 1.0, 50.0) as usize;
    let axes = Vec3::new(
        log_range(dice, 0.2, 0.5),
        log_range(dice, 0.2, 0.5),
        log_range(dice, 0.2, 0.5),
    );
    hull_of(dice, |dice| {
        let points = (0..count).map(|_| axes * (0.4 + 0.6 * dice.unit()) * dice.direction());
        points.collect()
    })
}

/// The hull of points that are drawn until they make one that is not too flat; only its corners, about their mean.
fn hull_of(dice: &mut Dice, draw: impl Fn(&mut Dice) -> Vec<Vec3>) -> Form {
    loop {
        let Ok(hull) = ConvexHull::from_points(&draw(dice)) else {
            continue;
        };
        let size = hull.aabb().extents();
        // Flat bodies have a family of their own.
        if hull.volume() > 0.02 * f64::from(size.element_product()) {
            return centered(hull.vertices());
        }
    }
}

/// Corners about their mean.
pub(crate) fn centered(corners: &[Vec3]) -> Form {
    let mean = corners.iter().sum::<Vec3>() / corners.len() as f32;
    Form::Hull(corners.iter().map(|c| *c - mean).collect())
}

/// A body with many faces: points on a sphere or an ellipsoid, an icosphere, or a prism with many sides.
pub(crate) fn round(dice: &mut Dice) -> Form {
    match dice.below(4) {
        0 => {
            let subdivisions = 1 + dice.below(2) as u32;
            corners(primitives::icosphere(0.5, subdivisions).expect("valid"))
        }
        1 => {
            let (sides, height) = (12 + dice.below(40) as u32, log_range(dice, 0.2, 1.0));
            corners(primitives::regular_prism(sides, 0.5, height).expect("valid"))
        }
        kind => {
            let count = log_range(dice, 40.0, 500.0) as usize;
            let flat = if kind == 2 {
                1.0
            } else {
                log_range(dice, 0.4, 1.0)
            };
            let axes = 0.5 * Vec3::new(1.0, flat, 1.0);
            hull_of(dice, |dice| {
                (0..count).map(|_| axes * dice.direction()).collect()
            })
        }
    }
}

/// A thin plate with its face up: a box or a prism.
pub(crate) fn plate(dice: &mut Dice) -> Form {
    let thickness = log_range(dice, 3e-3, 0.1);
    if once_in(dice, 3) {
        let sides = 3 + dice.below(6) as u32;
        return corners(primitives::regular_prism(sides, 0.5, thickness).expect("valid"));
    }
    let (x, z) = (log_range(dice, 0.5, 1.0), log_range(dice, 0.5, 1.0));
    Form::Box(Vec3::new(x, thickness, z))
}

/// A long thin rod along x: a box or a prism.
pub(crate) fn rod(dice: &mut Dice) -> Form {
    let thickness = log_range(dice, 1e-3, 0.05);
    if once_in(dice, 3) {
        let sides = 3 + dice.below(8) as u32;
        let prism = primitives::regular_prism(sides, 0.5 * thickness, 1.0).expect("valid");
        let along_x = prism.vertices().iter().map(|v| Vec3::new(v.y, v.z, v.x));
        return Form::Hull(along_x.collect());
    }
    Form::Box(Vec3::new(
        1.0,
        thickness,
        thickness * dice.in_range(0.6, 1.0),
    ))
}

/// A body with two points and a thin waist.
pub(crate) fn needle(dice: &mut Dice) -> Form {
    let thickness = log_range(dice, 3e-3, 0.1);
    let waist = 3 + dice.below(4);
    hull_of(dice, |dice| {
        let around = (0..waist).map(|_| {
            let d = dice.direction();
            let across = Vec3::new(0.0, d.y, d.z).normalize_or(Vec3::Y);
            Vec3::new(dice.in_range(-0.2, 0.2), 0.0, 0.0) + 0.5 * thickness * across
        });
        let mut points: Vec<Vec3> = around.collect();
        points.extend([-0.5 * Vec3::X, 0.5 * Vec3::X]);
        points
    })
}

/// A ramp or a random tetrahedron.
pub(crate) fn wedge(dice: &mut Dice) -> Form {
    if once_in(dice, 3) {
        return hull_of(dice, |dice| {
            (0..4).map(|_| 0.6 * dice.direction()).collect()
        });
    }
    let mut side = || log_range(dice, 0.2, 1.0);
    let (x, y, z) = (side(), side(), side());
    corners(primitives::wedge(x, y, z).expect("valid"))
}

/// What is round: about y, or with round edges.
pub(crate) fn smooth(dice: &mut Dice) -> Form {
    let radius = log_range(dice, 0.15, 0.5);
    let length = log_range(dice, 0.1, 1.0);
    match dice.below(5) {
        4 => {
            let mut core = any(dice);
            core.scaled(0.7);
            Form::Rounded(Box::new(core), log_range(dice, 0.01, 0.2))
        }
        kind => Form::Smooth(Smooth::NAMES[kind].0, [radius, length]),
    }
}

/// One of all kinds that are neither thin nor round.
pub(crate) fn any(dice: &mut Dice) -> Form {
    match dice.below(4) {
        0 | 1 => cuboid(dice),
        2 => hull(dice),
        _ => wedge(dice),
    }
}

/// One of all kinds.
pub(crate) fn of_all_kinds(dice: &mut Dice) -> Form {
    match dice.below(7) {
        0 | 1 => cuboid(dice),
        2 => hull(dice),
        3 => plate(dice),
        4 => rod(dice),
        5 => wedge(dice),
        _ => round(dice),
    }
}
