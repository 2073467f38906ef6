//! What the plugin costs beside the plain step: the same columns of cubes stepped by both in turn, in one run.
//!
//! Three times are told: `Simulation::step`, one run of `PhysicsSchedule` with everything the plugin does (`Transform`s
//! written back included), and a whole `App::update` less that of an app without the plugin.
#![allow(clippy::print_stdout, reason = "a bench tells its figures")]

#[path = "../tests/plugin/app.rs"]
mod app;
#[path = "../tests/common/mod.rs"]
mod common;

use app::step_length;
use bevy_app::{App, TaskPoolPlugin};
use bevy_cleave::prelude::*;
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy};
use common::structures;
use std::time::Instant;

fn bare_app() -> App {
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin::default(), TimePlugin))
        .insert_resource(Time::<Fixed>::from_duration(step_length()))
        .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    app.finish();
    app.cleanup();
    app.update();
    app
}

fn microseconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1e6
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn compare(count: usize, rounds: usize) {
    let mut plain = Simulation::default();
    plain.config.sleep = SleepConfig::off();
    let (mut updated, mut scheduled, mut bare) = (app::app(), app::app(), bare_app());
    for app in [&mut updated, &mut scheduled] {
        app.world_mut().resource_mut::<SolverConfig>().sleep = SleepConfig::off();
    }
    for desc in structures::columns(count) {
        plain.bodies.insert(desc.clone()).expect("usable");
        updated.world_mut().spawn_body(desc.clone());
        scheduled.world_mut().spawn_body(desc);
    }
    let h = step_length().as_secs_f32();
    // A run of the schedule alone finds the clock of the last update.
    scheduled.update();
    scheduled.world_mut().insert_resource(Time::<()>::default());
    scheduled
        .world_mut()
        .resource_mut::<Time>()
        .advance_by(step_length());
    let mut times = [const { Vec::new() }; 4];
    for _ in 0..rounds {
        times[0].push(microseconds(|| plain.step(h)));
        times[1].push(microseconds(|| {
            scheduled.world_mut().run_schedule(PhysicsSchedule);
        }));
        times[2].push(microseconds(|| updated.update()));
        times[3].push(microseconds(|| bare.update()));
    }
    // The first half lets everything settle and buffers grow.
    let [step, schedule, update, bare] = times.map(|mut t| median(&mut t[rounds / 2..]));
    let share = |time: f64| 100.0 * (time / step - 1.0);
    println!(
        "{count} bodies: step {step:.1} us; schedule {schedule:.1} us, {:+.1} us or {:+.1} %; update less bare app \
         {:.1} us, {:+.1} us or {:+.1} % (bare app {bare:.1} us)",
        schedule - step,
        share(schedule),
        update - bare,
        update - bare - step,
        share(update - bare),
    );
}

fn main() {
    // Without `--bench` it is a test that the bench runs.
    let is_bench = std::env::args().any(|arg| arg == "--bench");
    let cases: &[(usize, usize)] = if is_bench {
        &[(1, 20_000), (50, 4000), (1000, 300), (5000, 500)]
    } else {
        &[(1, 4), (50, 4)]
    };
    for &(count, rounds) in cases {
        compare(count, rounds);
    }
}
