//! What stands because it is in balance: towers, decks, arches, houses of cards, stacks on slopes and on turntables.

use super::{COARSEST, Draft, drive, log_range, once_in, piles, set_material};
use crate::judge::dice::Dice;
use crate::judge::laws::Law;
use crate::judge::scene::{Actor, Form};
use bevy_cleave::geometry::primitives;
use glam::{Quat, Vec2, Vec3};

const LAWS: [Law; 6] = [
    Law::Finite,
    Law::Energy,
    Law::Overlap,
    Law::Rest,
    Law::Sleep,
    Law::Stand,
];

/// How long what stands is looked at.
const TIME: f32 = 40.0;

fn standing(mut actors: Vec<Actor>, friction: f32) -> Draft {
    set_material(&mut actors, friction, 0.0);
    Draft {
        actors,
        time: TIME,
        laws: LAWS.into(),
        min_steps_per_unit: COARSEST,
        soft: 0,
        down: Vec3::NEG_Y,
    }
}

/// A half-space or a large box.
fn floor(dice: &mut Dice) -> Vec<Actor> {
    match dice.below(3) {
        0 => vec![piles::box_floor()],
        _ => vec![Actor::fixed(Form::HalfSpace(Vec3::Y), Vec3::ZERO)],
    }
}

/// Boxes of nearly one footprint in exact contact, up to a thousandth off the axis.
fn column(dice: &mut Dice, heights: &[f32]) -> Vec<Actor> {
    let mut top = 0.0;
    let (x, z) = (log_range(dice, 0.5, 1.0), log_range(dice, 0.5, 1.0));
    let boxes = heights.iter().map(|&height| {
        let off = 1e-3 * dice.vector(-1.0, 1.0);
        let shrink = dice.in_range(0.9, 1.0);
        let size = Vec3::new(shrink * x, height, shrink * z);
        let body = Actor::new(Form::Box(size), Vec3::new(off.x, top + 0.5 * height, off.z));
        top += height;
        body
    });
    boxes.collect()
}

/// 2 to 24 boxes, all alike in weight, or with loads up to 1000 times as heavy.
pub(super) fn towers(dice: &mut Dice) -> Draft {
    let count = log_range(dice, 2.0, 25.0) as usize;
    let heights: Vec<f32> = (0..count).map(|_| log_range(dice, 0.3, 1.0)).collect();
    let mut boxes = column(dice, &heights);
    match dice.below(4) {
        0 => {
            let load = log_range(dice, 1.0, 1000.0);
            boxes.truncate(6);
            boxes.last_mut().expect("two or more").density *= load;
        }
        1 => boxes
            .iter_mut()
            .for_each(|b| b.density *= log_range(dice, 0.2, 5.0)),
        _ => {}
    }
    let friction = dice.in_range(0.3, 1.0);
    let mut actors = floor(dice);
    actors.extend(boxes);
    standing(actors, friction)
}

/// 3 to 60 thin plates of one thickness on top of each other.
pub(super) fn decks(dice: &mut Dice) -> Draft {
    let count = log_range(dice, 3.0, 61.0) as usize;
    let thickness = log_range(dice, 2e-3, 0.05);
    let mut actors = floor(dice);
    actors.extend(column(dice, &vec![thickness; count]));
    let friction = dice.in_range(0.2, 1.0);
    standing(actors, friction)
}

/// A tower of few boxes on a slope with up to twice the friction that holds it, at least 5 % above the least.
pub(super) fn slopes(dice: &mut Dice) -> Draft {
    let count = 1 + dice.below(3);
    let heights: Vec<f32> = (0..count).map(|_| log_range(dice, 0.05, 0.3)).collect();
    let slope = dice.in_range(0.02, 0.6);
    // The middle of the whole stays half a width, at least 0.25, beside the lower edge, with a fifth to spare.
    let lowest = |total: f32| 0.5 * total * slope < 0.2;
    let heights = match lowest(heights.iter().sum()) {
        true => heights,
        false => vec![0.2],
    };
    let mut actors = floor(dice);
    actors.extend(column(dice, &heights));
    let mut draft = standing(actors, slope * log_range(dice, 1.05, 2.0));
    // Floor and all are turned so that the floor falls by `slope`.
    let axis = Quat::from_rotation_arc(Vec3::Y, Vec3::new(slope, 1.0, 0.0).normalize());
    let yaw = Quat::from_xyzw(0.0, dice.in_range(-1.0, 1.0), 0.0, 1.0).normalize();
    for actor in &mut draft.actors {
        actor.pose.position = axis * (yaw * actor.pose.position);
        actor.pose.rotation = (axis * yaw * actor.pose.rotation).normalize();
    }
    draft
}

/// Boxes on a table that turns steadily, moving with it, on at most 0.7 of the friction there is.
pub(super) fn turntables(dice: &mut Dice) -> Draft {
    let friction = dice.in_range(0.2, 1.0);
    let reach = 4.0;
    let rate = (0.7 * friction / reach).sqrt() * dice.in_range(0.05, 1.0);
    let spin = rate * Vec3::Y;
    let table = primitives::regular_prism(32, reach + 2.0, 0.5).expect("valid");
    let mut table = Actor::fixed(Form::Hull(table.vertices().to_vec()), -0.25 * Vec3::Y);
    drive(&mut table, Vec3::ZERO, spin);
    let mut actors = vec![table];
    for (x, z) in [
        (0.0, 0.0),
        (2.2, 0.0),
        (-2.2, 0.5),
        (0.3, 2.3),
        (-0.2, -2.4),
    ] {
        let count = 1 + dice.below(3);
        let heights: Vec<f32> = (0..count).map(|_| log_range(dice, 0.2, 0.5)).collect();
        for mut body in column(dice, &heights) {
            body.pose.position += Vec3::new(x, 0.0, z);
            body.linear = spin.cross(body.pose.position);
            body.angular = spin;
            actors.push(body);
        }
    }
    let mut draft = standing(actors, friction);
    draft.laws = vec![Law::Finite, Law::Overlap, Law::Rest, Law::Stand];
    // So that the table does not turn by more than a twentieth of a turn in a step.
    draft.min_steps_per_unit = 2.0;
    draft
}

/// The body of a polygon in the xy plane about its mean.
fn extruded(polygon: &[Vec2], depth: f32) -> Actor {
    let mean = polygon.iter().sum::<Vec2>() / polygon.len() as f32;
    let corners = polygon.iter().flat_map(|&corner| {
        let flat = corner - mean;
        [-0.5, 0.5].map(|side| flat.extend(side * depth))
    });
    Actor::new(Form::Hull(corners.collect()), mean.extend(0.0))
}

/// A unit vector by the tangent of half its angle to the x axis: no sines.
fn by_half_tangent(t: f32) -> Vec2 {
    Vec2::new(1.0 - t * t, 2.0 * t) / (1.0 + t * t)
}

/// A semicircular arch with radial joints at uneven angles, 0.15 to 0.3 of its radius thick (0.107 is the least that stands).
pub(super) fn arches(dice: &mut Dice) -> Draft {
    let (count, thickness) = (3 + dice.below(7), dice.in_range(0.15, 0.3));
    let side: Vec<Vec2> = (0..=count)
        .map(|i| {
            let is_end = i == 0 || i == count;
            let shift = if is_end {
                0.0
            } else {
                dice.in_range(-0.2, 0.2)
            };
            by_half_tangent((i as f32 + shift) / count as f32)
        })
        .collect();
    let mirrored = side.iter().rev().skip(1).map(|d| Vec2::new(-d.x, d.y));
    let joints: Vec<Vec2> = side.iter().copied().chain(mirrored).collect();
    let depth = dice.in_range(0.3, 0.8);
    let (inner, outer) = (1.0 - 0.5 * thickness, 1.0 + 0.5 * thickness);
    let blocks = joints.windows(2).map(|ends| {
        let (from, to) = (ends[0], ends[1]);
        extruded(&[inner * from, outer * from, outer * to, inner * to], depth)
    });
    let mut actors = floor(dice);
    actors.extend(blocks);
    let friction = dice.in_range(0.6, 1.0);
    standing(actors, friction)
}

/// Half the width of the strips on which cards touch.
const STRIP: f32 = 2e-3;

/// The right one of two cards that lean against each other in direction `lean` (up, as long as the card), with its foot on
/// the floor at `lean.x` and its top at x = 0. Its ends are strips, so that where it touches and along which normal is clear:
/// flat on the floor, upright against the other card, level on top.
fn card(lean: Vec2, thickness: f32) -> [Vec2; 9] {
    let up = Vec2::new(-lean.x, lean.y).normalize();
    let outward = 0.5 * thickness * Vec2::new(up.y, -up.x);
    let (foot, top) = (Vec2::new(lean.x, 0.0), Vec2::new(0.0, lean.y));
    let bevel = 2.0 * thickness * up;
    let (low, high, s) = (foot + bevel, top - bevel, STRIP);
    [
        foot - s * Vec2::X,
        foot + s * Vec2::X,
        low + outward,
        high + outward,
        top + Vec2::new(2.0 * s, s),
        top + Vec2::new(0.0, s),
        top - Vec2::new(0.0, s),
        high - outward,
        low - outward,
    ]
}

/// A house of cards of one to three levels.
pub(super) fn houses(dice: &mut Dice) -> Draft {
    let levels = 1 + dice.below(3);
    house(dice, levels)
}

/// A draft with a fixed number of sub-steps: more may not be worse than fewer, and from four on nothing falls.
fn softly(dice: &mut Dice, mut draft: Draft) -> Draft {
    draft.soft = [4, 5, 6, 8, 10, 12, 16][dice.below(7)];
    draft.laws = vec![Law::Finite, Law::Stand];
    // The time between two sub-steps is what counts: of rates of the usual order.
    draft.min_steps_per_unit = 10.0;
    draft
}

/// Up to five levels.
pub(super) fn soft_houses(dice: &mut Dice) -> Draft {
    let levels = 1 + dice.below(5);
    let draft = house(dice, levels);
    softly(dice, draft)
}

pub(super) fn soft_arches(dice: &mut Dice) -> Draft {
    let draft = arches(dice);
    softly(dice, draft)
}

/// A house of cards. The feet push out with less than 0.75 of the load times the tangent of the lean,
/// so that friction of 0.4 would do.
fn house(dice: &mut Dice, levels: usize) -> Draft {
    // Angles to the upright of 11 to 28 degrees.
    let across = by_half_tangent(dice.in_range(0.1, 0.25));
    let lean = Vec2::new(across.y, across.x);
    let thickness = dice.in_range(0.015, 0.03);
    let right = card(lean, thickness);
    let left = right.map(|c| Vec2::new(-c.x, c.y));
    let (span, height) = (2.0 * (lean.x + STRIP), lean.y + STRIP);
    let mut actors = floor(dice);
    for level in 0..levels {
        let base = level as f32 * (height + thickness);
        let pairs = levels - level;
        for pair in 0..pairs {
            let middle = Vec2::new((pair as f32 - 0.5 * (pairs - 1) as f32) * span, base);
            actors.extend([right, left].map(|card| extruded(&card.map(|c| c + middle), 0.7)));
            if pair + 1 < pairs {
                let size = Vec3::new(span - STRIP, thickness, 0.7);
                let at = middle + Vec2::new(0.5 * span, height + 0.5 * thickness);
                actors.push(Actor::new(Form::Box(size), at.extend(0.0)));
            }
        }
    }
    let friction = dice.in_range(0.6, 1.0);
    let mut draft = standing(actors, friction);
    if once_in(dice, 2) {
        draft.time *= 2.0;
    }
    draft
}
