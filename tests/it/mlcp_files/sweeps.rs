//! Iterative methods on problem files: error against work, with the sweep of the run-time solver in double precision.
//!
//! All problems are in the box form: friction bounds frozen at those of the stored solution, so that the velocities are
//! unique and the error is known.

use super::{File, Reference};
use bevy_cleave::testing::exact::Bounds;
use bevy_cleave::testing::pgs;
use bevy_cleave::testing::pgs::ContactRows;
use bevy_cleave::testing::rows::{ImpulseSystem, Momentum};
use std::time::Instant;

/// A method of sweeps. One unit of work is one update of every row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Method {
    /// Projected Gauss-Seidel.
    Pgs,
    /// What the default method does with the rows of a sub-step until they are within its tolerance: the first sweep plain,
    /// those that follow with momentum, by the source of the run time.
    Momentum,
    /// As many sub-steps as there are sweeps, as the default method takes them where one sweep each is enough: each adds its
    /// share of `b`, starts from the impulses of the one before and may have its share of the bounds.
    Substeps,
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

    fn unbounded_normal(&self) -> f64 {
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
}

impl ImpulseSystem for State<'_> {
    type Real = f64;
    type Velocity = f64;

    fn count(&self) -> usize {
        self.len() / self.per_contact
    }

    fn impulses(&self, contact: usize) -> [f64; 3] {
        let mut impulses = [0.0; 3];
        let rows = &self.lambda[contact * self.per_contact..][..self.per_contact];
        impulses[..self.per_contact].copy_from_slice(rows);
        impulses
    }

    fn velocities(&mut self) -> &mut [f64] {
        &mut self.w
    }

    fn ahead(now: f64, last: f64, weight: f64) -> f64 {
        now + weight * (now - last)
    }

    fn place(&mut self, contact: usize, impulses: [f64; 3]) {
        let first = contact * self.per_contact;
        for (i, wish) in (first..first + self.per_contact).zip(impulses) {
            self.lambda[i] = wish;
            self.move_row(i, wish.max(self.lo[i]).min(self.hi[i]));
        }
    }

    fn sweep(&mut self) -> f64 {
        let mut change = 0.0_f64;
        for first in (0..self.len()).step_by(self.per_contact) {
            let state = &mut *self;
            change = change.max(if state.per_contact == 3 {
                pgs::relax(&mut Contact::<2> { state, first }, pgs::friction_in_box)
            } else {
                pgs::relax(&mut Contact::<1> { state, first }, pgs::friction_in_box)
            });
        }
        change
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
        Method::Pgs => errors_of_sweeps(whole(), start, sweeps, error, |state, _| {
            state.sweep();
        }),
        Method::Momentum => {
            let mut momentum = Momentum::default();
            errors_of_sweeps(whole(), start, sweeps, error, |state, k| {
                sweep_of_the_default(&mut momentum, state, k);
            })
        }
        Method::Substeps => {
            let run = |&n: &usize| {
                let state = State::new(file, reference, a, 0.0);
                error(&sum_of_substeps(state, &file.b, start, n))
            };
            sweeps.iter().map(run).collect()
        }
    }
}

/// Microseconds of `sweeps` sweeps from `start`, without what prepares them.
pub(crate) fn micros(method: Method, file: &File, a: &[f64], start: &[f64], sweeps: usize) -> f64 {
    let reference = file.reference.as_ref().expect("solvable");
    let is_whole = method != Method::Substeps;
    let state = State::new(file, reference, a, f64::from(u8::from(is_whole)));
    let first = |lambda: &[f64]| lambda[0];
    let clock = Instant::now();
    let found = match method {
        Method::Pgs => errors_of_sweeps(state, start, &[sweeps], first, |state, _| {
            state.sweep();
        }),
        Method::Momentum => {
            let mut momentum = Momentum::default();
            errors_of_sweeps(state, start, &[sweeps], first, |state, k| {
                sweep_of_the_default(&mut momentum, state, k);
            })
        }
        Method::Substeps => sum_of_substeps(state, &file.b, start, sweeps),
    };
    // So that none of it is left out by the compiler.
    std::hint::black_box(found);
    clock.elapsed().as_secs_f64() * 1e6
}

/// The first sweep plain, the others with momentum.
fn sweep_of_the_default(momentum: &mut Momentum<f64, f64>, state: &mut State, k: usize) {
    if k == 1 {
        state.sweep();
    } else {
        momentum.sweep(state);
    }
}

/// `sweep` is told the number of the sweep, from 1.
fn errors_of_sweeps(
    mut state: State,
    start: &[f64],
    sweeps: &[usize],
    error: impl Fn(&[f64]) -> f64,
    mut sweep: impl FnMut(&mut State, usize),
) -> Vec<f64> {
    state.move_to(start);
    let mut errors = Vec::new();
    for k in 1..=*sweeps.last().expect("sorted list") {
        sweep(&mut state, k);
        if sweeps.contains(&k) {
            errors.push(error(&state.lambda));
        }
    }
    errors
}

/// `n` sub-steps of one sweep; returns the sum of their impulses.
fn sum_of_substeps(mut state: State, b: &[f64], start: &[f64], n: usize) -> Vec<f64> {
    let share = 1.0 / n as f64;
    let bounds = state.lo.iter_mut().chain(&mut state.hi);
    bounds.for_each(|bound| *bound *= share);
    let mut total = vec![0.0; b.len()];
    let mut warm: Vec<f64> = start.iter().map(|l| l * share).collect();
    for _ in 0..n {
        let rows = state.w.iter_mut().zip(b);
        rows.for_each(|(w, b)| *w -= share * b);
        // The velocities keep what earlier impulses did.
        state.lambda.fill(0.0);
        let bounds = state.lo.iter().zip(&state.hi);
        let clipped = warm
            .iter()
            .zip(bounds)
            .map(|(l, (lo, hi))| l.max(*lo).min(*hi));
        let next: Vec<f64> = clipped.collect();
        state.move_to(&next);
        state.sweep();
        warm.copy_from_slice(&state.lambda);
        total.iter_mut().zip(&warm).for_each(|(sum, l)| *sum += l);
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
