//! Bodies of several convex parts, of about length 1: furniture, crosses, rings and clusters.

use super::{forms, log_range};
use crate::judge::dice::Dice;
use crate::judge::scene::Form;
use bevy_cleave::prelude::Pose;
use glam::{Quat, Vec3};

pub(crate) fn compound(dice: &mut Dice) -> Form {
    Form::Compound(match dice.below(5) {
        0 => table(dice),
        1 => cross(dice),
        2 => ring(dice),
        3 => dumbbell(dice),
        _ => cluster(dice),
    })
}

fn block(size: Vec3, at: Vec3) -> (Form, Pose) {
    (Form::Box(size), Pose::from_position(at))
}

/// A slab on three or four legs, sometimes with a back.
fn table(dice: &mut Dice) -> Vec<(Form, Pose)> {
    let (x, z) = (dice.in_range(0.5, 1.0), dice.in_range(0.5, 1.0));
    let [slab, leg] = [(); 2].map(|()| log_range(dice, 0.03, 0.15));
    let height = dice.in_range(0.2, 0.9);
    let mut parts = vec![block(Vec3::new(x, slab, z), Vec3::ZERO)];
    let middle = -0.5 * (slab + height);
    let [dx, dz] = [x, z].map(|width| 0.5 * (width - leg));
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    for (i, j) in corners.into_iter().take(3 + dice.below(2)) {
        let size = Vec3::new(leg, height, leg);
        parts.push(block(size, Vec3::new(i * dx, middle, j * dz)));
    }
    if dice.below(3) == 0 {
        let size = Vec3::new(leg, height, z);
        parts.push(block(size, Vec3::new(dx, -middle, 0.0)));
    }
    parts
}

/// Bars along two or three axes through a common middle, or the corner of an L.
fn cross(dice: &mut Dice) -> Vec<(Form, Pose)> {
    let thickness = log_range(dice, 0.05, 0.25);
    let count = 2 + dice.below(2);
    let is_corner = dice.below(2) == 0;
    let bars = Vec3::AXES.into_iter().take(count).map(|axis| {
        let length = dice.in_range(0.5, 1.0);
        let size = Vec3::splat(thickness) + (length - thickness) * axis;
        let off = if is_corner {
            0.5 * (length - thickness)
        } else {
            0.0
        };
        block(size, off * axis)
    });
    bars.collect()
}

/// `tan(pi / n)` for rings of `n` from 4 to 8, since platforms differ in the last digit.
const HALF_TURNS: [f32; 5] = [1.0, 0.726_542_5, 0.577_350_26, 0.481_574_6, 0.414_213_57];

/// Boxes around a hole, with or without a bottom: a ring, a tub.
fn ring(dice: &mut Dice) -> Vec<(Form, Pose)> {
    let kind = dice.below(HALF_TURNS.len());
    let half_turn = HALF_TURNS[kind];
    let one = Quat::from_xyzw(0.0, half_turn, 0.0, 1.0).normalize();
    let wall = dice.in_range(0.04, 0.12);
    let height = dice.in_range(0.15, 0.7);
    let radius = 0.5 - 0.5 * wall;
    let mut turn = Quat::IDENTITY;
    let mut parts = Vec::new();
    for _ in 0..4 + kind {
        // As long as the outside of the wall is.
        let size = Vec3::new(wall, height, half_turn);
        parts.push((Form::Box(size), Pose::new(turn * (radius * Vec3::X), turn)));
        turn = (one * turn).normalize();
    }
    if dice.below(2) == 0 {
        let size = Vec3::new(0.7, wall, 0.7);
        parts.push(block(size, 0.5 * (wall - height) * Vec3::Y));
    }
    parts
}

/// Two ends and a bar between them.
fn dumbbell(dice: &mut Dice) -> Vec<(Form, Pose)> {
    let thickness = log_range(dice, 0.04, 0.2);
    let mut parts = vec![block(Vec3::new(0.8, thickness, thickness), Vec3::ZERO)];
    for side in [-0.4, 0.4] {
        let mut end = forms::any(dice);
        end.scaled(dice.in_range(0.2, 0.5));
        parts.push((end, Pose::new(side * Vec3::X, dice.rotation())));
    }
    parts
}

/// Bodies that overlap each other.
fn cluster(dice: &mut Dice) -> Vec<(Form, Pose)> {
    let parts = (0..2 + dice.below(6)).map(|_| {
        let mut form = forms::any(dice);
        form.scaled(dice.in_range(0.3, 0.8));
        (form, Pose::new(dice.vector(-0.25, 0.25), dice.rotation()))
    });
    parts.collect()
}
