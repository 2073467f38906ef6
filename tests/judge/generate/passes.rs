//! A body that flies past another and does not touch it.

use super::{COARSEST, Draft, forms, log_range, once_in};
use crate::judge::dice::Dice;
use crate::judge::laws::Law;
use crate::judge::scene::{Actor, Form, Role};
use bevy_cleave::prelude::RigidBody;
use glam::{Quat, Vec3};

/// How far a body turned by `rotation` reaches along `direction`.
fn reach(form: &Form, rotation: Quat, direction: Vec3) -> f32 {
    let along = rotation.inverse() * direction;
    match form {
        Form::Box(size) => 0.5 * size.dot(along.abs()),
        Form::Hull(corners) => corners
            .iter()
            .fold(f32::MIN, |far, c| far.max(c.dot(along))),
        _ => unreachable!("what passes is a hull, and passes one"),
    }
}

/// A way along a plane that the obstacle touches from below, and that the body stays above by 2e-3 of its size or more.
pub(super) fn passes(dice: &mut Dice) -> Draft {
    let mut obstacle = Actor::fixed(forms::of_all_kinds(dice), Vec3::ZERO);
    obstacle.form.scaled(log_range(dice, 0.3, 10.0));
    obstacle.role = Role::Here;
    if once_in(dice, 3) {
        obstacle.kind = RigidBody::Dynamic;
    }
    // Over a face or past an edge or a corner.
    let is_over_face = once_in(dice, 3);
    let above = if is_over_face {
        Vec3::Y
    } else {
        dice.direction()
    };
    if !once_in(dice, 4) {
        obstacle.pose.rotation = if is_over_face {
            Quat::IDENTITY
        } else {
            dice.rotation()
        };
    }
    let heading = above
        .cross(dice.direction())
        .normalize_or(above.any_orthonormal_vector());
    let mut body = Actor::new(forms::of_all_kinds(dice), Vec3::ZERO);
    body.pose.rotation = if once_in(dice, 4) {
        Quat::IDENTITY
    } else {
        dice.rotation()
    };
    let gap = 2.0 * body.form.radius() * log_range(dice, 2e-3, 0.3);
    let is_turning = once_in(dice, 3);
    let below = if is_turning {
        body.angular = log_range(dice, 0.01, 10.0) * dice.direction();
        // Twice, because a hull's center of mass need not be at its origin.
        2.0 * body.form.radius()
    } else {
        reach(&body.form, body.pose.rotation, -above)
    };
    let height = reach(&obstacle.form, obstacle.pose.rotation, above) + below + gap;
    let start = 1.5 * (obstacle.form.radius() + body.form.radius());
    let speed = log_range(dice, 0.1, 100.0);
    let aside = dice.in_range(-0.3, 0.3) * above.cross(heading);
    body.pose.position = height * above - start * heading + aside;
    body.linear = speed * heading;
    Draft {
        actors: vec![obstacle, body],
        time: 2.0 * start / speed,
        laws: vec![Law::Finite, Law::Cause],
        min_steps_per_unit: COARSEST,
        soft: 0,
        down: Vec3::ZERO,
    }
}
