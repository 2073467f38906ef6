//! What settings and parts of the library bring on scenes that users have: CPU time in runs that take turns, and
//! instructions.
//!
//! `cargo run --release` prints a table for each question; `-- friction order` only those, `-- --count` adds instructions
//! (callgrind, some minutes). Each run is a process of its own that says what a step took; runs of one scene take turns, and the least
//! counts. `-- probe --against OTHER` takes turns with another build of this program, made in a copy of the tree in which
//! something is switched off (say, `prefetch` does nothing): so parts are weighed that no setting leaves out.

#[path = "../../../../../tests/plugin/app.rs"]
mod app;
mod common;
#[allow(dead_code, reason = "the example also asks for the worst")]
#[path = "../../../../../examples/demolition/hitch.rs"]
mod hitch;
mod job;
mod scenes;
mod settings;
#[allow(dead_code, reason = "the examples use more of it")]
#[path = "../../../../../examples/support/stats.rs"]
mod stats;
#[allow(dead_code, reason = "the example also spawns it into an app")]
#[path = "../../../../../examples/demolition/scene.rs"]
mod wall;

/// What `wall` and `hitch` expect of the example that they are parts of.
mod support {
    pub(crate) use crate::stats;
    pub(crate) use weigh::Error;
}

use job::{Job, Outcome};
use std::path::PathBuf;
use std::process::ExitCode;
use weigh::Error;

/// A question: which scenes are run in which settings.
struct Question {
    name: &'static str,
    /// The first one is what the others are compared with.
    settings: &'static [&'static str],
    scenes: &'static [&'static str],
}

const QUESTIONS: [Question; 7] = [
    Question {
        name: "plugin",
        settings: &["plain", "app"],
        scenes: &["app-1", "app-10", "app-100", "app-1000"],
    },
    Question {
        name: "probe",
        settings: &["default", "fixed-8"],
        scenes: &[
            "wall-0",
            "wall-1",
            "small-wall-0",
            "small-wall-1",
            "lone-shots-0",
            "lone-shots-1",
            "lone-shots-2",
            "lone-shots-3",
            "lone-shots-4",
            "calm-wall",
        ],
    },
    Question {
        name: "prefetch",
        settings: &["fixed-6"],
        scenes: &["pile-200", "pile-2000", "pile-8000", "pile-32000"],
    },
    Question {
        name: "friction",
        settings: &["paper", "paper-box"],
        scenes: &["pile-200", "pyramid-10", "slide"],
    },
    Question {
        name: "lanes",
        settings: &["default", "four", "one"],
        scenes: &["stick", "tower-10", "pyramid-30", "pile-200", "pile-2000"],
    },
    Question {
        name: "order",
        settings: &["fixed-4", "ordered-4", "colored-4"],
        scenes: &[
            "tower-10",
            "load",
            "arch",
            "cards",
            "pyramid-30",
            "pile-200",
            "pile-2000",
            "chain",
        ],
    },
    Question {
        name: "exact",
        settings: &["default", "fixed-64", "exact", "paper"],
        scenes: &["stick", "tower-10", "load", "arch", "cards", "pyramid-10"],
    },
];

/// What the command line asks for.
struct Arguments {
    names: Vec<String>,
    count: bool,
    repeats: usize,
    against: Option<PathBuf>,
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("worth: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Error> {
    let mut words = std::env::args().skip(1).peekable();
    if words.next_if_eq(job::COMMAND).is_some() {
        return Job::parse(words)?.perform();
    }
    let arguments = Arguments::parse(words)?;
    for question in QUESTIONS {
        if arguments.names.is_empty() || arguments.names.iter().any(|name| name == question.name) {
            question.answer(&arguments)?;
        }
    }
    Ok(())
}

impl Arguments {
    fn parse(mut words: impl Iterator<Item = String>) -> Result<Self, Error> {
        let mut arguments = Self {
            names: Vec::new(),
            count: false,
            repeats: 5,
            against: None,
        };
        while let Some(word) = words.next() {
            let mut value = || words.next().ok_or(format!("{word} what?"));
            match word.as_str() {
                "--count" => arguments.count = true,
                "--repeats" => arguments.repeats = value()?.parse()?,
                "--against" => arguments.against = Some(value()?.into()),
                name if QUESTIONS.iter().any(|q| q.name == name) => arguments.names.push(word),
                _ => return Err(format!("{word}: unknown").into()),
            }
        }
        Ok(arguments)
    }
}

impl Question {
    fn answer(&self, arguments: &Arguments) -> Result<(), Error> {
        let this = std::env::current_exe()?;
        let mut runs: Vec<_> = self
            .settings
            .iter()
            .map(|&s| (s.to_string(), s, &this))
            .collect();
        if let Some(other) = &arguments.against {
            runs.extend(
                self.settings
                    .iter()
                    .map(|&s| (format!("{s}, other build"), s, other)),
            );
        }
        println!("\n## {}\n", self.name);
        println!(
            "| scene | setting | us a step | of the first | worst step, us | instructions | of the first | error |"
        );
        println!("|---|---|---|---|---|---|---|---|");
        for scene in self.scenes {
            let mut best: Vec<Option<Outcome>> = vec![None; runs.len()];
            for _ in 0..arguments.repeats {
                for ((_, setting, program), best) in runs.iter().zip(&mut best) {
                    let outcome = Job::new(scene, setting).start(program)?;
                    *best = Some(best.map_or(outcome, |best| best.least(outcome)));
                }
            }
            let mut first = None;
            for ((name, setting, program), outcome) in runs.iter().zip(best) {
                let outcome = outcome.ok_or("no run")?;
                let count = if arguments.count {
                    Job::new(scene, setting).count(program)?
                } else {
                    f64::NAN
                };
                let first = *first.get_or_insert((outcome.us, count));
                println!(
                    "| {scene} | {name} | {:.2} | {:.3} | {:.0} | {count:.0} | {:.3} | {:.2e} |",
                    outcome.us,
                    outcome.us / first.0,
                    outcome.worst,
                    count / first.1,
                    outcome.error,
                );
            }
        }
        Ok(())
    }
}
