//! Bodies of all kinds on rough ground, but for thin ones, which have families of their own.

use super::heaps::settle_on;
use super::piles::heap;
use super::{Draft, compounds, forms, log_range, once_in};
use crate::judge::dice::Dice;
use crate::judge::laws::Law;
use crate::judge::scene::{Actor, Form, Ground};
use glam::Vec3;

/// Steepest slope of the ground inside, and height of its rim.
const STEEPEST: f32 = 0.3;
const RIM: f32 = 1.5;

/// Heights between -1 and 0 times an amplitude, about the origin, with a rim around them.
fn ground(dice: &mut Dice) -> Actor {
    let width = 16.0;
    let columns = (width / log_range(dice, 0.5, 4.0)) as usize + 2;
    let spacing = width / (columns - 1) as f32;
    let amplitude = spacing * dice.in_range(0.0, STEEPEST / std::f32::consts::SQRT_2);
    let is_rim = |i: usize| i == 0 || i == columns - 1;
    let heights = (0..columns * columns).map(|i| {
        if is_rim(i % columns) || is_rim(i / columns) {
            RIM
        } else {
            -amplitude * dice.unit()
        }
    });
    let heights = heights.collect();
    let form = Form::Ground(Ground {
        heights,
        columns,
        spacing,
    });
    Actor::fixed(form, Vec3::new(-0.5 * width, 0.0, -0.5 * width))
}

fn on_ground(dice: &mut Dice, draw: fn(&mut Dice) -> Form) -> Draft {
    let ground = ground(dice);
    let count = log_range(dice, 3.0, 20.0) as usize;
    let forms = (0..count).map(|_| draw(dice)).collect();
    let width = log_range(dice, 0.5, 6.0);
    let pile = heap(dice, forms, width);
    let top = pile.top();
    settle_on(dice, vec![ground], pile.actors, top, 40.0)
}

pub(super) fn terrains(dice: &mut Dice) -> Draft {
    on_ground(dice, |dice| match dice.below(3) {
        0 => compounds::compound(dice),
        _ => forms::any(dice),
    })
}

/// What is round rolls until a hollow stops it, if there is one: there is no time for it.
pub(super) fn mixtures(dice: &mut Dice) -> Draft {
    let draw = |dice: &mut Dice| match dice.below(4) {
        0 => compounds::compound(dice),
        1 => forms::any(dice),
        _ => forms::smooth(dice),
    };
    let mut draft = if once_in(dice, 3) {
        let count = log_range(dice, 3.0, 16.0) as usize;
        let forms = (0..count).map(|_| draw(dice)).collect();
        super::heaps::heap_of(dice, forms, 0.0)
    } else {
        on_ground(dice, draw)
    };
    draft
        .laws
        .retain(|law| !matches!(law, Law::Rest | Law::Sleep));
    draft.time = draft.time.min(20.0);
    draft
}
