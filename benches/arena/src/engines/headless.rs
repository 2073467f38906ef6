//! The app around a physics plugin, the same for every engine that is one: a clock and a pool of threads, nothing else.

use bevy_app::{App, TaskPoolOptions, TaskPoolPlugin, TaskPoolThreadAssignmentPolicy};
use bevy_ecs::schedule::{Schedules, SingleThreadedExecutor};
use bevy_tasks::ComputeTaskPool;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use std::time::Duration;

/// An app in which each update is one frame of `dt` seconds, with a compute pool of `pool_threads`.
///
/// The plugin belongs into `PostUpdate`: an update is a step then, without the loop that fits fixed steps to frames.
pub(crate) fn app(dt: f32, pool_threads: usize) -> App {
    let pool = |threads| TaskPoolThreadAssignmentPolicy {
        min_threads: threads,
        max_threads: threads,
        percent: 0.0,
        on_thread_spawn: None,
        on_thread_destroy: None,
    };
    let task_pool_options = TaskPoolOptions {
        io: pool(1),
        async_compute: pool(1),
        compute: pool(pool_threads),
        ..Default::default()
    };
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin { task_pool_options }, TimePlugin));
    let frame = Duration::from_secs_f32(dt);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(frame));
    app
}

/// Ends the building of the app; the first tick of the clock is empty.
///
/// Without threads in the pool its schedules run on the calling thread: to hand systems to a pool that nobody else serves
/// would only add to the time of every engine that is a plugin.
pub(crate) fn start(app: &mut App) {
    if ComputeTaskPool::get().thread_num() == 0 {
        for (_, schedule) in app.world_mut().resource_mut::<Schedules>().iter_mut() {
            schedule.set_executor(SingleThreadedExecutor::new());
        }
    }
    app.finish();
    app.cleanup();
    app.update();
}
