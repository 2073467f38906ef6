//! What a step costs when all bodies sleep, against the same scene awake: 10 000 cubes in columns of five.
#![allow(
    missing_docs,
    reason = "criterion's macros make undocumented functions"
)]

#[path = "../tests/plugin/app.rs"]
mod app;
#[path = "../tests/common/mod.rs"]
mod common;

use bevy_cleave::prelude::*;
use common::structures;
use criterion::{Criterion, criterion_group, criterion_main};
use glam::Vec3;

/// Length of a step, s.
const H: f32 = 1.0 / 60.0;

/// Columns in each of the two horizontal directions.
const COLUMNS: (usize, usize) = (50, 40);

/// Steps after which all columns rest.
const SETTLED: usize = 60;

fn columns() -> Vec<BodyDesc> {
    let column = structures::tower(5);
    let places = (0..COLUMNS.0)
        .flat_map(|i| (0..COLUMNS.1).map(move |k| 2.0 * Vec3::new(i as f32, 0.0, k as f32)));
    let cubes = places.flat_map(|place| {
        column[1..].iter().cloned().map(move |mut desc| {
            desc.pose.position += place;
            desc
        })
    });
    std::iter::once(column[0].clone()).chain(cubes).collect()
}

fn sleep(enabled: bool) -> SolverConfig {
    SolverConfig {
        sleep: SleepConfig {
            enabled,
            ..SleepConfig::default()
        },
        ..SolverConfig::default()
    }
}

fn name(enabled: bool) -> &'static str {
    if enabled { "asleep" } else { "awake" }
}

fn plain(c: &mut Criterion) {
    for enabled in [false, true] {
        let mut simulation = Simulation {
            config: sleep(enabled),
            ..Default::default()
        };
        for desc in columns() {
            simulation.bodies.insert(desc).expect("usable");
        }
        (0..SETTLED).for_each(|_| simulation.step(H));
        let expected = if enabled { 10_000 } else { 0 };
        assert_eq!(simulation.report.asleep, expected);
        c.bench_function(&format!("sleep/plain/{}", name(enabled)), |b| {
            b.iter(|| simulation.step(H));
        });
    }
}

/// The whole update of an app: besides the physics that is Bevy's schedule of about 20 us.
fn plugin(c: &mut Criterion) {
    for enabled in [false, true] {
        let mut app = app::app();
        app.insert_resource(sleep(enabled));
        for desc in columns() {
            app.world_mut().spawn_body(desc);
        }
        (0..SETTLED).for_each(|_| app.update());
        let expected = if enabled { 10_000 } else { 0 };
        assert_eq!(app.world().resource::<StepReport>().asleep, expected);
        c.bench_function(&format!("sleep/plugin/{}", name(enabled)), |b| {
            b.iter(|| app.update());
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = plain, plugin
}
criterion_main!(benches);
