//! Where bodies may be in a step lies within the boxes that the broad phase keeps for them, however they move: in steps in
//! which it is told nothing of them too.

use crate::common::dice::Dice;
use crate::common::scenes::awake;
use bevy_cleave::math::Aabb;
use bevy_cleave::prelude::*;
use bevy_cleave::testing::collide::{Lookahead, NarrowPhase, update_pairs};
use bevy_cleave::testing::contact::Broadphase;
use glam::Vec3;

const H: f32 = 1.0 / 60.0;

/// Boxes of all shapes that fly and tumble.
fn bodies(dice: &mut Dice, simulation: &mut Simulation) -> Vec<u32> {
    let mut add = |_| {
        let size = dice.vector(0.05, 2.0);
        let mesh = ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box is valid");
        let mut body = BodyDesc::dynamic(mesh, dice.vector(-400.0, 400.0));
        body.pose.rotation = dice.rotation();
        simulation.bodies.insert(body).expect("usable")
    };
    (0..40).map(&mut add).collect()
}

/// Now and then a body is thrown, nudged or stopped.
fn meddle(dice: &mut Dice, simulation: &mut Simulation, slot: u32) {
    let (linear, angular) = simulation.bodies.velocity(slot);
    let (linear, angular) = match dice.below(60) {
        0 => (50.0 * dice.direction(), 20.0 * dice.direction()),
        1 => (5.0 * dice.direction(), 2.0 * dice.direction()),
        2 => (Vec3::ZERO, Vec3::ZERO),
        3..10 => (linear + 0.5 * dice.direction(), angular),
        _ => return,
    };
    let set = simulation.bodies.set_velocity(slot, linear, angular);
    set.expect("finite velocities");
}

/// The box around the body now and at the end of the step, m.
fn reach(bodies: &Bodies, slot: u32) -> Aabb {
    let pose = bodies.pose(slot);
    let travel = H * bodies.velocity(slot).0;
    let hull = bodies.convex(slot).expect("a hull").hull();
    let mut reach = Aabb::EMPTY;
    for &vertex in hull.vertices() {
        let vertex = pose.transform_point(vertex);
        reach.min = reach.min.min(vertex).min(vertex + travel);
        reach.max = reach.max.max(vertex).max(vertex + travel);
    }
    reach
}

#[test]
fn kept_boxes_hold_what_bodies_may_reach() {
    let mut dice = Dice::new(1);
    let mut simulation = awake();
    let slots = bodies(&mut dice, &mut simulation);
    let (mut broadphase, mut narrow) = (Broadphase::new(), NarrowPhase::default());
    let (mut same, mut moving) = (0, 0);
    for step in 0..600 {
        for &slot in &slots {
            meddle(&mut dice, &mut simulation, slot);
        }
        let before: Vec<_> = slots.iter().map(|&s| broadphase.kept_box(s)).collect();
        let ahead = Lookahead::new(H, simulation.gravity.0);
        update_pairs(&mut broadphase, &mut narrow, &simulation.bodies, ahead);
        for (&slot, before) in slots.iter().zip(before) {
            let kept = broadphase.kept_box(slot).expect("a body that moves");
            let reach = reach(&simulation.bodies, slot);
            assert!(
                kept.contains(&reach),
                "step {step}, body {slot}: {reach:?} beyond {kept:?}"
            );
            moving += 1;
            same += usize::from(before == Some(kept));
        }
        simulation.step(H);
    }
    assert!(3 * same > moving, "{same} boxes of {moving} kept");
}
