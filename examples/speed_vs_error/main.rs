//! Error against speed: every method on scenes and on single problems whose answer is known.
//!
//! `cargo run --release --example speed_vs_error` takes some minutes and writes a report (`accuracy.md`), the figures of all
//! runs (`results.csv`) and pictures under `target/speed_vs_error/`. Look for the ring: the default settings; the
//! grey line joins the settings that none beats in both time and error.
//!
//! `-- --quick` runs one setting for each method, in seconds. `-- --publish` writes to `docs/report/` instead, which holds
//! the last committed run.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "an example prints what it shows"
)]
#![expect(
    clippy::disallowed_methods,
    reason = "angles of scenes and logarithms of figures, not part of a step"
)]

#[path = "../../tests/common/dice.rs"]
mod dice;
#[path = "../../tests/it/hard_cases/support.rs"]
mod measure;
#[path = "../../tests/it/mlcp_files/mod.rs"]
mod mlcp_files;
#[path = "../../tests/common/structures.rs"]
mod structures;
#[path = "../support/mod.rs"]
mod support;

mod files;
mod findings;
mod inheritance;
mod machine;
mod order;
mod pictures;
mod report;
mod scenes;
mod settings;
mod sweep;

use files::Files;
use indicatif::{ProgressBar, ProgressStyle};
use report::Results;
use settings::Size;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;
use support::Error;
use sweep::Sweep;

/// Where the report goes.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/target/speed_vs_error");
/// Where it goes to be committed.
const PUBLISHED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/report");

/// Most sweeps on the files, and in the short form.
const MAX_SWEEPS: [usize; 2] = [512, 64];

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("speed_vs_error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Error> {
    let (mut is_quick, mut folder) = (false, FOLDER);
    for argument in std::env::args().skip(1) {
        match argument.as_str() {
            "--quick" => is_quick = true,
            "--publish" => folder = PUBLISHED,
            other => return Err(format!("{other}: only --quick and --publish are known").into()),
        }
    }
    if is_quick && folder == PUBLISHED {
        return Err("the short form is not for publication".into());
    }
    let clock = Instant::now();
    let mut results = measure_all(is_quick)?;
    results.seconds = clock.elapsed().as_secs_f64();
    report::write(Path::new(folder), &results)?;
    println!("{}", report::summary(&results.sweeps));
    println!("{:.0} s; {folder}/accuracy.md", results.seconds);
    Ok(())
}

fn measure_all(is_quick: bool) -> Result<Results, Error> {
    let bar = ProgressBar::new_spinner().with_style(ProgressStyle::with_template(
        "{elapsed_precise} {wide_msg}",
    )?);
    let mut scenes = scenes::all();
    if is_quick {
        scenes.retain(|scene| scene.size != Size::Large);
    }
    let sweeps = scenes.into_iter().map(|scene| {
        let title = scene.title;
        bar.set_message(title);
        bar.tick();
        Sweep::measure(scene, is_quick, |point| {
            bar.set_message(format!("{title}: {} done", point.setting.name));
            bar.tick();
        })
    });
    let sweeps = sweeps.collect();
    let files = Files::measure(MAX_SWEEPS[usize::from(is_quick)], |method| {
        bar.set_message(format!("problems from files: {method}"));
        bar.tick();
    });
    bar.set_message("order of convergence, stiffness, sag");
    bar.tick();
    let results = Results {
        sweeps,
        files,
        orders: order::measure(),
        spikes: inheritance::measure(),
        noise: findings::noise(),
        sag: findings::sag(),
        seconds: 0.0,
        is_quick,
    };
    bar.finish_and_clear();
    Ok(results)
}
