//! Bodies cut into pieces by random planes.

use super::forms;
use crate::judge::dice::Dice;
use crate::judge::scene::{Actor, Form};
use bevy_cleave::geometry::ConvexHull;
use bevy_cleave::math::Plane;
use bevy_cleave::prelude::Shape;
use bevy_cleave::slice::slice_hull;
use glam::Vec3;

/// The hull of a form.
pub(crate) fn hull_of(form: &Form) -> ConvexHull {
    let Some(Shape::Convex(mesh)) = form.shape() else {
        unreachable!("the forms that are cut have an inside")
    };
    mesh.hull().clone()
}

/// What `planes` make of a hull.
pub(crate) fn cut(hull: ConvexHull, planes: impl IntoIterator<Item = Plane>) -> Vec<ConvexHull> {
    let mut pieces = vec![hull];
    for plane in planes {
        let cut = pieces.drain(..).flat_map(|piece| {
            let halves = slice_hull(&piece, plane).ok().and_then(|cut| cut.halves());
            match halves {
                Some(halves) => vec![halves.below, halves.above],
                None => vec![piece],
            }
        });
        pieces = cut.collect();
    }
    pieces
}

/// Pieces of a body by planes near its middle; those of less than a thousandth of it are left out.
pub(crate) fn pieces(dice: &mut Dice) -> Vec<ConvexHull> {
    let form = match dice.below(3) {
        0 => forms::round(dice),
        1 => forms::hull(dice),
        _ => forms::cuboid(dice),
    };
    let hull = hull_of(&form);
    let min_volume = 1e-3 * hull.volume();
    let count = 2 + dice.below(3);
    let planes: Vec<Plane> = (0..count)
        .map(|_| Plane::through(0.15 * dice.vector(-1.0, 1.0), dice.direction()))
        .collect();
    let mut pieces = cut(hull, planes);
    pieces.retain(|piece| piece.volume() > min_volume);
    pieces
}

/// A piece as a body, where it is.
pub(crate) fn in_place(piece: &ConvexHull, offset: Vec3) -> Actor {
    let corners = piece.vertices();
    let mean = corners.iter().sum::<Vec3>() / corners.len() as f32;
    Actor::new(forms::centered(corners), mean + offset)
}
