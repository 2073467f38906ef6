//! One run in a process of its own.

use crate::scenes;
use crate::scenes::Scene;
use std::path::Path;
use std::process::{Command, Output};
use weigh::{Error, cpu_us};

/// The argument by which a process knows that it is to do a job.
pub(crate) const COMMAND: &str = "job";

/// Instructions within this function are counted.
const COUNTED: &str = "measured_steps";

/// A scene in a setting.
pub(crate) struct Job {
    scene: String,
    setting: String,
}

/// What a run found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outcome {
    /// CPU time of a step in microseconds, mean over the window of the scene.
    pub(crate) us: f64,
    /// The slowest step.
    pub(crate) worst: f64,
    /// Steps of the window.
    steps: usize,
    /// What the scene calls its error.
    pub(crate) error: f64,
}

impl Job {
    pub(crate) fn new(scene: &str, setting: &str) -> Self {
        let [scene, setting] = [scene, setting].map(str::to_string);
        Self { scene, setting }
    }

    pub(crate) fn parse(mut words: impl Iterator<Item = String>) -> Result<Self, Error> {
        let mut word = || words.next().ok_or("a job is a scene and a setting");
        Ok(Self::new(&word()?, &word()?))
    }

    /// Does the job here, and prints what was found.
    pub(crate) fn perform(&self) -> Result<(), Error> {
        let mut scene = scenes::build(&self.scene, &self.setting)?;
        let (before, window) = scene.steps;
        (0..before).for_each(|_| scene.step());
        let mut times = vec![0.0; window];
        measured_steps(&mut scene, &mut times);
        let us = times.iter().sum::<f64>() / window as f64;
        let worst = times.iter().copied().fold(0.0, f64::max);
        println!("{us} {worst} {window} {}", scene.error(&times));
        Ok(())
    }

    /// Has a program do the job.
    pub(crate) fn start(&self, program: &Path) -> Result<Outcome, Error> {
        Outcome::parse(&Command::new(program).args(self.arguments()).output()?)
    }

    /// Instructions of a step.
    pub(crate) fn count(&self, program: &Path) -> Result<f64, Error> {
        let (output, total) = weigh::count(program, &self.arguments(), COUNTED)?;
        Ok(total / Outcome::parse(&output)?.steps as f64)
    }

    fn arguments(&self) -> [&str; 3] {
        [COMMAND, &self.scene, &self.setting]
    }
}

impl Outcome {
    fn parse(output: &Output) -> Result<Self, Error> {
        let text = String::from_utf8_lossy(&output.stdout);
        let words = text.split_whitespace();
        let numbers: Vec<f64> = words.filter_map(|word| word.parse().ok()).collect();
        let [us, worst, steps, error] = numbers[..] else {
            return Err(String::from_utf8_lossy(&output.stderr).into());
        };
        Ok(Self {
            us,
            worst,
            steps: steps as usize,
            error,
        })
    }

    /// The least times of two runs.
    pub(crate) fn least(self, other: Self) -> Self {
        Self {
            us: self.us.min(other.us),
            worst: self.worst.min(other.worst),
            ..other
        }
    }
}

#[inline(never)]
fn measured_steps(scene: &mut Scene, times: &mut [f64]) {
    for time in times {
        let start = cpu_us();
        scene.step();
        *time = cpu_us() - start;
    }
}
