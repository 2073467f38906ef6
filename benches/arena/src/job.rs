//! One run of one engine on one scene, in a process of its own.
//!
//! Bevy's pools of threads are global and their first size stays, allocators remember what was freed, and an engine that
//! aborts takes its process with it: so the arena starts itself again for each run and reads one line from it.

use crate::Error;
use crate::cli::{self, Arguments};
use crate::engine::{Engine, Entry, Settings, registry};
use crate::measure::{Meter, Report};
use crate::scene::{self, Scene};
use std::process::{Command, Stdio};
use std::time::Instant;

/// The command under which the arena does a job.
pub(crate) const COMMAND: &str = "job";

/// What the line with the outcome starts with; engines may print lines of their own.
const MARK: &str = "outcome ";

/// What to run.
#[derive(Clone, Debug)]
pub(crate) struct Job {
    pub(crate) scene: String,
    pub(crate) engine: String,
    pub(crate) setting: String,
    pub(crate) threads: usize,
    pub(crate) sleeping: bool,
    /// Whether errors are measured, at the price of cold caches between steps.
    pub(crate) measure: bool,
    /// Seconds after which the run is given up.
    pub(crate) limit: f64,
    /// Steps before the timing window and steps in all, if not those of the scene.
    pub(crate) window: Option<[usize; 2]>,
}

/// What a run found; times in ms per step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outcome {
    pub(crate) bodies: usize,
    pub(crate) steps: usize,
    /// Wall time, median and 99th percentile.
    pub(crate) wall: [f64; 2],
    /// CPU time of the process, median and mean.
    pub(crate) cpu: [f64; 2],
    pub(crate) build_ms: f64,
    /// Not a number where the engine does not tell.
    pub(crate) awake: f64,
    pub(crate) contacts: f64,
    /// Zeros unless it was measured.
    pub(crate) report: Report,
}

impl Job {
    /// Does the job in a new process.
    ///
    /// # Errors
    /// If the process ends without an outcome.
    pub(crate) fn start(&self) -> Result<Outcome, Error> {
        let mut command = Command::new(std::env::current_exe()?);
        command.arg(COMMAND).args(self.arguments());
        let output = command.stderr(Stdio::inherit()).output()?;
        let text = String::from_utf8_lossy(&output.stdout);
        let line = text.lines().find_map(|line| line.strip_prefix(MARK));
        let name = || format!("{} {} on {}", self.engine, self.setting, self.scene);
        line.and_then(Outcome::from_line)
            .ok_or_else(|| format!("{}: {}", name(), output.status).into())
    }

    fn arguments(&self) -> [String; 8] {
        let [warmup, steps] = self.window.unwrap_or_default();
        [
            self.scene.clone(),
            self.engine.clone(),
            self.setting.clone(),
            self.threads.to_string(),
            self.sleeping.to_string(),
            self.measure.to_string(),
            self.limit.to_string(),
            format!("{warmup},{steps}"),
        ]
    }

    fn from_arguments(mut words: Arguments) -> Result<Self, Error> {
        let mut job = Self {
            scene: words.value("scene")?,
            engine: words.value("engine")?,
            setting: words.value("setting")?,
            threads: words.value("threads")?,
            sleeping: words.value("sleeping")?,
            measure: words.value("measure")?,
            limit: words.value("limit")?,
            window: None,
        };
        let window: Vec<usize> = words.list("window")?;
        job.window = <[usize; 2]>::try_from(window).ok().filter(|w| w[1] > 0);
        Ok(job)
    }

    /// Builds the scene and runs it in this process.
    fn perform(&self, entry: &Entry, value: u32) -> Result<Outcome, Error> {
        let mut scene = scene::build(&self.scene).ok_or(format!("no scene `{}`", self.scene))?;
        if let Some([warmup, steps]) = self.window {
            (scene.warmup, scene.steps) = (warmup, steps);
        }
        let settings = Settings {
            value,
            threads: self.threads,
            sleeping: self.sleeping,
        };
        let start = Instant::now();
        let engine = (entry.build)(&scene, &settings);
        let build_ms = ms(start);
        let mut outcome = self.time(&scene, engine);
        (outcome.bodies, outcome.build_ms) = (scene.num_dynamic(), build_ms);
        Ok(outcome)
    }

    fn time(&self, scene: &Scene, mut engine: Box<dyn Engine>) -> Outcome {
        let mut meter = self.measure.then(|| Meter::new(scene));
        let mut states = Vec::with_capacity(scene.bodies.len());
        let mut times = Times::default();
        let start = Instant::now();
        while times.wall.len() < scene.steps && ms(start) < 1e3 * self.limit {
            times.step(&mut *engine);
            if let Some(meter) = &mut meter {
                states.clear();
                engine.read(&mut states);
                meter.sample(&states);
            }
        }
        let is_late = times.wall.len() < scene.steps;
        let tell = |number: Option<usize>| number.map_or(f64::NAN, |n| n as f64);
        Outcome {
            steps: times.wall.len(),
            awake: tell(engine.num_awake()),
            contacts: tell(engine.num_contacts()),
            report: meter.map_or(Report::default(), |m| m.finish(is_late)),
            ..times.outcome(scene.warmup)
        }
    }
}

/// Times of all steps, ms.
#[derive(Default)]
struct Times {
    wall: Vec<f64>,
    cpu: Vec<f64>,
}

impl Times {
    fn step(&mut self, engine: &mut dyn Engine) {
        let (start, cpu_start) = (Instant::now(), cpu_ms());
        engine.step();
        self.cpu.push(cpu_ms() - cpu_start);
        self.wall.push(ms(start));
    }

    /// The times after the first `warmup` steps; of all steps if there are no more.
    fn outcome(&self, warmup: usize) -> Outcome {
        let from = if warmup < self.wall.len() { warmup } else { 0 };
        let (wall, cpu) = (&self.wall[from..], &self.cpu[from..]);
        let mean = cpu.iter().sum::<f64>() / cpu.len() as f64;
        Outcome {
            wall: [quantile(wall, 0.5), quantile(wall, 0.99)],
            cpu: [quantile(cpu, 0.5), mean],
            ..Outcome::default()
        }
    }
}

impl Outcome {
    fn to_line(&self) -> String {
        let (r, [wall, p99], [cpu, mean]) = (&self.report, self.wall, self.cpu);
        let (bodies, steps, fallen) = (self.bodies as f64, self.steps as f64, r.fallen as f64);
        let numbers = [
            bodies,
            steps,
            wall,
            p99,
            cpu,
            mean,
            self.build_ms,
            self.awake,
            self.contacts,
            r.err,
            r.pen_max,
            r.pen_mean,
            r.energy_gain,
            r.energy_drift,
            r.disp_max,
            r.rms_speed,
            fallen,
        ];
        numbers.map(|n| n.to_string()).join(" ")
    }

    fn from_line(line: &str) -> Option<Self> {
        let numbers: Result<Vec<f64>, _> = line.split(' ').map(str::parse).collect();
        let [
            bodies,
            steps,
            wall,
            p99,
            cpu,
            mean,
            build_ms,
            awake,
            contacts,
            err,
            pen_max,
            pen_mean,
            energy_gain,
            energy_drift,
            disp_max,
            rms_speed,
            fallen,
        ] = numbers.ok()?.try_into().ok()?;
        Some(Self {
            bodies: bodies as usize,
            steps: steps as usize,
            wall: [wall, p99],
            cpu: [cpu, mean],
            build_ms,
            awake,
            contacts,
            report: Report {
                err,
                pen_max,
                pen_mean,
                energy_gain,
                energy_drift,
                disp_max,
                rms_speed,
                fallen: fallen as usize,
            },
        })
    }
}

/// The command behind [`Job::start`].
pub(crate) fn run(words: Arguments) -> Result<(), Error> {
    let job = Job::from_arguments(words)?;
    let all = registry();
    cli::check_engines(&all, std::slice::from_ref(&job.engine))?;
    let entry = all.iter().find(|entry| entry.name == job.engine);
    let entry = entry.expect("checked above");
    let setting = entry.settings.iter().find(|s| s.name == job.setting);
    let setting = setting.ok_or(format!("{} has no setting `{}`", job.engine, job.setting))?;
    println!("{MARK}{}", job.perform(entry, setting.value)?.to_line());
    Ok(())
}

fn ms(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}

/// CPU time of the process, all threads, ms.
pub(crate) fn cpu_ms() -> f64 {
    let mut time = libc::timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    // SAFETY: `time` is a valid place to write to.
    unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &mut time) };
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}

/// The value that a share `q` of all values lies below. Not a number if there are none.
pub(crate) fn quantile(values: &[f64], q: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1);
    let value = sorted.get((last as f64 * q).round() as usize);
    value.copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_in_order() {
        let values = [3.0, 1.0, 2.0];
        assert_eq!(
            [0.0, 0.5, 1.0].map(|q| quantile(&values, q)),
            [1.0, 2.0, 3.0]
        );
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn outcomes_survive_the_way_between_processes() {
        let outcome = Outcome {
            bodies: 7,
            cpu: [0.1, 0.2],
            awake: f64::NAN,
            report: Report {
                err: f64::INFINITY,
                fallen: 3,
                ..Report::default()
            },
            ..Outcome::default()
        };
        let back = Outcome::from_line(&outcome.to_line()).expect("a line");
        assert_eq!(format!("{back:?}"), format!("{outcome:?}"));
    }
}
