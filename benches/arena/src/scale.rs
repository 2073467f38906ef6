//! `arena scale`: how the time of a step grows with the number of bodies.

use crate::cli::{self, Arguments};
use crate::compare::chosen;
use crate::engine::{Entry, registry};
use crate::job::{Job, Outcome, quantile};
use crate::report::{self, machine};
use crate::{Error, scene};
use std::fs;
use std::io::Write;
use std::path::PathBuf;

/// Steps before the timing window and in all. Piles of all sizes have about ten layers, but not the same number: in `LANDING`
/// some have settled farther than others, in `AT_REST` all have landed, though large ones still shift a little. A pyramid is at
/// rest from the start.
const LANDING: [usize; 2] = [150, 180];
const AT_REST: [usize; 2] = [330, 360];
const PYRAMIDS: [usize; 2] = [30, 60];

/// Bodies of a pyramid of base 5.
const PYRAMID: f64 = 15.0;

/// Number of bodies that the growth is told against.
const REFERENCE: usize = 2000;

const COLUMNS: &str = "scene,bodies,engine,setting,threads,ms_median,cpu_ms,bodies_per_ms,us_per_body,contacts_per_body";

struct Options {
    scenes: Vec<String>,
    bodies: Vec<usize>,
    engines: Vec<String>,
    settings: Vec<String>,
    threads: Vec<usize>,
    repeats: usize,
    out: PathBuf,
}

impl Options {
    fn parse(mut words: Arguments, all: &[Entry]) -> Result<Self, Error> {
        let mut options = Self {
            scenes: ["pile", "pile-at-rest", "pyramids"].map(Into::into).into(),
            bodies: vec![1000, 2000, 4000, 8000, 16_000, 32_000],
            engines: all.iter().map(|entry| entry.name.into()).collect(),
            settings: vec!["default".into()],
            threads: vec![1],
            repeats: 1,
            out: report::results("scale.csv"),
        };
        while let Some(flag) = words.word() {
            match flag.as_str() {
                "--scene" => options.scenes = words.list(&flag)?,
                "--bodies" => options.bodies = words.list(&flag)?,
                "--engines" => options.engines = words.list(&flag)?,
                "--settings" => options.settings = words.list(&flag)?,
                "--threads" => options.threads = words.list(&flag)?,
                "--repeats" => options.repeats = words.value(&flag)?,
                "--out" => options.out = words.value(&flag)?,
                _ => return Err(cli::unknown(&flag)),
            }
        }
        cli::check_engines(all, &options.engines)?;
        match options.threads.contains(&0) || options.repeats == 0 {
            true => Err("at least one thread and one run".into()),
            false => Ok(options),
        }
    }
}

/// A scene with about `bodies` dynamic bodies, and its window.
fn sized(scene: &str, bodies: usize) -> Result<(String, [usize; 2]), Error> {
    match scene {
        "pile" => Ok((format!("pile:{bodies}"), LANDING)),
        "pile-at-rest" => Ok((format!("pile:{bodies}"), AT_REST)),
        "pyramids" => {
            let side = (bodies as f64 / PYRAMID).sqrt().round().max(1.0);
            Ok((format!("pyramids:{side}"), PYRAMIDS))
        }
        _ => Err(format!("`{scene}` does not grow: pile, pile-at-rest or pyramids").into()),
    }
}

/// One engine with one setting on one number of threads, and its times at each size.
struct Line {
    job: Job,
    name: String,
    /// By size.
    runs: Vec<Vec<Outcome>>,
    /// Microseconds and contacts per body at the size that the others are told against, once it was run.
    reference: Option<[f64; 2]>,
}

/// Runs what the command line says.
pub(crate) fn run(words: Arguments) -> Result<(), Error> {
    let command = machine::command_line();
    let all = registry();
    let options = Options::parse(words, &all)?;
    let mut file = open(&options.out, &machine::heading(&command))?;
    for scene in &options.scenes {
        let mut lines = lines(&options, &all);
        let sizes = options.bodies.iter().map(|&bodies| sized(scene, bodies));
        let sizes = sizes.collect::<Result<Vec<_>, _>>()?;
        // Sizes in turns, so that all of them see the machine when it is fast and when it is slow.
        for round in 1..=options.repeats {
            for (size, (spec, window)) in sizes.iter().enumerate() {
                for line in &mut lines {
                    (line.job.scene, line.job.window) = (spec.clone(), Some(*window));
                    line.run(size);
                }
                eprintln!("{spec}: {round} of {}", options.repeats);
            }
        }
        print_head();
        for (size, (spec, _)) in sizes.iter().enumerate() {
            let count = scene::build(spec).map_or(0, |s| s.num_dynamic());
            let is_reference = options.bodies[size] == REFERENCE;
            for line in &mut lines {
                line.tell(scene, size, count, is_reference, &mut file)?;
            }
        }
        println!();
    }
    Ok(())
}

fn open(path: &PathBuf, comment: &str) -> Result<fs::File, Error> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let mut file = fs::OpenOptions::new()
        .append(true)
        .create(true)
        .open(path)?;
    if file.metadata()?.len() == 0 {
        writeln!(file, "{COLUMNS}")?;
    }
    writeln!(file, "# {comment}")?;
    Ok(file)
}

fn lines(options: &Options, all: &[Entry]) -> Vec<Line> {
    let entries = all
        .iter()
        .filter(|entry| options.engines.iter().any(|n| n == entry.name));
    let points =
        entries.flat_map(|entry| chosen(entry, &options.settings).map(move |s| (entry, s)));
    let line = |(entry, setting): (&Entry, &crate::engine::Setting), threads| Line {
        job: Job {
            scene: String::new(),
            engine: entry.name.into(),
            setting: setting.name.clone(),
            threads,
            sleeping: false,
            measure: false,
            limit: 600.0,
            window: None,
        },
        name: format!("{} {}", entry.name, setting.name),
        runs: vec![vec![]; options.bodies.len()],
        reference: None,
    };
    points
        .flat_map(|point| options.threads.iter().map(move |&t| line(point, t)))
        .collect()
}

impl Line {
    fn run(&mut self, size: usize) {
        match self.job.start() {
            Ok(outcome) => self.runs[size].push(outcome),
            Err(error) => eprintln!("{error}"),
        }
    }

    /// Prints and files the medians at one size.
    fn tell(
        &mut self,
        scene: &str,
        size: usize,
        bodies: usize,
        is_reference: bool,
        file: &mut fs::File,
    ) -> Result<(), Error> {
        let runs = &self.runs[size];
        let median =
            |of: fn(&Outcome) -> f64| quantile(&runs.iter().map(of).collect::<Vec<_>>(), 0.5);
        let (wall, cpu) = (median(|o| o.wall[0]), median(|o| o.cpu[0]));
        let (threads, n) = (self.job.threads, bodies as f64);
        let cost = if threads == 1 { cpu } else { wall };
        let (per_body, contacts) = (1e3 * cost / n, median(|o| o.contacts) / n);
        if is_reference {
            self.reference = Some([per_body, contacts]);
        }
        let over = |[body, contact]: [f64; 2]| {
            let growth = per_body / body;
            format!("{growth:>8.2} {:>8.2}", growth * contact / contacts)
        };
        let growth = self.reference.map_or(String::new(), over);
        println!(
            "{:<14} {bodies:>6} {:<24} {threads:>2} {wall:>9.3} {cpu:>9.3} {:>8.1} {per_body:>8.3} {contacts:>8.2} {growth}",
            scene,
            self.name,
            n / cost
        );
        let (engine, setting) = (&self.job.engine, &self.job.setting);
        writeln!(
            file,
            "{scene},{bodies},{engine},{setting},{threads},{wall:.5},{cpu:.5},{:.3},{per_body:.5},{contacts:.3}",
            n / cost
        )?;
        Ok(())
    }
}

fn print_head() {
    println!(
        "{:<14} {:>6} {:<24} {:>2} {:>9} {:>9} {:>8} {:>8} {:>8} {:>8} {:>8}",
        "scene",
        "bodies",
        "engine",
        "T",
        "ms",
        "cpu ms",
        "per ms",
        "us/body",
        "contacts",
        "growth",
        "/contact"
    );
}
