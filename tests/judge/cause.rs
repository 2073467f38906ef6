//! No motion without cause: what touches nothing moves as if nothing were there.
//!
//! The scene is run without what is passed by. Where every body's way, the hull of its corners before and after each step,
//! stays clear of that by a thousandth of the body's size and by how far corners bulge out of their chords, the run with
//! it has to give the same velocities, up to rounding: a body near another is moved in sub-steps, of which each may round.

use super::laws::{Breach, Law};
use super::run::{Run, State};
use super::scene::{Role, Scene};
use super::solid::Solid;
use bevy_cleave::geometry::ConvexHull;
use bevy_cleave::math::Pose;
use glam::Vec3;

/// Velocity that may be gained, as a share of the fastest point's.
const VELOCITY: f64 = 1e-3;

/// How clear the way must be, as a share of the largest extent.
const CLEAR: f64 = 1e-3;

pub(crate) fn judge(scene: &Scene) -> Option<Breach> {
    let (near, alone) = (scene.version(Role::Here), scene.version(Role::There));
    let mut runs = [Run::new(&near, false)?, Run::new(&alone, false)?];
    let obstacles = Obstacles::new(&runs[0]);
    let mut worst: Option<Breach> = None;
    for step in 1..=scene.steps {
        let before = free_states(&runs[1]);
        runs.iter_mut().for_each(Run::step);
        let [near, alone] = &runs;
        let after = free_states(alone);
        for ((i, before), (_, after)) in before.iter().zip(&after) {
            if !obstacles.is_clear(alone, *i, [before, after]) {
                return None;
            }
        }
        let found = free_states(near).into_iter().zip(&after);
        for ((i, found), (_, right)) in found {
            let excess = deflection(near, i, [&found, right]) / VELOCITY;
            if excess > worst.as_ref().map_or(1.0, |worst| worst.excess) {
                let share = VELOCITY * excess;
                worst = Some(Breach {
                    law: Law::Cause,
                    excess,
                    what: format!("body {i}: velocity changed by {share:.1e} until step {step}"),
                });
            }
        }
    }
    worst
}

/// Motion of the bodies of both versions, with their numbers in the version.
fn free_states(run: &Run<'_>) -> Vec<(usize, State)> {
    let both = run.dynamic().filter(|(_, _, a)| a.role == Role::Both);
    both.map(|(i, slot, _)| (i, run.state(slot))).collect()
}

/// Difference of two velocities as a share of the fastest point's.
fn deflection(run: &Run<'_>, i: usize, [found, right]: [&State; 2]) -> f64 {
    let (_, radius) = run.size(run.slots[i]);
    let off =
        (found.linear - right.linear).length() + radius * (found.angular - right.angular).length();
    let speed = right.linear.length() + radius * right.angular.length();
    off / speed.max(f64::MIN_POSITIVE)
}

/// What is passed by.
struct Obstacles(Vec<Solid>);

impl Obstacles {
    fn new(run: &Run<'_>) -> Self {
        let here = run.scene.actors.iter().zip(&run.slots);
        let here = here.filter(|(actor, _)| actor.role == Role::Here);
        Self(here.filter_map(|(_, &slot)| run.solid(slot)).collect())
    }

    /// Whether a body that went from one state to another in a step came near none of them.
    fn is_clear(&self, run: &Run<'_>, i: usize, way: [&State; 2]) -> bool {
        let mesh = run.simulation.bodies.convex(run.slots[i]);
        let Some(hull) = mesh.map(|mesh| mesh.hull()) else {
            return false;
        };
        let (_, radius) = run.size(run.slots[i]);
        let h = f64::from(run.scene.step_length());
        let turn = h * way[0].angular.length().max(way[1].angular.length());
        // A corner that turns by an angle a on radius r leaves its chord by r (1 - cos(a / 2)) <= r a^2 / 8.
        let margin =
            CLEAR * f64::from(hull.aabb().extents().max_element()) + radius * turn * turn / 8.0;
        let corners = way.iter().flat_map(|state| {
            let vertices = hull.vertices().iter();
            vertices.map(|v| state.pose.transform_point(*v))
        });
        let corners: Vec<Vec3> = corners.collect();
        let Ok(swept) = ConvexHull::from_points(&corners) else {
            return false;
        };
        let swept = Solid::new(&swept, &Pose::IDENTITY);
        self.0
            .iter()
            .all(|solid| solid.separation(&swept, margin) >= margin)
    }
}
