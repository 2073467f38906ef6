//! Going back in time: moments of the physics, kept to be restored.
//!
//! A [`Moment`] holds what is simulated, as it can be copied, and the components by which bodies and joints were described. What breaks while
//! moments are kept does not go: it is [set aside](crate::ecs::set_aside), with all that the app has put on it, to come back with the moment in which it was
//! whole.

mod moment;
mod values;

pub use crate::ecs::rewind::moment::Rewound;

use crate::ecs::rewind::moment::Moment;
use crate::ecs::rewind::values::{Values, ValuesOf, physics_values};
use crate::ecs::set_aside::Aside;
use bevy_app::App;
use bevy_ecs::component::Mutable;
use bevy_ecs::prelude::*;
use std::collections::VecDeque;
use std::fmt;

/// What the physics was at the ends of the last steps, as far as [`RewindPlugin`](crate::plugin::RewindPlugin) keeps it.
///
/// Settings ([`Gravity`](crate::solver::config::Gravity), [`SolverConfig`](crate::solver::config::SolverConfig)), clocks and messages that were
/// sent are not part of it.
#[derive(Resource)]
pub struct PhysicsHistory {
    moments: VecDeque<Moment>,
    /// Most moments.
    limit: usize,
    /// Steps from one to the next.
    interval: u64,
    /// Steps made, without those that were taken back.
    step: u64,
    /// What is kept of entities.
    values: Vec<Box<dyn Values>>,
    /// Whether a step is being made.
    is_in_step: bool,
    /// Steps to go back when it is over.
    asked: Option<u64>,
}

/// Going back.
pub trait RewindCommands {
    /// Takes the physics back to what it was at the end of the step so many steps ago: to the last moment before that which is kept, or
    /// else to the first; at once, or, from within a step, at its end. [`Rewound`] tells what came of it. Without
    /// [`RewindPlugin`](crate::plugin::RewindPlugin) there is nothing to go back to, and a warning is logged.
    fn rewind(&mut self, steps: u64);
}

impl RewindCommands for Commands<'_, '_> {
    fn rewind(&mut self, steps: u64) {
        self.queue(
            move |world: &mut World| match world.get_resource_mut::<PhysicsHistory>() {
                Some(mut history) if history.is_in_step => history.asked = Some(steps),
                Some(_) => go_back(world, steps),
                None => log::warn!("there is nothing to rewind to: the app has no RewindPlugin"),
            },
        );
    }
}

/// What else is taken back with the physics.
pub trait RewindApp {
    /// Lets `C` be what it was, on all entities that had it then and still exist.
    fn rewind_component<C: Component<Mutability = Mutable> + Clone>(&mut self) -> &mut Self;
}

impl RewindApp for App {
    fn rewind_component<C: Component<Mutability = Mutable> + Clone>(&mut self) -> &mut Self {
        if let Some(mut history) = self.world_mut().get_resource_mut::<PhysicsHistory>() {
            history.values.push(ValuesOf::<C, ()>::boxed());
        } else {
            log::warn!("add RewindPlugin before what is to be rewound");
        }
        self
    }
}

impl fmt::Debug for PhysicsHistory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PhysicsHistory")
            .field("moments", &self.moments.len())
            .field("step", &self.step)
            .finish_non_exhaustive()
    }
}

impl PhysicsHistory {
    /// Keeps at most `limit` moments, one in each `interval` steps.
    pub(crate) fn new(limit: usize, interval: u64) -> Self {
        Self {
            moments: VecDeque::new(),
            limit: limit.max(1),
            interval: interval.max(1),
            step: 0,
            values: physics_values(),
            is_in_step: false,
            asked: None,
        }
    }

    /// Forgets all moments: before them is nothing to go back to.
    pub fn clear(&mut self) {
        self.moments.clear();
    }

    /// Number of moments.
    pub fn len(&self) -> usize {
        self.moments.len()
    }

    /// Whether there is nothing to go back to.
    pub fn is_empty(&self) -> bool {
        self.moments.is_empty()
    }

    /// How many steps ago the first of them was.
    pub fn reach(&self) -> u64 {
        self.moments
            .front()
            .map_or(0, |first| self.step - first.step)
    }

    /// Notes the end of a step.
    fn end_step(&mut self, world: &mut World) {
        self.step += 1;
        if self.step.is_multiple_of(self.interval) {
            self.moments
                .push_back(Moment::take(world, self.step, &mut self.values));
            if self.moments.len() > self.limit {
                self.moments.pop_front();
            }
        }
        let first = self.moments.front().map_or(self.step, |first| first.step);
        let mut aside = world.resource_mut::<Aside>();
        aside.steps = self.step;
        for entity in aside.take_until(first) {
            // It may have been despawned by the app.
            if let Ok(entity) = world.get_entity_mut(entity) {
                entity.despawn();
            }
        }
    }

    /// Restores the last moment that is so many steps ago, or else the first; later ones are forgotten.
    fn go_back(&mut self, world: &mut World, steps: u64) -> Option<Rewound> {
        let last = self.step.saturating_sub(steps);
        let after = self.moments.partition_point(|moment| moment.step <= last);
        self.moments.truncate(after.max(1));
        let moment = self.moments.back()?;
        let steps = self.step - moment.step;
        self.step = moment.step;
        let mut aside = world.resource_mut::<Aside>();
        aside.steps = self.step;
        let aside = aside.take_after(self.step);
        Some(moment.restore(world, steps, aside))
    }
}

/// System: a step begins.
pub(crate) fn begin_step(mut history: ResMut<PhysicsHistory>) {
    history.is_in_step = true;
}

/// System: a step is over.
pub(crate) fn end_step(world: &mut World) {
    world.resource_scope(|world, mut history: Mut<PhysicsHistory>| {
        history.is_in_step = false;
        history.end_step(world);
    });
    if let Some(steps) = world.resource_mut::<PhysicsHistory>().asked.take() {
        go_back(world, steps);
    }
}

fn go_back(world: &mut World, steps: u64) {
    let rewound = world
        .resource_scope(|world, mut history: Mut<PhysicsHistory>| history.go_back(world, steps));
    if let Some(rewound) = rewound {
        world.trigger(rewound.clone());
        world.write_message(rewound);
    }
}
