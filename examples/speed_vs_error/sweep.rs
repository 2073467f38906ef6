//! Every scene with every setting: error against time.

use crate::scenes::{Run, Scene};
use crate::settings::{self, DEFAULT, PAPER, Setting};
use crate::support::stats;
use bevy_cleave::prelude::*;

/// Error that single precision cannot be told from none, in the unit of the scene: what is below counts as this.
pub(crate) const ROUNDING: f64 = 1e-7;

/// One scene with one setting.
#[derive(Clone, Debug)]
pub(crate) struct Point {
    pub(crate) setting: Setting,
    /// Median and 99th percentile of the step times, ms.
    pub(crate) median: f64,
    pub(crate) p99: f64,
    pub(crate) steps: usize,
    /// Most contact points of a step.
    pub(crate) contacts: usize,
    /// Share of the steps in which an island ended above its tolerance, or without a certificate.
    pub(crate) unconverged: f64,
    /// At least [`ROUNDING`]; `None` if the scene failed.
    pub(crate) error: Option<f64>,
}

/// One scene with all of its settings.
pub(crate) struct Sweep {
    pub(crate) scene: Scene,
    pub(crate) points: Vec<Point>,
}

impl Sweep {
    pub(crate) fn measure(scene: Scene, is_quick: bool, mut progress: impl FnMut(&Point)) -> Self {
        let settings = if is_quick {
            settings::quick(scene.size)
        } else {
            settings::all(scene.size)
        };
        let points = settings.into_iter().map(|setting| {
            let point = measure(&scene, setting);
            progress(&point);
            point
        });
        let points = points.collect();
        Self { scene, points }
    }

    fn named(&self, name: &str) -> &Point {
        let found = self.points.iter().find(|p| p.setting.name == name);
        found.expect("every scene is run with it")
    }

    pub(crate) fn default(&self) -> &Point {
        self.named(DEFAULT)
    }

    pub(crate) fn paper(&self) -> &Point {
        self.named(PAPER)
    }

    /// The points that none beats in both time and error, from fast to slow.
    pub(crate) fn front(&self) -> Vec<&Point> {
        let mut points: Vec<_> = self.points.iter().filter(|p| p.error.is_some()).collect();
        points.sort_by(|p, q| p.median.total_cmp(&q.median));
        let mut least = f64::INFINITY;
        points.retain(|p| {
            let error = p.error.unwrap_or(f64::INFINITY);
            let is_better = error < least;
            least = least.min(error);
            is_better
        });
        points
    }

    /// The fastest setting other than the default with an error below the default's, or as large where that is rounding.
    pub(crate) fn cheapest_as_good(&self) -> Option<&Point> {
        let target_velocity = self.default().error.unwrap_or(f64::INFINITY);
        let is_as_good = |p: &&Point| {
            let error = p.error.unwrap_or(f64::INFINITY);
            p.setting.name != DEFAULT && (error < target_velocity || error == ROUNDING)
        };
        let good = self.points.iter().filter(is_as_good);
        good.min_by(|p, q| p.median.total_cmp(&q.median))
    }
}

fn measure(scene: &Scene, setting: Setting) -> Point {
    let mut run = Run::new(setting.config);
    let error = (scene.run)(&mut run);
    let has_failed = !error.is_finite() || error > scene.failed_above;
    Point {
        median: stats::median(&run.times),
        p99: stats::percentile(&run.times, 0.99),
        steps: run.times.len(),
        contacts: run.contacts,
        unconverged: run.unconverged as f64 / run.times.len() as f64,
        error: (!has_failed).then_some(error.max(ROUNDING)),
        setting,
    }
}

/// Name of a method in legends and tables.
pub(crate) fn method_name(method: Method) -> &'static str {
    match method {
        Method::SoftStep(_) => "soft step",
        Method::Pgs(_) => "Gauss-Seidel",
        Method::Exact(_) => "exact",
    }
}
