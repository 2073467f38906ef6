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
///
/// ```
/// use bevy_app::App;
/// use bevy_cleave::prelude::*;
/// # use bevy_time::Time;
///
/// let mut app = App::new();
/// app.add_plugins((CleavePlugin::default(), RewindPlugin::default()));
/// # app.init_resource::<Time>();
/// let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box");
/// let cube = app.world_mut().spawn((RigidBody::Dynamic, cube)).id();
/// let step = |app: &mut App| {
///     # app.world_mut().flush();
///     # app.world_mut().resource_mut::<Time>().advance_by(std::time::Duration::from_millis(16));
///     app.world_mut().run_schedule(PhysicsSchedule)
/// };
/// step(&mut app);
/// app.world_mut().commands().slice(cube, Plane::through(Default::default(), bevy_math::Vec3::X));
/// step(&mut app);
/// assert_eq!(app.world().resource::<Bodies>().len(), 2);
/// app.world_mut().commands().rewind(1);
/// app.world_mut().flush();
/// assert_eq!(app.world().resource::<Bodies>().len(), 1); // whole again
/// ```
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
