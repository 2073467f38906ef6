//! Bodies put above each other without touching, and floors below them.

use super::log_range;
use crate::judge::dice::Dice;
use crate::judge::scene::{Actor, Form};
use crate::judge::solid::Solid;
use bevy_cleave::prelude::*;
use glam::{DVec3, Quat, Vec3};

/// Half the width of floors that end.
const HALF_FLOOR: f32 = 30.0;

/// A floor at height 0: a half-space, a large box or flush tiles.
pub(crate) fn floor(dice: &mut Dice) -> Vec<Actor> {
    match dice.below(10) {
        0..=5 => vec![Actor::fixed(Form::HalfSpace(Vec3::Y), Vec3::ZERO)],
        6..=8 => vec![box_floor()],
        _ => tiles(dice.in_range(1.0, 3.0)),
    }
}

/// A large box with its upper face at height 0.
pub(crate) fn box_floor() -> Actor {
    let size = Vec3::new(2.0 * HALF_FLOOR, 2.0, 2.0 * HALF_FLOOR);
    Actor::fixed(Form::Box(size), -Vec3::Y)
}

/// Six by six flush boxes below the pile, and large ones around them.
fn tiles(size: f32) -> Vec<Actor> {
    let tile = |x: usize, z: usize| {
        let [x, z] = [x, z].map(|i| (i as f32 - 2.5) * size);
        let form = Form::Box(Vec3::new(size, 2.0, size));
        Actor::fixed(form, Vec3::new(x, -1.0, z))
    };
    let inner = (0..36).map(|i| tile(i % 6, i / 6));
    let (half, width) = (3.0 * size, HALF_FLOOR);
    let sides = [-1.0_f32, 1.0].into_iter().flat_map(|side| {
        let off = side * (half + 0.5 * width);
        [
            (Vec3::new(width, 2.0, 2.0 * half), Vec3::new(off, -1.0, 0.0)),
            (
                Vec3::new(2.0 * (half + width), 2.0, width),
                Vec3::new(0.0, -1.0, off),
            ),
        ]
    });
    let outer = sides.map(|(size, at)| Actor::fixed(Form::Box(size), at));
    inner.chain(outer).collect()
}

/// A body where nothing else is, as low as it goes in steps of a third of its radius above `gap`.
pub(crate) struct Pile {
    placed: Vec<Solid>,
    pub(crate) actors: Vec<Actor>,
}

impl Pile {
    pub(crate) fn new() -> Self {
        Self {
            placed: Vec::new(),
            actors: Vec::new(),
        }
    }

    /// Puts a body with the given rotation above (x, z).
    pub(crate) fn put(&mut self, form: Form, [x, z]: [f32; 2], rotation: Quat, gap: f32) {
        let shape = form.shape().expect("the forms of piles are usable");
        let at = |y: f32| Pose::new(Vec3::new(x, y, z), rotation);
        let solid = |y: f32| Solid::of(&shape, &at(y)).expect("they have an inside");
        let lowest = solid(0.0).lowest(DVec3::Y) as f32;
        let size = match &shape {
            Shape::Convex(mesh) => mesh.aabb().extents().min_element(),
            _ => 0.5 * form.radius(),
        };
        let clear = 0.05 * f64::from(size);
        let mut y = gap + 0.05 * size - lowest;
        loop {
            let solid = solid(y);
            if self
                .placed
                .iter()
                .all(|other| solid.separation(other, clear) >= clear)
            {
                self.placed.push(solid);
                break;
            }
            y += form.radius() / 3.0;
        }
        let mut actor = Actor::new(form, Vec3::ZERO);
        actor.pose = at(y);
        self.actors.push(actor);
    }

    /// Height of the highest corner.
    pub(crate) fn top(&self) -> f32 {
        let top = |solid: &Solid| -solid.lowest(-DVec3::Y) as f32;
        self.placed.iter().map(top).fold(0.0, f32::max)
    }
}

/// A heap of the given shapes, turned at random, within `width`.
pub(crate) fn heap(dice: &mut Dice, forms: Vec<Form>, width: f32) -> Pile {
    let mut pile = Pile::new();
    let gap = log_range(dice, 0.01, 1.0);
    for form in forms {
        let place = [(); 2].map(|()| 0.5 * width * dice.in_range(-1.0, 1.0));
        let rotation = dice.rotation();
        pile.put(form, place, rotation, gap);
    }
    pile
}
