//! The plugin of characters that walk.

use crate::ecs::joint::read_joints;
use crate::ecs::walker::{WalkersMove, check_walkers, walk};
use crate::plugin::{PhysicsSchedule, PhysicsSystems};
use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

/// Moves [`Walker`](crate::ecs::Walker)s in each step, at the end of [`PhysicsSystems::MassProperties`]: what moves by velocity or
/// `Transform` is known then. In an app without it they have an issue, and do nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct WalkerPlugin;

impl Plugin for WalkerPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<WalkersMove>();
        app.add_systems(
            PhysicsSchedule,
            (check_walkers, walk)
                .chain()
                .in_set(PhysicsSystems::MassProperties)
                .after(read_joints),
        );
    }
}
