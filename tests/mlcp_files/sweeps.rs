//! Iterative methods on problem files: error against work, with the sweep of the run-time solver in double precision.
//!
//! All problems are in the box form: friction bounds frozen at those of the stored solution, so that the velocities are
//! unique and the error is known.

use super::{File, Reference};
use bevy_cleave::solver::exact::problem::Bounds;
use bevy_cleave::solver::pgs::{self, ContactRows};
use std::time::Instant;

/// A method of sweeps. One unit of work is one update of every row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Method {
    /// Projected Gauss-Seidel.
    Pgs,
    /// Nonsmooth nonlinear conjugate gradients around it; the iterate with the least residual counts.
    ///
    /// Silcowitz-Hansen, Niebe, Erleben, "A Nonsmooth Nonlinear Conjugate Gradient Method for Interactive Contact Force
    /// Problems", The Visual Computer 26, 2010.
    Nncg,
    /// As many sub-steps as there are sweeps. Each adds its share of `b` and starts from the impulses of the one before.
    Substeps(Clip),
}

/// What the bounds of a sub-step are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Clip {
    /// The impulses of each sub-step, which may have its share of the bounds.
    EachSubstep,
    /// The sum of the impulses of all sub-steps so far, which may have the share of the time that has passed.
    ///
    /// With `k` of `n` sub-steps over and `mu_k = n / k` times the sum of their impulses, starting from the impulses of the
    /// sub-step before is `mu_k + (k - 1) / (k + 1) (mu_k - mu_(k-1))`: Gauss-Seidel with the momentum of Nesterov's
    /// accelerated gradients.
    RunningTotal,
}

/// `lambda` and `w = A lambda - b` of a problem.
struct State<'a> {
    a: &'a [f64],
    /// Of each column of `a` the rows and values that are not zero.
    columns: Vec<Vec<(usize, f64)>>,
    per_contact: usize,
    lambda: Vec<f64>,
    w: Vec<f64>,
    lo: Vec<f64>,
    hi: Vec<f64>,
}

/// One contact with `T` tangents.
struct Contact<'s, 'a, const T: usize> {
    state: &'s mut State<'a>,
    first: usize,
}

impl<const T: usize> ContactRows for Contact<'_, '_, T> {
    type Real = f64;
    const TANGENTS: usize = T;

    fn has_friction(&self) -> bool {
        let [lo, hi] = self.bounds(1);
        hi > lo
    }

    fn impulse(&self, row: usize) -> f64 {
        self.state.lambda[self.first + row]
    }

    fn velocity(&self, row: usize) -> f64 {
        self.state.w[self.first + row]
    }

    fn effective_mass(&self, row: usize) -> f64 {
        1.0 / self.state.diagonal(self.first + row)
    }

    fn normal_wish(&self) -> f64 {
        self.impulse(0) - self.velocity(0) * self.effective_mass(0)
    }

    fn bounds(&self, row: usize) -> [f64; 2] {
        let i = self.first + row;
        [self.state.lo[i], self.state.hi[i]]
    }

    fn move_to(&mut self, row: usize, impulse: f64) -> f64 {
        let i = self.first + row;
        let change = impulse - self.state.lambda[i];
        self.state.move_row(i, impulse);
        (change * self.state.diagonal(i)).abs()
    }
}

impl<'a> State<'a> {
    /// Without impulses; `w = -share b`.
    fn new(file: &File, reference: &Reference, a: &'a [f64], share: f64) -> Self {
        let Bounds::Frozen { lo, hi } = reference.bounds.clone() else {
            panic!("references have frozen bounds")
        };
        let entries = |column: &[f64]| {
            let entries = column.iter().copied().enumerate();
            entries.filter(|(_, a)| *a != 0.0).collect()
        };
        Self {
            a,
            columns: a.chunks_exact(file.b.len()).map(entries).collect(),
            per_contact: file.rows_per_contact,
            lambda: vec![0.0; file.b.len()],
            w: file.b.iter().map(|b| -share * b).collect(),
            lo,
            hi,
        }
    }

    fn len(&self) -> usize {
        self.w.len()
    }

    fn diagonal(&self, i: usize) -> f64 {
        self.a[i * self.len() + i]
    }

    fn move_row(&mut self, i: usize, impulse: f64) {
        let change = impulse - self.lambda[i];
        self.lambda[i] = impulse;
        if change != 0.0 {
            for &(row, a) in &self.columns[i] {
                self.w[row] += a * change;
            }
        }
    }

    fn move_to(&mut self, lambda: &[f64]) {
        (0..self.len()).for_each(|i| self.move_row(i, lambda[i]));
    }

    fn sweep(&mut self) {
        for first in (0..self.len()).step_by(self.per_contact) {
            let state = &mut *self;
            if state.per_contact == 3 {
                pgs::relax(&mut Contact::<2> { state, first }, pgs::friction_in_box);
            } else {
                pgs::relax(&mut Contact::<1> { state, first }, pgs::friction_in_box);
            }
        }
    }

    /// Square of the natural map in the mass norm.
    fn residual(&self) -> f64 {
        let row = |i: usize| {
            let (l, a) = (self.lambda[i], self.diagonal(i));
            let r = l - (l - self.w[i] / a).max(self.lo[i]).min(self.hi[i]);
            r * r * a
        };
        (0..self.len()).map(row).sum()
    }
}

/// Velocity error in the mass norm, relative to the velocity change that the contacts make.
pub(crate) fn velocity_error(a: &[f64], lambda: &[f64], reference: &Reference) -> f64 {
    let off = lambda.iter().zip(&reference.lambda);
    let off: Vec<f64> = off.map(|(x, y)| x - y).collect();
    let rows = a.chunks_exact(lambda.len()).zip(&off);
    let row = |row: &[f64]| row.iter().zip(&off).map(|(a, d)| a * d).sum::<f64>();
    let square: f64 = rows.map(|(a, d)| d * row(a)).sum();
    square.max(0.0).sqrt() / reference.energy_norm
}

/// Velocity errors after each of `sweeps` (ascending) from `start`; `a` is the file's matrix.
pub(crate) fn errors(
    method: Method,
    file: &File,
    a: &[f64],
    start: &[f64],
    sweeps: &[usize],
) -> Vec<f64> {
    let reference = file.reference.as_ref().expect("solvable");
    let whole = || State::new(file, reference, a, 1.0);
    let error = |lambda: &[f64]| velocity_error(a, lambda, reference);
    match method {
        Method::Pgs => pgs_errors(whole(), start, sweeps, error),
        Method::Nncg => nncg_errors(whole(), start, sweeps, error),
        Method::Substeps(clip) => {
            let run = |&n: &usize| {
                let state = State::new(file, reference, a, 0.0);
                error(&sum_of_substeps(state, &file.b, start, n, clip))
            };
            sweeps.iter().map(run).collect()
        }
    }
}

/// Microseconds of `sweeps` sweeps from `start`, without what prepares them.
pub(crate) fn micros(method: Method, file: &File, a: &[f64], start: &[f64], sweeps: usize) -> f64 {
    let reference = file.reference.as_ref().expect("solvable");
    let is_whole = !matches!(method, Method::Substeps(_));
    let state = State::new(file, reference, a, f64::from(u8::from(is_whole)));
    let clock = Instant::now();
    let found = match method {
        Method::Pgs => pgs_errors(state, start, &[sweeps], |lambda| lambda[0]),
        Method::Nncg => nncg_errors(state, start, &[sweeps], |lambda| lambda[0]),
        Method::Substeps(clip) => sum_of_substeps(state, &file.b, start, sweeps, clip),
    };
    // So that none of it is left out by the compiler.
    std::hint::black_box(found);
    clock.elapsed().as_secs_f64() * 1e6
}

fn pgs_errors(
    mut state: State,
    start: &[f64],
    sweeps: &[usize],
    error: impl Fn(&[f64]) -> f64,
) -> Vec<f64> {
    state.move_to(start);
    let mut errors = Vec::new();
    for k in 1..=*sweeps.last().expect("sorted list") {
        state.sweep();
        if sweeps.contains(&k) {
            errors.push(error(&state.lambda));
        }
    }
    errors
}

fn nncg_errors(
    mut state: State,
    start: &[f64],
    sweeps: &[usize],
    error: impl Fn(&[f64]) -> f64,
) -> Vec<f64> {
    state.move_to(start);
    let n = state.len();
    let (mut errors, mut direction) = (Vec::new(), vec![0.0; n]);
    let (mut best, mut least) = (start.to_vec(), f64::INFINITY);
    let mut old_square = 0.0;
    for k in 1..=*sweeps.last().expect("sorted list") {
        let old = state.lambda.clone();
        state.sweep();
        let residual = state.residual();
        if residual < least {
            least = residual;
            best.copy_from_slice(&state.lambda);
        }
        if sweeps.contains(&k) {
            errors.push(error(&best));
        }
        // What the sweep changed is the negative gradient; its length is taken in the mass norm.
        let change: Vec<f64> = (0..n).map(|i| state.lambda[i] - old[i]).collect();
        let square: f64 = (0..n)
            .map(|i| change[i] * change[i] * state.diagonal(i))
            .sum();
        let beta = square / old_square;
        old_square = square;
        if k == 1 {
            direction = change;
        } else if beta <= 1.0 {
            let step = |i: usize| state.lambda[i] + beta * direction[i];
            let next: Vec<f64> = (0..n).map(step).collect();
            state.move_to(&next);
            (0..n).for_each(|i| direction[i] = beta * direction[i] + change[i]);
        } else {
            direction.fill(0.0);
        }
    }
    errors
}

/// `n` sub-steps of one sweep; returns the sum of their impulses.
fn sum_of_substeps(mut state: State, b: &[f64], start: &[f64], n: usize, clip: Clip) -> Vec<f64> {
    let share = 1.0 / n as f64;
    let (lo, hi) = (state.lo.clone(), state.hi.clone());
    let mut total = vec![0.0; b.len()];
    let mut warm: Vec<f64> = start.iter().map(|l| l * share).collect();
    for k in 1..=n {
        let passed = match clip {
            Clip::EachSubstep => 1.0,
            Clip::RunningTotal => k as f64,
        };
        for i in 0..b.len() {
            state.w[i] -= share * b[i];
            state.lo[i] = passed * share * lo[i];
            state.hi[i] = passed * share * hi[i];
        }
        // The velocities keep what earlier impulses did; only what the bounds are for differs.
        match clip {
            Clip::EachSubstep => state.lambda.fill(0.0),
            Clip::RunningTotal => state.lambda.copy_from_slice(&total),
        }
        let before = state.lambda.clone();
        let next = (0..b.len()).map(|i| (before[i] + warm[i]).max(state.lo[i]).min(state.hi[i]));
        let next: Vec<f64> = next.collect();
        state.move_to(&next);
        state.sweep();
        for i in 0..b.len() {
            warm[i] = state.lambda[i] - before[i];
            total[i] += warm[i];
        }
    }
    total
}

/// Velocity errors of a method on a set of files: `errors[file][sweeps]`.
pub(crate) struct Profile {
    pub(crate) sweeps: Vec<usize>,
    pub(crate) errors: Vec<Vec<f64>>,
}

impl Profile {
    /// Runs `method` on `files` (with their `matrices`), cold or from the solution of a step before.
    pub(crate) fn measure(
        method: Method,
        files: &[File],
        matrices: &[Vec<f64>],
        warm: bool,
        sweeps: &[usize],
    ) -> Self {
        let run = |(file, a): (&File, &Vec<f64>)| {
            let before = file.reference.as_ref().and_then(|r| r.warm.clone());
            let start = if warm {
                before?
            } else {
                vec![0.0; file.b.len()]
            };
            Some(errors(method, file, a, &start, sweeps))
        };
        Self {
            sweeps: sweeps.to_vec(),
            errors: files.iter().zip(matrices).filter_map(run).collect(),
        }
    }

    /// Files solved to `level`, for each number of sweeps.
    pub(crate) fn solved(&self, level: f64) -> Vec<usize> {
        let count = |k| self.errors.iter().filter(|e| e[k] <= level).count();
        (0..self.sweeps.len()).map(count).collect()
    }

    /// The same in percent.
    pub(crate) fn shares(&self, level: f64) -> Vec<f64> {
        let whole = self.errors.len() as f64;
        let shares = self.solved(level).into_iter();
        shares.map(|n| 100.0 * n as f64 / whole).collect()
    }
}
