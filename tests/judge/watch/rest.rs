//! What is passive comes to rest, and what rests sleeps, within the time that the scene is given.
//!
//! The time is the generator's: so many times what a fall from the scene's height takes. A body rests on its floor, which may
//! move or turn, when in the last quarter of that time no point of it was ever faster than 1 % of `sqrt(g L)` with its least
//! extent `L`, which is the speed after a fall by half of `L`: the limit of sleep.

use super::Worst;
use crate::judge::laws::{Breach, Law};
use crate::judge::run::{Run, State};
use crate::judge::scene::Form;
use glam::DVec3;

/// Fastest speed at rest, as a share of `sqrt(g L)`.
const SPEED: f64 = 0.01;

/// Steps that are run after all have fallen asleep: nothing is to wake them.
const AFTER: u32 = 10;

pub(super) struct Rest {
    /// Slot of the floor that the bodies rest on, if it moves.
    floor: Option<u32>,
    /// For how many steps all have slept.
    asleep: u32,
    worst: Worst,
}

impl Rest {
    pub(super) fn new(run: &Run<'_>) -> Self {
        let actors = run.scene.actors.iter().zip(&run.slots);
        let mut moving = actors.filter(|(actor, _)| {
            !actor.is_dynamic() && (actor.linear, actor.angular) != Default::default()
        });
        Self {
            floor: moving.next().map(|(_, &slot)| slot),
            asleep: 0,
            worst: Worst::default(),
        }
    }

    pub(super) fn look(&mut self, run: &Run<'_>, step: u32) {
        let all_sleep = run
            .dynamic()
            .all(|(_, slot, _)| run.simulation.bodies.is_asleep(slot) || is_off(run, slot));
        self.asleep = if all_sleep { self.asleep + 1 } else { 0 };
        let is_late = 4 * (run.scene.steps - step) <= run.scene.steps;
        if is_late && run.scene.has(Law::Rest) {
            self.measure(run, step);
        }
    }

    fn measure(&mut self, run: &Run<'_>, step: u32) {
        let floor = self.floor.map(|slot| run.state(slot));
        let gravity = f64::from(run.scene.gravity.length());
        for (i, slot, _) in run.dynamic() {
            if is_off(run, slot) {
                continue;
            }
            let state = run.state(slot);
            let (min_extent, _) = run.size(slot);
            let (carried, turned) = floor.map_or((DVec3::ZERO, DVec3::ZERO), |floor| {
                let arm = state.center - floor.center;
                (floor.linear + floor.angular.cross(arm), floor.angular)
            });
            let speed = fastest(run, slot, &state, carried, turned);
            self.worst
                .note(speed / (SPEED * (gravity * min_extent).sqrt()), step, i);
        }
    }

    /// Whether nothing will happen any more.
    pub(super) fn is_over(&self) -> bool {
        self.asleep >= AFTER
    }

    pub(super) fn breach(&self, run: &Run<'_>) -> Option<Breach> {
        if self.is_over() {
            return None;
        }
        let moves = self.worst.breach(Law::Rest, |worst| {
            let share = SPEED * worst.excess;
            format!(
                "body {} moves with {share:.2} of sqrt(g L) in step {}",
                worst.actor, worst.step
            )
        });
        let asleep = run.simulation.bodies.asleep();
        let bodies = run.dynamic().count();
        moves.or_else(|| {
            run.scene.has(Law::Sleep).then(|| Breach {
                law: Law::Sleep,
                excess: 1.0,
                what: format!("{asleep} of {bodies} bodies sleep in the end"),
            })
        })
    }
}

/// Speed of a body's fastest corner, seen from a floor that moves and turns there.
fn fastest(run: &Run<'_>, slot: u32, state: &State, carried: DVec3, turned: DVec3) -> f64 {
    let corners = run
        .solid(slot)
        .map(|solid| solid.corners().collect::<Vec<_>>());
    let speeds = corners.into_iter().flatten().map(|corner| {
        let arm = corner - state.center;
        (state.linear - carried + (state.angular - turned).cross(arm)).length()
    });
    speeds.fold(0.0, f64::max)
}

/// Whether a body of a scene that is to come to rest is beyond the edges of all floors. What got through one is not.
fn is_off(run: &Run<'_>, slot: u32) -> bool {
    if !run.scene.has(Law::Rest) {
        return false;
    }
    let center = run.state(slot).center.as_vec3();
    let floors = run.scene.actors.iter().zip(&run.slots);
    let mut floors = floors.filter(|(actor, _)| !actor.is_dynamic());
    floors.all(|(actor, &floor)| {
        let pose = run.simulation.bodies.pose(floor);
        let at = pose.inverse_transform_point(center);
        match &actor.form {
            Form::Box(size) => at.x.abs() > 0.5 * size.x || at.z.abs() > 0.5 * size.z,
            Form::Ground(ground) => {
                let [x, z] = ground.extent();
                !((0.0..x).contains(&at.x) && (0.0..z).contains(&at.z))
            }
            _ => false,
        }
    })
}
