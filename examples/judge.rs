//! Judges random scenes that nobody named, and says which share of them breaks which law.
//!
//! `cargo run --release --example judge -- --scenes 200` judges 200 scenes of each family. More options:
//! `--seed S` the first seed (0); `--families a,b` only these; `--hours H` new seeds until the time is over; `--threads N`;
//! `--shrink DIR` writes the smallest scene for each family and law that fails into a folder, `--failures` lists the seeds that
//! fail. `--show FAMILY SEED` judges one scene and prints it; `--replay FILE` judges a file that was written.
#![expect(clippy::print_stdout, reason = "an example prints what it shows")]

#[path = "../tests/judge/mod.rs"]
mod judge;

use judge::clock::cpu_ms;
use judge::generate::{FAMILIES, scene};
use judge::laws::{Breach, Law};
use judge::scene::Scene;
use judge::tally::{Tally, Verdict};
use judge::{file, laws, shrink};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Trials that the shrinker may make for one scene.
const SHRINK_RUNS: usize = 400;

/// What is asked for.
struct Options {
    scenes: u64,
    seed: u64,
    families: Vec<&'static str>,
    hours: Option<f64>,
    threads: usize,
    shrink: Option<PathBuf>,
    failures: bool,
    show: Option<(String, u64)>,
    replay: Option<PathBuf>,
}

impl Options {
    fn read() -> Result<Self, Box<dyn Error>> {
        let mut options = Self {
            scenes: 100,
            seed: 0,
            families: FAMILIES.iter().map(|(name, _)| *name).collect(),
            hours: None,
            threads: 1,
            shrink: None,
            failures: false,
            show: None,
            replay: None,
        };
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            let mut next = || words.next().ok_or(format!("{word}: of what?"));
            match word.as_str() {
                "--scenes" => options.scenes = next()?.parse()?,
                "--seed" => options.seed = next()?.parse()?,
                "--hours" => options.hours = Some(next()?.parse()?),
                "--threads" => options.threads = next()?.parse()?,
                "--shrink" => options.shrink = Some(next()?.into()),
                "--failures" => options.failures = true,
                "--show" => options.show = Some((next()?, next()?.parse()?)),
                "--replay" => options.replay = Some(next()?.into()),
                "--families" => {
                    let asked = next()?;
                    options
                        .families
                        .retain(|name| asked.split(',').any(|a| a == *name));
                }
                _ => {
                    return Err(
                        format!("no option {word}; the head of this file lists them").into(),
                    );
                }
            }
        }
        Ok(options)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::read()?;
    if let Some(path) = &options.replay {
        let scene = file::read(&std::fs::read_to_string(path)?)?;
        print_verdict(&laws::judge(&scene));
    } else if let Some((family, seed)) = &options.show {
        let scene = scene(family, *seed).ok_or("no such family")?;
        println!("{}", file::write(&scene, &[]));
        print_verdict(&laws::judge(&scene));
    } else {
        sweep(&options)?;
    }
    Ok(())
}

fn print_verdict(breaches: &[Breach]) {
    if breaches.is_empty() {
        println!("keeps all laws");
    }
    for Breach { law, excess, what } in breaches {
        println!(
            "breaks {} ({excess:.1} times the bound): {what}",
            law.name()
        );
    }
}

/// Judges what is asked for, prints the table and keeps the smallest failures.
fn sweep(options: &Options) -> Result<(), Box<dyn Error>> {
    let end = options
        .hours
        .map(|hours| Instant::now() + Duration::from_secs_f64(3600.0 * hours));
    let (next, verdicts) = (AtomicU64::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..options.threads {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    let families = options.families.len() as u64;
                    let (seed, family) = (number / families, (number % families) as usize);
                    let is_over = match end {
                        Some(end) => Instant::now() >= end,
                        None => seed >= options.scenes,
                    };
                    if is_over {
                        return;
                    }
                    let verdict = verdict(options.families[family], options.seed + seed);
                    verdicts.lock().expect("no thread panics").push(verdict);
                }
            });
        }
    });
    let mut verdicts = verdicts.into_inner()?;
    let place = |v: &Verdict| options.families.iter().position(|name| *name == v.family);
    verdicts.sort_by_key(|v| (place(v), v.seed));
    let mut tally = Tally::default();
    verdicts.iter().for_each(|verdict| tally.note(verdict));
    println!("{}", tally.table());
    if options.failures {
        print_failures(&verdicts);
    }
    if let Some(folder) = &options.shrink {
        keep_smallest(&verdicts, folder)?;
    }
    Ok(())
}

fn verdict(family: &'static str, seed: u64) -> Verdict {
    let start = cpu_ms();
    let scene = scene(family, seed).expect("families are listed");
    let breaches = laws::judge(&scene);
    Verdict {
        family,
        seed,
        breaches,
        cost: cpu_ms() - start,
    }
}

fn print_failures(verdicts: &[Verdict]) {
    for verdict in verdicts {
        for Breach { law, excess, what } in &verdict.breaches {
            let (family, seed) = (verdict.family, verdict.seed);
            println!("{family} {seed} {} {excess:.1}: {what}", law.name());
        }
    }
}

/// Writes the smallest scene of each family and law that some scene broke: of the one that broke it worst.
fn keep_smallest(verdicts: &[Verdict], folder: &Path) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    for (family, _) in FAMILIES {
        for (law, name) in Law::ALL {
            let of_family = verdicts.iter().filter(|v| v.family == family);
            let found = of_family
                .flat_map(|v| v.breaches.iter().map(move |b| (v.seed, b)))
                .filter(|(_, breach)| breach.law == law)
                .max_by(|(_, a), (_, b)| a.excess.total_cmp(&b.excess));
            let Some((seed, _)) = found else {
                continue;
            };
            let scene = scene(family, seed).expect("just judged");
            let small = shrink::shrink(&scene, law, SHRINK_RUNS);
            let path = folder.join(format!("{family}_{name}_{seed}.txt"));
            std::fs::write(&path, describe(&small))?;
            println!("{}: {} bodies", path.display(), small.actors.len());
        }
    }
    Ok(())
}

/// The file of a failing scene, with what it does.
fn describe(scene: &Scene) -> String {
    let breaches = laws::judge(scene);
    let say = |Breach { law, what, .. }: &Breach| format!("{}: {what}", law.name());
    file::write(scene, &breaches.iter().map(say).collect::<Vec<_>>())
}
