//! A body that slides over a floor in many pieces, and over the same floor in one.

use super::{Draft, broken, log_range, once_in, set_material};
use crate::judge::dice::Dice;
use crate::judge::laws::Law;
use crate::judge::scene::{Actor, Form, Role};
use bevy_cleave::geometry::primitives;
use bevy_cleave::math::Plane;
use glam::{DVec3, Quat, Vec2, Vec3};

/// Thickness of the floor.
const THICKNESS: f32 = 1.0;

/// Most pieces along one side of the floor.
const MOST: usize = 14;

/// What lies on the floor, its frame's origin at least height 0.
fn slider(dice: &mut Dice) -> Form {
    match dice.below(6) {
        0 => Form::Box(Vec3::ONE),
        1 => Form::Box(Vec3::new(1.0, log_range(dice, 0.01, 0.1), 1.0)),
        2 => {
            let (sides, height) = (3 + dice.below(30) as u32, log_range(dice, 0.1, 1.0));
            let prism = primitives::regular_prism(sides, 0.5, height).expect("valid");
            Form::Hull(prism.vertices().to_vec())
        }
        3 => {
            let sphere = primitives::icosphere(0.5, 1 + dice.below(2) as u32).expect("valid");
            Form::Hull(sphere.vertices().to_vec())
        }
        4 => Form::Box(Vec3::new(1.0, 0.02, 0.02)),
        _ => super::forms::cuboid(dice),
    }
}

/// Seams along one side of the floor: even, or anywhere.
fn seams(dice: &mut Dice, length: f32) -> Vec<f32> {
    let tile = log_range(dice, 0.2, 4.0).max(length / MOST as f32);
    let count = (length / tile).ceil() as usize;
    let width = length / count as f32;
    let is_even = !once_in(dice, 3);
    let places = (1..count).map(|i| {
        let shift = if is_even {
            0.0
        } else {
            dice.in_range(-0.4, 0.4)
        };
        (i as f32 + shift) * width
    });
    places.collect()
}

/// Flush boxes between the seams.
fn boxes(dice: &mut Dice, size: Vec2) -> Vec<Actor> {
    let [x, z] = [size.x, size.y].map(|length| {
        let mut ends = seams(dice, length);
        ends.insert(0, 0.0);
        ends.push(length);
        ends
    });
    let spans = |ends: &[f32]| -> Vec<[f32; 2]> { ends.windows(2).map(|w| [w[0], w[1]]).collect() };
    let (x, z) = (spans(&x), spans(&z));
    let tiles = x.iter().flat_map(|x| z.iter().map(move |z| (x, z)));
    tiles
        .map(|([x0, x1], [z0, z1])| {
            let form = Form::Box(Vec3::new(x1 - x0, THICKNESS, z1 - z0));
            let at = Vec3::new(0.5 * (x0 + x1), -0.5 * THICKNESS, 0.5 * (z0 + z1));
            Actor::fixed(form, at)
        })
        .collect()
}

/// Each tile as two prisms.
fn prisms(dice: &mut Dice, size: Vec2) -> Vec<Actor> {
    let halves = boxes(dice, size).into_iter().flat_map(|tile| {
        let Form::Box(s) = tile.form else {
            unreachable!("tiles are boxes")
        };
        let (x, y, z) = (0.5 * s.x, 0.5 * s.y, 0.5 * s.z);
        let ends = [[[-x, -z], [x, -z], [x, z]], [[-x, -z], [x, z], [-x, z]]];
        ends.map(|triangle| {
            let corners = triangle.map(|[x, z]| [Vec3::new(x, -y, z), Vec3::new(x, y, z)]);
            Actor::fixed(Form::Hull(corners.concat()), tile.pose.position)
        })
    });
    halves.collect()
}

/// One slab cut by upright planes.
fn cut(dice: &mut Dice, size: Vec2) -> Vec<Actor> {
    let (slab, middle) = slab(size);
    let count = 2 + dice.below(5);
    let planes: Vec<Plane> = (0..count)
        .map(|_| {
            let through = dice.vector(-0.4, 0.4) * Vec3::new(size.x, 0.0, size.y);
            let across = dice.direction() * Vec3::new(1.0, 0.0, 1.0);
            Plane::through(through, across.normalize_or(Vec3::X))
        })
        .collect();
    let pieces = broken::cut(broken::hull_of(&slab), planes);
    let fixed = pieces.iter().map(|piece| {
        let Actor { form, pose, .. } = broken::in_place(piece, middle);
        Actor::fixed(form, pose.position)
    });
    fixed.collect()
}

/// The whole floor and its middle.
fn slab(size: Vec2) -> (Form, Vec3) {
    let form = Form::Box(Vec3::new(size.x, THICKNESS, size.y));
    (form, 0.5 * Vec3::new(size.x, -THICKNESS, size.y))
}

pub(super) fn slides(dice: &mut Dice) -> Draft {
    let speed = log_range(dice, 0.03, 16.0);
    let friction = if once_in(dice, 2) {
        0.0
    } else {
        dice.in_range(0.05, 0.8)
    };
    let way = if speed > 3.0 { 12.0 } else { 4.0 };
    let time = (way / speed).min(30.0);
    // Along the tiles or askew to them.
    let heading = match dice.below(3) {
        0 => Vec3::X,
        _ => (dice.direction().abs() * Vec3::new(1.0, 0.0, 1.0)).normalize_or(Vec3::X),
    };
    let start = Vec3::new(2.0, 0.0, 2.0);
    let size = Vec2::new(4.0 + way * heading.x, 4.0 + way * heading.z);
    let mut actors = match dice.below(4) {
        0 => prisms(dice, size),
        1 => cut(dice, size),
        _ => boxes(dice, size),
    };
    actors.iter_mut().for_each(|actor| actor.role = Role::Here);
    let (slab, middle) = slab(size);
    actors.push(Actor {
        role: Role::There,
        ..Actor::fixed(slab, middle)
    });
    let form = slider(dice);
    let turn = Quat::from_xyzw(0.0, dice.in_range(-1.0, 1.0), 0.0, 1.0).normalize();
    let rotation = if once_in(dice, 3) {
        turn
    } else {
        Quat::IDENTITY
    };
    let hull = broken::hull_of(&form);
    let corners = hull.vertices().iter().map(|v| v.as_dvec3().dot(DVec3::Y));
    let height = -corners.fold(f64::MAX, f64::min) as f32;
    let mut body = Actor::new(form, start + height * Vec3::Y);
    body.pose.rotation = rotation;
    body.linear = speed * heading;
    actors.push(body);
    set_material(&mut actors, friction, 0.0);
    Draft {
        actors,
        time,
        laws: vec![Law::Finite, Law::Seam],
        is_heavy: true,
    }
}
