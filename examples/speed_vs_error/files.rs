//! The methods on single problems from files, whose solutions are known: error against work and against time.

use crate::mlcp_files::sweeps::{Method, Profile, micros, velocity_error};
use crate::mlcp_files::{File, load_all};
use crate::support::stats;
use bevy_cleave::testing::exact::ExactScratch;
use std::time::Instant;

/// Velocity errors to which a problem counts as solved.
pub(crate) const LEVELS: [f64; 3] = [1e-1, 1e-2, 1e-3];

/// Iterative methods and their names.
const METHODS: [(&str, Method); 3] = [
    ("Gauss-Seidel", Method::Pgs),
    ("default (momentum)", Method::Momentum),
    ("sub-steps of one sweep", Method::Substeps),
];

/// Numbers of sweeps that are tried; every other one is a power of two.
const SWEEPS: [usize; 15] = [4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512];

/// Sweeps that are timed, and how often.
const TIMED: (usize, usize) = (32, 5);

/// An iterative method on the files.
pub(crate) struct Curve {
    pub(crate) name: &'static str,
    /// All files from no impulses.
    pub(crate) cold: Profile,
    /// The files that have a step before, from no impulses and from those of the step before.
    pub(crate) again_cold: Profile,
    pub(crate) warm: Profile,
    /// Microseconds of one sweep and contact, by file.
    pub(crate) micros: Vec<f64>,
}

/// The exact method on one file.
pub(crate) struct Exact {
    pub(crate) factorisations: u32,
    /// Microseconds for each contact.
    pub(crate) micros: f64,
    pub(crate) error: f64,
    pub(crate) is_certified: bool,
}

/// All that is measured on the files.
pub(crate) struct Files {
    pub(crate) curves: Vec<Curve>,
    /// By file, cold; and warm where there is a step before.
    pub(crate) exact: Vec<Exact>,
    pub(crate) exact_warm: Vec<Exact>,
}

impl Files {
    /// Reads the problems and runs all methods on them, the iterative ones with up to `most` sweeps.
    pub(crate) fn measure(most: usize, mut progress: impl FnMut(&str)) -> Self {
        let (all, again) = (Set::new(|_| true), Set::new(|f| warm(f).is_some()));
        let sweeps: Vec<usize> = SWEEPS.into_iter().filter(|&k| k <= most).collect();
        let curves = METHODS.into_iter().map(|(name, method)| {
            progress(name);
            Curve::measure(name, method, &all, &again, &sweeps)
        });
        let curves = curves.collect();
        progress("exact");
        let solve = |(file, a): (&File, &[f64])| Exact::measure(file, a, &vec![0.0; file.b.len()]);
        let again_exact = |(file, a): (&File, &[f64])| Some(Exact::measure(file, a, warm(file)?));
        Self {
            curves,
            exact: all.iter().map(solve).collect(),
            exact_warm: again.iter().filter_map(again_exact).collect(),
        }
    }

    /// Share of the files, in percent, that the exact method has solved within `micros` for each contact.
    pub(crate) fn exact_share(&self, micros: f64) -> f64 {
        let done = self
            .exact
            .iter()
            .filter(|e| e.micros <= micros && e.is_certified);
        100.0 * done.count() as f64 / self.exact.len() as f64
    }

    /// All times that are on the way of a method to its last sweep, microseconds for each contact.
    pub(crate) fn times(&self) -> impl Iterator<Item = f64> + '_ {
        let sweeps = self.curves.iter().flat_map(|curve| {
            let (first, last) = (SWEEPS[0] as f64, SWEEPS[SWEEPS.len() - 1] as f64);
            curve
                .micros
                .iter()
                .flat_map(move |&m| [m * first, m * last])
        });
        sweeps.chain(self.exact.iter().map(|e| e.micros))
    }
}

/// Problems with their matrices.
struct Set {
    files: Vec<File>,
    matrices: Vec<Vec<f64>>,
}

impl Set {
    /// Those that have a solution and that `pick` takes, with the friction bounds of the solution.
    fn new(pick: impl Fn(&File) -> bool) -> Self {
        let mut files = load_all();
        for file in &mut files {
            if let Some(reference) = &file.reference {
                file.problem.set_bounds(reference.bounds.clone());
            }
        }
        files.retain(|file| file.reference.is_some() && pick(file));
        let matrices = files.iter().map(|f| f.problem.matrix()).collect();
        Self { files, matrices }
    }

    fn iter(&self) -> impl Iterator<Item = (&File, &[f64])> {
        self.files
            .iter()
            .zip(self.matrices.iter().map(Vec::as_slice))
    }
}

fn warm(file: &File) -> Option<&Vec<f64>> {
    file.reference.as_ref()?.warm.as_ref()
}

fn contacts(file: &File) -> f64 {
    (file.b.len() / file.rows_per_contact) as f64
}

impl Curve {
    fn measure(
        name: &'static str,
        method: Method,
        all: &Set,
        again: &Set,
        sweeps: &[usize],
    ) -> Self {
        let time = |(file, a): (&File, &[f64])| {
            let (count, runs) = TIMED;
            let start = vec![0.0; file.b.len()];
            let times = (0..runs).map(|_| micros(method, file, a, &start, count));
            stats::median(&times.collect::<Vec<_>>()) / count as f64 / contacts(file)
        };
        let run =
            |set: &Set, warm| Profile::measure(method, &set.files, &set.matrices, warm, sweeps);
        Self {
            name,
            cold: run(all, false),
            again_cold: run(again, false),
            warm: run(again, true),
            micros: all.iter().map(time).collect(),
        }
    }

    /// Share of the files, in percent, that are solved to `level` with the sweeps that fit in `micros` for each contact.
    pub(crate) fn share(&self, level: f64, micros: f64) -> f64 {
        let solved = self
            .cold
            .errors
            .iter()
            .zip(&self.micros)
            .filter(|(errors, sweep)| {
                let sweeps = self.cold.sweeps.iter();
                let fit = sweeps.filter(|&&k| k as f64 * **sweep <= micros).count();
                fit > 0 && errors[fit - 1] <= level
            });
        100.0 * solved.count() as f64 / self.cold.errors.len() as f64
    }
}

/// Velocity error of the stored solutions, at most: what is below counts as this.
pub(crate) const REFERENCE: f64 = 1e-10;

/// Geometric mean and largest of the errors of all files after the `k`th number of sweeps.
pub(crate) fn mean_and_worst(profile: &Profile, k: usize) -> [f64; 2] {
    let errors = || profile.errors.iter().map(|e| e[k].max(REFERENCE));
    let mean = errors().map(f64::ln).sum::<f64>() / profile.errors.len() as f64;
    [mean.exp(), errors().fold(0.0, f64::max)]
}

impl Exact {
    /// Solves three times and takes the median time.
    fn measure(file: &File, a: &[f64], start: &[f64]) -> Self {
        let reference = file.reference.as_ref().expect("solvable");
        let mut scratch = ExactScratch::default();
        let runs = [(); 3].map(|()| {
            let mut lambda = start.to_vec();
            let clock = Instant::now();
            let certificate = file.problem.solve(&mut lambda, &mut scratch);
            let micros = 1e6 * clock.elapsed().as_secs_f64();
            (certificate, micros, lambda)
        });
        let (certificate, _, lambda) = &runs[2];
        Self {
            factorisations: certificate.iterations,
            micros: stats::median(&runs.each_ref().map(|r| r.1)) / contacts(file),
            error: velocity_error(a, lambda, reference),
            is_certified: certificate.converged,
        }
    }
}
