//! Bodies that bounce, collide in free space, or are shot at thin plates.

use super::{COARSEST, Draft, forms, log_range, once_in, piles, set_material};
use crate::judge::dice::Dice;
use crate::judge::laws::Law;
use crate::judge::scene::{Actor, Form};
use glam::{Quat, Vec3};

/// One to three bodies that fall on a floor, turning; one in two without friction and loss.
pub(super) fn bounces(dice: &mut Dice) -> Draft {
    let count = 1 + dice.below(3);
    let forms = (0..count).map(|_| match dice.below(4) {
        0 => forms::round(dice),
        1 => forms::plate(dice),
        _ => forms::any(dice),
    });
    let forms: Vec<Form> = forms.collect();
    let pile = piles::heap(dice, forms, 4.0);
    let mut actors = vec![Actor::fixed(Form::HalfSpace(Vec3::Y), Vec3::ZERO)];
    actors.extend(pile.actors);
    for actor in actors.iter_mut().skip(1) {
        actor.angular = log_range(dice, 0.01, 3.0) * dice.direction();
    }
    let is_lossless = once_in(dice, 2);
    if is_lossless {
        set_material(&mut actors, 0.0, 1.0);
    } else {
        let friction = dice.in_range(0.0, 2.0);
        set_material(&mut actors, friction, dice.unit());
    }
    let laws = [Law::Finite, Law::Energy, Law::Overlap, Law::Elastic];
    Draft {
        actors,
        time: 60.0,
        laws: laws[..if is_lossless { 4 } else { 3 }].into(),
        // Turning by up to 3 in the unit of time.
        min_steps_per_unit: 3.0,
        soft: 0,
        down: Vec3::NEG_Y,
    }
}

/// Bodies in free space that fly at each other.
pub(super) fn swarms(dice: &mut Dice) -> Draft {
    let count = log_range(dice, 2.0, 13.0) as usize;
    let forms = (0..count).map(|_| match dice.below(5) {
        0 => forms::plate(dice),
        1 => forms::round(dice),
        _ => forms::any(dice),
    });
    let forms: Vec<Form> = forms.collect();
    let pile = piles::heap(dice, forms, 2.0);
    let mut actors = pile.actors;
    let middle = actors.iter().map(|a| a.pose.position).sum::<Vec3>() / count as f32;
    let speed = log_range(dice, 0.03, 3.0);
    for actor in &mut actors {
        let inward = (middle - actor.pose.position).normalize_or(Vec3::X);
        actor.linear = speed * (inward + 0.5 * dice.direction());
        actor.angular = speed * dice.direction();
        actor.density *= log_range(dice, 0.1, 10.0);
    }
    let (friction, restitution) = (dice.in_range(0.0, 2.0), dice.unit());
    set_material(&mut actors, friction, restitution);
    Draft {
        actors,
        time: (8.0 / speed).min(60.0),
        laws: vec![Law::Finite, Law::Energy, Law::Momentum, Law::Overlap],
        min_steps_per_unit: COARSEST,
        soft: 0,
        down: Vec3::ZERO,
    }
}

/// A body shot at a plate as thick as a hundredth of its way per step, or thicker. The steps are those of the usual rate: the
/// speed is per step, not per second.
pub(super) fn shots(dice: &mut Dice) -> Draft {
    let thickness = log_range(dice, 0.01, 0.5);
    let plate = Form::Box(Vec3::new(60.0, thickness, 60.0));
    let mut plate = Actor::fixed(plate, Vec3::ZERO);
    if once_in(dice, 2) {
        plate.pose.rotation = dice.rotation();
    }
    let form = match dice.below(4) {
        0 => forms::rod(dice),
        1 => forms::plate(dice),
        _ => forms::any(dice),
    };
    let speed = log_range(dice, 1.0, 300.0);
    let normal = plate.pose.rotation * Vec3::Y;
    let askew = (dice.direction() * dice.in_range(0.0, 0.8) - normal).normalize();
    let aim = 3.0 * dice.vector(-1.0, 1.0);
    let aim = aim - aim.dot(normal) * normal;
    let start = (form.radius() + thickness) / -askew.dot(normal) + log_range(dice, 0.1, 5.0);
    let mut body = Actor::new(form, aim - start * askew);
    body.pose.rotation = if once_in(dice, 3) {
        Quat::IDENTITY
    } else {
        dice.rotation()
    };
    body.linear = speed * askew;
    if once_in(dice, 2) {
        body.angular = log_range(dice, 0.1, 30.0) * dice.direction();
    }
    let mut actors = vec![plate, body];
    let (friction, restitution) = (dice.in_range(0.0, 1.0), 0.5 * dice.unit());
    set_material(&mut actors, friction, restitution);
    Draft {
        actors,
        // Until it was through by now, and never so long that it gets around the edge.
        time: (start + 10.0) / speed,
        laws: vec![Law::Finite, Law::Tunnel],
        min_steps_per_unit: COARSEST,
        soft: 0,
        down: Vec3::ZERO,
    }
}
