//! The plugin that keeps what was.

use crate::ecs::rewind::{PhysicsHistory, Rewound, begin_step, end_step};
use crate::ecs::set_aside::Aside;
use crate::plugin::{PhysicsSchedule, PhysicsSystems};
use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

/// Keeps moments of the physics in a [`PhysicsHistory`], so that [`commands.rewind`](crate::ecs::RewindCommands::rewind) can go back to them: for
/// games that turn back time, undo, and predict.
///
/// From a moment that was restored the physics goes on to the same bits, as long as the app does the same. A moment costs a copy of all that
/// is simulated; see `docs/features.md`.
#[derive(Clone, Copy, Debug)]
pub struct RewindPlugin {
    /// Most moments that are kept.
    pub moments: usize,
    /// Steps from one to the next.
    pub interval: u64,
}

impl Default for RewindPlugin {
    /// The last five seconds at 60 Hz, each step.
    fn default() -> Self {
        Self {
            moments: 300,
            interval: 1,
        }
    }
}

impl Plugin for RewindPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(PhysicsHistory::new(self.moments, self.interval))
            .init_resource::<Aside>()
            .add_message::<Rewound>()
            .add_systems(
                PhysicsSchedule,
                (
                    begin_step.before(PhysicsSystems::MassProperties),
                    end_step.after(PhysicsSystems::Writeback),
                ),
            );
    }
}
