//! A body that slides over a floor in many pieces, and over the same floor in one.

use super::{COARSEST, Draft, broken, log_range, once_in, piles, set_material};
use crate::judge::dice::Dice;
use crate::judge::laws::Law;
use crate::judge::scene::{Actor, Form, Role};
use bevy_cleave::geometry::primitives;
use bevy_cleave::math::Plane;
use bevy_cleave::prelude::RigidBody;
use glam::{Quat, Vec2, Vec3};

/// Thickness of the floor.
const THICKNESS: f32 = 1.0;

/// Most pieces along one side of the floor.
const MAX_TILES: usize = 14;

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
            // On a face: on an edge or a corner it would tip over sooner or later, on any floor.
            let down = sphere.faces()[0].plane.normal;
            let turn = Quat::from_rotation_arc(down, Vec3::NEG_Y);
            Form::Hull(sphere.vertices().iter().map(|&v| turn * v).collect())
        }
        4 => Form::Box(Vec3::new(1.0, 0.02, 0.02)),
        _ => super::forms::cuboid(dice),
    }
}

/// Seams along one side of the floor: even, or anywhere.
fn seams(dice: &mut Dice, length: f32) -> Vec<f32> {
    let tile = log_range(dice, 0.2, 4.0).max(length / MAX_TILES as f32);
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

/// A floor of `size` in pieces and in one, and what may lie below it.
fn floors(dice: &mut Dice, size: Vec2) -> Vec<Actor> {
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
    actors
}

/// Lets the floor rest on a half-space instead of being fixed.
fn set_down(floor: &mut Vec<Actor>) {
    for piece in floor.iter_mut() {
        piece.kind = RigidBody::Dynamic;
        piece.density *= 10.0;
    }
    let ground = Actor::fixed(Form::HalfSpace(Vec3::Y), -THICKNESS * Vec3::Y);
    floor.push(ground);
}

/// Which way gravity acts on what slides along `heading`: onto the floor, or along it as down a wall. A second wall makes a
/// shaft; `height` is that of what slides.
fn set_upright(dice: &mut Dice, floor: &mut Vec<Actor>, heading: Vec3, height: f32) -> Vec3 {
    if once_in(dice, 2) {
        let mut opposite = floor.clone();
        for wall in &mut opposite {
            wall.pose.position.y = height - wall.pose.position.y;
        }
        floor.extend(opposite);
        return heading;
    }
    (heading - dice.in_range(0.0, 0.5) * Vec3::Y).normalize()
}

/// What slides, on its lowest corner or face at height 0, and its highest corner.
fn lying(dice: &mut Dice) -> (Actor, f32) {
    let form = slider(dice);
    let heights = broken::hull_of(&form);
    let heights = heights.vertices().iter().map(|v| v.y);
    let (low, high) = heights.fold((f32::MAX, f32::MIN), |(low, high), y| {
        (low.min(y), high.max(y))
    });
    let mut body = Actor::new(form, -low * Vec3::Y);
    if once_in(dice, 3) {
        body.pose.rotation = Quat::from_xyzw(0.0, dice.in_range(-1.0, 1.0), 0.0, 1.0).normalize();
    }
    (body, high - low)
}

pub(super) fn slides(dice: &mut Dice) -> Draft {
    let speed = log_range(dice, 0.03, 16.0);
    let friction = if once_in(dice, 2) {
        0.0
    } else {
        dice.in_range(0.05, 0.8)
    };
    let way = if speed > 3.0 { 12.0 } else { 4.0 };
    // Along the tiles or askew to them.
    let heading = match dice.below(3) {
        0 => Vec3::X,
        _ => (dice.direction().abs() * Vec3::new(1.0, 0.0, 1.0)).normalize_or(Vec3::X),
    };
    let size = Vec2::new(4.0 + way * heading.x, 4.0 + way * heading.z);
    let mut actors = floors(dice, size);
    let (mut body, height) = lying(dice);
    body.pose.position += Vec3::new(2.0, 0.0, 2.0);
    body.linear = speed * heading;
    let (mut down, mut time) = (Vec3::NEG_Y, (way / speed).min(30.0));
    match dice.below(5) {
        0 => {
            down = set_upright(dice, &mut actors, heading, height);
            // Until it has fallen all the way.
            time = time.min((2.0 * way + speed * speed).sqrt() - speed);
        }
        1 if friction == 0.0 => set_down(&mut actors),
        _ => {}
    }
    actors.push(body);
    set_material(&mut actors, friction, 0.0);
    Draft {
        actors,
        time,
        laws: vec![Law::Finite, Law::Seam],
        min_steps_per_unit: COARSEST,
        soft: 0,
        down,
    }
}

/// A box that slides too slowly to get over a ledge of 1e-3 to 0.3 of its size, however it tips: the ledge stops it.
pub(super) fn ledges(dice: &mut Dice) -> Draft {
    let ledge = log_range(dice, 1e-3, 0.3);
    // With less than half of the energy that lifting it over takes.
    let speed = ledge.sqrt() * dice.in_range(0.1, 1.0);
    let size = Vec3::new(1.0, log_range(dice, 0.4, 1.0), 1.0);
    let mut body = Actor::new(Form::Box(size), 0.5 * size.y * Vec3::Y);
    body.linear = speed * Vec3::X;
    let way = dice.in_range(0.1, 1.0);
    let wall = Form::Box(Vec3::new(0.2, 1.0, 10.0));
    let at = Vec3::new(0.5 + way + 0.1, ledge - 0.5, 0.0);
    let mut actors = vec![piles::box_floor(), Actor::fixed(wall, at), body];
    set_material(&mut actors, 0.0, 0.0);
    Draft {
        actors,
        time: (3.0 * way / speed).min(60.0),
        laws: vec![Law::Finite, Law::Energy, Law::Overlap, Law::Tunnel],
        min_steps_per_unit: COARSEST,
        soft: 0,
        down: Vec3::NEG_Y,
    }
}
