//! Runs the same scenes through several physics engines: speed against error. See README.md.

mod ask;
mod cli;
mod compare;
mod engine;
mod engines;
mod events;
mod heaps;
mod job;
#[path = "../../../tests/judge/mod.rs"]
mod judge;
mod level;
mod measure;
mod race;
mod report;
mod scale;
mod scene;
mod suites;
mod table;

/// A sentence for the person at the terminal.
type Error = Box<dyn std::error::Error + Send + Sync>;

fn main() -> std::process::ExitCode {
    let mut arguments = std::env::args().skip(1);
    let command = arguments.next().unwrap_or_default();
    let rest = cli::Arguments::new(arguments.collect());
    let done = match command.as_str() {
        "run" => compare::run(rest),
        "scale" => scale::run(rest),
        "ask" => ask::run(rest),
        "level" => level::run(rest),
        "events" => events::run(rest),
        "heaps" => heaps::run(rest),
        "report" => report::run(rest),
        "list" => cli::list(rest),
        job::COMMAND => job::run(rest),
        _ => Err(cli::USAGE.into()),
    };
    match done {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            std::process::ExitCode::FAILURE
        }
    }
}
