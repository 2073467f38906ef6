//! Error against speed: every method on scenes and on single problems whose answer is known.
//!
//! `cargo run --release --example speed_vs_error` takes some minutes and writes a report (`accuracy.md`), the figures
//! (`results.csv`, `files.csv`) and pictures under `target/speed_vs_error/`. Look for the ring: the default settings; the
//! grey line joins the settings that none beats in both.
//!
//! `-- --quick` runs one setting for each method, in seconds. `-- --publish` writes to `docs/report/` instead, which holds
//! the last committed run.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "an example prints what it measures")]
#![expect(clippy::disallowed_methods, reason = "angles of scenes and logarithms of figures, not part of a step")]

#[path = "../../tests/dice/mod.rs"]
mod dice;
#[path = "../../tests/hard_cases/support.rs"]
mod measure;
#[path = "../../tests/scenes/structures.rs"]
mod structures;
#[path = "../support/mod.rs"]
mod support;

mod pictures;
mod scenes;
mod settings;
mod sweep;

use std::process::ExitCode;
use sweep::Sweep;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("speed_vs_error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), support::Error> {
    let is_quick = std::env::args().any(|a| a == "--quick");
    for scene in scenes::all() {
        if let Ok(only) = std::env::var("ONLY") { if !only.contains(scene.key) { continue; } }
        println!("{}", scene.title);
        let clock = std::time::Instant::now();
        let sweep = Sweep::measure(scene, is_quick, |p| {
            println!("  {:<20} {:>9.4} ms  p99 {:>9.4}  error {:?} contacts {} capped {:.2} steps {}", p.setting.name, p.median, p.p99, p.error, p.contacts, p.capped, p.steps);
        });
        pictures::scene(std::path::Path::new("target/speed_vs_error"), &sweep)?;
        println!("  {:.1} s, front: {:?}", clock.elapsed().as_secs_f64(), sweep.front().iter().map(|p| &p.setting.name).collect::<Vec<_>>());
    }
    Ok(())
}
