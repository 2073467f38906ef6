//! A body that lies on one of its edges is borne all along it: which of the two ends is lower, by rounding or by a thousandth of the body's
//! thickness, does not decide where it is touched. Otherwise it rolls off the end that is left for a step, and back in the next one.

#![expect(clippy::print_stdout, reason = "the measured figures are the result")]

use crate::common::dice::Dice;
use bevy_cleave::contact::{LocalManifold, NarrowScratch, collide_hulls};
use bevy_cleave::geometry::{ConvexHull, ConvexMesh};
use bevy_cleave::math::Pose;
use glam::{Quat, Vec3};

/// Members of the family.
const PAIRS: u32 = 8000;

/// How far apart, as a share of the thinner body's least extent, points are that are the same.
const SAME: f32 = 0.1;

/// A needle, a flat splinter, a rod, a prism, a hull or a box.
fn form(dice: &mut Dice) -> ConvexMesh {
    let share = dice.in_range(0.31, 1.0);
    let thickness = 0.1 * share * share * share;
    let made = match dice.below(6) {
        0 => {
            let mut corners: Vec<Vec3> = (0..3 + dice.below(4))
                .map(|_| {
                    let across = dice.direction().with_x(0.0).normalize_or(Vec3::Y);
                    dice.in_range(-0.2, 0.2) * Vec3::X + 0.5 * thickness * across
                })
                .collect();
            corners.extend([-0.5 * Vec3::X, 0.5 * Vec3::X]);
            ConvexMesh::from_points(&corners)
        }
        1 => {
            let size = Vec3::new(1.0, thickness, dice.in_range(0.1, 1.0));
            let corners: Vec<Vec3> = (0..8).map(|_| 0.5 * size * dice.direction()).collect();
            ConvexMesh::from_points(&corners)
        }
        2 => ConvexMesh::cuboid(1.0, thickness, thickness * dice.in_range(0.5, 1.0)),
        3 => ConvexMesh::regular_prism(3 + dice.below(9) as u32, thickness, 1.0),
        4 => {
            let corners: Vec<Vec3> = (0..4 + dice.below(20))
                .map(|_| 0.5 * dice.direction())
                .collect();
            ConvexMesh::from_points(&corners)
        }
        _ => ConvexMesh::cuboid(dice.in_range(0.2, 1.0), dice.in_range(0.2, 1.0), 0.5),
    };
    made.unwrap_or_else(|_| form(dice))
}

/// A point between some corners of a hull.
fn between(hull: &ConvexHull, corners: &[u32], dice: &mut Dice) -> Vec3 {
    let corners = corners
        .iter()
        .map(|&corner| hull.vertices()[corner as usize]);
    let weighed: Vec<_> = corners.map(|at| (dice.in_range(0.05, 1.0), at)).collect();
    let total: f32 = weighed.iter().map(|(weight, _)| weight).sum();
    weighed.iter().map(|(weight, at)| weight / total * at).sum()
}

/// Where B lies with one of its edges on a face of A, in A's frame, and a point where they touch.
fn lay(a: &ConvexHull, b: &ConvexHull, dice: &mut Dice) -> (Pose, Vec3) {
    let face = &a.faces()[dice.below(a.faces().len())];
    let at = between(a, a.face_loop(face), dice);
    let edge = &b.edges()[dice.below(b.edges().len())];
    let weight = dice.in_range(0.1, 0.9);
    let [first, second] = edge.faces.map(|face| b.faces()[face as usize].plane.normal);
    let down = (weight * first + (1.0 - weight) * second).normalize();
    let spin = Quat::from_axis_angle(face.plane.normal, dice.in_range(0.0, 6.0));
    let turn = spin * Quat::from_rotation_arc(down, -face.plane.normal);
    (
        Pose::new(at - turn * between(b, &edge.vertices, dice), turn),
        at,
    )
}

/// How far a point is outside of those of a contact, across its normal, m.
fn outside(point: Vec3, contact: &LocalManifold) -> f32 {
    let across = contact.normal.any_orthonormal_vector();
    let ways = (0..32_u8).map(|i| {
        let angle = f32::from(i) / 32.0 * std::f32::consts::TAU;
        let way = Quat::from_axis_angle(contact.normal, angle) * across;
        let heights = contact.points().iter().map(|p| way.dot(point - p.on_a));
        heights.fold(f32::INFINITY, f32::min)
    });
    ways.fold(f32::NEG_INFINITY, f32::max)
}

#[test]
fn what_lies_on_an_edge_is_touched_at_both_ends_whichever_is_lower() {
    let mut dice = Dice::new(61);
    let (mut compared, mut lost) = (0, Vec::new());
    for pair in 0..PAIRS {
        let (a, b) = (form(&mut dice), form(&mut dice));
        let (a, b) = (a.hull(), b.hull());
        let thinner = [a, b].map(|hull| hull.aabb().extents().min_element());
        let least = thinner[0].min(thinner[1]);
        let (pose, at) = lay(a, b, &mut dice);
        let reach = b.aabb().extents().length();
        let contacts = [(); 2].map(|()| {
            let turn = Quat::from_scaled_axis(3e-3 * least / reach * dice.direction());
            let tilted = Pose::new(
                at + turn * (pose.position - at),
                (turn * pose.rotation).normalize(),
            );
            collide_hulls(a, b, tilted, 0.1 * least, &mut NarrowScratch::new())
        });
        let [Some(first), Some(second)] = contacts else {
            continue;
        };
        // Of more than four points some are left out.
        if first.points().len().max(second.points().len()) == 4 {
            continue;
        }
        compared += 1;
        let bearing = first
            .points()
            .iter()
            .filter(|p| p.separation < 0.02 * least);
        let farthest = bearing
            .map(|p| outside(p.on_a, &second))
            .fold(0.0, f32::max);
        if farthest > SAME * least {
            lost.push((pair, farthest / least));
        }
    }
    println!(
        "{compared} pairs, {} of which lose a point that bears",
        lost.len()
    );
    assert!(compared > 4000, "{compared} only");
    // Two of these lie over the edge between two faces of a splinter whose normals differ by 2e-4, and are on either of them.
    assert!(lost.len() <= 2, "{lost:?}");
}
