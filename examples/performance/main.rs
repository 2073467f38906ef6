//! What the kernels cost: instructions counted, and the solver's sweep against the limits of the machine.
//!
//! `cargo run --release --example performance` writes `performance.md` and `counts.csv` to `target/performance/`;
//! `-- --publish` writes them to `docs/report/` instead, which holds the last committed run: the baseline.
//! `-- --compare` only counts instructions and says which kernels are more than 2 % off the baseline.
//!
//! Counting needs `valgrind` (callgrind); without it the counts are left out. They are the same in every run of one build on
//! one machine, whatever else runs beside it, which times are not.
#![expect(
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "an example prints what it shows"
)]

#[path = "../../tests/common/mod.rs"]
mod common;
#[path = "../speed_vs_error/machine.rs"]
mod machine;

mod contacts;
mod counts;
mod kernels;
mod limits;
mod report;
mod roofline;

use common::{scenes as heaps, structures};
use counts::Counts;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// The error of everything here: a sentence for the person who runs the example.
type Error = Box<dyn std::error::Error + Send + Sync>;

/// Where the report goes.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/target/performance");
/// Where it goes to be committed, and where the baseline is.
const PUBLISHED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/report");

/// Length of a step, s.
const H: f32 = 1.0 / 60.0;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("performance: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Error> {
    let mut folder = FOLDER;
    for argument in std::env::args().skip(1) {
        match argument.as_str() {
            "--compare" => return compare(),
            "--publish" => folder = PUBLISHED,
            counts::CHILD => {
                kernels::run_all();
                return Ok(());
            }
            other => return Err(format!("{other}: only --compare and --publish are known").into()),
        }
    }
    let clock = Instant::now();
    let counts = Counts::measure();
    if folder == PUBLISHED {
        counts.as_ref().map_err(|error| error.to_string())?;
    }
    let roofline = roofline::measure();
    let seconds = clock.elapsed().as_secs_f64();
    report::write(Path::new(folder), &counts, &roofline, seconds)?;
    println!("{seconds:.0} s; {folder}/performance.md");
    Ok(())
}

/// Prints the counts beside the baseline.
fn compare() -> Result<(), Error> {
    let baseline = Counts::read(&Path::new(PUBLISHED).join("counts.csv"))?;
    println!("{}", Counts::measure()?.against(&baseline));
    Ok(())
}
