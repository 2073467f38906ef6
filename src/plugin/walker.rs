//! The plugin of characters that walk.

use crate::ecs::walker::walk;
use crate::plugin::{PhysicsSchedule, PhysicsSystems};
use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

/// Moves [`Walker`](crate::ecs::Walker)s before each step, in [`PhysicsSchedule`]. An app without it does nothing for them.
#[derive(Clone, Copy, Debug, Default)]
pub struct WalkerPlugin;

impl Plugin for WalkerPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PhysicsSchedule, walk.before(PhysicsSystems::MassProperties));
    }
}
