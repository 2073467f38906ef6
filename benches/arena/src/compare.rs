//! `arena run`: points of several engines on several scenes, interleaved.

use crate::cli::{self, Arguments};
use crate::engine::{Entry, Setting, registry};
use crate::job::{Job, Outcome, quantile};
use crate::report::{self, dominance, machine};
use crate::scene::Scene;
use crate::table::{Row, Table, Writer};
use crate::{Error, scene, suites};
use std::path::PathBuf;

/// What is run.
struct Options {
    scenes: Vec<String>,
    engines: Vec<String>,
    settings: Vec<String>,
    threads: Vec<usize>,
    repeats: usize,
    limit: f64,
    sleeping: bool,
    out: PathBuf,
}

impl Options {
    fn parse(mut words: Arguments, all: &[Entry]) -> Result<Self, Error> {
        let mut options = Self {
            scenes: suites::FULL.iter().map(|&s| s.into()).collect(),
            engines: all.iter().map(|entry| entry.name.into()).collect(),
            settings: vec!["all".into()],
            threads: vec![1],
            repeats: 3,
            limit: 300.0,
            sleeping: false,
            out: report::results("arena.csv"),
        };
        while let Some(flag) = words.word() {
            match flag.as_str() {
                "--suite" => options.take_suite(&words.value::<String>(&flag)?)?,
                "--scene" => options.scenes = words.list(&flag)?,
                "--engines" => options.engines = words.list(&flag)?,
                "--settings" => options.settings = words.list(&flag)?,
                "--threads" => options.threads = words.list(&flag)?,
                "--repeats" => options.repeats = words.value(&flag)?,
                "--limit" => options.limit = words.value(&flag)?,
                "--sleeping" => options.sleeping = true,
                "--out" => options.out = words.value(&flag)?,
                _ => return Err(cli::unknown(&flag)),
            }
        }
        cli::check_engines(all, &options.engines)?;
        if options.threads.contains(&0) {
            return Err("a step needs a thread".into());
        }
        Ok(options)
    }

    fn take_suite(&mut self, name: &str) -> Result<(), Error> {
        let suite = suites::named(name).ok_or(format!("no suite `{name}`"))?;
        self.scenes = suite.iter().map(|&s| s.into()).collect();
        let settings = if name == "quick" { "default" } else { "all" };
        self.settings = vec![settings.into()];
        Ok(())
    }

    fn job(&self, point: &Point, measure: bool) -> Job {
        Job {
            scene: point.scene.clone(),
            engine: point.entry.name.into(),
            setting: point.setting.name.clone(),
            threads: point.threads,
            sleeping: self.sleeping,
            measure,
            limit: self.limit,
            window: None,
        }
    }
}

/// The settings of `entry` that are among `names`.
pub(crate) fn chosen<'a>(entry: &'a Entry, names: &[String]) -> impl Iterator<Item = &'a Setting> {
    let has = |name: &str| names.iter().any(|n| n == name);
    let (all, default) = (has("all"), has("default"));
    let is_chosen = move |s: &&Setting| all || default && s.name == entry.default || has(&s.name);
    let chosen: Vec<_> = entry.settings.iter().filter(is_chosen).collect();
    chosen.into_iter()
}

/// One engine with one setting on one scene.
struct Point<'a> {
    scene: String,
    bodies: usize,
    entry: &'a Entry,
    setting: &'a Setting,
    threads: usize,
    /// The run in which errors were measured; none if it failed.
    measured: Option<Outcome>,
    timed: Vec<Outcome>,
}

/// Runs what the command line says.
pub(crate) fn run(words: Arguments) -> Result<(), Error> {
    let command = machine::command_line();
    let all = registry();
    let options = Options::parse(words, &all)?;
    let mut writer = Writer::open(&options.out, &machine::heading(&command))?;
    let mut table = Table::default();
    for spec in &options.scenes {
        let scene = scene::build(spec).ok_or(format!("no scene `{spec}`, see `arena list`"))?;
        let mut points = points(spec, &scene, &options, &all);
        for repeat in 0..=options.repeats {
            for point in &mut points {
                point.run(&options, repeat == 0);
            }
        }
        print_head();
        for row in points.iter().map(Point::row) {
            print(&row);
            writer.add(&row)?;
            table.rows.push(row);
        }
        println!();
    }
    print!("{}", dominance::summary(&table));
    Ok(())
}

fn points<'a>(spec: &str, scene: &Scene, options: &Options, all: &'a [Entry]) -> Vec<Point<'a>> {
    let bodies = scene.num_dynamic();
    let entries = all
        .iter()
        .filter(|entry| !(entry.is_for_joints && scene.joints.is_empty()))
        .filter(|entry| options.engines.iter().any(|n| n == entry.name));
    let mut points = Vec::new();
    for entry in entries {
        let settings = chosen(entry, &options.settings).filter(|s| bodies <= s.max_bodies);
        for setting in settings {
            points.extend(options.threads.iter().map(|&threads| Point {
                scene: spec.into(),
                bodies,
                entry,
                setting,
                threads,
                measured: None,
                timed: vec![],
            }));
        }
    }
    points
}

impl Point<'_> {
    /// One run; the first one measures errors, and one that failed is not run again.
    fn run(&mut self, options: &Options, measure: bool) {
        if !measure
            && self
                .measured
                .as_ref()
                .is_none_or(|m| m.report.err.is_infinite())
        {
            return;
        }
        match options.job(self, measure).start() {
            Ok(outcome) if measure => self.measured = Some(outcome),
            Ok(outcome) => self.timed.push(outcome),
            Err(error) => eprintln!("{error}"),
        }
    }

    fn row(&self) -> Row {
        let failed = Outcome::default();
        let measured = self.measured.as_ref().unwrap_or(&failed);
        let timed = if self.timed.is_empty() {
            std::slice::from_ref(measured)
        } else {
            &self.timed
        };
        let all = |of: fn(&Outcome) -> f64| timed.iter().map(of).collect::<Vec<_>>();
        let median = |of| quantile(&all(of), 0.5);
        let cost = all(if self.threads == 1 {
            |o| o.cpu[0]
        } else {
            |o| o.wall[0]
        });
        let r = &measured.report;
        Row {
            scene: self.scene.clone(),
            bodies: self.bodies,
            engine: self.entry.name.into(),
            setting: self.setting.name.clone(),
            is_default: self.setting.name == self.entry.default,
            threads: self.threads,
            steps: measured.steps,
            wall: median(|o| o.wall[0]),
            wall_p99: median(|o| o.wall[1]),
            cpu: median(|o| o.cpu[0]),
            cpu_mean: median(|o| o.cpu[1]),
            noise: quantile(&cost, 1.0) / quantile(&cost, 0.0),
            build_ms: measured.build_ms,
            err: if self.measured.is_some() {
                r.err
            } else {
                f64::INFINITY
            },
            pen_max: r.pen_max,
            pen_mean: r.pen_mean,
            energy_gain: r.energy_gain,
            energy_drift: r.energy_drift,
            disp_max: r.disp_max,
            rms_speed: r.rms_speed,
            fallen: r.fallen,
            awake: measured.awake,
            contacts: measured.contacts,
        }
    }
}

fn print_head() {
    println!(
        "{:<14} {:<14} {:<10} {:>2} {:>9} {:>9} {:>9} {:>9} {:>10} {:>9} {:>9} {:>9} {:>6}",
        "scene",
        "engine",
        "setting",
        "T",
        "ms",
        "p99",
        "cpu ms",
        "cpu mean",
        "err",
        "pen_mean",
        "E gain",
        "rms v",
        "fallen"
    );
}

fn print(row: &Row) {
    let noise = if row.noise > 1.15 {
        format!("  noise {:.2}", row.noise)
    } else {
        String::new()
    };
    println!(
        "{:<14} {:<14} {:<10} {:>2} {:>9.4} {:>9.4} {:>9.4} {:>9.4} {:>10.3e} {:>9.2e} {:>9.2e} {:>9.2e} {:>6}{noise}",
        row.scene,
        row.engine,
        row.setting,
        row.threads,
        row.wall,
        row.wall_p99,
        row.cpu,
        row.cpu_mean,
        row.err,
        row.pen_mean,
        row.energy_gain,
        row.rms_speed,
        row.fallen
    );
}
