//! Heaps that fall, and unlike boxes on top of each other.

use super::piles::{self, Pile, heap};
use super::{
    COARSEST, Draft, broken as fragments, compounds as several, drive, forms, log_range, once_in,
    set_material,
};
use crate::judge::dice::Dice;
use crate::judge::laws::Law;
use crate::judge::scene::{Actor, Form};
use glam::{Quat, Vec3};

/// What every heap has to keep.
const LAWS: [Law; 5] = [
    Law::Finite,
    Law::Energy,
    Law::Overlap,
    Law::Rest,
    Law::Sleep,
];

/// 3 to 24 of a kind, few more often than many.
fn some(dice: &mut Dice, draw: fn(&mut Dice) -> Form) -> Vec<Form> {
    let count = log_range(dice, 3.0, 25.0) as usize;
    (0..count).map(|_| draw(dice)).collect()
}

/// Puts bodies on a floor, draws friction, restitution and first velocities, and tells the time.
fn settle(dice: &mut Dice, mut bodies: Vec<Actor>, height: f32, rolling: f32) -> Draft {
    if once_in(dice, 4) {
        let speed = dice.in_range(0.0, 1.0);
        for body in &mut bodies {
            body.linear = speed * dice.direction();
            body.angular = speed * dice.direction();
        }
    }
    let floor = piles::floor(dice);
    settle_on(dice, floor, bodies, height, rolling)
}

/// The same on a given floor, with the velocities that bodies have.
pub(super) fn settle_on(
    dice: &mut Dice,
    floor: Vec<Actor>,
    bodies: Vec<Actor>,
    height: f32,
    rolling: f32,
) -> Draft {
    let mut actors = floor;
    actors.extend(bodies);
    let friction = match dice.below(6) {
        0 => log_range(dice, 0.1, 0.3),
        1 => dice.in_range(1.0, 2.0),
        _ => dice.in_range(0.3, 1.0),
    };
    let restitution = match dice.below(3) {
        0 => dice.in_range(0.0, 0.8),
        _ => 0.0,
    };
    set_material(&mut actors, friction, restitution);
    Draft {
        actors,
        time: time_to_rest(height, friction, restitution) + rolling,
        laws: LAWS.into(),
        min_steps_per_unit: COARSEST,
        soft: 0,
        down: Vec3::NEG_Y,
    }
}

/// How long a heap of a height may take. A fall takes `t = sqrt(2 h)`, and all bounces after it `t (1 + e) / (1 - e)`;
/// then what is fast slides for `t / mu`; each may follow another some times over in a heap. What remains is to tip over and
/// to rock, from face to face.
fn time_to_rest(height: f32, friction: f32, restitution: f32) -> f32 {
    let fall = (2.0 * (height + 1.0)).sqrt();
    let bounces = (1.0 + restitution) / (1.0 - restitution);
    3.0 * fall * (bounces + 1.0 / friction.min(1.0)) + 20.0
}

pub(super) fn heap_of(dice: &mut Dice, forms: Vec<Form>, rolling: f32) -> Draft {
    let width = log_range(dice, 0.3, 3.0);
    let pile = heap(dice, forms, width);
    let top = pile.top();
    settle(dice, pile.actors, top, rolling)
}

pub(super) fn boxes(dice: &mut Dice) -> Draft {
    let forms = some(dice, forms::cuboid);
    heap_of(dice, forms, 0.0)
}

pub(super) fn hulls(dice: &mut Dice) -> Draft {
    let forms = some(dice, forms::hull);
    heap_of(dice, forms, 20.0)
}

/// What is round rolls from face to face until it is slower than it takes to tip over an edge; each face takes a share of the
/// energy that falls with the square of the angle between faces, some tens of times the time for a length.
pub(super) fn round(dice: &mut Dice) -> Draft {
    let mut forms = some(dice, forms::round);
    forms.truncate(10);
    heap_of(dice, forms, 60.0)
}

pub(super) fn plates(dice: &mut Dice) -> Draft {
    let forms = some(dice, forms::plate);
    heap_of(dice, forms, 20.0)
}

pub(super) fn rods(dice: &mut Dice) -> Draft {
    let mut forms = some(dice, forms::rod);
    forms.truncate(12);
    heap_of(dice, forms, 20.0)
}

pub(super) fn needles(dice: &mut Dice) -> Draft {
    let mut forms = some(dice, forms::needle);
    forms.truncate(12);
    heap_of(dice, forms, 20.0)
}

pub(super) fn wedges(dice: &mut Dice) -> Draft {
    let forms = some(dice, forms::wedge);
    heap_of(dice, forms, 0.0)
}

pub(super) fn compounds(dice: &mut Dice) -> Draft {
    let mut forms = some(dice, several::compound);
    forms.truncate(16);
    heap_of(dice, forms, 20.0)
}

/// Sizes of 1 : 30.
pub(super) fn sizes(dice: &mut Dice) -> Draft {
    let mut forms = some(dice, forms::any);
    for form in &mut forms {
        form.scaled(log_range(dice, 1.0 / 30.0, 1.0));
    }
    heap_of(dice, forms, 0.0)
}

/// Densities of 1 : 1000.
pub(super) fn masses(dice: &mut Dice) -> Draft {
    let forms = some(dice, forms::any);
    let mut draft = heap_of(dice, forms, 0.0);
    for actor in &mut draft.actors {
        actor.density *= log_range(dice, 0.03, 30.0);
    }
    draft
}

/// A body in pieces: where they were made, or in a heap.
pub(super) fn broken(dice: &mut Dice) -> Draft {
    let pieces = fragments::pieces(dice);
    if once_in(dice, 2) {
        let centered = pieces.iter().map(|piece| forms::centered(piece.vertices()));
        let forms = centered.collect();
        return heap_of(dice, forms, 20.0);
    }
    let low = |low: f32, v: &Vec3| low.min(v.y);
    let vertices = pieces.iter().flat_map(|piece| piece.vertices());
    let lift = log_range(dice, 1e-3, 0.3) - vertices.fold(f32::MAX, low);
    let bodies = pieces
        .iter()
        .map(|piece| fragments::in_place(piece, lift * Vec3::Y));
    let bodies = bodies.collect();
    settle(dice, bodies, 1.0, 20.0)
}

/// Unlike boxes nearly above each other, flat on their faces: some stand, some topple.
pub(super) fn stacks(dice: &mut Dice) -> Draft {
    let forms = some(dice, forms::cuboid);
    let mut pile = Pile::new();
    let gap = log_range(dice, 1e-4, 0.1);
    let mut top = 0.0;
    for form in forms {
        let place = [(); 2].map(|()| dice.in_range(-0.1, 0.1));
        let angle = dice.in_range(-1.0, 1.0);
        let rotation = Quat::from_xyzw(0.0, angle, 0.0, 1.0).normalize();
        pile.put(form, place, rotation, top + gap);
        top = pile.top();
    }
    settle(dice, pile.actors, top, 0.0)
}

/// A heap on a floor that moves steadily, and falls with it.
pub(super) fn lifts(dice: &mut Dice) -> Draft {
    let forms = some(dice, forms::any);
    let mut draft = heap_of(dice, forms, 0.0);
    let is_floor = |actor: &Actor| !actor.is_dynamic();
    let first = draft.actors.iter().find(|actor| is_floor(actor)).cloned();
    draft.actors.retain(|actor| !is_floor(actor));
    let motion = log_range(dice, 0.01, 3.0) * dice.direction();
    draft
        .actors
        .iter_mut()
        .for_each(|actor| actor.linear += motion);
    let mut floor = piles::box_floor();
    if let Some(first) = first {
        (floor.friction, floor.restitution) = (first.friction, first.restitution);
    }
    drive(&mut floor, motion, Vec3::ZERO);
    draft.actors.insert(0, floor);
    // What is carried by something that moves does not sleep.
    draft.laws.retain(|law| *law != Law::Sleep);
    draft
}

/// A small heap, or unlike boxes on each other, that is judged while it lands.
fn landing(dice: &mut Dice, law: Law) -> Draft {
    let mut draft = match dice.below(3) {
        0 => stacks(dice),
        1 => boxes(dice),
        _ => masses(dice),
    };
    let mut left = 1 + dice.below(5);
    draft.actors.retain(|actor| {
        let stays = !actor.is_dynamic() || left > 0;
        left -= usize::from(stays && actor.is_dynamic());
        stays
    });
    draft.time = 5.0;
    draft.laws = vec![Law::Finite, law];
    draft
}

pub(super) fn copies(dice: &mut Dice) -> Draft {
    landing(dice, Law::Same)
}

pub(super) fn steps(dice: &mut Dice) -> Draft {
    landing(dice, Law::Finer)
}
