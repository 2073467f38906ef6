//! Round shapes and characters that walk: a program of their own, which takes half a minute by itself.
#![expect(
    clippy::print_stdout,
    reason = "the figures that the documents tell are printed"
)]

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/hierarchy.rs"]
mod hierarchy;

mod crowds;
mod cutting;
mod heaps;
mod mass;
mod queries;
mod rest;
mod rolling;
mod walker_company;
mod walker_laws;
mod walker_places;
mod walker_rides;
mod walker_rooms;
mod walker_stage;
mod walking;
mod walking_anywhere;

use bevy_cleave::prelude::*;
use common::dice::Dice;

/// A round shape of some kind and size, between 0.2 m and 1 m across.
fn any_shape(dice: &mut Dice) -> ConvexMesh {
    let [a, b] = [(); 2].map(|()| dice.in_range(0.1, 0.4));
    match dice.below(5) {
        0 => ConvexMesh::sphere(a),
        1 => ConvexMesh::capsule(a, 2.0 * b),
        2 => ConvexMesh::cylinder(a, 2.0 * b),
        3 => ConvexMesh::cone(a, 2.0 * b),
        _ => ConvexMesh::cuboid(a, b, 0.3).and_then(|cuboid| cuboid.rounded(0.25 * a.min(b))),
    }
    .expect("usable sizes")
}
