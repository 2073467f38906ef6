//! Ten minutes of steady destruction: does the step stay as long as it is?
//!
//! `cargo run --release --example soak [MINUTES]` drops a block that breaks every half a second, on pieces of those before, and lets the
//! oldest pieces go when there are more than 600. It prints `name: value` lines and writes a plot of the time of a step under
//! `target/soak/`. Look at the last minute beside the second one: nothing may grow, and no step may stand out. Times are those of the thread,
//! so that what else runs on the machine does not show.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "an example prints what it shows"
)]

#[path = "support/mod.rs"]
mod support;

use bevy_cleave::prelude::*;
use cpu_time::ThreadTime;
use glam::Vec3;
use std::path::Path;
use std::process::ExitCode;
use support::plot::{Panel, time_series};
use support::stats;

const FOLDER: &str = "target/soak";
const H: f32 = 1.0 / 60.0;

/// Steps between two blocks.
const EVERY: usize = 30;

/// Steps of a point of the plot: 5 s.
const WINDOW: usize = 300;

fn main() -> ExitCode {
    match soak() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("soak: {error}");
            ExitCode::FAILURE
        }
    }
}

fn soak() -> Result<(), support::Error> {
    let minutes: f64 = match std::env::args().nth(1) {
        Some(text) => text.parse()?,
        None => 10.0,
    };
    let mut simulation = Simulation::default();
    let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    simulation.bodies.insert(floor)?;
    simulation.config.sleep = SleepConfig::default();
    simulation.budget.debris = DebrisRules {
        max_pieces: 600,
        dust_volume: 1e-4,
        fade: 0.5,
        ..DebrisRules::default()
    };
    let (mut times, mut counts, mut breaks) = (Vec::new(), Vec::new(), Vec::new());
    let mut work: [Vec<f64>; 2] = Default::default();
    let (mut dropped, mut blocks) = (0.0, 0);
    for step in 0..(minutes * 60.0 / f64::from(H)) as usize {
        if step % EVERY == 0 {
            simulation.bodies.insert(block(blocks)?)?;
            blocks += 1;
        }
        let start = ThreadTime::now();
        simulation.step(H);
        times.push(start.elapsed().as_secs_f64() * 1e3);
        counts.push(simulation.bodies.len() as f64);
        breaks.push(!simulation.fractures.done.is_empty());
        let report = &simulation.report;
        let counted = [report.awake, report.contacts];
        for (counts, count) in work.iter_mut().zip(counted) {
            counts.push(count as f64);
        }
        let ledgers = simulation.fractures.done.iter().map(|f| f.ledger);
        dropped += ledgers.map(|l| l.dropped.mass).sum::<f64>();
    }
    report(&simulation, &times, dropped, blocks)?;
    report_breaks(&times, &breaks);
    report_neighbors(&times, &breaks);
    report_work(&times, &breaks, &work);
    plot(&times, &counts)
}

/// The next block to fall: 125 kg, in a ring about the middle.
fn block(number: usize) -> Result<BodyDesc, support::Error> {
    let turn = [
        (2.0, 0.0),
        (0.6, 1.9),
        (-1.6, 1.2),
        (-1.6, -1.2),
        (0.6, -1.9),
    ][number % 5];
    let shape = ConvexMesh::cuboid(0.5, 0.5, 0.5)?;
    Ok(BodyDesc {
        fracturable: Some(Fracturable {
            strength: 100.0,
            pattern: FracturePattern::Voronoi {
                cells: 16,
                focus: 0.3,
            },
            seed: number as u64,
            ..Fracturable::default()
        }),
        ..BodyDesc::dynamic(shape, Vec3::new(turn.0, 5.0, turn.1))
    })
}

fn report(
    simulation: &Simulation,
    times: &[f64],
    dropped: f64,
    blocks: usize,
) -> Result<(), support::Error> {
    let bodies = &simulation.bodies;
    let there: f64 = bodies
        .iter()
        .map(|slot| f64::from(bodies.mass(slot).mass))
        .sum();
    let removed = simulation.fractures.removed;
    let all = 125.0 * blocks as f64;
    let minute = (60.0 / H).round() as usize;
    let of_minute = |number: usize| times.chunks(minute).nth(number).unwrap_or(times);
    let last = times.len().div_ceil(minute).saturating_sub(1);
    println!("blocks: {blocks}");
    println!("bodies: {}", bodies.len());
    println!("removed_pieces: {}", removed.pieces);
    println!(
        "mass_error_rel: {:.1e}",
        (there + dropped + removed.mass) / all - 1.0
    );
    for (name, number) in [("second", 1), ("last", last)] {
        let times = of_minute(number);
        println!("{name}_minute_step_ms_median: {:.3}", stats::median(times));
        println!(
            "{name}_minute_step_ms_p99: {:.3}",
            stats::percentile(times, 0.99)
        );
    }
    Ok(())
}

/// Steps in which something broke, and the others.
fn report_breaks(times: &[f64], breaks: &[bool]) {
    for (name, broke) in [("breaking", true), ("other", false)] {
        let steps = times.iter().zip(breaks).filter(|(_, b)| **b == broke);
        let times: Vec<f64> = steps.map(|(time, _)| *time).collect();
        println!("{name}_steps: {}", times.len());
        println!("{name}_steps_ms_median: {:.3}", stats::median(&times));
        println!(
            "{name}_steps_ms_p99: {:.3}",
            stats::percentile(&times, 0.99)
        );
        println!("{name}_steps_ms_longest: {:.3}", stats::max(&times));
    }
}

/// How much longer steps are than both of their neighbors, once the scene is full.
fn report_neighbors(times: &[f64], breaks: &[bool]) {
    let first = times.len() / 4;
    let inner = first.max(1)..times.len().saturating_sub(1);
    let over = |i: usize| times[i] / times[i - 1].max(times[i + 1]);
    for (name, broke) in [("breaking", true), ("other", false)] {
        let steps = inner.clone().filter(|&i| breaks[i] == broke);
        let over: Vec<f64> = steps.map(over).collect();
        let spikes = over.iter().filter(|&&over| over > 1.5).count();
        println!("{name}_steps_over_1.5_of_both_neighbors: {spikes}");
        println!("{name}_steps_over_neighbors_most: {:.2}", stats::max(&over));
    }
}

/// What sets steps apart in which nothing broke: how much of the scatter of their times goes with the bodies that are awake and with the contacts;
/// and how many of these there are in the longest hundredth beside the median.
fn report_work(times: &[f64], breaks: &[bool], work: &[Vec<f64>; 2]) {
    // Not while the scene fills.
    let first = times.len() / 4;
    let others: Vec<usize> = (first..times.len()).filter(|&i| !breaks[i]).collect();
    let of = |values: &[f64]| others.iter().map(|&i| values[i]).collect::<Vec<_>>();
    let times = of(times);
    let least = stats::percentile(&times, 0.99);
    for (name, work) in ["awake", "contacts"].iter().zip(work) {
        let work = of(work);
        let longest = times.iter().zip(&work).filter(|(time, _)| **time >= least);
        let longest: Vec<f64> = longest.map(|(_, work)| *work).collect();
        println!("{name}_determination: {:.3}", determination(&work, &times));
        println!("{name}_median: {:.0}", stats::median(&work));
        println!("{name}_of_longest_median: {:.0}", stats::median(&longest));
    }
}

/// Share of the variance of `y` that goes with `x` linearly.
fn determination(x: &[f64], y: &[f64]) -> f64 {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (a, b) = (mean(x), mean(y));
    let sum = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        x.iter().zip(y).map(|(x, y)| f(x - a, y - b)).sum()
    };
    let both = sum(&|x, y| x * y);
    both * both / (sum(&|x, _| x * x) * sum(&|_, y| y * y))
}

fn plot(times: &[f64], counts: &[f64]) -> Result<(), support::Error> {
    let series = |values: &[f64], pick: &dyn Fn(&[f64]) -> f64| {
        let windows = values.chunks(WINDOW).enumerate();
        windows
            .map(|(i, window)| ((i * WINDOW) as f64 * f64::from(H), pick(window)))
            .collect::<Vec<_>>()
    };
    let panel = |label: &str, unit: &str, series| Panel {
        label: label.into(),
        unit: unit.into(),
        log: false,
        series,
    };
    let panels = [
        panel("step, median of 5 s", "ms", series(times, &stats::median)),
        panel(
            "step, 99 of 100",
            "ms",
            series(times, &|w| stats::percentile(w, 0.99)),
        ),
        panel("bodies", "", series(counts, &stats::median)),
    ];
    time_series(Path::new(FOLDER).join("plot.png"), "soak", &panels)
}
